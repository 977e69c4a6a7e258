//! Between what is asked by names and what root decides by ids.

use ambidex_model::{Change, Location, MissionSpec, Names, Objection, Uptake, suggestion};

use super::protocol::{Answer, Request, Why, WorldChange, read_request};

/// The change that a line of a client asks for in a mission with such names.
///
/// # Errors
/// The answer to what asks for none that the mission knows.
pub fn asked(line: &[u8], names: &Names) -> Result<Change, Answer> {
    match read_request(line)? {
        Request::World(asked) => change(&asked, names),
    }
}

/// The change that is asked for.
///
/// # Errors
/// The answer, where the mission has no such thing.
fn change(asked: &WorldChange, names: &Names) -> Result<Change, Answer> {
    let fact = |name: &str| find("fact", name, &names.facts).map(Into::into);
    Ok(match asked {
        WorldChange::Set(name) => Change::Fact(fact(name)?, true),
        WorldChange::Clear(name) => Change::Fact(fact(name)?, false),
        WorldChange::Move { object, to } => {
            let object = find("object", object, &names.objects)?;
            Change::Object(object.into(), Location::At(find("place", to, &names.places)?.into()))
        }
    })
}

/// What root made of it, in words.
pub(super) fn answer(change: &Change, uptake: Uptake, mission: &MissionSpec) -> Answer {
    let names = &mission.names;
    match uptake {
        Uptake::Changed => Answer::Changed { said: state(change, "now", names) },
        Uptake::Same => Answer::Same { said: state(change, "already", names) },
        Uptake::Refused(objection) => Answer::Refused {
            why: why(objection),
            said: objection.sentence(change, names),
            help: help(change, objection, mission),
        },
    }
}

/// That a run ended before root could decide.
pub(super) fn over() -> Answer {
    Answer::Refused { why: Why::Over, said: "the mission is over".into(), help: None }
}

fn find(what: &str, name: &str, names: &[String]) -> Result<usize, Answer> {
    names.iter().position(|known| known == name).ok_or_else(|| Answer::Refused {
        why: Why::NoSuchName,
        said: format!("the mission has no {what} `{}`", beginning(name)),
        help: Some(suggestion(beginning(name), what, names.iter().map(String::as_str))),
    })
}

/// No name is longer than that, and an answer has to fit into a line.
fn beginning(name: &str) -> &str {
    const MOST: usize = 64;
    &name[..name.floor_char_boundary(MOST)]
}

fn state(change: &Change, when: &str, names: &Names) -> String {
    match *change {
        Change::Fact(fact, true) => format!("\"{}\" holds {when}", names.fact(fact)),
        Change::Fact(fact, false) if when == "now" => format!("\"{}\" holds no more", names.fact(fact)),
        Change::Fact(fact, false) => format!("\"{}\" does not hold {when}", names.fact(fact)),
        Change::Object(object, Location::At(place)) => {
            format!("{} is at {} {when}", names.thing(object), names.place(place))
        }
        Change::Object(object, Location::In(_) | Location::Unknown) => {
            format!("nobody knows where {} is {when}", names.thing(object))
        }
        Change::Base(_) | Change::Taken(..) | Change::Emptied(_) => format!("it is so {when}"),
    }
}

fn why(objection: Objection) -> Why {
    match objection {
        Objection::NotOutside => Why::NotOutside,
        Objection::Held { .. } => Why::Held,
        Objection::NotTheirs => Why::NotTheirs,
        Objection::NotBegun => Why::NotBegun,
        Objection::Over => Why::Over,
    }
}

fn help(change: &Change, objection: Objection, mission: &MissionSpec) -> Option<String> {
    match (objection, change) {
        (Objection::NotOutside, Change::Fact(fact, _)) => {
            let holds = mission.start.facts.get(fact.index()).copied().unwrap_or_default();
            let name = mission.names.fact(*fact);
            Some(format!("declare it in the mission: `facts: {{{name}: {{holds: {holds}, outside: true}}}}`"))
        }
        (Objection::Held { .. }, _) => Some("what is in a gripper moves only by the word of its controller".into()),
        (Objection::NotOutside | Objection::NotTheirs | Objection::NotBegun | Objection::Over, _) => None,
    }
}
