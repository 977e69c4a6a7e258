//! `ambidex import`.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ambidex::config::{self, Beside, ConfigError, ImportError, Imported};
use clap::Args;
use miette::{IntoDiagnostic, Report, Result, WrapErr, miette};

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
    let imported = config::import(&args.file, args.robot.as_deref(), target).map_err(into_report)?;
    for warning in &imported.warnings {
        say(&format!("{:?}", Report::new(warning.clone())));
    }
    if imported.unshown > 0 {
        say(&format!("and {} more warnings: each stands as a comment in what is written", imported.unshown));
    }
    match target {
        Some(target) => write(args, target, &imported)?,
        None => print(&imported)?,
    }
    Ok(Exit::Done)
}

fn into_report(error: ImportError) -> Report {
    match error {
        ImportError::Faulty(faults) => ConfigError::into_report(faults),
        ImportError::Defect(faults) => ConfigError::into_report(faults)
            .wrap_err("what was made of the file does not load, so nothing was written; this is a defect of `import`"),
    }
}

fn write(args: &ImportArgs, target: &Path, imported: &Imported) -> Result<()> {
    let files: Vec<(&Path, &str)> = imported
        .beside
        .iter()
        .map(|Beside { path, text }| (path.as_path(), text.as_str()))
        .chain([(target, imported.text.as_str())])
        .collect();
    let is_input = |path: &Path| {
        let inputs = [Some(args.file.as_path()), args.robot.as_deref()];
        let same = |input: &Path| path.canonicalize().is_ok_and(|path| input.canonicalize().is_ok_and(|at| at == path));
        inputs.into_iter().flatten().any(same)
    };
    for (path, _) in &files {
        if is_input(path) {
            return Err(miette!("{} is imported itself, and nothing was written", path.display()));
        }
        if !args.force && path.symlink_metadata().is_ok() {
            let help = "choose another --output, or overwrite with --force";
            return Err(miette!(help = help, "{} is there already, and nothing was written", path.display()));
        }
    }
    for (path, text) in &files {
        write_file(path, text, args.force)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    let paths: Vec<_> = files.iter().rev().map(|(path, _)| path.display().to_string()).collect();
    say(&format!("imported {}: {}", args.file.display(), imported.summary));
    say(&format!("wrote {}", paths.join(" and ")));
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
        say(&format!("note: the mission names {path}, which is written with `--output FILE` only"));
    }
    Ok(())
}

fn say(text: &str) {
    drop(writeln!(io::stderr(), "{text}"));
}
