//! `ambidex man`: manual pages from the same descriptions as `--help`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use ambidex::record::shown;
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Inline, Roff, bold, italic, roman};
use miette::{Context, IntoDiagnostic, Result};

use crate::args::Cli;
use crate::exit::{Exit, MEANINGS};
use crate::log::say;
use crate::page::Page;

/// What in the surroundings makes a difference.
const ENVIRONMENT: [(&str, &str); 6] = [
    ("NO_COLOR", "Set to anything, nothing is colored."),
    (
        "RUST_LOG",
        "Which tracing events are told on stderr, such as ambidex=debug. Targets are ambidex::mission, ambidex::tree, \
         ambidex::controller and ambidex::diagnostics.",
    ),
    ("XDG_STATE_HOME", "Where logs lie, an absolute path; ~/.local/state where it is not set."),
    ("HOME", "Where logs lie if XDG_STATE_HOME is not set: below .local/state in it."),
    (
        "NOTIFY_SOCKET",
        "The service manager that run and daemon tell when they are ready, what they are at, and that they end.",
    ),
    (
        "WATCHDOG_USEC, WATCHDOG_PID",
        "Within how many microseconds that manager wants a sign of life, and of which process.",
    ),
];

/// What lies where.
const FILES: [(&str, &str); 5] = [
    (
        "$XDG_STATE_HOME/ambidex/INSTANCE/journal.jsonl",
        "The log of the last run of an instance; older ones lie beside it.",
    ),
    ("/dev/shm/ambidex-UID/", "Locks and sockets of the living instances of a user, for that user alone."),
    ("/dev/shm/ambidex-UID/*/control.sock", "Where the daemon of an instance is asked."),
    ("/dev/shm/ambidex_*", "Shared memory between a daemon and its controllers."),
    ("~/.config/ambidex/INSTANCE.env", "What the unit ambidex@INSTANCE.service reads: MISSION and OPTIONS."),
];

/// `ambidex man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Write the pages of all verbs into this folder, which is made if it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Prints the page of the program, or writes all.
pub fn man(args: &ManArgs) -> Result<Exit> {
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let pages = pages(&program);
    match &args.output {
        None => {
            let (_, page) = &pages[0];
            Page::new().text(&String::from_utf8_lossy(page))?;
        }
        Some(folder) => {
            write_all(folder, &pages)?;
            say(&format!("{} pages in {}", pages.len(), shown(folder)));
        }
    }
    Ok(Exit::Done)
}

fn write_all(folder: &Path, pages: &[(String, Vec<u8>)]) -> Result<()> {
    fs::create_dir_all(folder).into_diagnostic().wrap_err_with(|| format!("cannot make {}", shown(folder)))?;
    for (file, page) in pages {
        let path = folder.join(file);
        fs::write(&path, page).into_diagnostic().wrap_err_with(|| format!("cannot write {}", shown(&path)))?;
    }
    Ok(())
}

/// Every page with the name of its file, that of the program first.
fn pages(program: &Command) -> Vec<(String, Vec<u8>)> {
    let commands = with_verbs(program);
    let names: Vec<String> = commands.iter().map(|command| name(command)).collect();
    let page = |command: &&Command| {
        let page = page(command, &names).expect("a vector takes everything");
        (format!("{}.1", name(command)), page)
    };
    commands.iter().map(page).collect()
}

/// A command and all below it that people are to know of.
fn with_verbs(command: &Command) -> Vec<&Command> {
    let verbs = command.get_subcommands().filter(|verb| !verb.is_hide_set());
    std::iter::once(command).chain(verbs.flat_map(with_verbs)).collect()
}

fn name(command: &Command) -> String {
    command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned()
}

fn page(command: &Command, names: &[String]) -> io::Result<Vec<u8>> {
    let source = format!("ambidex {}", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).title(name(command)).source(source).manual("Ambidex");
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    let mut roff = Roff::new();
    notes(&mut roff, command);
    roff.control("SH", ["EXIT STATUS"]);
    for (exit, meaning) in MEANINGS {
        entry(&mut roff, bold((exit as u8).to_string()), &meaning.replace('\n', " "));
    }
    roff.control("SH", ["ENVIRONMENT"]);
    ENVIRONMENT.iter().for_each(|(variable, meaning)| entry(&mut roff, bold(*variable), meaning));
    roff.control("SH", ["FILES"]);
    FILES.iter().for_each(|(file, meaning)| entry(&mut roff, italic(*file), meaning));
    roff.control("SH", ["SEE ALSO"]);
    let own = name(command);
    let others = names.iter().filter(|other| **other != own).map(|other| (other.as_str(), "(1)"));
    let others: Vec<_> = others.chain([("systemd.service", "(5)")]).collect();
    for (index, (other, section)) in others.iter().enumerate() {
        let comma = if index + 1 < others.len() { "," } else { "" };
        roff.text([bold(*other), roman(format!("{section}{comma}"))]);
    }
    roff.to_writer(&mut page)?;
    Ok(page)
}

/// What `--help` says below the options; exit codes have a section of their own.
fn notes(roff: &mut Roff, command: &Command) {
    let Some(said) = command.get_after_help() else { return };
    let said = said.to_string();
    let paragraphs = said.split("\n\n").filter(|paragraph| !paragraph.starts_with("Exit codes:\n"));
    for (index, paragraph) in paragraphs.enumerate() {
        if index == 0 {
            roff.control("SH", ["NOTES"])
        } else {
            roff.control("PP", [])
        };
        for line in paragraph.lines() {
            roff.text([roman(line)]);
        }
    }
}

fn entry(roff: &mut Roff, what: Inline, meaning: &str) {
    roff.control("TP", []);
    roff.text([what]);
    roff.text([roman(meaning)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verb_has_a_page_with_all_sections() {
        let mut program = Cli::command().disable_help_subcommand(true);
        program.build();
        let pages = pages(&program);
        assert_eq!(pages[0].0, "ambidex.1");
        let page = |file: &str| {
            let page = pages.iter().find(|(name, _)| name == file).unwrap_or_else(|| panic!("{file} is not there"));
            String::from_utf8(page.1.clone()).expect("it is text")
        };
        for verb in program.get_subcommands() {
            let text = page(&format!("ambidex-{}.1", verb.get_name()));
            for section in [
                "NAME",
                "SYNOPSIS",
                "DESCRIPTION",
                "OPTIONS",
                "\"EXIT STATUS\"",
                "ENVIRONMENT",
                "FILES",
                "\"SEE ALSO\"",
            ] {
                assert!(text.contains(&format!(".SH {section}\n")), "{}: {section}", verb.get_name());
            }
            assert!(
                page("ambidex.1").contains(&format!("ambidex\\-{}\\fR(1)", verb.get_name())),
                "{}",
                page("ambidex.1")
            );
        }
        assert!(page("ambidex-world-set.1").contains("FACT"));
        for variable in ["NO_COLOR", "RUST_LOG", "XDG_STATE_HOME", "NOTIFY_SOCKET"] {
            assert!(page("ambidex-daemon.1").contains(variable), "{variable}");
        }
        assert!(!page("ambidex.1").contains("Exit codes"), "they have a section");
    }
}
