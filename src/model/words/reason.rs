//! Why a behavior does not run: a closed list, each with its sentence.

use serde::{Deserialize, Serialize};

use super::{
    ChannelId, Clash, Deadlock, FactId, Fault, Hold, Loss, Misheld, Names, NodeId, ObjectId, PlaceId, Request,
    ResourceId, TypeId, reach,
};

/// Why a request was refused or not made. It speaks of the behavior that it is said of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Its goal is met already.
    Satisfied,
    /// Somebody holds the resource in a way that does not fit.
    Held {
        /// The first claimed one that is held.
        resource: ResourceId,
        /// Who holds it.
        by: NodeId,
        /// For what, where it is shared.
        channel: Option<ChannelId>,
    },
    /// Every resource of the type is held or full.
    NoneFree {
        /// None of its resources would serve.
        of: TypeId,
    },
    /// It claims more of a type at once than it can get.
    TooFew {
        /// None of the others would serve.
        of: TypeId,
        /// How many of its claims want one.
        wanted: u32,
        /// How many there are for them.
        free: u32,
    },
    /// The robot has no resource of the type.
    Missing {
        /// It is in no robot file.
        of: TypeId,
    },
    /// No empty resource reaches the object.
    OutOfReach {
        /// What is to be reached from where the robot stands.
        object: ObjectId,
    },
    /// Nothing that could do it reaches the object, or where it is to be put, from any stand.
    Unreachable {
        /// What is to be taken or put down.
        object: ObjectId,
        /// Where it is to be put; none where it is to be taken.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        place: Option<PlaceId>,
        /// Whether there are stands from which it would be reached, and no path leads to any of them.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        is_shut: bool,
    },
    /// There is nowhere to put something down from where the robot stands.
    NoSpot {
        /// Where it is to be put down.
        place: PlaceId,
        /// Whether there are some within reach, each of them taken.
        is_taken: bool,
    },
    /// What could take the object does not reach where it is to be put later.
    OutOfReachLater {
        /// What is to be taken.
        object: ObjectId,
        /// The behavior that is to put it there.
        by: NodeId,
    },
    /// The object is in no gripper of its own line.
    NotHeld {
        /// What is needed and in no gripper of the line.
        object: ObjectId,
    },
    /// It is not held as it must be for what it needs, or for what it does.
    Misheld(Misheld),
    /// The object is in a gripper already.
    Taken {
        /// What somebody was faster with.
        object: ObjectId,
        /// The gripper that has it.
        by: ResourceId,
    },
    /// The object is not at the place.
    Elsewhere {
        /// What is missed.
        object: ObjectId,
        /// Where it should be.
        place: PlaceId,
    },
    /// The object lies at no place that anybody knows of.
    Nowhere {
        /// What is missed.
        object: ObjectId,
    },
    /// The base does not stand at the place.
    NotAt {
        /// Where the base should stand.
        place: PlaceId,
    },
    /// The base is driving.
    Driving {
        /// Who drives it.
        by: NodeId,
    },
    /// No free path leads to the place.
    NoPath {
        /// Where the base is to go.
        place: PlaceId,
    },
    /// Something came to stand where the base was driving.
    InTheWay {
        /// Where it was going.
        place: PlaceId,
    },
    /// A search that is bounded in work found no free path to the place, which does not mean that there is none.
    PathNotFound {
        /// Where the base is to go.
        place: PlaceId,
        /// How much work it was: boxes held against legs, mostly.
        steps: u32,
    },
    /// A fact is not as it must be.
    Fact {
        /// Its name in the mission.
        fact: FactId,
        /// What it must be.
        holds: bool,
    },
    /// The controller of what it needs is away.
    Unavailable {
        /// The first such resource.
        resource: ResourceId,
        /// How the controller came to be away.
        why: Loss,
    },
    /// The controller of what it needs would not do it, for reach or kind, and nothing has changed since.
    Unfit {
        /// The resource.
        resource: ResourceId,
    },
    /// It failed, and waits before it asks again.
    BackingOff {
        /// How long, milliseconds of robot time.
        wait_ms: u64,
        /// How it failed.
        fault: Fault,
    },
    /// Its potential is 0 whatever happens: it is never to be asked for.
    Unwanted,
    /// Its potential is 0: nothing of the type would be available to it there.
    NothingAvailable {
        /// The one that scales the potential.
        of: TypeId,
    },
    /// It was done for another behavior, which still lacks something.
    AlreadyDone {
        /// What it was done for.
        heir: NodeId,
        /// What that one lacks.
        lacks: Box<Reason>,
    },
    /// A request with greater potential took the resource (Algorithm 1).
    Outbid {
        /// The other request's behavior.
        by: NodeId,
        /// What both want.
        resource: ResourceId,
        /// Its own potential.
        own: f64,
        /// The other's.
        theirs: f64,
    },
    /// A more urgent request took the resource.
    LessUrgent {
        /// The other request's behavior.
        by: NodeId,
        /// What both want.
        resource: ResourceId,
        /// How urgent it is itself.
        own: i32,
        /// How urgent the other is.
        theirs: i32,
    },
    /// A request of work that has been done fewer times took the resource.
    DoneOftener {
        /// The other request's behavior.
        by: NodeId,
        /// What both want.
        resource: ResourceId,
        /// How often its own work has been done.
        own: u32,
        /// How often the other's.
        theirs: u32,
    },
    /// A request with greater potential was passed on instead, and was not granted either.
    Outdone {
        /// The other request's behavior.
        by: NodeId,
    },
    /// Another behavior changes the same object.
    SameObject {
        /// What both would change.
        object: ObjectId,
        /// The other behavior.
        with: NodeId,
    },
    /// The two would be in each other's way.
    Clash {
        /// The other behavior.
        with: NodeId,
        /// What of them would.
        #[serde(default)]
        over: Clash,
    },
    /// An OR above chose another way.
    Alternative {
        /// The child it chose.
        chosen: NodeId,
    },
    /// One behavior at a time, and another was chosen (serial).
    WholeRobot {
        /// The other behavior.
        by: NodeId,
    },
    /// It could be granted, and then something could never be finished (`semantics` 4, "No deadlock").
    WouldDeadlock {
        /// Who would wait for whom.
        deadlock: Box<Deadlock>,
    },
    /// Its turn comes after another node.
    NotItsTurn {
        /// The node before it.
        after: NodeId,
    },
    /// A node above fails and is waiting for what still runs.
    Ending {
        /// The child that failed.
        failed: NodeId,
    },
    /// A more urgent behavior waits for what it needs.
    Reserved {
        /// What both need; none where it is an object that both change.
        resource: Option<ResourceId>,
        /// The other behavior.
        by: NodeId,
    },
    /// A task that came before has waited for so long that it is its turn.
    TooEarly {
        /// That task.
        task: NodeId,
    },
    /// The next time of a node above that repeats has not come.
    NotYet {
        /// The node.
        node: NodeId,
        /// How long after the last time ended, milliseconds of robot time.
        wait_ms: u64,
    },
    /// A node above is given up, or an OR leaves the way: nothing but cleanups begins there.
    GivenUp {
        /// The node.
        node: NodeId,
    },
    /// A node above took too long and is waiting for what still runs.
    OutOfTime {
        /// That node.
        node: NodeId,
    },
}

impl Hold {
    /// Why it is not so, when so many of the own line hold it that count.
    pub fn reason(self, found: u32) -> Reason {
        let object = self.object;
        if self == Self::from(object) {
            Reason::NotHeld { object }
        } else {
            Reason::Misheld(Misheld::NotSo { hold: self, found })
        }
    }
}

/// A leaf and why it does not run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Blocked {
    /// The behavior that does not run.
    pub leaf: NodeId,
    /// What keeps it.
    pub reason: Reason,
}

impl Reason {
    /// Why a request does not get a resource that another one takes, which comes before it.
    pub fn outbid(own: &Request, resource: ResourceId, other: &Request) -> Self {
        let by = other.leaf;
        if own.priority < other.priority {
            Self::LessUrgent { by, resource, own: own.priority, theirs: other.priority }
        } else if own.priority == other.priority && own.iterations > other.iterations {
            Self::DoneOftener { by, resource, own: own.iterations, theirs: other.iterations }
        } else {
            Self::Outbid { by, resource, own: own.potential, theirs: other.potential }
        }
    }

    /// The reason as a sentence about the behavior, without its name: "`left_gripper` is held by pick 1".
    pub fn sentence(&self, names: &Names) -> String {
        match self {
            Self::Satisfied => "its goal is met already".into(),
            Self::Held { resource, by, channel: None } => {
                format!("{} is held by {}", names.resource(*resource), names.node(*by))
            }
            Self::Held { resource, by, channel: Some(channel) } => {
                format!(
                    "{} is held by {} for \"{}\"",
                    names.resource(*resource),
                    names.node(*by),
                    names.channel(*channel)
                )
            }
            Self::NoneFree { of } => format!("every {} is held or full", names.ty(*of)),
            Self::Unavailable { resource, why } => {
                format!("{} is unavailable ({})", names.resource(*resource), away(*why))
            }
            Self::Unfit { resource } => format!("{} has refused to do it", names.resource(*resource)),
            Self::BackingOff { wait_ms, fault } => {
                format!("it waits {} s after failing: {}", *wait_ms as f64 / 1e3, fault.sentence(names))
            }
            Self::TooFew { of, wanted, free } => format!("needs {wanted} {}s, {free} free", names.ty(*of)),
            Self::Missing { of } => format!("the robot has no {}", names.ty(*of)),
            Self::OutOfReach { object } => format!("no free resource reaches {}", names.thing(*object)),
            Self::OutOfReachLater { object, by } => {
                let object = names.thing(*object);
                format!("nothing that could take {object} reaches what {} asks of it later", names.node(*by))
            }
            Self::Unreachable { object, place, is_shut } => reach::unreachable(names, *object, *place, *is_shut),
            Self::NoSpot { place, is_taken } => reach::no_spot(names.place(*place), *is_taken),
            Self::NotHeld { object } => format!("{} is not held by this branch of the task", names.thing(*object)),
            Self::Taken { object, by } => format!("{} is in {} already", names.thing(*object), names.resource(*by)),
            Self::Misheld(misheld) => misheld.sentence(names),
            Self::Elsewhere { object, place } => format!("{} is not at {}", names.thing(*object), names.place(*place)),
            Self::Nowhere { object } => format!("nobody knows where {} is", names.thing(*object)),
            Self::NotAt { place } => format!("the base does not stand at {}", names.place(*place)),
            Self::Driving { by } => format!("the base is being driven by {}", names.node(*by)),
            Self::NoPath { place } => format!("no free path leads to {}", names.place(*place)),
            Self::InTheWay { place } => format!("something came to stand in the way to {}", names.place(*place)),
            Self::PathNotFound { place, steps } => {
                format!("no free path to {} was found within {steps} steps of search", names.place(*place))
            }
            Self::Fact { fact, holds } => {
                format!("\"{}\" {}", names.fact(*fact), if *holds { "does not hold" } else { "holds" })
            }
            Self::Unwanted => "its potential is 0, which means that it is not to run".into(),
            Self::NothingAvailable { of } => format!("no {} would be available to it there", names.ty(*of)),
            Self::AlreadyDone { heir, lacks } => {
                format!("already done for {}, which still lacks: {}", names.node(*heir), lacks.sentence(names))
            }
            Self::Outbid { .. }
            | Self::LessUrgent { .. }
            | Self::DoneOftener { .. }
            | Self::Outdone { .. }
            | Self::SameObject { .. }
            | Self::Clash { .. }
            | Self::Alternative { .. }
            | Self::WholeRobot { .. }
            | Self::WouldDeadlock { .. }
            | Self::NotItsTurn { .. }
            | Self::Ending { .. }
            | Self::Reserved { .. }
            | Self::TooEarly { .. }
            | Self::NotYet { .. }
            | Self::GivenUp { .. }
            | Self::OutOfTime { .. } => self.of_order(names),
        }
    }

    /// The same where others come before it, or its turn is not now.
    fn of_order(&self, names: &Names) -> String {
        if let Self::Outbid { by, resource, own, theirs } = self {
            format!("outbid by {} for {} ({theirs:.3} against {own:.3})", names.node(*by), names.resource(*resource))
        } else if let Self::LessUrgent { by, resource, own, theirs } = self {
            format!(
                "{} is more urgent and takes {} (priority {theirs} against {own})",
                names.node(*by),
                names.resource(*resource)
            )
        } else if let Self::DoneOftener { by, resource, own, theirs } = self {
            format!(
                "{} comes first for {}: it has been done {theirs} times, this one {own} times",
                names.node(*by),
                names.resource(*resource)
            )
        } else if let Self::Outdone { by } = self {
            format!("{} was asked for instead, and did not get what it needs", names.node(*by))
        } else if let Self::SameObject { object, with } = self {
            format!("{} changes {} too", names.node(*with), names.thing(*object))
        } else if let Self::Clash { with, over } = self {
            over.sentence(names.node(*with))
        } else if let Self::Alternative { chosen } = self {
            format!("{} was chosen instead", names.node(*chosen))
        } else if let Self::WholeRobot { by } = self {
            format!("one behavior at a time, and {} has the robot", names.node(*by))
        } else if let Self::WouldDeadlock { deadlock } = self {
            format!("would deadlock: {}", deadlock.sentence(names))
        } else if let Self::NotItsTurn { after } = self {
            format!("its turn comes after {}", names.node(*after))
        } else if let Self::Ending { failed } = self {
            format!("{} failed; its siblings are being canceled", names.node(*failed))
        } else if let Self::Reserved { resource: Some(resource), by } = self {
            format!("{} is reserved for {}", names.resource(*resource), names.node(*by))
        } else if let Self::Reserved { resource: None, by } = self {
            format!("{} comes first, which changes the same", names.node(*by))
        } else if let Self::TooEarly { task } = self {
            format!("{} has waited longer, and it is its turn", names.node(*task))
        } else if let Self::NotYet { node, wait_ms } = self {
            format!("{} is not due again before {} s have passed", names.node(*node), *wait_ms as f64 / 1e3)
        } else if let Self::GivenUp { node } = self {
            format!("{} is given up; what runs below it is being canceled", names.node(*node))
        } else if let Self::OutOfTime { node } = self {
            format!("{} took too long; what runs below it is being canceled", names.node(*node))
        } else {
            String::new()
        }
    }

    /// Whether it is about somebody who has what it wants, and so may pass.
    pub fn is_of_resources(&self) -> bool {
        matches!(
            self,
            Self::Held { .. }
                | Self::NoneFree { .. }
                | Self::TooFew { .. }
                | Self::OutOfReach { .. }
                | Self::SameObject { .. }
        )
    }

    /// Whether it is why nothing goes on: whose goal is met, or whose turn comes after others, only goes with them.
    pub fn is_telling(&self) -> bool {
        !matches!(self, Self::Satisfied | Self::NotItsTurn { .. })
    }

    /// Whether others are what it waits for: they have what it wants, or came before it.
    pub fn is_of_others(&self) -> bool {
        self.is_of_resources()
            || matches!(
                self,
                Self::NothingAvailable { .. }
                    | Self::Outbid { .. }
                    | Self::LessUrgent { .. }
                    | Self::DoneOftener { .. }
                    | Self::Outdone { .. }
                    | Self::Reserved { .. }
                    | Self::Clash { .. }
                    | Self::WholeRobot { .. }
                    | Self::TooEarly { .. }
                    | Self::Driving { .. }
            )
    }

    /// What an "already done" is about in the end.
    pub fn root_cause(&self) -> &Self {
        match self {
            Self::AlreadyDone { lacks, .. } => lacks.root_cause(),
            other => other,
        }
    }
}
/// How a controller is away, within a sentence.
fn away(why: Loss) -> String {
    match why {
        Loss::Inhibited(why) => format!("its controller is inhibited: {why}"),
        Loss::Ended
        | Loss::Silent
        | Loss::Left { .. }
        | Loss::Unanswered
        | Loss::Broken
        | Loss::Hung
        | Loss::HoldsUnknown => {
            format!("its controller: {why}")
        }
    }
}
