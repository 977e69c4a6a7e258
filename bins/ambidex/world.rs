//! `ambidex world`: what somebody outside says of the world.

use ambidex::http::Request;
use ambidex::runtime::control::{Work, WorldChange};
use clap::{Args, Subcommand};
use miette::Result;

use crate::asking::{self, AskArgs};
use crate::exit::Exit;

/// `ambidex world`.
#[derive(Debug, Args)]
pub struct WorldArgs {
    /// What is different.
    #[command(subcommand)]
    change: ChangeArgs,
    #[command(flatten)]
    ask: AskArgs,
}

#[derive(Debug, Subcommand)]
enum ChangeArgs {
    /// A fact holds that the mission declares `outside: true`.
    Set {
        /// The fact.
        fact: String,
    },
    /// A fact does not hold that the mission declares `outside: true`.
    Clear {
        /// The fact.
        fact: String,
    },
    /// An object that no gripper holds lies at a place now.
    Move {
        /// The object.
        object: String,
        /// The place.
        place: String,
    },
    /// Something stands in the room that was not there before: the base does not drive into it.
    Block {
        /// Its middle on the map, meters.
        #[arg(value_name = "X,Y", allow_hyphen_values = true, value_parser = pair)]
        at: [f64; 2],
        /// Along its own x and y, meters.
        #[arg(value_name = "X,Y", value_parser = pair)]
        size: [f64; 2],
        /// Where its x points, degrees, counterclockwise from x of the map.
        #[arg(long, value_name = "DEG", allow_hyphen_values = true, default_value_t = 0.0)]
        heading: f64,
    },
    /// What came to stand around a point of the map is gone.
    Unblock {
        /// The point, meters.
        #[arg(value_name = "X,Y", allow_hyphen_values = true, value_parser = pair)]
        at: [f64; 2],
    },
    /// There is an object that was not there before, at a place.
    Add {
        /// What it is called; no other object is.
        object: String,
        /// The place.
        place: String,
    },
    /// An object is not there any more.
    Remove {
        /// The object.
        object: String,
    },
}

/// Tells it to the daemon of the instance, and what came of it.
pub fn world(args: &WorldArgs) -> Result<Exit> {
    let request = match &args.change {
        ChangeArgs::Set { fact } => Request::World(WorldChange::Fact { fact: fact.clone(), holds: true }),
        ChangeArgs::Clear { fact } => Request::World(WorldChange::Fact { fact: fact.clone(), holds: false }),
        ChangeArgs::Move { object, place } => {
            Request::World(WorldChange::Place { object: object.clone(), place: place.clone() })
        }
        ChangeArgs::Block { at, size, heading } => {
            Request::World(WorldChange::Block { at: *at, size: *size, heading: heading.to_radians() })
        }
        ChangeArgs::Unblock { at } => Request::World(WorldChange::Unblock { at: *at }),
        ChangeArgs::Add { object, place } => {
            Request::Work(Work::AddObject { object: object.clone(), place: place.clone() })
        }
        ChangeArgs::Remove { object } => Request::Work(Work::RemoveObject { object: object.clone() }),
    };
    asking::tell(&args.ask, &request)
}

/// Two numbers.
fn pair(written: &str) -> std::result::Result<[f64; 2], String> {
    let found = written.split_once(',').and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    found.ok_or_else(|| "two numbers such as 1.5,-2".to_owned())
}
