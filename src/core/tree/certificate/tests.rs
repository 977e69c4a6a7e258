//! Orders and deadlocks of small trees over two grippers.

use std::sync::Arc;
use std::time::Duration;

use super::blame;
use super::forecast::Forecast;
use super::needs::Needs;
use super::order::{Search, find};
use ambidex_model::state::State;
use ambidex_model::{
    Access, BehaviorSpec, Claim, Condition, Distance, EffectTerm, Location, MissionSpec, Names, NodeId, NodeKind,
    ObjectId, PlaceId, Pose, Potential, ResourceId, ResourceSpec, Retention, RobotSpec, Selector, Topology, TreeSpec,
    TypeId, WorldSpec, WorldState,
};

const GRIPPER: TypeId = TypeId(0);
const CUP: ObjectId = ObjectId(0);

/// A tree as a value; leaves are called a, b, c in their order.
enum Tree {
    And(Vec<Tree>),
    Or(Vec<Tree>),
    Then(Vec<Tree>),
    /// So many grippers, of which so many are kept.
    Needs(usize, usize),
    /// This gripper, kept.
    Keeps(ResourceId),
    /// Takes the cup.
    Take,
    /// Puts down the cup.
    Put,
}

use Tree::{And, Keeps, Needs as Wants, Or, Put, Take, Then};

fn behavior(tree: &Tree) -> Option<BehaviorSpec> {
    let physical = Retention::Physical(Access::Exclusive);
    let claim = |selector, keep| Claim { selector, access: Access::Exclusive, keep };
    let any = |index, keeps| claim(Selector::Any(GRIPPER), if index < keeps { physical } else { Retention::Release });
    let (claims, effects) = match *tree {
        Tree::And(_) | Tree::Or(_) | Tree::Then(_) => return None,
        Tree::Needs(count, keeps) => ((0..count).map(|index| any(index, keeps)).collect(), Vec::new()),
        Tree::Keeps(resource) => (vec![claim(Selector::Named(resource), physical)], Vec::new()),
        Tree::Take => {
            let empty = Selector::AnyEmpty { of: GRIPPER, reaches: None };
            (vec![claim(empty, physical)], vec![EffectTerm::Taken(CUP, 0)])
        }
        Tree::Put => {
            let holder = Selector::Holding { object: CUP, of: GRIPPER, resource: None };
            (vec![claim(holder, Retention::Release)], vec![EffectTerm::Lies(CUP, PlaceId(0))])
        }
    };
    Some(BehaviorSpec {
        kind: "test".into(),
        claims,
        potential: Potential::Constant(1.0),
        satisfied: Condition::Never,
        precondition: Condition::All(Vec::new()),
        lasting: Condition::All(Vec::new()),
        is_interruptible: true,
        effects,
        commands: Vec::new(),
        changes: Vec::new(),
        takes: Duration::ZERO,
        timeout: Duration::from_secs(60),
        retries: 0,
        backoff: std::time::Duration::ZERO,
        elsewhere: None,
        stands: None,
    })
}

fn mission(tree: &Tree) -> MissionSpec {
    fn add(tree: &Tree, parent: NodeId, all: &mut (Vec<NodeKind>, Vec<NodeId>, Vec<String>)) {
        let id = NodeId::from(all.0.len());
        let leaves = all.0.iter().filter(|node| matches!(node, NodeKind::Behavior(_))).count();
        let (kind, children): (_, &[Tree]) = match tree {
            Tree::And(children) => (NodeKind::And, children),
            Tree::Or(children) => (NodeKind::Or, children),
            Tree::Then(children) => (NodeKind::Then, children),
            Tree::Needs(..) | Tree::Keeps(_) | Tree::Take | Tree::Put => {
                (NodeKind::Behavior(Box::new(behavior(tree).expect("a leaf"))), &[])
            }
        };
        let is_leaf = matches!(kind, NodeKind::Behavior(_));
        all.0.push(kind);
        all.1.push(parent);
        all.2.push(if is_leaf { ["a", "b", "c", "d", "e"][leaves] } else { "node" }.to_owned());
        children.iter().for_each(|child| add(child, id, all));
    }
    let mut all = (vec![NodeKind::Root], vec![NodeId(0)], vec!["root".to_owned()]);
    add(tree, NodeId(0), &mut all);
    let (nodes, parents, names) = all;
    let resources = vec![ResourceSpec { ty: GRIPPER, controller: None, at: None }; 2];
    let base = Pose::new(0.0, 0.0, 0.0);
    MissionSpec {
        name: "test".into(),
        robot: RobotSpec { name: "test".into(), resources, controllers: Vec::new(), radius_m: 0.3 },
        world: WorldSpec {
            places: Vec::new(),
            objects: Vec::new(),
            obstacles: Vec::new(),
            distance: Distance::Straight,
            outside: Vec::new(),
        },
        start: WorldState::new(base, vec![Location::At(PlaceId(0))], Vec::new()),
        tree: TreeSpec::new(nodes, Topology::new(parents)),
        names: Names { nodes: names.into(), resources: vec!["left".into(), "right".into()], ..Names::default() },
        source: None,
    }
}

/// The order of a tree that nothing has been done of, or what else comes of it.
fn check(tree: &Tree, expected: &str) {
    let mission = mission(tree);
    let name = |leaf: &NodeId| mission.names.node(*leaf).to_owned();
    let Some(needs) = Needs::of(&mission, None) else {
        assert_eq!("needless", expected);
        return;
    };
    let state = State::new(Arc::new(mission.tree.topology.clone()), 2, mission.start.clone());
    let ahead = Forecast::new(&needs, &state);
    let said = match find(&ahead, &mut { 100 }) {
        Search::Found(order) => order.iter().map(name).collect::<Vec<_>>().join(" "),
        Search::Nowhere => "nowhere".to_owned(),
        Search::CutOff => "cut off".to_owned(),
    };
    assert_eq!(said, expected);
}

#[test]
fn orders_of_small_trees() {
    check(&And(vec![Wants(1, 0), Wants(2, 0)]), "needless");
    check(&And(vec![Wants(1, 1), Wants(1, 1)]), "needless");
    check(&And(vec![Wants(1, 1), Wants(2, 0)]), "b a");
    check(&And(vec![Wants(1, 1), Wants(2, 1)]), "b a");
    check(&And(vec![Wants(2, 1), Wants(2, 1)]), "nowhere");
    check(&Then(vec![Wants(2, 2), Wants(2, 2)]), "a b");
    check(&And(vec![Wants(1, 1), Then(vec![Wants(1, 0), Wants(2, 1)])]), "b c a");
    // Neither child as a whole comes first.
    check(&And(vec![Then(vec![Wants(2, 0), Wants(1, 1)]), Then(vec![Wants(2, 0), Wants(1, 1)])]), "a c b d");
    check(&And(vec![Then(vec![Take, Put]), Wants(2, 0)]), "a b c");
    check(&Then(vec![Take, Wants(2, 0), Put]), "a b c");
    check(&And(vec![Or(vec![Wants(2, 2), Wants(1, 1)]), Wants(1, 1)]), "b c");
    check(&And(vec![Keeps(ResourceId(1)), Wants(1, 1), Wants(2, 0)]), "c a b");
    check(&And(vec![Keeps(ResourceId(1)), Keeps(ResourceId(1))]), "nowhere");
}

#[test]
fn who_would_wait_for_whom() {
    let check = |tree: &Tree, granted: u32, expected: &str| {
        let mission = mission(tree);
        let needs = Needs::of(&mission, None).expect("grippers are kept");
        let state = State::new(Arc::new(mission.tree.topology.clone()), 2, mission.start.clone());
        let mut ahead = Forecast::new(&needs, &state);
        assert!(ahead.run(NodeId(granted)));
        assert_eq!(find(&ahead, &mut { 100 }), Search::Nowhere);
        let deadlock = blame::deadlock(&ahead, NodeId(granted));
        assert_eq!(deadlock.sentence(&mission.names), expected);
    };
    check(&And(vec![Wants(1, 1), Wants(2, 1)]), 2, "b needs 2; a would hold left");
    let two = || Then(vec![Wants(1, 1), Wants(2, 0)]);
    let third = And(vec![two(), Then(vec![Wants(2, 1), Wants(2, 1)]), Keeps(ResourceId(0))]);
    check(&third, 8, "b holds right and needs 2; e would hold left");
}
