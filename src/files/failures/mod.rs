//! A failure file: what goes wrong on purpose, as it is written, and for a mission that has all that it names.

mod written;

use std::collections::BTreeMap;
use std::time::Duration;

use crate::describe::{Count, Custom, Described, Flag, List, Map, Reads, Word, described};
use crate::fault::Faults;
use crate::names::Register;
use crate::quantity::DURATION;
use crate::reader::{Item, Name};
use crate::room::{OBSTACLE, ON_THE_MAP};
use crate::shape::Form;
pub use written::failures_text;
use written::word;

use ambidex_model::{
    Change, ControllerId, Disk, Failures, Flaw, FlawKind, Location, Mishap, MissionSpec, NodeId, Obstacle, Pose, Time,
    nearest,
};

/// The key of all that goes wrong.
pub(crate) const FAILURES: &str = "failures";

const BEHAVIOR: &str = "behavior";
const ALL: &str = "all";
const ABORTED: [&str; 1] = ["aborted"];
const EVERY: [&str; 1] = ["every"];
const DISKS: [&str; 3] = ["full", "slow", "well"];
/// Latest attempt that can be meant: retries are at most 1000.
const MAX_ATTEMPT: u32 = 1001;

described! {
    /// A failure file.
    pub(crate) struct FailureFile: "a failure file",
    "What goes wrong on purpose: `simulate MISSION --fail FILE`, and `run` with the same." {
        failures: Option<Vec<Entry>> =
            wanted(FAILURES, "All that goes wrong, in any order.", List("a list of what goes wrong", ENTRY)),
    }
}

/// An entry of `failures`.
#[derive(Debug)]
pub(crate) enum Entry {
    Mishap(MishapTerm),
    Flaw(FlawTerm),
}

described! {
    /// Something that happens at a moment.
    pub(crate) struct MishapTerm: "a mishap", "Something that happens to the robot or the world at a moment." {
        at_s: f64 = required("at", "When, since the mission began.", &DURATION),
        event: Event = one(Event),
    }
}

described! {
    /// What happens.
    pub(crate) enum Event: "a mishap", "What happens." {
        Lose(Name) = ("lose", "The process of this controller ends.", CONTROLLER),
        Hang(Name) = ("hang", "This controller is there and does nothing any more.", CONTROLLER),
        Inhibit(Name) = (
            "inhibit",
            "The emergency stop of this controller is pressed: it lives, and may not move.",
            CONTROLLER
        ),
        Return(Name) = (
            "return",
            "This controller, which was lost, hung or inhibited, is there again and may move.",
            CONTROLLER
        ),
        Set(Name) = ("set", "The fact holds from now on.", Word("a fact")),
        Clear(Name) = ("clear", "The fact does not hold any more.", Word("a fact")),
        Disk(Disk) = (
            "disk",
            "What the disk of the log does from then on: it is `full`, each write takes half a second (`slow`), or `well`.",
            DISK
        ),
        Cancel(()) = ("cancel", "`true`: the mission is told to end, as by Ctrl-C.", HAPPENS),
        Lies(ObjectAt) = ("lies", "Somebody has laid the object there.", Map::<ObjectAt>::new()),
        Block(Obstacle) = ("block", "Something has come to stand there, which the base must not drive into.", OBSTACLE),
        Unblock([f64; 2]) = ("unblock", "What came to stand around that point is gone.", ON_THE_MAP),
    }
}

described! {
    /// `lies`.
    pub(crate) struct ObjectAt: "an object at a place", "An object and a place." {
        object: Name = required("object", "The object.", Word("an object")),
        place: Name = required("at", "The place.", Word("a place")),
    }
}

described! {
    /// What a behavior does wrong.
    pub(crate) struct FlawTerm: "a flaw", "What a behavior does wrong." {
        behavior: Name = required(BEHAVIOR, "The name of its node.", Word("the name of a behavior")),
        attempt: Attempt = or(
            "attempt",
            "In which of its attempts, counted from 1, or `every`; the first.",
            ATTEMPT,
            Attempt(Some(1))
        ),
        wrong: Wrong = one(Wrong),
    }
}

/// Which attempt is meant; none is every one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Attempt(Option<u32>);

described! {
    /// What goes wrong in a behavior.
    pub(crate) enum Wrong: "a flaw", "What goes wrong." {
        Fails(()) = ("fails", "`aborted`: a controller gives up at the end of what it does.", GIVES_UP),
        Hangs(()) = ("hangs", "`true`: it never ends by itself, so that its timeout comes.", HAPPENS),
        Late(f64) = ("late", "It takes at least so much longer than it needs, such as `3 s`.", &DURATION),
        Drops(Name) = (
            "drops",
            "As it begins, a gripper loses this object, or `all`: what its grippers hold, or the robot's if it uses \
             none. It lies at the nearest place, and the behavior goes on.",
            Word("an object, or `all`")
        ),
    }
}

const CONTROLLER: Word = Word("a controller");

/// An entry, which its keys tell apart.
const ENTRY: Custom<Entry> = Custom(
    || Form::Either(vec![Form::Map(MishapTerm::shape), Form::Map(FlawTerm::shape)]),
    |item, reading| {
        if is_of_behavior(&item) {
            FlawTerm::read(item, reading).map(Entry::Flaw)
        } else {
            MishapTerm::read(item, reading).map(Entry::Mishap)
        }
    },
);

const ATTEMPT: Custom<Attempt> = Custom(
    || Form::Either(vec![Count(MAX_ATTEMPT).form(), Form::Words(&EVERY)]),
    |item, reading| {
        if item.text().is_some_and(|text| EVERY.contains(&text)) {
            return Some(Attempt(None));
        }
        match item.text().and_then(|text| text.parse().ok()) {
            Some(number @ 1..=MAX_ATTEMPT) => Some(Attempt(Some(number))),
            Some(_) | None => {
                item.wrong(&format!("a whole number from 1 to {MAX_ATTEMPT}, or `every`"), reading.faults);
                None
            }
        }
    },
);

const DISK: Custom<Disk> = Custom(
    || Form::Words(&DISKS),
    |item, reading| {
        let found = item.word(&DISKS, "what a disk does", reading.faults)?;
        [Disk::Full, Disk::Slow, Disk::Well].into_iter().find(|disk| word(*disk) == found)
    },
);

const GIVES_UP: Custom<()> =
    Custom(|| Form::Words(&ABORTED), |item, reading| item.word(&ABORTED, "`aborted`", reading.faults).map(|_| ()));

const HAPPENS: Custom<()> = Custom(
    || Form::Flag,
    |item, reading| {
        let happens = Flag.read(item, reading)?;
        if !happens {
            reading.faults.push_with(&item, "a flaw that does not happen", "write `true`, or leave the entry out");
        }
        happens.then_some(())
    },
);

/// Whether an entry is about a behavior; one whose keys are all misspelt is what they are nearest to.
fn is_of_behavior(item: &Item<'_>) -> bool {
    let (mishap, flaw) = (MishapTerm::shape(), FlawTerm::shape());
    if item.value_of(BEHAVIOR).is_some() {
        return true;
    }
    let is_of = |key: &str| match (mishap.allows(key), flaw.allows(key)) {
        (true, _) => false,
        (false, true) => true,
        (false, false) => nearest(key, mishap.keys().chain(flaw.keys())).is_some_and(|near| flaw.allows(near)),
    };
    item.keys().any(is_of) && !item.keys().any(|key| mishap.allows(key))
}

/// The failures of a mission; `None` where a name is not of it, or what happens cannot.
pub(crate) fn build(file: FailureFile, mission: &MissionSpec, faults: &mut Faults) -> Option<Failures> {
    let (mut mishaps, mut flaws) = (Vec::new(), Vec::new());
    for entry in file.failures? {
        match entry {
            Entry::Mishap(term) => mishaps.push(term),
            Entry::Flaw(term) => flaws.push(term),
        }
    }
    let names = Names::of(mission);
    mishaps.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
    let mut lives = BTreeMap::new();
    let mishaps = mishaps.iter().map(|term| names.mishap(term, &mut lives, faults)).collect::<Vec<_>>();
    let mut ends = Vec::new();
    let flaws = flaws.iter().map(|term| names.flaw(term, &mut ends, faults)).collect::<Vec<_>>();
    let (mishaps, flaws): (Option<Vec<_>>, Option<Vec<_>>) =
        (mishaps.into_iter().collect(), flaws.into_iter().collect());
    Some(Failures { mishaps: mishaps?, flaws: flaws? })
}

/// What became of a controller, and when.
#[derive(Debug, Clone, Copy)]
struct Away {
    word: &'static str,
    is_lost: bool,
    since_s: f64,
}

/// Everything that a failure can name.
struct Names<'a> {
    mission: &'a MissionSpec,
    controllers: Register,
    behaviors: Register,
    leaves: Vec<NodeId>,
    objects: Register,
    places: Register,
    facts: Register,
}

impl<'a> Names<'a> {
    fn of(mission: &'a MissionSpec) -> Self {
        let register = |what, names: &[String]| Register::of(what, names.iter().map(String::as_str));
        let names = &mission.names;
        let leaves: Vec<NodeId> = mission.tree.leaves().collect();
        Self {
            controllers: register("controller", &names.controllers),
            behaviors: Register::of("behavior", leaves.iter().map(|leaf| names.node(*leaf))),
            objects: register("object", &names.objects),
            places: register("place", &names.places),
            facts: register("fact", &names.facts),
            mission,
            leaves,
        }
    }

    fn mishap(
        &self,
        term: &MishapTerm,
        lives: &mut BTreeMap<ControllerId, Away>,
        faults: &mut Faults,
    ) -> Option<(Time, Mishap)> {
        let fact = |name, holds, faults: &mut Faults| {
            let fact = self.facts.find(name, faults)?;
            Some(Mishap::World(Change::Fact(fact.into(), holds)))
        };
        let mishap = match &term.event {
            Event::Lose(name) => Mishap::Lose(self.leaving(name, "lost", term.at_s, lives, faults)?),
            Event::Hang(name) => Mishap::Hang(self.leaving(name, "hung", term.at_s, lives, faults)?),
            Event::Inhibit(name) => Mishap::Inhibit(self.leaving(name, "inhibited", term.at_s, lives, faults)?),
            Event::Return(name) => {
                let id = ControllerId::from(self.controllers.find(name, faults)?);
                if lives.remove(&id).is_none() {
                    let help = "it can return from what `lose`, `hang` or `inhibit` did before";
                    faults.push_with(name, format!("`{}` is there at that moment", name.value), help);
                }
                Mishap::Return(id)
            }
            Event::Cancel(()) => Mishap::Cancel,
            Event::Disk(disk) => Mishap::Disk(*disk),
            Event::Set(name) => fact(name, true, faults)?,
            Event::Clear(name) => fact(name, false, faults)?,
            Event::Block(obstacle) => Mishap::World(Change::Blocked(*obstacle)),
            Event::Unblock([x, y]) => Mishap::World(Change::Cleared(Pose::new(*x, *y, 0.0))),
            Event::Lies(ObjectAt { object, place }) => {
                let (object, place) = (self.objects.find(object, faults), self.places.find(place, faults));
                Mishap::World(Change::Object(object?.into(), Location::At(place?.into())))
            }
        };
        Some((Time((term.at_s * 1e6).round() as u64), mishap))
    }

    /// A controller that goes, hangs or is inhibited, and has not before.
    fn leaving(
        &self,
        name: &Name,
        word: &'static str,
        since_s: f64,
        lives: &mut BTreeMap<ControllerId, Away>,
        faults: &mut Faults,
    ) -> Option<ControllerId> {
        let id = ControllerId::from(self.controllers.find(name, faults)?);
        let is_lost = word == "lost";
        if let Some(before) = lives.insert(id, Away { word, is_lost, since_s })
            && (before.is_lost || !is_lost)
        {
            let message = format!("`{}` is {} since {} s", name.value, before.word, before.since_s);
            faults.push_with(name, message, format!("write `return: {}` at a moment between", name.value));
        }
        Some(id)
    }

    fn flaw(&self, term: &FlawTerm, ends: &mut Vec<(NodeId, Attempt)>, faults: &mut Faults) -> Option<Flaw> {
        let leaf = self.behaviors.find(&term.behavior, faults).map(|index| self.leaves[index]);
        let kind = match &term.wrong {
            Wrong::Fails(()) => FlawKind::Fails,
            Wrong::Hangs(()) => FlawKind::Hangs,
            Wrong::Late(by_s) => FlawKind::Late(Duration::from_secs_f64(*by_s)),
            Wrong::Drops(name) if name.value == ALL && self.objects.id(ALL).is_none() => FlawKind::Drops(None),
            Wrong::Drops(name) => FlawKind::Drops(Some(self.objects.find(name, faults)?.into())),
        };
        let (leaf, attempt) = (leaf?, term.attempt);
        let has_commands = self.mission.tree.behavior(leaf).is_some_and(|spec| !spec.commands.is_empty());
        if kind == FlawKind::Fails && !has_commands {
            let help = "no controller does anything in it; `hangs: true` is possible";
            faults.push_with(&term.behavior, format!("nobody can give up `{}`", term.behavior.value), help);
        }
        if matches!(kind, FlawKind::Fails | FlawKind::Hangs) {
            let is_same = |(other, of): &(NodeId, Attempt)| {
                *other == leaf && (*of == attempt || of.0.is_none() || attempt.0.is_none())
            };
            if ends.iter().any(is_same) {
                let message = format!("an attempt of `{}` ends in one way only", term.behavior.value);
                faults.push_with(
                    &term.behavior,
                    message,
                    "leave out one of `fails` and `hangs`, or name other attempts",
                );
            }
            ends.push((leaf, attempt));
        }
        Some(Flaw { leaf, attempt: attempt.0, kind })
    }
}
