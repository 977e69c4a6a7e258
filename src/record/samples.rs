//! One record of every kind and every variant inside it, for the tests of this room.

mod controllers;

use std::sync::Arc;

use ambidex_model::*;

/// The smallest message there is.
pub fn activation() -> Record {
    sent(Message::Activation)
}

/// A name behind every id that the samples use.
pub fn names() -> Names {
    let list = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    Names {
        nodes: list(&["root", "both", "pick 1", "pick 2"]).into(),
        resources: list(&["base", "left_gripper", "right_gripper"]),
        types: list(&["base", "gripper"]),
        channels: list(&["at shelf"]),
        objects: list(&["cup"]),
        places: list(&["shelf"]),
        stands: vec![list(&["front", "back"])],
        facts: list(&["lit"]),
        controllers: list(&["base", "left_arm"]),
    }
}

/// A header first, an end last.
pub fn records() -> Vec<Record> {
    let mut records = vec![header()];
    records.extend(messages().into_iter().map(sent));
    records.extend(turns());
    records.extend(decisions());
    records.extend(releases());
    let changes = [
        Change::Base(Pose::new(0.5, -1.25, 0.0)),
        Change::Object(ObjectId(0), Location::At(PlaceId(0))),
        Change::Laid(ObjectId(0), PlaceId(0), SpotId(3)),
        Change::Taken(ObjectId(0), ResourceId(1)),
        Change::Blocked(Obstacle::between([0.0, 1.0, 0.0].into(), [0.5, 2.0, 1.5].into())),
        Change::Cleared(Pose::new(0.25, 1.5, 0.0)),
        Change::Object(ObjectId(0), Location::Unknown),
        Change::Object(ObjectId(0), Location::held(ResourceId(2))),
        Change::Emptied(ResourceId(1)),
        Change::Fact(FactId(0), true),
    ];
    let at = Time(2_000_000);
    records.extend(changes.map(|change| Record::World { at, change, origin: Origin::Script }));
    let change = Change::Object(ObjectId(0), Location::At(PlaceId(0)));
    let origins = [Origin::Operator, Origin::Controller(ControllerId(1)), Origin::Dropped, Origin::Resumed];
    records.extend(origins.map(|origin| Record::World { at, change, origin }));
    let objections = [
        Objection::NotOutside,
        Objection::Held { by: Holders::one(ResourceId(1)) },
        Objection::NotTheirs,
        Objection::NotBegun,
        Objection::Over,
    ];
    let denied = |change, why| Record::Denied { at, change, origin: Origin::Operator, why };
    records.extend(objections.map(|why| denied(change, why)));
    records.push(denied(Change::Fact(FactId(0), true), Objection::NotOutside));
    records.extend(resources());
    records.extend(tasks());
    records.extend(controllers::messages().into_iter().map(told));
    let ends = [
        MissionEnd::Done,
        MissionEnd::Failed(NodeId(2)),
        MissionEnd::Stalled,
        MissionEnd::Canceled,
        MissionEnd::ControllerLost(ControllerId(1)),
        MissionEnd::NotAttached,
        MissionEnd::NodeLost(NodeId(3)),
        MissionEnd::TaskLost,
    ];
    records.extend(ends.map(|end| Record::Ended { at, end }));
    records
}

/// A message between two nodes.
pub fn sent(message: Message) -> Record {
    Record::Sent { at: Time(1_500_000), round: 3, from: NodeId(0), to: NodeId(1), message }
}

/// A message to or from a controller.
pub fn told(message: ControllerMessage) -> Record {
    Record::Controller { at: Time(1_750_000), controller: ControllerId(1), message }
}

fn header() -> Record {
    let entry = |parent, kind: &str| NodeEntry { parent: NodeId(parent), kind: EntryKind::from(kind.to_owned()) };
    Record::Header(Box::new(Header {
        version: JOURNAL_VERSION,
        mission: "tidy up".into(),
        robot: "pr2".into(),
        allocator: "greedy".into(),
        nodes: vec![entry(0, "root"), entry(0, "and"), entry(1, "pick"), entry(1, "pick")].into(),
        resource_types: vec![TypeId(0), TypeId(1), TypeId(1)],
        movers: vec![Some(ControllerId(0)), Some(ControllerId(1)), None],
        start: Some(WorldState::new(Pose::new(0.0, 0.0, 0.0), vec![Location::At(PlaceId(0))], vec![false])),
        names: names(),
        waits_when_stalled: false,
        reattach_us: 10_000_000,
        cleanup_grace_us: 10_000_000,
        has_messages: true,
        source: None,
    }))
}

/// A request with every kind of need.
pub fn request() -> Request {
    let need = |access, candidates: &[u32]| ClaimOptions {
        access,
        keep: Retention::Physical(Access::Exclusive),
        candidates: candidates
            .iter()
            .map(|&resource| Candidate { cost_m: 0.25, ..Candidate::at_hand(ResourceId(resource)) })
            .collect(),
        beyond: vec![
            Beyond { resource: ResourceId(2), by: None },
            Beyond { resource: ResourceId(1), by: Some(NodeId(3)) },
        ],
    };
    Request {
        leaf: NodeId(2),
        priority: 1,
        iterations: 2,
        potential: 8.5,
        heir: true,
        claims: vec![need(Access::Shared(ChannelId(0)), &[0]), need(Access::Exclusive, &[1, 2])],
        changes: vec![ObjectId(0)],
        skips: vec![NodeRange { from: NodeId(2), to: NodeId(3) }],
        place: None,
        stand: Some(StandId(1)),
        spots: vec![(ObjectId(0), SpotId(3))],
        distance: None,
    }
}

/// The answer of a leaf.
pub fn answer(request: Option<Request>, blocked: Vec<Blocked>) -> Message {
    Message::Answer {
        running: false,
        satisfied: false,
        potential: request.as_ref().map(|request| request.potential),
        asking: request.iter().map(|request| request.leaf).collect(),
        request: request.map(Arc::new),
        blocked,
    }
}

fn messages() -> Vec<Message> {
    let leaf = NodeId(2);
    let end = End::Failed(Fault::TimedOut);
    vec![
        Message::Activation,
        answer(Some(request()), Vec::new()),
        answer(None, blocked()),
        Message::Verdict { granted: vec![leaf], stopped: Vec::new() },
        Message::Verdict { granted: Vec::new(), stopped: vec![leaf] },
        Message::Release { leaf, end: End::Succeeded },
        Message::Release { leaf, end },
    ]
}

/// The end of a round.
pub fn decided(granted: Vec<Grant>, reopened: Option<Reopened>) -> Record {
    Record::Decided {
        at: Time(1_500_000),
        round: 3,
        granted,
        refused: blocked(),
        reopened,
        deadlines: Vec::new(),
        urged: Some(vec![Urged { node: NodeId(1), priority: 2 }]),
        overdue: Some(vec![NodeId(1)]),
    }
}

/// A grant behind a skip.
pub fn grant() -> Grant {
    let binding = |resource, access, keep| Binding { resource: ResourceId(resource), access, keep };
    let shared = Access::Shared(ChannelId(0));
    Grant {
        request: Arc::new(request()),
        bindings: vec![
            binding(0, shared, Retention::Release),
            binding(0, shared, Retention::Intention(shared)),
            binding(1, Access::Exclusive, Retention::Physical(Access::Exclusive)),
        ],
        met: vec![NodeId(2)],
        way: vec![Pose::new(1.0, 2.0, 0.0)],
    }
}

/// A resource that is held, and one that is free again.
pub fn resources() -> [Record; 2] {
    let mut table = ResourceTable::new(3);
    table.take(&Topology::new([0, 0, 1, 1].map(NodeId).to_vec()), &grant());
    let states = [table.resource(ResourceId(0)).clone(), Resource::default()];
    states.map(|state| Record::Resource { at: Time(1_500_000), resource: ResourceId(0), state })
}

fn decisions() -> Vec<Record> {
    let heir = Box::new(Blocked { leaf: NodeId(3), reason: Reason::NotAt { place: PlaceId(0) } });
    vec![
        decided(vec![grant()], None),
        decided(Vec::new(), Some(reopened(Cause::Lapse { resource: ResourceId(0), heir }))),
        decided(Vec::new(), Some(reopened(Cause::Redo { leaf: NodeId(3) }))),
    ]
}

fn reopened(cause: Cause) -> Reopened {
    Reopened::new(NodeId(2), NodeId(1), cause)
}

/// What root was told, its turns, and what it did in them besides deciding and releasing.
fn turns() -> Vec<Record> {
    let at = Time(1_400_000);
    let world_state = || {
        let state = WorldState::new(Pose::new(1.0, 0.0, 0.0), vec![Location::At(PlaceId(0))], vec![true]);
        Box::new(WorldState { spots: vec![(ObjectId(0), SpotId(3))], ..state })
    };
    let outcome = Outcome { end: End::Interrupted, changes: vec![Change::Base(Pose::new(1.0, 2.0, 0.5))] };
    let told = |input| Record::Told { at, input };
    let controller = ControllerId(1);
    let served = |service| Record::Served { at, controller, resources: vec![ResourceId(1)], service };
    vec![
        told(Told::Begin { changes: vec![Change::Base(Pose::new(1.0, 0.0, 0.0))] }),
        told(Told::Resumed),
        told(Told::World { change: Change::Fact(FactId(0), true), origin: Origin::Operator }),
        told(Told::Ended { leaf: NodeId(2), outcome }),
        told(Told::End { end: MissionEnd::Canceled }),
        Record::Observed { at, change: Change::Base(Pose::new(1.0, 2.0, 0.5)) },
        Record::Turn { at },
        Record::Began { at, world_state: world_state() },
        Record::Stopped { at, leaves: vec![NodeId(2)], cause: StopCause::Ends },
        Record::Stopped { at, leaves: vec![NodeId(2)], cause: StopCause::Preempted { by: NodeId(3) } },
        Record::Stopped {
            at,
            leaves: vec![NodeId(2)],
            cause: StopCause::Broken(Reason::Fact { fact: FactId(0), holds: false }),
        },
        Record::Ending { at, end: MissionEnd::Canceled, until: Time(11_400_000) },
        Record::Leaving { at, way: NodeId(2) },
        Record::Cleaning { at, node: NodeId(1) },
        Record::Cleaned { at, node: NodeId(1), is_done: true, consequences: Consequences::default() },
        Record::Cleaned { at, node: NodeId(1), is_done: false, consequences: Consequences::default() },
        Record::Reopened { at, reopened: reopened(Cause::Repeat { since: at, until: None }) },
        Record::Reopened { at, reopened: reopened(Cause::Repeat { since: at, until: Some(Time(11_900_000)) }) },
        Record::Reopened { at, reopened: reopened(Cause::Yield) },
        told(Told::Service { controller, outage: Some(Loss::Silent), changes: Vec::new() }),
        told(Told::Service { controller, outage: None, changes: vec![Change::Emptied(ResourceId(1))] }),
        told(Told::Woke),
        Record::Woke { at, leaves: vec![NodeId(2), NodeId(3)] },
        served(Service::Unavailable { why: Loss::Hung, since: at }),
        served(Service::Gone { why: Loss::Ended, since: at }),
        served(Service::Available),
        served(Service::Unavailable { why: Loss::Inhibited(Inhibition::EmergencyStop), since: at }),
        Record::Awaited { at, until: Some(Time(11_400_000)), facts: Vec::new(), places: Vec::new() },
        Record::Awaited { at, until: None, facts: Vec::new(), places: Vec::new() },
        Record::Awaited { at, until: None, facts: vec![FactId(0)], places: vec![PlaceId(0)] },
        Record::Infeasible {
            at,
            leaf: NodeId(3),
            reason: Reason::Fact { fact: FactId(0), holds: true },
            consequences: Consequences::default(),
        },
        Record::TimedOut { at, node: NodeId(2), consequences: Consequences::default() },
        Record::Overtaken {
            at,
            leaf: NodeId(3),
            skips: vec![NodeRange { from: NodeId(3), to: NodeId(5) }],
            goal: NodeId(4),
            consequences: Consequences::default(),
        },
        Record::Reopened { at, reopened: reopened(Cause::Leave) },
        Record::Reopened {
            at,
            reopened: reopened(Cause::Retry { fault: Fault::TimedOut, since: at, until: Time(11_900_000) }),
        },
    ]
}

/// Tasks that come and go, in a run that takes them.
fn tasks() -> Vec<Record> {
    let at = Time(1_950_000);
    let source = Source {
        kind: SourceKind::Task,
        mission: "task.yaml".into(),
        robot: None,
        settings: vec![("object".into(), "cup".into())],
        files: vec![SourceFile { path: "task.yaml".into(), same_as: None, text: "task: {pick: cup}".into() }],
    };
    let branch = || Branch { source: source.clone(), fragment: None };
    let submission =
        Submission { name: "fetch".into(), priority: Some(2), granting: Granting::Paused, branch: branch() };
    let (task, place, object) = (NodeId(2), PlaceId(0), ObjectId(1));
    let work = [
        Work::Submit(Box::new(submission)),
        Work::Cancel { task },
        Work::Grant { task: Some(task), granting: Granting::Step },
        Work::Grant { task: None, granting: Granting::Freely },
        Work::Add { under: task, behind: Some(1), branch: branch() },
        Work::Remove { node: task },
        Work::Replace { node: task, branch: branch() },
        Work::AddObject { name: "mug".into(), place },
        Work::RemoveObject { object },
    ];
    let entry = |parent| NodeEntry { parent: NodeId(parent), kind: EntryKind::from("pick".to_owned()) };
    let added = |under, task| Record::Added {
        at,
        top: NodeId(4),
        under: NodeId(under),
        behind: 2,
        nodes: vec![entry(0)],
        names: vec!["pick cup".into()],
        channels: vec!["at sink".into()],
        task,
    };
    let entry = TaskEntry { name: "fetch".into(), priority: 2, granting: Granting::Paused };
    let told = work.into_iter().map(|work| Record::Told { at, input: Told::Work { work } });
    let records = [
        added(0, Some(entry)),
        added(1, None),
        Record::Removed { at, node: NodeId(3) },
        Record::Granting { at, task: Some(task), granting: Granting::Step },
        Record::Granting { at, task: None, granting: Granting::Freely },
        Record::Canceled { at, task, until: Time(9_000_000) },
        Record::TaskEnded { at, task, end: MissionEnd::Failed(NodeId(3)) },
        Record::Stalled { at, tasks: vec![task], blocked: Vec::new() },
        Record::Stalled { at, tasks: Vec::new(), blocked: Vec::new() },
        Record::ObjectAdded { at, object, name: "mug".into(), place },
        Record::ObjectRemoved { at, object },
        Record::Declined { at, number: 3, why: Hindrance::Runs { leaf: NodeId(3) } },
    ];
    told.chain(records).collect()
}

fn releases() -> Vec<Record> {
    let controller = ControllerId(1);
    let ends = [
        End::Succeeded,
        End::Canceled,
        End::Interrupted,
        End::Failed(Fault::Rejected(controller, Rejection::Busy)),
        End::Failed(Fault::Refused(controller, Rejection::NotFinite)),
        End::Failed(Fault::Unanswered(controller)),
        End::Failed(Fault::Aborted(controller)),
        End::Failed(Fault::NotMaintained(controller)),
        End::Failed(Fault::Contradicted(ResourceId(1))),
        End::Failed(Fault::TimedOut),
        End::Failed(Fault::Blocked),
        End::Failed(Fault::Lost(controller)),
    ];
    let released = |end| Record::Released {
        at: Time(1_900_000),
        leaf: NodeId(2),
        end,
        consequences: Consequences { failed: Some(NodeId(1)), ..Consequences::default() },
        changes: vec![Change::Fact(FactId(0), false)],
        waits_until: None,
        unfit: Vec::new(),
    };
    ends.map(released).into()
}

fn blocked() -> Vec<Blocked> {
    let (node, resource, object) = (NodeId(3), ResourceId(1), ObjectId(0));
    let (place, fact, of) = (PlaceId(0), FactId(0), TypeId(1));
    let reasons = [
        Reason::Satisfied,
        Reason::Held { resource, by: node, channel: None },
        Reason::Held { resource, by: node, channel: Some(ChannelId(0)) },
        Reason::NoneFree { of },
        Reason::Unavailable { resource, why: Loss::Silent },
        Reason::Unavailable { resource, why: Loss::Inhibited(Inhibition::Fault) },
        Reason::BackingOff { wait_ms: 500, fault: Fault::TimedOut },
        Reason::TooFew { of, wanted: 3, free: 2 },
        Reason::Unwanted,
        Reason::Outdone { by: node },
        Reason::LessUrgent { by: node, resource, own: 0, theirs: 1 },
        Reason::DoneOftener { by: node, resource, own: 2, theirs: 1 },
        Reason::Reserved { resource: Some(resource), by: node },
        Reason::Reserved { resource: None, by: node },
        Reason::TooEarly { task: node },
        Reason::NotYet { node, wait_ms: 500 },
        Reason::GivenUp { node },
        Reason::Missing { of },
        Reason::OutOfReach { object },
        Reason::OutOfReachLater { object, by: node },
        Reason::Unreachable { object, place: Some(PlaceId(0)), is_shut: true },
        Reason::NoSpot { place, is_taken: true },
        Reason::InTheWay { place },
        Reason::NotHeld { object },
        Reason::Taken { object, by: resource },
        Reason::Elsewhere { object, place },
        Reason::NotAt { place },
        Reason::Misheld(Misheld::NotSo { hold: Hold { object, by: HeldBy::Any, hands: 2, alone: false }, found: 1 }),
        Reason::Misheld(Misheld::NotSo {
            hold: Hold { object, by: HeldBy::Type(of), hands: 1, alone: false },
            found: 0,
        }),
        Reason::Misheld(Misheld::NotSo {
            hold: Hold { object, by: HeldBy::Resource(resource), hands: 1, alone: false },
            found: 0,
        }),
        Reason::Misheld(Misheld::Too { object, by: resource }),
        Reason::Misheld(Misheld::Last { object }),
        Reason::Misheld(Misheld::Full { object }),
        Reason::Driving { by: node },
        Reason::NoPath { place },
        Reason::PathNotFound { place, steps: 1_000 },
        Reason::Fact { fact, holds: true },
        Reason::NothingAvailable { of },
        Reason::AlreadyDone { heir: node, lacks: Box::new(Reason::NotAt { place }) },
        Reason::Outbid { by: node, resource, own: 0.375, theirs: 1.5 },
        Reason::SameObject { object, with: node },
        Reason::Clash { with: node, over: Clash::Arms },
        Reason::Alternative { chosen: node },
        Reason::WholeRobot { by: node },
        Reason::WouldDeadlock {
            deadlock: Box::new(Deadlock {
                other: Standstill { node, holds: Some(resource), needs: 2 },
                own: Standstill { node: NodeId(2), holds: None, needs: 0 },
            }),
        },
        Reason::NotItsTurn { after: node },
        Reason::Ending { failed: node },
    ];
    let leaf = NodeId(2);
    reasons.map(|reason| Blocked { leaf, reason }).into()
}

/// A command to a controller.
pub fn goal(command: Command) -> ControllerMessage {
    ControllerMessage::Told {
        leaf: Some(NodeId(2)),
        message: ToController::Goal { id: id(), mode: Mode::Achieve, command },
    }
}

/// The command of all samples.
pub fn id() -> CommandId {
    CommandId { generation: 1, number: 7 }
}
