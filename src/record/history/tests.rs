//! States of a small task after odd turns.

use std::sync::Arc;

use ambidex_model::*;

use super::{History, LeafState, Phase};

const TASK: NodeId = NodeId(1);
const THEN: NodeId = NodeId(2);
const A: NodeId = NodeId(3);
const B: NodeId = NodeId(4);
const OR: NodeId = NodeId(5);
const C: NodeId = NodeId(6);
const D: NodeId = NodeId(7);

/// An AND of a THEN of two behaviors and an OR of two.
fn header() -> Record {
    let kinds = [(0, "root"), (0, "and"), (1, "then"), (2, "a"), (2, "b"), (1, "or"), (5, "c"), (5, "d")];
    let names = kinds.iter().map(|(_, kind)| (*kind).to_owned()).collect();
    let entry = |(parent, kind): (u32, &str)| NodeEntry { parent: NodeId(parent), kind: kind.to_owned().into() };
    let resources = vec!["left".into(), "right".into()];
    Record::Header(Box::new(Header {
        version: JOURNAL_VERSION,
        mission: "small".into(),
        robot: "robot".into(),
        allocator: "greedy".into(),
        nodes: kinds.map(entry).to_vec().into(),
        resource_types: vec![TypeId(0); 2],
        movers: vec![Some(ControllerId(0)), None],
        start: None,
        names: Names { nodes: names, resources, objects: vec!["cup".into()], ..Names::default() },
        waits_when_stalled: false,
        reattach_us: 0,
        cleanup_grace_us: 0,
        has_messages: true,
        source: None,
    }))
}

fn skips_of(request: &Request, leaf: NodeId) -> bool {
    request.skips.iter().any(|skip| skip.contains(leaf))
}

fn decided(at: u64, grants: &[(NodeId, &[NodeId])], reopened: Option<NodeId>, refused: &[(NodeId, Reason)]) -> Record {
    let range = |skip: &NodeId| NodeRange { from: *skip, to: NodeId(skip.0 + 1) };
    let grant = |(leaf, skips): &(NodeId, &[NodeId])| {
        let skips = skips.iter().map(range).collect();
        let request = Request {
            leaf: *leaf,
            priority: 0,
            iterations: 0,
            potential: 1.0,
            heir: false,
            claims: Vec::new(),
            changes: Vec::new(),
            skips,
            place: None,
            stand: None,
            spots: Vec::new(),
            distance: None,
        };
        let is_met = |(leaf, reason): &&(NodeId, Reason)| *reason == Reason::Satisfied && skips_of(&request, *leaf);
        let met = refused.iter().filter(is_met).map(|(leaf, _)| *leaf).collect();
        Grant { request: Arc::new(request), bindings: Vec::new(), met, way: Vec::new() }
    };
    let blocked = |(leaf, reason): &(NodeId, Reason)| Blocked { leaf: *leaf, reason: reason.clone() };
    Record::Decided {
        at: Time(at),
        round: 1,
        granted: grants.iter().map(grant).collect(),
        refused: refused.iter().map(blocked).collect(),
        reopened: reopened.map(|node| Reopened::new(node, THEN, Cause::Redo { leaf: node })),
        deadlines: Vec::new(),
        urged: None,
        overdue: None,
    }
}

fn granted(at: u64, leaf: NodeId) -> Record {
    decided(at, &[(leaf, &[])], None, &[])
}

fn ended(at: u64, leaf: NodeId, end: End, completed: Option<NodeId>, failed: Option<NodeId>) -> Record {
    let completed = completed.map(|node| Completion { node, heir: None });
    let consequences = Consequences { completed, failed, failing: None, cleaned: None };
    Record::Released {
        at: Time(at),
        leaf,
        end,
        consequences,
        changes: Vec::new(),
        waits_until: None,
        unfit: Vec::new(),
    }
}

fn succeeded(at: u64, leaf: NodeId, completed: NodeId) -> Record {
    ended(at, leaf, End::Succeeded, Some(completed), None)
}

fn over(end: MissionEnd) -> Record {
    Record::Ended { at: Time(99), end }
}

fn history(records: &[Record]) -> History {
    History::of([&[header()], records].concat().iter()).expect("a header comes first")
}

/// What task, THEN, a, b, OR, c and d are.
fn check(records: &[Record], expected: [LeafState; 7]) {
    let history = history(records);
    let states = [TASK, THEN, A, B, OR, C, D].map(|node| history.state(node));
    assert_eq!(states, expected, "{records:#?}");
    let done = [A, B, C, D].iter().filter(|leaf| history.state(**leaf).is_done()).count();
    assert_eq!((history.counts(NodeId(0)).done, history.counts(NodeId(0)).of), (done, 4));
}

#[test]
fn composites_are_what_their_leaves_make_them() {
    use LeafState::{Active, Done, NotNeeded, Skipped, Waiting};
    let [begun, first] = [granted(1, A), succeeded(2, A, A)];
    check(&[], [Waiting; 7]);
    check(std::slice::from_ref(&begun), [Active, Active, Active, Waiting, Waiting, Waiting, Waiting]);
    check(&[begun.clone(), first.clone()], [Waiting, Waiting, Done, Waiting, Waiting, Waiting, Waiting]);
    let skip = decided(1, &[(B, &[A])], None, &[]);
    check(std::slice::from_ref(&skip), [Active, Active, Skipped, Active, Waiting, Waiting, Waiting]);
    check(&[skip, succeeded(2, B, THEN)], [Waiting, Done, Skipped, Done, Waiting, Waiting, Waiting]);
    let way = [granted(1, D), succeeded(2, D, OR)];
    check(&way, [Waiting, Waiting, Waiting, Waiting, Done, NotNeeded, Done]);
}

#[test]
fn what_failed_for_good_says_so_before_the_mission_is_over() {
    use LeafState::{Canceled, Failed, NotAsked, Waiting};
    let fault = End::Failed(Fault::TimedOut);
    let again = [granted(1, A), ended(2, A, fault, None, None)];
    check(&again, [Waiting; 7]);
    let told = [&again[..], &[over(MissionEnd::Stalled)]].concat();
    check(&told, [Waiting, Waiting, Failed, Waiting, Waiting, Waiting, Waiting]);
    let last = [decided(1, &[(A, &[]), (C, &[])], None, &[]), ended(2, A, fault, None, Some(TASK))];
    let ending = [Failed, Failed, Failed, NotAsked, LeafState::Active, LeafState::Active, NotAsked];
    check(&last, ending);
    let stopped = [&last[..], &[ended(3, C, End::Canceled, None, None), over(MissionEnd::Failed(A))]].concat();
    check(&stopped, [Failed, Failed, Failed, NotAsked, Canceled, Canceled, NotAsked]);
}

#[test]
fn what_is_done_no_more_opens_what_is_above_it() {
    use LeafState::{Done, Waiting};
    let way = [granted(1, C), succeeded(2, C, OR), decided(3, &[], Some(C), &[])];
    check(&way, [Waiting; 7]);
    let again = [&way[..], &[granted(4, D), succeeded(5, D, OR)]].concat();
    check(&again, [Waiting, Waiting, Waiting, Waiting, Done, LeafState::NotNeeded, Done]);
    let reopened = history(&way);
    assert_eq!(reopened.leaf(C).and_then(|leaf| leaf.reopened()).map(|reopened| reopened.up_to), Some(THEN));
    let phases = history(&again).leaf(C).expect("a leaf").phases().to_vec();
    let expected = [Phase::Active, Phase::Done, Phase::Reopened, Phase::NotNeeded];
    assert!(phases.iter().map(|(_, phase)| *phase).eq(expected), "{phases:?}");
}

#[test]
fn what_is_done_stays_done_whatever_it_is_refused_for() {
    let done = [granted(1, A), succeeded(2, A, A)];
    for reason in [Reason::Ending { failed: OR }, Reason::Alternative { chosen: C }, Reason::Satisfied] {
        let history = history(&[&done[..], &[decided(3, &[], None, &[(A, reason)])]].concat());
        assert_eq!(history.state(A), LeafState::Done);
    }
}

#[test]
fn what_is_met_in_the_end_is_skipped_but_for_ways_that_an_or_did_not_take() {
    let met = [A, B, C].map(|leaf| (leaf, Reason::Satisfied));
    let records = [decided(1, &[(D, &[])], None, &met), succeeded(2, D, TASK), over(MissionEnd::Done)];
    assert_eq!(history(&records).skipped(), [(A, Time(98)), (B, Time(98))]);
}

#[test]
fn of_an_or_one_way_is_skipped_and_the_others_are_not_needed() {
    let met = [C, D].map(|leaf| (leaf, Reason::Satisfied));
    let check = |records: &[Record], skipped: &[NodeId], rest: NodeId, by: NodeId| {
        let history = history(records);
        assert!(history.skipped().iter().map(|(leaf, _)| *leaf).eq(skipped.iter().copied()), "{:?}", history.skipped());
        assert_eq!((history.state(rest), history.instead_of(rest)), (LeafState::NotNeeded, Some(by)));
    };
    let past_the_or = |met: &[(NodeId, Reason)]| {
        let mut skip = decided(1, &[(A, &[OR])], None, met);
        let Record::Decided { granted, .. } = &mut skip else { panic!("a decision") };
        Arc::make_mut(&mut granted[0].request).skips[0].to = NodeId(8);
        let is_met = |(_, reason): &&(NodeId, Reason)| *reason == Reason::Satisfied;
        granted[0].met = met.iter().filter(is_met).map(|(leaf, _)| *leaf).collect();
        skip
    };
    check(&[past_the_or(&met)], &[C], D, C);
    check(&[past_the_or(&met[1..])], &[D], C, D);
    let at_the_end = [decided(1, &[(B, &[A])], None, &met), succeeded(2, B, THEN), over(MissionEnd::Done)];
    check(&at_the_end, &[A, C], D, C);
}

#[test]
fn what_ran_in_a_way_that_was_left_is_not_skipped() {
    let way = [granted(1, C), succeeded(2, C, C), decided(3, &[], Some(C), &[])];
    let other = [decided(4, &[(D, &[])], None, &[(C, Reason::Satisfied)]), succeeded(5, D, OR)];
    let rest = [granted(6, A), succeeded(7, A, A), granted(8, B), succeeded(9, B, TASK), over(MissionEnd::Done)];
    let history = history(&[&way[..], &other, &rest].concat());
    assert_eq!((history.skipped(), history.state(C)), (vec![], LeafState::NotNeeded));
}

#[test]
fn time_begins_with_the_first_decision() {
    let attached = |at, message| Record::Controller { at: Time(at), controller: ControllerId(0), message };
    let before = [attached(3, ControllerMessage::Attached), attached(5, ControllerMessage::Lost { why: Loss::Silent })];
    let waiting = history(&before);
    assert_eq!((waiting.now(), waiting.lost(ControllerId(0))), (Time(0), Some((Time(0), Loss::Silent))));
    let records = [&before[..], &[decided(7, &[], None, &[]), granted(8, A), succeeded(9, A, A)]].concat();
    let history = history(&records);
    let leaf = history.leaf(A).expect("a leaf");
    assert_eq!((leaf.since(), leaf.phases()[0], history.steps()[0].at), (Time(2), (Time(1), Phase::Active), Time(1)));
    assert_eq!((history.now(), history.last_moment(), history.makespan_s()), (Time(2), Time(2), 2e-6));
    assert_eq!([6, 7, 9].map(|at| history.moment(Time(at))), [0, 0, 2].map(Time));
}

#[test]
fn without_its_past_a_history_goes_on_as_the_same() {
    let records = [granted(1, A), succeeded(2, A, A), granted(3, B), succeeded(4, B, THEN)];
    let (before, behind) = records.split_at(2);
    let mut whole = history(before);
    let mut present = whole.present();
    behind.iter().for_each(|record| {
        whole.apply(record);
        present.apply(record);
    });
    for node in (0..8).map(NodeId) {
        assert_eq!(present.state(node), whole.state(node), "{node:?}");
    }
    assert_eq!((present.step_count(), present.now(), present.messages()), (2, whole.now(), whole.messages()));
    assert!(present.steps().is_empty() && present.leaf(A).is_some_and(|leaf| leaf.phases().is_empty()));
    assert_eq!(whole.steps().len(), 2);
    assert!(whole.leaf(A).is_some_and(|leaf| !leaf.phases().is_empty()));
}

#[test]
fn only_what_is_a_cause_is_named_as_one() {
    let check = |refused: &[(NodeId, Reason)], expected: &[NodeId]| {
        let causes = history(&[decided(1, &[], None, refused), over(MissionEnd::Stalled)]).causes();
        assert!(causes.iter().map(|(leaf, _)| *leaf).eq(expected.iter().copied()), "{causes:?}");
    };
    let full = || Reason::NoneFree { of: TypeId(0) };
    check(&[(A, full()), (C, Reason::Satisfied)], &[A]);
    check(&[(A, Reason::Satisfied), (B, full())], &[B]);
    check(&[(A, full()), (C, Reason::Outdone { by: A }), (D, Reason::Alternative { chosen: C })], &[A, D]);
    check(&[(C, full()), (D, Reason::Alternative { chosen: C })], &[B, C]);
}

#[test]
fn who_was_not_asked_is_told_why() {
    let check = |records: &[Record], leaf: NodeId, expected: Option<Reason>| {
        assert_eq!(history(records).reason(leaf), expected);
    };
    check(&[], A, None);
    check(&[], B, Some(Reason::NotItsTurn { after: A }));
    check(&[granted(1, A), succeeded(2, A, A)], B, None);
    check(&[granted(1, C)], D, Some(Reason::Alternative { chosen: C }));
    let told = Reason::NothingAvailable { of: TypeId(0) };
    check(&[decided(1, &[], None, &[(B, told.clone())])], B, Some(told));
}

#[test]
fn a_log_can_hold_anything() {
    let far = 1_000_000;
    let mut endless =
        decided(1, &[(B, &[A]), (NodeId(far), &[])], Some(NodeId(far)), &[(NodeId(far), Reason::Unwanted)]);
    if let Record::Decided { granted, .. } = &mut endless {
        Arc::make_mut(&mut granted[0].request).skips[0].to = NodeId(u32::MAX);
    }
    let at = Time(2);
    let history = history(&[
        endless,
        ended(2, NodeId(far), End::Succeeded, Some(NodeId(far)), Some(NodeId(far))),
        ended(2, B, End::Succeeded, Some(NodeId(far)), Some(C)),
        Record::World { at, change: Change::Taken(ObjectId(far), ResourceId(far)), origin: Origin::Script },
        Record::World { at, change: Change::Fact(FactId(far), true), origin: Origin::Script },
        Record::Resource { at, resource: ResourceId(far), state: Resource::default() },
        Record::Sent { at, round: 1, from: NodeId(far), to: NodeId(far), message: Message::Activation },
        over(MissionEnd::Failed(NodeId(far))),
    ]);
    assert_eq!(history.skipped().len(), 2, "a skip is no longer than the tree");
    assert_eq!(history.state(NodeId(far)), LeafState::Waiting);
    assert_eq!(history.base(), None, "nobody told");
}
