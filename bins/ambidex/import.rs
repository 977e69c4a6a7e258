//! `ambidex import`.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ambidex::files::{self, Beside, Disk, ImportError, Imported};
use clap::Args;
use miette::{IntoDiagnostic, Report, Result, WrapErr, miette};

use crate::diagnostics::{legible, report_all, say_all};
use crate::exit::Exit;

/// `ambidex import`.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// A task file or a robot file of the dHTT software.
    pub file: PathBuf,
    /// The robot for a task: a robot file of dHTT or of Ambidex [default: two grippers, a head and a base].
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Where the mission or the robot goes; `-` is stdout. The robot file of MISSION.yaml becomes MISSION.robot.yaml.
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Overwrite what is there.
    #[arg(long)]
    pub force: bool,
}

/// Imports a file; what is not carried over is told on stderr.
pub fn import(args: &ImportArgs) -> Result<Exit> {
    let target = (args.output.as_os_str() != "-").then_some(args.output.as_path());
    let imported = files::import(&Disk, &args.file, args.robot.as_deref(), target).map_err(into_report)?;
    let files = target.map(|target| files(target, &imported)).unwrap_or_default();
    refuse(args, &files)?;
    say_all(&imported.warnings);
    if imported.unshown > 0 {
        say(&format!("and {} more warnings: each is told by a comment in what is written", imported.unshown));
    }
    match target {
        Some(target) => write(args, target, &files, &imported)?,
        None => print(&imported)?,
    }
    Ok(Exit::Done)
}

fn into_report(error: ImportError) -> Report {
    match error {
        ImportError::Faulty(faults) => report_all(&faults),
        error @ ImportError::TooLarge(_) => miette!("{error}"),
        ImportError::Defect(faults) => report_all(&faults)
            .wrap_err("what was made of the file does not load, so nothing was written; this is a defect of `import`"),
    }
}

/// What is to be written, the mission last: it names the other.
fn files<'a>(target: &'a Path, imported: &'a Imported) -> Vec<(&'a Path, &'a str)> {
    let beside = imported.beside.iter().map(|Beside { path, text }| (path.as_path(), text.as_str()));
    beside.chain([(target, imported.text.as_str())]).collect()
}

/// Nothing is written over what is read, and nothing over what is there, unless that is asked for.
fn refuse(args: &ImportArgs, files: &[(&Path, &str)]) -> Result<()> {
    let inputs = [Some(args.file.as_path()), args.robot.as_deref()];
    let is_same = |one: &Path, other: &Path| {
        one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
    };
    for (path, _) in files {
        let shown = legible(&path.display().to_string());
        if inputs.into_iter().flatten().any(|input| is_same(path, input)) {
            let help = "choose another --output";
            return Err(miette!(help = help, "{shown} is read by this import, so nothing was written"));
        }
        if !args.force && path.symlink_metadata().is_ok() {
            let help = "choose another --output, or overwrite with --force";
            return Err(miette!(help = help, "{shown} is there already, so nothing was written"));
        }
    }
    Ok(())
}

fn write(args: &ImportArgs, target: &Path, files: &[(&Path, &str)], imported: &Imported) -> Result<()> {
    for (path, text) in files {
        let written = write_file(path, text, args.force);
        written.into_diagnostic().wrap_err_with(|| legible(&format!("cannot write {}", path.display())))?;
    }
    let paths: Vec<_> = files.iter().rev().map(|(path, _)| path.display().to_string()).collect();
    say(&format!("imported {}: {}", args.file.display(), imported.summary));
    say(&format!("wrote {}", paths.join(" and ")));
    if imported.is_mission {
        say(&format!("try: ambidex simulate {}", target.display()));
    }
    Ok(())
}

/// Writes a file; one that came to be since it was looked for is left as it is.
fn write_file(path: &Path, text: &str, overwrites: bool) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true);
    if overwrites {
        options.create(true).truncate(true);
    } else {
        options.create_new(true);
    }
    options.open(path)?.write_all(text.as_bytes())
}

fn print(imported: &Imported) -> Result<()> {
    let mut stdout = io::stdout().lock();
    let printed = stdout.write_all(imported.text.as_bytes()).and_then(|()| stdout.flush());
    // Whoever closes the pipe has read enough.
    if let Err(error) = printed.as_ref()
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        printed.into_diagnostic().wrap_err("cannot write to stdout")?;
    }
    if let Some(Beside { path, .. }) = &imported.beside {
        let path = path.display();
        say(&format!("note: the mission names {path}, which is only written with `--output FILE`"));
    }
    Ok(())
}

fn say(text: &str) {
    drop(writeln!(io::stderr(), "{}", legible(text)));
}
