//! `ambidex explain`.

use ambidex::record::Reader;
use ambidex::show::explain::{Account, Story};
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};

use crate::exit::Exit;
use crate::log;
use crate::page::Page;
use crate::telling::Telling;

/// `ambidex explain`.
#[derive(Debug, Args)]
#[command(after_help = log::HELP)]
pub struct ExplainArgs {
    /// The log: a file or an instance.
    pub log: Option<String>,
    /// A behavior, or a node whose behaviors are meant; * ? and [...] match as in a shell. Without it the story of the
    /// whole run is told.
    pub node: Option<String>,
    /// Only this round.
    #[arg(long, value_name = "N", requires = "node")]
    pub round: Option<u32>,
}

/// Says why a run, or a behavior of it, went as it did.
pub fn explain(args: &ExplainArgs) -> Result<Exit> {
    let found = log::find(args.log.as_deref()).map_err(|error| match (&args.log, &args.node) {
        (Some(only), None) if !only.contains(['/', '.']) => {
            miette!(help = "to explain a behavior, name the log first: ambidex explain LOG NODE", "{error}")
        }
        (Some(_) | None, _) => error,
    });
    let path = found?;
    let reader = Reader::open(&path).into_diagnostic()?;
    let mut page = Page::new();
    let (width, palette) = (page.width(), page.palette());
    let text = match &args.node {
        None => {
            let story = Story::new(reader.header());
            log::folded(reader, story, Story::add)?.text(width, &palette)
        }
        Some(node) => {
            let account = Account::new(reader.header(), node, args.round);
            let mut account = account.map_err(|error| log::unknown(&error))?;
            let mut telling = Telling::new(reader.header(), &path, |node| account.is_about(node))?;
            log::read(reader, |record| {
                telling.tell(record, |record| {
                    account.add(record);
                    Ok(true)
                })
            })?;
            account.text(width, &palette).map_err(|error| log::unknown(&error))?
        }
    };
    page.text(&text)?;
    Ok(Exit::Done)
}
