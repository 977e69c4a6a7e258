//! The task as written, to nodes in preorder: kinds and subtrees looked up, arguments filled in.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use super::node::{AND, MAY_RUN, NAMED, Node, OR, OfAll, PERIOD, RETRIES, THEN, TIMES, URGENT, USE, WAITS, word_for};
use super::subtrees::{Filled, Named, Scope, Subtrees};
use super::{Call, Draft, DraftKind, MAX_NODES, Surroundings};
use crate::describe::{Described, Reads};
use crate::document::SourceSpan;
use crate::fault::Faults;
use crate::kinds::{BACKOFF_S, Declared, Kinds};
use crate::parameter::{Argument, Known, Parameter, assign, example, warn_of_unused};
use crate::reader::{Fields, Item, Name};
use crate::scope::Reading;
use crate::types::Type;
use ambidex_model::{BehaviorSpec, Limits, NodeId, PlaceId, Pose, Repeat, nearest, suggestion};

/// Deepest tree: what files can nest.
const MAX_LEVELS: usize = 64;

/// The nodes read so far, in preorder.
pub(super) struct Flat<'a> {
    pub(super) kinds: &'a Kinds,
    pub(super) subtrees: &'a Subtrees<'a>,
    pub(super) known: Known<'a>,
    pub(super) stands: &'a [Pose],
    /// Where each object lies at the start.
    pub(super) starts: &'a [Option<PlaceId>],
    pub(super) drafts: Vec<Draft<'a>>,
    pub(super) parents: Vec<NodeId>,
    /// Parameters of the subtree at hand that something uses.
    pub(super) used: BTreeSet<usize>,
    /// Subtrees that the one at hand uses; while it is only checked they are not read.
    pub(super) uses: Option<Vec<(String, SourceSpan)>>,
}

/// Where a node goes.
#[derive(Clone, Copy)]
pub(super) struct Under<'s> {
    parent: NodeId,
    level: usize,
    scope: &'s Scope<'s>,
    /// What the node is to be called: the name of the `use` that it comes from.
    wish: Option<&'s Name>,
    /// What that `use` tells of it, which wins over its own.
    told: Told,
}

/// How long a node may take, and how often it is tried, as far as that is told.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told {
    pub(super) retries: Option<u32>,
    pub(super) backoff_s: Option<f64>,
    pub(super) timeout_s: Option<f64>,
    pub(super) priority: Option<i32>,
    pub(super) repeat: Option<Repeat>,
}

impl Told {
    fn of(written: &OfAll<'_>, faults: &mut Faults) -> Self {
        Self {
            priority: written.priority.and_then(|item| URGENT.take(item, faults)),
            repeat: repeat(written, faults),
            retries: written.retries.and_then(|item| RETRIES.take(item, faults)),
            backoff_s: written.backoff.and_then(|item| WAITS.take(item, faults)),
            timeout_s: written.timeout.and_then(|item| MAY_RUN.take(item, faults)),
        }
    }

    /// The same, but for what is told by something that wins.
    fn or(self, winner: Self) -> Self {
        Self {
            retries: winner.retries.or(self.retries),
            backoff_s: winner.backoff_s.or(self.backoff_s),
            timeout_s: winner.timeout_s.or(self.timeout_s),
            priority: winner.priority.or(self.priority),
            repeat: winner.repeat.or(self.repeat),
        }
    }

    /// What it makes of a behavior, wherever an object lies that this follows.
    pub(super) fn tell(self, behavior: &mut BehaviorSpec) {
        behavior.timeout = self.timeout_s.map_or(behavior.timeout, Duration::from_secs_f64);
        behavior.retries = self.retries.unwrap_or(behavior.retries);
        behavior.backoff = self.backoff_s.map_or(behavior.backoff, Duration::from_secs_f64);
        if let Some(followed) = &mut behavior.elsewhere {
            Arc::make_mut(followed).at.iter_mut().for_each(|other| self.tell(other));
        }
    }

    /// What it makes of a task node; none where nothing is told.
    pub(super) fn limits(self) -> Option<Limits> {
        let is_told = self.retries.is_some() || self.backoff_s.is_some() || self.timeout_s.is_some();
        is_told.then(|| Limits {
            timeout: self.timeout_s.map(Duration::from_secs_f64),
            retries: self.retries.unwrap_or_default(),
            backoff: Duration::from_secs_f64(self.backoff_s.unwrap_or(BACKOFF_S)),
        })
    }
}

/// How often a node is done, and when; none where that is once.
fn repeat(written: &OfAll<'_>, faults: &mut Faults) -> Option<Repeat> {
    let every = written.every.and_then(|item| PERIOD.take(item, faults)).map(Duration::from_secs_f64);
    let Some(item) = written.repeat else {
        if let Some(every) = &written.every {
            faults.push_with(every, "nothing is repeated here", "write `repeat: forever`, or how often, beside it");
        }
        return None;
    };
    let times = TIMES.take(item, faults)?;
    if times.is_none() && written.every.is_none() {
        faults.push_with(
            &item,
            "repeated without end, it never rests",
            "write how often beside it, such as `every: 60 s`",
        );
    }
    Some(Repeat { times, every })
}

/// What a node turned out to be.
enum Is<'a, 'i> {
    Composite(DraftKind<'a>, Item<'i>),
    Use(Item<'i>),
    Behavior(&'a Declared, Item<'i>),
}

impl<'s> Under<'s> {
    /// Right below the root.
    pub(super) fn root(scope: &'s Scope<'s>) -> Self {
        Self { parent: NodeId(0), level: 1, scope, wish: None, told: Told::default() }
    }
}

impl<'a> Flat<'a> {
    pub(super) fn new(subtrees: &'a Subtrees<'a>, around: &'a Surroundings<'a>, stands: &'a [Pose]) -> Self {
        let starts = around.world.map_or(&[][..], |world| &world.starts);
        Self {
            kinds: around.kinds,
            subtrees,
            known: around.known,
            stands,
            starts,
            drafts: Vec::new(),
            parents: Vec::new(),
            used: BTreeSet::new(),
            uses: None,
        }
    }

    /// Reads a node and what is below it.
    pub(super) fn add(&mut self, item: Item<'_>, under: Under<'_>, faults: &mut Faults) {
        if self.drafts.len() > MAX_NODES {
            return;
        }
        if under.level > MAX_LEVELS {
            faults.push(&item, format!("more than {MAX_LEVELS} nodes one in another"));
            return;
        }
        if item.is_scalar() {
            self.add_word(item, under, faults);
            return;
        }
        let Some(fields) = item.fields(Node::shape(), faults) else { return };
        let Some(written) = Node::from_map(&fields, &mut Reading::new(faults)) else { return };
        let is = self.is(&written, &fields, faults);
        let name = written.of_all.name.and_then(|item| self.name(item, under.scope, faults));
        let told = Told::of(&written.of_all, faults).or(under.told);
        match written.of_all.cleanup {
            Some(cleanup) => {
                let outer = Told { priority: told.priority, ..Told::default() };
                let parent = self.begin_draft(Some(DraftKind::Cleanup), outer, None, fields.span(), under);
                let below = Under { parent, level: under.level + 1, ..under };
                self.add_known(is, told, name, fields.span(), below, faults);
                self.add(cleanup, Under { wish: None, told: Told::default(), ..below }, faults);
            }
            None => self.add_known(is, told, name, fields.span(), under, faults),
        }
    }

    /// Adds a node of which it is known what it is, and what is below it.
    fn add_known(
        &mut self,
        is: Option<Is<'a, '_>>,
        told: Told,
        name: Option<Name>,
        span: SourceSpan,
        under: Under<'_>,
        faults: &mut Faults,
    ) {
        match is {
            Some(Is::Use(item)) => {
                self.insert(item, span, name.as_ref().or(under.wish), Under { told, ..under }, faults);
            }
            is => self.add_draft(is, told, name, span, under, faults),
        }
    }

    /// Adds a node that is a word alone: a kind of behavior that needs no argument.
    fn add_word(&mut self, item: Item<'_>, under: Under<'_>, faults: &mut Faults) {
        let kinds = self.kinds;
        let Some(word) = item.name("a node of the task", faults).filter(|word| !kinds.is_broken(&word.value)) else {
            return;
        };
        let Some(kind) = kinds.get(&word.value) else {
            let subtree = self.subtrees.get(&word.value).map(|(_, subtree)| &subtree.parameters);
            let help = || match subtree {
                Some(parameters) => format!("write `{{{USE}: {}}}`", example(&word.value, parameters)),
                None => self.kind_meant(&word.value),
            };
            faults.push_with(&word, no_kind(&word.value), help);
            return;
        };
        if let Some(lacking) = kind.parameters.iter().find(|parameter| parameter.defaults.is_none()) {
            let message =
                format!("`{}` lacks its parameter `{}`, {}", word.value, lacking.name.value, lacking.ty.what());
            faults.push_with(&word, message, format!("write `{}`", example(&word.value, &kind.parameters)));
            return;
        }
        let nothing = Item::nothing(item.key, item.span);
        let is = Some(Is::Behavior(kind, nothing));
        self.add_draft(is, under.told, None, item.span, under, faults);
    }

    /// Adds a node that is no `use`, and what is below it.
    fn add_draft(
        &mut self,
        is: Option<Is<'a, '_>>,
        told: Told,
        name: Option<Name>,
        span: SourceSpan,
        under: Under<'_>,
        faults: &mut Faults,
    ) {
        let name = name.or_else(|| under.wish.cloned());
        let node = self.begin_draft(None, told, name, span, under);
        match is {
            Some(Is::Composite(kind, item)) => {
                self.drafts[node.index()].kind = Some(kind);
                let below = Under { parent: node, level: under.level + 1, wish: None, told: Told::default(), ..under };
                for child in item.list("a list of nodes, each with a dash", faults).into_iter().flatten() {
                    self.add(child, below, faults);
                }
            }
            Some(Is::Behavior(kind, item)) => {
                let call = self.call(kind, item, span, under.scope, faults);
                self.drafts[node.index()].kind = call.map(|call| DraftKind::Behavior(Box::new(call)));
            }
            Some(Is::Use(_)) | None => {}
        }
    }

    fn begin_draft(
        &mut self,
        kind: Option<DraftKind<'a>>,
        told: Told,
        name: Option<Name>,
        span: SourceSpan,
        under: Under<'_>,
    ) -> NodeId {
        let node = NodeId::from(self.drafts.len());
        self.drafts.push(Draft { span, name, is_used: under.scope.is_subtree, kind, told });
        self.parents.push(under.parent);
        node
    }

    /// What a node is: exactly one of AND, OR, THEN, a use, or a kind of behavior.
    fn is<'i>(&self, node: &Node<'i>, fields: &Fields<'i>, faults: &mut Faults) -> Option<Is<'a, 'i>> {
        let kinds = self.kinds;
        let composites = [(node.and, DraftKind::And), (node.or, DraftKind::Or), (node.then, DraftKind::Then)];
        let composites = composites.into_iter().filter_map(|(item, kind)| Some(Is::Composite(kind, item?)));
        let mut found: Vec<_> = composites.chain(node.subtree.map(Is::Use)).collect();
        if fields.others().any(|(key, _)| kinds.is_broken(&key.value)) {
            return None;
        }
        let (known, unknown): (Vec<_>, Vec<_>) = fields.others().partition(|(key, _)| kinds.get(&key.value).is_some());
        found.extend(known.into_iter().filter_map(|(key, item)| Some(Is::Behavior(kinds.get(&key.value)?, item))));
        for (key, _) in &unknown {
            match found.first() {
                None => faults.push_with((key.span, &key.value), no_kind(&key.value), || self.kind_meant(&key.value)),
                Some(_) => fields.unknown(key, OfAll::shape().keys(), faults),
            }
        }
        if found.len() > 1 || (found.is_empty() && unknown.is_empty()) {
            fields.not_one_of(found.len(), self.words(), faults);
            return None;
        }
        found.pop()
    }

    /// All that a node can be.
    fn words(&self) -> impl Iterator<Item = &str> {
        [AND, OR, THEN, USE].into_iter().chain(self.kinds.names())
    }

    /// What was meant by a kind of node that there is not.
    fn kind_meant(&self, found: &str) -> String {
        let word = word_for(found).filter(|_| nearest(found, self.words()).is_none());
        match word {
            Some(word) => format!("did you mean `{word}`? Allowed: {}", listed(self.words())),
            None => suggestion(found, "kind of node", self.words()),
        }
    }

    fn name(&mut self, item: Item<'_>, scope: &Scope<'_>, faults: &mut Faults) -> Option<Name> {
        let name = NAMED.take(item, faults)?;
        match scope.fill(item, Type::Text, &mut self.used, faults)? {
            Filled::Value(node) => Some(Name { value: Item::of(item.key, &node).text()?.to_owned(), ..name }),
            Filled::Open => Some(name),
        }
    }

    /// The arguments of a node, each looked up; none for what is left to its default or is not known yet.
    fn arguments(
        &mut self,
        parameters: &[Parameter],
        values: &[Option<Item<'_>>],
        scope: &Scope<'_>,
        faults: &mut Faults,
    ) -> Option<Vec<Option<(Argument, Filled)>>> {
        let before = faults.errors();
        let mut arguments = Vec::with_capacity(parameters.len());
        for (parameter, value) in parameters.iter().zip(values) {
            let filled = value.and_then(|item| Some((item, scope.fill(item, parameter.ty, &mut self.used, faults)?)));
            let argument = filled.and_then(|(item, filled)| match filled {
                Filled::Open => None,
                Filled::Value(node) => {
                    let argument = self.known.argument(Item::of(item.key, &node), parameter.ty, faults)?;
                    Some((argument, Filled::Value(node)))
                }
            });
            arguments.push(argument);
        }
        (faults.errors() == before).then_some(arguments)
    }

    fn call(
        &mut self,
        kind: &'a Declared,
        item: Item<'_>,
        span: SourceSpan,
        scope: &Scope<'_>,
        faults: &mut Faults,
    ) -> Option<Call<'a>> {
        let values = assign(&kind.name, &kind.parameters, item, span, faults)?;
        let arguments = self.arguments(&kind.parameters, &values, scope, faults)?;
        let arguments: Vec<_> = arguments.into_iter().map(|given| given.map(|(argument, _)| argument)).collect();
        let types = self.known.robot.map(|names| &names.types);
        let find = |word: &str| types.and_then(|types| types.id(word)).map(Into::into);
        Some(Call {
            stop: kind.stop(&arguments, self.stands, self.starts),
            types: kind.types(&arguments, find),
            kind,
            arguments,
        })
    }

    /// Reads a subtree where it is used.
    fn insert(&mut self, item: Item<'_>, span: SourceSpan, wish: Option<&Name>, under: Under<'_>, faults: &mut Faults) {
        let Some(((declared, subtree), values)) = self.used_subtree(item, span, faults) else { return };
        let given = self.arguments(&subtree.parameters, &values, under.scope, faults);
        if let Some(uses) = &mut self.uses {
            uses.push((declared.value.clone(), item.span));
            return;
        }
        let Some(given) = given.filter(|_| !self.subtrees.is_endless(&declared.value)) else { return };
        let mut nodes = Vec::with_capacity(given.len());
        let mut first = None;
        for (parameter, given) in subtree.parameters.iter().zip(given) {
            let default = || parameter.defaults.as_ref().and_then(|defaults| defaults.first()).cloned();
            nodes.push(match given {
                Some((argument, Filled::Value(node))) => {
                    first.get_or_insert(argument.text);
                    Some(node)
                }
                Some((_, Filled::Open)) | None => default(),
            });
        }
        let value = [Some(declared.value.clone()), first].into_iter().flatten().collect::<Vec<_>>().join(" ");
        let label = Name { value, ..declared.clone() };
        let scope = Scope::of(&subtree.parameters, nodes);
        let saved = std::mem::take(&mut self.used);
        let inner = Under { scope: &scope, level: under.level + 1, wish: Some(wish.unwrap_or(&label)), ..under };
        self.add(subtree.task, inner, faults);
        self.used = saved;
    }

    /// The subtree that a `use` names, and its arguments as written: `use: tidy` or `use: {deliver: {object: cup}}`.
    fn used_subtree<'i>(
        &self,
        item: Item<'i>,
        span: SourceSpan,
        faults: &mut Faults,
    ) -> Option<(&'a Named<'a>, Vec<Option<Item<'i>>>)> {
        let (name, arguments) = if item.is_map() {
            let mut entries = item.named("a subtree and its arguments", faults)?;
            if entries.len() != 1 {
                item.wrong("one subtree with its arguments", faults);
                return None;
            }
            entries.pop()?
        } else {
            (item.name("a subtree", faults)?, Item::nothing(item.key, span))
        };
        if self.subtrees.is_broken(&name.value) {
            return None;
        }
        let Some(found) = self.subtrees.get(&name.value) else {
            let message = format!("there is no subtree `{}`", name.value);
            faults.push_with((name.span, USE), message, || suggestion(&name.value, "subtree", self.subtrees.names()));
            return None;
        };
        let values = assign(&found.0, &found.1.parameters, arguments, name.span, faults)?;
        Some((found, values))
    }
}

fn no_kind(found: &str) -> String {
    format!("there is no kind of node `{found}`")
}

fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// Checks every subtree by itself, used or not; who uses target comes back.
pub(super) fn check_subtrees(flat: &mut Flat<'_>, faults: &mut Faults) -> BTreeMap<String, Vec<(String, SourceSpan)>> {
    let mut uses = BTreeMap::new();
    let subtrees = flat.subtrees;
    for (name, subtree) in subtrees.iter() {
        flat.uses = Some(Vec::new());
        flat.used.clear();
        let before = faults.errors();
        let scope = Scope::open(&subtree.parameters);
        flat.add(subtree.task, Under::root(&scope), faults);
        warn_of_unused(&subtree.parameters, &flat.used, before, faults);
        uses.insert(name.value.clone(), flat.uses.take().unwrap_or_default());
    }
    uses
}
