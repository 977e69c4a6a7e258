//! Values of records as text, for the fields of events and for lines that people read; written only when it is formatted.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use ambidex_model::{
    Access, Binding, Blocked, Change, Command, CommandId, End, Fault, Location, Names, NodeId, PartEnd, Reason, Request,
};

/// Text made when it is asked for.
pub fn lazy(write: impl Fn(&mut Formatter<'_>) -> fmt::Result) -> impl Display {
    struct Lazy<F>(F);
    impl<F: Fn(&mut Formatter<'_>) -> fmt::Result> Display for Lazy<F> {
        fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
            (self.0)(f)
        }
    }
    Lazy(write)
}

/// Things with commas between them.
fn list<T>(
    things: impl Iterator<Item = T>,
    f: &mut Formatter<'_>,
    write: impl Fn(T, &mut Formatter<'_>) -> fmt::Result,
) -> fmt::Result {
    for (index, thing) in things.enumerate() {
        f.write_str(if index == 0 { "" } else { ", " })?;
        write(thing, f)?;
    }
    Ok(())
}

/// Names of nodes with commas between them.
pub fn nodes(nodes: impl Iterator<Item = NodeId> + Clone, names: &Names) -> impl Display {
    lazy(move |f| list(nodes.clone(), f, |node, f| f.write_str(names.node(node))))
}

/// A reason as its sentence.
pub fn reason(reason: &Reason, names: &Names) -> impl Display {
    lazy(move |f| f.write_str(&reason.sentence(names)))
}

/// The reason of one leaf as its sentence, those of several with their names.
pub fn reasons(blocked: &[Blocked], names: &Names) -> impl Display {
    lazy(move |f| match blocked {
        [one] => f.write_str(&one.reason.sentence(names)),
        many => list(many.iter(), f, |blocked, f| {
            let sentence = blocked.reason.sentence(names);
            write!(f, "{}: {sentence}", names.node(blocked.leaf))
        }),
    })
}

/// The claims of a request: `base for "at shelf", left_gripper or right_gripper alone`.
pub fn claims(request: &Request, names: &Names) -> impl Display {
    lazy(move |f| {
        list(request.claims.iter(), f, |need, f| {
            for (index, candidate) in need.candidates.iter().enumerate() {
                f.write_str(if index == 0 { "" } else { " or " })?;
                f.write_str(names.resource(candidate.resource))?;
            }
            access(need.access, names, f)
        })
    })
}

/// The resources of a grant: `base for "at shelf", left_gripper alone`.
pub fn bindings(bindings: &[Binding], names: &Names) -> impl Display {
    lazy(move |f| {
        list(bindings.iter(), f, |binding, f| {
            f.write_str(names.resource(binding.resource))?;
            access(binding.access, names, f)
        })
    })
}

fn access(access: Access, names: &Names, f: &mut Formatter<'_>) -> fmt::Result {
    match access {
        Access::Exclusive => f.write_str(" alone"),
        Access::Shared(channel) => write!(f, " for \"{}\"", names.channel(channel)),
    }
}

/// Nodes that a request skips: composites and leaves.
pub fn skips(request: &Request, names: &Names) -> impl Display {
    let of = names.nodes.len();
    nodes(request.skips.iter().flat_map(move |skip| skip.nodes(of)), names)
}

/// Changes of the world.
pub fn changes(changes: &[Change], names: &Names) -> impl Display {
    lazy(move |f| {
        list(changes.iter(), f, |change, f| match change {
            Change::Base(pose) => {
                let (at, heading) = (pose.at, pose.heading);
                write!(f, "base at ({:.2}, {:.2}, {heading:.2})", at.x, at.y)
            }
            Change::Object(object, at) => {
                let object = names.thing(*object);
                match at {
                    Location::At(place) => write!(f, "{object} at {}", names.place(*place)),
                    Location::In(holders) => {
                        write!(f, "{object} in ")?;
                        list(holders.as_slice().iter(), f, |holder, f| f.write_str(names.resource(*holder)))
                    }
                    Location::Unknown => write!(f, "{object} nobody knows where"),
                }
            }
            Change::Laid(object, place, spot) => {
                let (object, place) = (names.thing(*object), names.place(*place));
                write!(f, "{object} at {place}, spot {}", spot.0)
            }
            Change::Taken(object, resource) => {
                write!(f, "{} in {}", names.thing(*object), names.resource(*resource))
            }
            Change::Blocked(obstacle) => {
                write!(f, "something at ({:.2}, {:.2})", obstacle.middle.x, obstacle.middle.y)
            }
            Change::Cleared(around) => write!(f, "nothing at ({:.2}, {:.2})", around.at.x, around.at.y),
            Change::Emptied(resource) => write!(f, "{} is empty", names.resource(*resource)),
            Change::Fact(fact, true) => write!(f, "\"{}\" holds", names.fact(*fact)),
            Change::Fact(fact, false) => write!(f, "\"{}\" does not hold", names.fact(*fact)),
        })
    })
}

/// A command with its object, lengths in meters.
pub fn command(command: &Command, names: &Names) -> impl Display {
    lazy(move |f| match command {
        Command::Drive { path, .. } => match path.last() {
            Some(goal) => write!(f, "drive to ({:.2}, {:.2})", goal.at.x, goal.at.y),
            None => f.write_str("drive nowhere"),
        },
        Command::Stand => f.write_str("stand"),
        Command::Grasp { object, holder: Some(holder), .. } => {
            write!(f, "grasp {} from {}", names.thing(*object), names.resource(*holder))
        }
        Command::Grasp { object, holder: None, .. } => write!(f, "grasp {}", names.thing(*object)),
        Command::Put { object, holder: Some(holder), .. } => {
            write!(f, "put {} into {}", names.thing(*object), names.resource(*holder))
        }
        Command::Put { object, holder: None, .. } => write!(f, "put {}", names.thing(*object)),
        Command::Look { at, .. } => write!(f, "look at ({:.2}, {:.2}, {:.2})", at.x, at.y, at.z),
        Command::Call(call) => write!(f, "call {call}"),
    })
}

/// How a command ended.
pub fn part_end(end: PartEnd) -> &'static str {
    match end {
        PartEnd::Succeeded => "succeeded",
        PartEnd::Aborted => "aborted",
        PartEnd::Canceled => "canceled",
        PartEnd::Inhibited(_) => "inhibited",
    }
}

/// Identity of a command: generation and number.
pub fn goal(id: CommandId) -> impl Display {
    lazy(move |f| write!(f, "{}.{}", id.generation, id.number))
}

/// How a goal ended.
pub fn end(end: End) -> &'static str {
    match end {
        End::Succeeded => "succeeded",
        End::Canceled => "canceled",
        End::Interrupted => "interrupted",
        End::Failed(Fault::Rejected(..)) => "failed: rejected",
        End::Failed(Fault::Refused(..)) => "failed: refused",
        End::Failed(Fault::Unanswered(_)) => "failed: unanswered",
        End::Failed(Fault::Aborted(_)) => "failed: aborted",
        End::Failed(Fault::NotMaintained(_)) => "failed: not maintained",
        End::Failed(Fault::Contradicted(_)) => "failed: contradicted",
        End::Failed(Fault::TimedOut) => "failed: timed out",
        End::Failed(Fault::Blocked) => "failed: blocked",
        End::Failed(Fault::Lost(_)) => "failed: lost",
    }
}

/// The controller at which a goal failed.
pub fn at_fault(end: End, names: &Names) -> Option<&str> {
    end.at_fault().map(|controller| names.controller(controller))
}

/// The journal's word for a value that has no fields: `succeeded`, `maintain`.
pub fn word(value: impl Serialize) -> impl Display {
    lazy(move |f| value.serialize(f))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ambidex_model::{Mode, PartEnd, Record, Rejection, Time};

    #[test]
    fn words_are_those_of_the_journal() {
        let check = |word: String, expected: &str| assert_eq!(word, expected);
        check(part_end(PartEnd::Canceled).to_string(), "canceled");
        check(word(Mode::Maintain).to_string(), "maintain");
        check(word(Rejection::OutOfReach).to_string(), "out_of_reach");
    }

    /// Logs of before names and inhibited controllers are read as ever, and what has no place tells none.
    #[test]
    fn what_older_logs_lack_is_none() {
        let look = r#"{"look":{"at":[0.5,0.0,0.75]}}"#;
        let read: Command = serde_json::from_str(look).expect("a command");
        assert!(matches!(read, Command::Look { place: None, .. }));
        assert_eq!(serde_json::to_string(&read).expect("text"), look);
        let awaited = r#"{"record":"awaited","at":5,"until":7}"#;
        let read: Record = serde_json::from_str(awaited).expect("a record");
        assert_eq!(read, Record::Awaited { at: Time(5), until: Some(Time(7)), facts: Vec::new(), places: Vec::new() });
    }
}
