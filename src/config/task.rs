//! The task as read, to a tree in preorder: names looked up, nodes named, every behavior bound to robot and world.

use std::time::Duration;

use nalgebra::Vector2;

use super::document::Spot;
use super::fault::Faults;
use super::kinds::{Context, GRIPPER, Kind, Lack, Stop, Types};
use super::labels::label;
use super::names::Register;
use super::raw;
use super::reader::Name;
use super::robot::RobotFile;
use super::siblings::{Afters, moves_before};
use super::world::{Built, WorldNames};
use crate::model::{NodeId, NodeKind, ObjectId, PlaceId, Topology, TreeSpec, TypeId};

/// Most nodes of a task.
pub(super) const MAX_NODES: usize = 100_000;

/// What a task is bound to.
pub(super) struct Surroundings<'a> {
    pub(super) robot: Option<&'a RobotFile>,
    pub(super) world: Option<&'a Built>,
    pub(super) names: &'a WorldNames,
}

/// A node with its names looked up.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    pub(super) spot: Spot,
    pub(super) name: Option<Name>,
    /// None when something in it is wrong; that has its fault.
    pub(super) kind: Option<DraftKind>,
    retries: Option<u32>,
    timeout_s: Option<f64>,
}

/// What a node is.
#[derive(Debug, Clone, Copy)]
pub(super) enum DraftKind {
    Root,
    And,
    Or,
    Then,
    Behavior(Kind),
}

/// The tree and the names of its nodes; `None` when it has faults.
pub(super) fn build(raw: raw::Task, around: &Surroundings<'_>, faults: &mut Faults) -> Option<(TreeSpec, Vec<String>)> {
    let mut flat = Flat {
        around,
        types: around.robot.map(|file| types_of(&file.names.types)),
        drafts: vec![Draft::root(raw.spot)],
        parents: vec![NodeId(0)],
    };
    flat.add(raw, NodeId(0), faults);
    let Flat { drafts, parents, types, .. } = flat;
    if drafts.len() > MAX_NODES {
        let message = format!("more than {MAX_NODES} nodes");
        faults.push(drafts[0].spot, "task", message, None);
        return None;
    }
    let topology = Topology::new(parents);
    let names = label(&drafts, &around.names.places, &around.names.objects, faults);
    let nodes = bind_all(&drafts, &topology, types, around, faults)?;
    Some((TreeSpec { nodes, topology }, names))
}

fn types_of(names: &[String]) -> Register {
    Register::of("type of resource", names.iter().map(String::as_str))
}

impl Draft {
    fn root(spot: Spot) -> Self {
        Self { spot, name: None, kind: Some(DraftKind::Root), retries: None, timeout_s: None }
    }
}

/// The nodes read so far, in preorder.
struct Flat<'a> {
    around: &'a Surroundings<'a>,
    types: Option<Register>,
    drafts: Vec<Draft>,
    parents: Vec<NodeId>,
}

impl Flat<'_> {
    fn add(&mut self, raw: raw::Task, parent: NodeId, faults: &mut Faults) {
        let node = NodeId::from(self.drafts.len());
        self.drafts.push(Draft {
            spot: raw.spot,
            name: raw.name,
            kind: None,
            retries: raw.retries,
            timeout_s: raw.timeout_s,
        });
        self.parents.push(parent);
        let (kind, children) = match raw.kind {
            Some(raw::Kind::And(children)) => (Some(DraftKind::And), children),
            Some(raw::Kind::Or(children)) => (Some(DraftKind::Or), children),
            Some(raw::Kind::Then(children)) => (Some(DraftKind::Then), children),
            Some(raw::Kind::Behavior(behavior)) => {
                let kind = self.look_up(behavior, faults);
                (kind.map(DraftKind::Behavior), Vec::new())
            }
            None => (None, Vec::new()),
        };
        self.drafts[node.index()].kind = kind;
        for child in children {
            self.add(child, node, faults);
        }
    }

    fn look_up(&self, raw: raw::Behavior, faults: &mut Faults) -> Option<Kind> {
        match raw {
            raw::Behavior::Move { to, offset, scale_by } => {
                let place = self.place(&to, faults);
                let scale_by = self.scale_by(scale_by.as_ref(), faults);
                let stop = self.stop(place?, offset)?;
                Some(Kind::Move { to: stop, scale_by })
            }
            raw::Behavior::Pick { object, at } => {
                let object = self.object(&object, faults);
                let at = at.map(|at| self.place(&at, faults));
                Some(Kind::Pick { object: object?, at: all_or_none(at)? })
            }
            raw::Behavior::Place { object, at } => {
                let object = self.object(&object, faults);
                let at = at.map(|at| self.place(&at, faults));
                Some(Kind::Place { object: object?, at: all_or_none(at)? })
            }
        }
    }

    fn place(&self, name: &Name, faults: &mut Faults) -> Option<PlaceId> {
        let found = self.around.names.places.find(name, faults);
        found.map(PlaceId::from)
    }

    fn object(&self, name: &Name, faults: &mut Faults) -> Option<ObjectId> {
        let found = self.around.names.objects.find(name, faults);
        found.map(ObjectId::from)
    }

    /// A type that is written must be one of the robot's; the default counts only when it is.
    fn scale_by(&self, name: Option<&Name>, faults: &mut Faults) -> Option<TypeId> {
        let types = self.types.as_ref()?;
        let found = match name {
            Some(name) => types.find(name, faults),
            None => types.id(GRIPPER),
        };
        found.map(TypeId::from)
    }

    fn stop(&self, place: PlaceId, offset: [f64; 2]) -> Option<Stop> {
        let mut stand = self.around.world?.spec.places[place.index()].stand;
        stand.at += Vector2::from(offset);
        Some(Stop { place, stand })
    }
}

fn all_or_none(found: Option<Option<PlaceId>>) -> Option<Option<PlaceId>> {
    match found {
        Some(None) => None,
        Some(place @ Some(_)) => Some(place),
        None => Some(None),
    }
}

fn bind_all(
    drafts: &[Draft],
    topology: &Topology,
    types: Option<Register>,
    around: &Surroundings<'_>,
    faults: &mut Faults,
) -> Option<Vec<NodeKind>> {
    let types = types?;
    let id = |word| types.id(word).map(TypeId::from);
    let types = Types { gripper: id(GRIPPER), head: id(super::kinds::HEAD), base: id(super::kinds::BASE) };
    let world = around.world?;
    let stands: Vec<_> = world.spec.places.iter().map(|place| place.stand).collect();
    let befores = moves_before(drafts, topology);
    let afters = Afters::of(drafts, topology);
    let mut nodes = Vec::with_capacity(drafts.len());
    for (index, draft) in drafts.iter().enumerate() {
        let context = Context {
            robot: &around.robot?.robot,
            types,
            stands: &stands,
            starts: &world.starts,
            tolerance_m: world.tolerance_m,
            before: befores[index],
        };
        nodes.push(bind(draft, &context, &afters, index, faults));
    }
    nodes.into_iter().collect()
}

fn bind(draft: &Draft, context: &Context<'_>, afters: &Afters, index: usize, faults: &mut Faults) -> Option<NodeKind> {
    let kind = match draft.kind? {
        DraftKind::Root => return Some(NodeKind::Root),
        DraftKind::And => return Some(NodeKind::And),
        DraftKind::Or => return Some(NodeKind::Or),
        DraftKind::Then => return Some(NodeKind::Then),
        DraftKind::Behavior(kind) => afters.scaled(kind, index, &context.types),
    };
    match kind.bind(context) {
        Ok(mut behavior) => {
            let timeout = draft.timeout_s.map(Duration::from_secs_f64);
            behavior.timeout = timeout.unwrap_or(behavior.timeout);
            behavior.retries = draft.retries.unwrap_or(behavior.retries);
            Some(NodeKind::Behavior(Box::new(behavior)))
        }
        Err(lack) => {
            let (message, help) = match lack {
                Lack::Resource(ty) => {
                    (format!("the robot has no resource of type `{ty}`"), "see `resources` in the robot file")
                }
                Lack::Destination => {
                    ("not told where to".to_owned(), "write `at`, or let it follow a `move` in a `then`")
                }
            };
            faults.push(draft.spot, kind.word(), message, Some(help.to_owned()));
            None
        }
    }
}
