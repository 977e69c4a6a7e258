//! What a THEN asks later: the hand that takes something is to be one that reaches where it is put, and the base is to stand
//! where what comes next can be reached.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::ordering::Ordering;
use crate::behavior;
use crate::world::Geometry;
use ambidex_model::state::State;
use ambidex_model::{
    Approach, BehaviorSpec, CommandTerm, EffectTerm, MissionSpec, NodeId, ObjectId, PlaceId, Pose, Reason, ResourceId,
    Task,
};

/// From where it is asked what a hand reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum From {
    /// One of the stands itself.
    Stand,
    /// Wherever counts as being there.
    AboutThere,
}

/// What part of a tree does with an object.
enum Course {
    Keeps,
    LetsGo,
    /// This behavior would let go of it where the hand does not reach.
    Fails(NodeId),
}

/// The first behavior behind a leaf in its own THEN that is to let go of an object where a hand does not reach from the
/// stand; none where the hand can do all.
pub(super) fn out_of_reach(mission: &MissionSpec, leaf: NodeId, hand: ResourceId, object: ObjectId) -> Option<NodeId> {
    find(mission, leaf, (hand, object), From::Stand)
}

/// Why no hand at all could take what a behavior takes and then do what is asked of it later.
pub(super) fn lacks_for_good(mission: &MissionSpec, leaf: NodeId) -> Option<Reason> {
    let spec = mission.tree.behavior(leaf)?;
    spec.effects.iter().find_map(|effect| {
        let EffectTerm::Taken(object, claim) = *effect else { return None };
        let hands = mission.robot.could_serve(spec.claims[claim].selector);
        let mut failing = hands.into_iter().map(|hand| find(mission, leaf, (hand, object), From::AboutThere));
        let by = failing.next()??;
        failing.all(|by| by.is_some()).then_some(Reason::OutOfReachLater { object, by })
    })
}

fn find(mission: &MissionSpec, leaf: NodeId, held: (ResourceId, ObjectId), from: From) -> Option<NodeId> {
    let course = later(mission, leaf).map(|later| course(mission, later, held, from));
    match course.into_iter().find(|course| !matches!(course, Course::Keeps))? {
        Course::Fails(by) => Some(by),
        Course::Keeps | Course::LetsGo => None,
    }
}

/// What becomes of an object below a node, in the hand that holds it.
fn course(mission: &MissionSpec, node: NodeId, held: (ResourceId, ObjectId), from: From) -> Course {
    let Some(ordering) = Ordering::of(&mission.tree.nodes[node.index()]) else {
        return course_of_leaf(mission, node, held, from);
    };
    let children = || mission.tree.topology.children(node).map(|child| course(mission, child, held, from));
    match ordering {
        Ordering::Then | Ordering::And => {
            children().find(|course| !matches!(course, Course::Keeps)).unwrap_or(Course::Keeps)
        }
        Ordering::Cleanup => children().next().unwrap_or(Course::Keeps),
        // One way will do.
        Ordering::Or => {
            let best = children().find(|course| !matches!(course, Course::Fails(_)));
            best.or_else(|| children().next()).unwrap_or(Course::Keeps)
        }
    }
}

fn course_of_leaf(mission: &MissionSpec, leaf: NodeId, (hand, object): (ResourceId, ObjectId), from: From) -> Course {
    let Some(spec) = mission.tree.behavior(leaf) else { return Course::Keeps };
    let stands = behavior::stands(&spec.precondition);
    let puts = spec.commands.iter().filter(|term| term.task.put() == Some(object));
    let mut puts = puts
        .filter(|term| mission.robot.could_serve(spec.claims[term.claim].selector).contains(&hand))
        .filter_map(|term| match term.task {
            Task::Put(_, place) => Some(reaches_place(mission, (hand, object), place, stands, from)),
            Task::PutInto(_, into) => {
                let slots = mission.robot.could_serve(spec.claims[into].selector);
                Some(slots.into_iter().any(|slot| reaches_slot(mission, hand, slot)))
            }
            Task::DriveTo(..) | Task::Stand | Task::Grasp(_) | Task::GraspFrom(..) => None,
            Task::LookAt(_) | Task::Call(_) => None,
        })
        .peekable();
    if puts.peek().is_some() {
        return if puts.any(|reaches| reaches) { Course::LetsGo } else { Course::Fails(leaf) };
    }
    let lets_go = |effect: &EffectTerm| match *effect {
        EffectTerm::LetGo(other, _) | EffectTerm::Lies(other, _) => other == object,
        EffectTerm::Taken(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => false,
    };
    if spec.effects.iter().any(lets_go) { Course::LetsGo } else { Course::Keeps }
}

fn reaches_place(
    mission: &MissionSpec,
    (hand, object): (ResourceId, ObjectId),
    place: PlaceId,
    stands: Option<(&[Pose], f64)>,
    from: From,
) -> bool {
    let reaches = |stand: &Pose, slack_m| Geometry::of(mission).puts_from(stand, hand, (object, place), slack_m);
    match stands {
        Some((stands, tolerance_m)) => {
            let slack_m = if from == From::AboutThere { tolerance_m } else { 0.0 };
            stands.iter().any(|stand| reaches(stand, slack_m))
        }
        None => mission.world.places[place.index()].stands().any(|stand| reaches(&stand, 0.0)),
    }
}

/// Of a slot whose place nobody tells, so it seems.
fn reaches_slot(mission: &MissionSpec, hand: ResourceId, slot: ResourceId) -> bool {
    mission.robot.carried_at(slot).is_none_or(|at| mission.robot.reach_m(hand, at, Approach::ANY, 0.0).is_some())
}

/// How much of what comes behind a drive in its own THENs can be reached from a stand, as things are: behaviors up to the
/// next drive, those of a THEN up to the first that cannot.
pub(super) fn reached_from(mission: &MissionSpec, state: &State, drive: NodeId, stand: Pose) -> usize {
    Behind::of(mission, state, stand).all(drive)
}

/// Behaviors that are not reached from the stand from which most is, of what comes behind a drive as a mission begins, though
/// they are from another one: they need a drive of their own. Each with that drive; ways of an OR are not looked at.
pub fn split_stands(mission: &MissionSpec) -> Vec<(NodeId, NodeId)> {
    let topology = Arc::new(mission.tree.topology.clone());
    let state = State::new(topology, mission.robot.resources.len(), mission.start.clone());
    let drives = mission.tree.leaves().filter_map(|leaf| {
        let stands = mission.tree.behavior_in(leaf, state.world())?.stands.as_ref()?;
        let reached = stands.iter().filter_map(|spec| {
            let behind = Behind::of(mission, &state, behavior::driven_to(spec)?);
            let mut behind = Behind { is_thorough: true, ..behind };
            behind.all(leaf);
            Some(behind.reached)
        });
        let reached: Vec<_> = reached.collect();
        let best = reached.iter().max_by_key(|reached| reached.len())?;
        let other = reached.iter().flatten().find(|other| !best.contains(other))?;
        Some((leaf, *other))
    });
    drives.collect()
}

/// Objects of which it matters to a drive where they are: those that what comes behind it is about, up to the next drive.
pub(super) fn objects_behind(mission: &MissionSpec, drive: NodeId) -> BTreeSet<ObjectId> {
    let mut objects = BTreeSet::new();
    for spec in later(mission, drive)
        .flat_map(|node| mission.tree.leaves_below(node))
        .filter_map(|leaf| mission.tree.behavior(leaf))
    {
        objects.extend(spec.elsewhere.iter().map(|followed| followed.object));
        let tasks = spec.anywhere().flat_map(|one| &one.commands);
        objects.extend(tasks.filter_map(|term| term.task.grasped().or(term.task.put())));
        if behavior::driven_to(spec).is_some() {
            break;
        }
    }
    objects
}

/// What comes behind a node in its own THENs, in the order in which it is done.
fn later(mission: &MissionSpec, node: NodeId) -> impl Iterator<Item = NodeId> + '_ {
    let (topology, mut child) = (&mission.tree.topology, node);
    topology.path(node).skip(1).flat_map(move |above| {
        let before = std::mem::replace(&mut child, above);
        let is_then = Ordering::of(&mission.tree.nodes[above.index()]) == Some(Ordering::Then);
        let children = is_then.then(|| topology.children(above).skip_while(move |other| *other != before).skip(1));
        children.into_iter().flatten()
    })
}

/// What of a part of a tree can be reached from a stand.
struct Served {
    reached: usize,
    /// Whether what comes behind it is done at the same stand.
    goes_on: bool,
}

/// What comes behind a drive, from a stand.
struct Behind<'a> {
    mission: &'a MissionSpec,
    state: &'a State,
    stand: Pose,
    /// Objects that other hands take before what is looked at: those that hold them now do not count.
    passed_on: BTreeSet<ObjectId>,
    /// Behaviors that are reached and have to be done.
    reached: BTreeSet<NodeId>,
    /// Whether what comes behind one that is not reached is looked at too.
    is_thorough: bool,
}

impl<'a> Behind<'a> {
    fn of(mission: &'a MissionSpec, state: &'a State, stand: Pose) -> Self {
        Self { mission, state, stand, passed_on: BTreeSet::new(), reached: BTreeSet::new(), is_thorough: false }
    }

    fn all(&mut self, drive: NodeId) -> usize {
        let mut count = 0;
        for later in later(self.mission, drive) {
            let Served { reached, goes_on } = self.served(later);
            count += reached;
            if !goes_on {
                break;
            }
        }
        count
    }

    fn served(&mut self, node: NodeId) -> Served {
        let Some(ordering) = Ordering::of(&self.mission.tree.nodes[node.index()]) else {
            return self.served_by(node);
        };
        let none = Served { reached: 0, goes_on: true };
        let mission = self.mission;
        if ordering == Ordering::Or {
            // One way will do.
            let before = self.reached.clone();
            let ways = mission.tree.topology.children(node).map(|way| self.served(way));
            let best = ways.max_by_key(|way| way.reached).unwrap_or(none);
            self.reached = before;
            return best;
        }
        let mut children = mission.tree.topology.children(node).map(|child| self.served(child));
        match ordering {
            Ordering::Then => {
                let mut all = none;
                for child in children {
                    all = Served { reached: all.reached + child.reached, ..child };
                    if !all.goes_on {
                        break;
                    }
                }
                all
            }
            Ordering::And => children.fold(none, |all, child| Served {
                reached: all.reached + child.reached,
                goes_on: all.goes_on && child.goes_on,
            }),
            Ordering::Or | Ordering::Cleanup => children.next().unwrap_or(none),
        }
    }

    fn served_by(&mut self, leaf: NodeId) -> Served {
        let Some(spec) = self.mission.tree.behavior(leaf).map(|spec| spec.as_in(self.state.world())) else {
            return Served { reached: 0, goes_on: true };
        };
        if behavior::driven_to(spec).is_some() {
            return Served { reached: 0, goes_on: false };
        }
        let mut reached = 0;
        for term in &spec.commands {
            match self.reaches(leaf, spec, term) {
                Some(true) => reached = 1,
                Some(false) => return Served { reached: 0, goes_on: self.is_thorough },
                None => {}
            }
        }
        self.passed_on.extend(spec.commands.iter().filter_map(|term| term.task.grasped()));
        if reached > 0 {
            self.reached.insert(leaf);
        }
        Served { reached, goes_on: true }
    }

    /// Whether some hand of a command reaches what it is told; none where it is told nothing of the kind.
    fn reaches(&self, leaf: NodeId, spec: &BehaviorSpec, term: &CommandTerm) -> Option<bool> {
        let (world_state, geometry) = (self.state.world(), Geometry::of(self.mission));
        let hands = self.mission.robot.could_serve(spec.claims[term.claim].selector);
        match term.task {
            Task::Grasp(object) => {
                let place = world_state.objects[object.index()].place()?;
                let at = geometry.world.object(world_state, object)?;
                let approach = geometry.world.approach(object, place);
                let can = |hand: &ResourceId| {
                    geometry.reach_from(&self.stand, *hand, at, approach, 0.0).is_some()
                        && out_of_reach(self.mission, leaf, *hand, object).is_none()
                };
                Some(hands.iter().any(can))
            }
            Task::Put(object, place) => {
                let holders = world_state.objects[object.index()].holders();
                let can = |hand: &ResourceId| geometry.puts_from(&self.stand, *hand, (object, place), 0.0);
                // Of one that is held in a slot, or is to be handed over, any hand may be the one that puts it down.
                let holding: Vec<_> = hands.iter().filter(|hand| holders.contains(hand)).collect();
                Some(match holding.is_empty() || self.passed_on.contains(&object) {
                    true => hands.iter().any(can),
                    false => holding.into_iter().any(can),
                })
            }
            Task::DriveTo(..) | Task::Stand | Task::GraspFrom(..) | Task::PutInto(..) => None,
            Task::LookAt(_) | Task::Call(_) => None,
        }
    }
}
