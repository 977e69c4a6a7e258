//! `ambidex edit`: the tree of a task that runs is to be different.

use std::path::PathBuf;

use ambidex::files::{self, Disk, Setting};
use ambidex::http::Request;
use ambidex::model::Source;
use ambidex::runtime::control::{Edit, NameOrId, Work};
use clap::{Args, Subcommand};
use miette::Result;

use crate::asking::{self, AskArgs};
use crate::diagnostics::report_all;
use crate::exit::Exit;

/// `ambidex edit`.
#[derive(Debug, Args)]
pub struct EditArgs {
    /// The task: its number or its name.
    task: NameOrId,
    /// What is to be different.
    #[command(subcommand)]
    edit: ChangeArgs,
    #[command(flatten)]
    ask: AskArgs,
}

#[derive(Debug, Subcommand)]
enum ChangeArgs {
    /// A node has one more child.
    Add {
        /// The node: its number or its name.
        under: NameOrId,
        #[command(flatten)]
        file: FileArgs,
        /// So many children stand before it [default: all].
        #[arg(long, value_name = "N")]
        at: Option<u32>,
    },
    /// A node is not there any more, nor is what is below it.
    Remove {
        /// The node: its number or its name.
        node: NameOrId,
    },
    /// Another node takes the place of one.
    Replace {
        /// The node: its number or its name.
        node: NameOrId,
        #[command(flatten)]
        file: FileArgs,
    },
}

/// A task file and what it is told.
#[derive(Debug, Args)]
pub struct FileArgs {
    /// The task file, or the name of a subtree that the world's files declare, as in `submit fetch --set object=mug`.
    #[arg(value_name = "TASK.yaml|SUBTREE")]
    pub file: PathBuf,
    /// Tell the task a value for one of its parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<Setting>,
}

impl FileArgs {
    /// The file with all that it includes, or a use of the subtree.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn gather(&self) -> Result<Source> {
        let name = self.file.to_str().filter(|name| !name.contains(['/', '.']) && !self.file.exists());
        if let Some(name) = name {
            return Ok(files::use_source(name, &self.set));
        }
        files::task_source(&Disk, &self.file, &self.set).map_err(|error| report_all(&error))
    }
}

/// Tells it to the daemon of the instance, and what came of it.
pub fn edit(args: &EditArgs) -> Result<Exit> {
    let edit = match &args.edit {
        ChangeArgs::Add { under, file, at } => Edit::Add { under: under.clone(), source: file.gather()?, at: *at },
        ChangeArgs::Remove { node } => Edit::Remove { node: node.clone() },
        ChangeArgs::Replace { node, file } => Edit::Replace { node: node.clone(), source: file.gather()? },
    };
    asking::tell(&args.ask, &Request::Work(Work::Edit(args.task.clone(), edit)))
}
