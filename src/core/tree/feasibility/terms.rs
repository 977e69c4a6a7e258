//! What behaviors read and make so, found once: every single condition with those who need it and those who can make it so.

use std::collections::BTreeMap;

use crate::behavior;
use ambidex_model::{BehaviorSpec, Condition, EffectTerm, FactId, Hold, MissionSpec, NodeId, ObjectId, PlaceId, Pose};

/// All of a mission.
#[derive(Debug, Default)]
pub(super) struct Terms {
    pub(super) all: Vec<Term>,
    pub(super) promises: BTreeMap<NodeId, Promise>,
    by_topic: BTreeMap<About, Vec<usize>>,
}

/// A single condition that somebody reads.
#[derive(Debug)]
pub(super) struct Term {
    pub(super) condition: Condition,
    /// Behaviors that make it so, in tree order.
    pub(super) makers: Vec<NodeId>,
    /// Behaviors of whose precondition it is, in tree order.
    pub(super) needed_by: Vec<NodeId>,
    /// These, and those whose goal it is.
    pub(super) readers: Vec<NodeId>,
}

/// What a behavior reads and makes, as indices of terms.
#[derive(Debug, Default)]
pub(super) struct Promise {
    pub(super) precondition: Vec<usize>,
    /// None where only running reaches it.
    pub(super) goal: Option<Vec<usize>>,
    pub(super) makes: Vec<usize>,
}

/// What a condition is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum About {
    Fact(FactId),
    Object(ObjectId),
    /// Where the base is.
    Base,
    /// Where it can come to.
    Path,
}

/// A condition in an order.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    At(PlaceId, Vec<[u64; 3]>, u64),
    Path(PlaceId, Vec<[u64; 3]>),
    Held(Hold),
    Free(ObjectId),
    Somewhere(ObjectId),
    Lies(ObjectId, PlaceId),
    Fact(FactId, bool),
}

impl Terms {
    pub(super) fn of(mission: &MissionSpec) -> Self {
        let mut terms = Self::default();
        let mut known = BTreeMap::new();
        let is_way = |leaf: &NodeId| !mission.tree.topology.is_in_cleanup(*leaf);
        for leaf in mission.tree.leaves().filter(is_way) {
            let Some(spec) = mission.tree.behavior(leaf) else { continue };
            let precondition = terms.read_of(&mut known, spec, |spec| &spec.precondition).unwrap_or_default();
            let goal = terms.read_of(&mut known, spec, |spec| &spec.satisfied);
            for &term in &precondition {
                push_once(&mut terms.all[term].needed_by, leaf);
            }
            for &term in precondition.iter().chain(goal.iter().flatten()) {
                push_once(&mut terms.all[term].readers, leaf);
            }
            terms.promises.insert(leaf, Promise { precondition, goal, makes: Vec::new() });
        }
        terms.find_makers(mission);
        terms
    }

    /// Terms about something.
    pub(super) fn about(&self, topic: About) -> &[usize] {
        self.by_topic.get(&topic).map(Vec::as_slice).unwrap_or_default()
    }

    /// The single conditions of a behavior; of one that follows an object those that it has wherever that lies.
    fn read_of(
        &mut self,
        known: &mut BTreeMap<Key, usize>,
        spec: &BehaviorSpec,
        of: impl Fn(&BehaviorSpec) -> &Condition,
    ) -> Option<Vec<usize>> {
        let own = self.read(known, of(spec))?;
        let Some(followed) = &spec.elsewhere else { return Some(own) };
        let mut common = own.clone();
        for other in &followed.at {
            let there = self.read(known, of(other))?;
            common.retain(|term| there.contains(term));
        }
        if common.len() < own.len() {
            common.extend(self.read(known, &Condition::Somewhere(followed.object))?);
        }
        Some(common)
    }

    /// The single conditions of one; none where it can never be met.
    fn read(&mut self, known: &mut BTreeMap<Key, usize>, condition: &Condition) -> Option<Vec<usize>> {
        let mut read = Vec::new();
        for single in behavior::singles(condition) {
            let (key, about) = key(single)?;
            let index = *known.entry(key).or_insert_with(|| {
                let (makers, needed_by, readers) = (Vec::new(), Vec::new(), Vec::new());
                self.by_topic.entry(about).or_default().push(self.all.len());
                self.all.push(Term { condition: single.clone(), makers, needed_by, readers });
                self.all.len() - 1
            });
            read.push(index);
        }
        Some(read)
    }

    fn find_makers(&mut self, mission: &MissionSpec) {
        let mut at_stands = BTreeMap::<[u64; 3], Vec<usize>>::new();
        for (&leaf, promise) in &mut self.promises {
            let Some(spec) = mission.tree.behavior(leaf) else { continue };
            let anywhere =
                spec.anywhere().flat_map(|there| there.stands.iter().flat_map(|stands| stands.iter()).chain([there]));
            for effect in anywhere.flat_map(behavior::promised) {
                let (about, stand) = match effect {
                    EffectTerm::Stands(stand) => (About::Base, Some(stand)),
                    EffectTerm::Lies(object, _) | EffectTerm::Taken(object, _) | EffectTerm::LetGo(object, _) => {
                        (About::Object(object), None)
                    }
                    EffectTerm::Fact(fact, _) => (About::Fact(fact), None),
                };
                let about = self.by_topic.get(&about).map(Vec::as_slice).unwrap_or_default();
                let made = || {
                    let is_made = |term: &&usize| behavior::becomes_so(effect, &self.all[**term].condition);
                    about.iter().filter(is_made).copied().collect()
                };
                match stand {
                    Some(stand) => promise.makes.extend(at_stands.entry(bits(&stand)).or_insert_with(made).iter()),
                    None => promise.makes.extend::<Vec<usize>>(made()),
                }
            }
            promise.makes.sort_unstable();
            promise.makes.dedup();
            for &term in &promise.makes {
                self.all[term].makers.push(leaf);
            }
        }
    }
}

/// None of what is never met.
fn key(single: &Condition) -> Option<(Key, About)> {
    Some(match single {
        // A list has no lists left in it once it is taken apart.
        Condition::All(_) | Condition::Never => return None,
        Condition::At { place, stands, tolerance_m } => {
            (Key::At(*place, stands.iter().map(bits).collect(), tolerance_m.to_bits()), About::Base)
        }
        Condition::Path { place, stands } => (Key::Path(*place, stands.iter().map(bits).collect()), About::Path),
        Condition::Held(hold) => (Key::Held(*hold), About::Object(hold.object)),
        Condition::Free(object) => (Key::Free(*object), About::Object(*object)),
        Condition::Somewhere(object) => (Key::Somewhere(*object), About::Object(*object)),
        Condition::Lies(object, place) => (Key::Lies(*object, *place), About::Object(*object)),
        Condition::Fact(fact, holds) => (Key::Fact(*fact, *holds), About::Fact(*fact)),
    })
}

fn bits(pose: &Pose) -> [u64; 3] {
    [pose.at.x, pose.at.y, pose.heading].map(f64::to_bits)
}

fn push_once(list: &mut Vec<NodeId>, leaf: NodeId) {
    if list.last() != Some(&leaf) {
        list.push(leaf);
    }
}
