//! The task as written, to nodes in preorder: kinds and subtrees looked up, arguments filled in.

use std::collections::{BTreeMap, BTreeSet};

use super::node::{AND, NAMED, Node, OR, OfAll, THEN, USE, word_for};
use super::subtrees::{Filled, Part, Scope, Subtrees};
use super::told::Told;
use super::{Call, Draft, DraftKind, Surroundings};
use crate::describe::{Described, Reads};
use crate::document::SourceSpan;
use crate::fault::Faults;
use crate::kinds::{Declared, Kinds};
use crate::parameter::{Argument, Known, Parameter, assign, example, warn_of_unused};
use crate::reader::{Fields, Item, Name};
use crate::scope::Reading;
use crate::settings::Given;
use crate::types::Type;
use ambidex_model::{NodeId, PlaceId, nearest, suggestion};

/// Deepest tree: what files can nest.
const MAX_LEVELS: usize = 64;

/// The nodes read so far, in preorder.
pub(super) struct Flat<'a> {
    pub(super) kinds: &'a Kinds,
    pub(super) subtrees: &'a Subtrees,
    pub(super) known: Known<'a>,
    /// Where each object lies at the start.
    pub(super) starts: &'a [Option<PlaceId>],
    pub(super) drafts: Vec<Draft<'a>>,
    pub(super) parents: Vec<NodeId>,
    /// Parameters of the subtree at hand that something uses.
    pub(super) used: BTreeSet<usize>,
    /// Subtrees that the one at hand uses; while it is only checked they are not read.
    pub(super) uses: Option<Vec<(String, SourceSpan)>>,
    /// Whether there may be kinds and subtrees that nobody knows here.
    is_open: bool,
    most_nodes: usize,
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
    pub(super) fn new(subtrees: &'a Subtrees, around: &'a Surroundings<'a>) -> Self {
        let starts = around.world.map_or(&[][..], |world| &world.starts);
        Self {
            kinds: around.kinds,
            subtrees,
            known: around.known,
            starts,
            drafts: Vec::new(),
            parents: Vec::new(),
            used: BTreeSet::new(),
            uses: None,
            is_open: around.is_open,
            most_nodes: around.most_nodes,
        }
    }

    /// Reads a whole task; one that is a subtree has a label.
    pub(super) fn add_task(&mut self, task: Item<'_>, label: Option<&Name>, given: &Given, faults: &mut Faults) {
        let before = faults.errors();
        let scope = Scope::of_task(given, label.is_some());
        self.add(task, Under { wish: label, ..Under::root(&scope) }, faults);
        warn_of_unused(&given.parameters, &self.used, before, faults);
        if self.drafts.len() > self.most_nodes {
            faults.push(&task, format!("more than {} nodes", self.most_nodes));
        }
    }

    /// Reads a node and what is below it.
    pub(super) fn add(&mut self, item: Item<'_>, under: Under<'_>, faults: &mut Faults) {
        if self.drafts.len() > self.most_nodes {
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
        if self.is_open && is.is_none() {
            fields.others().for_each(|(_, item)| self.look_through(item, under.scope, faults));
        }
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
            let subtree = self.subtrees.get(&word.value).map(|subtree| &subtree.parameters);
            if self.is_open && subtree.is_none() {
                return self.suspect((word.span, &word.key), no_kind(&word.value), &word.value, faults);
            }
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
                None if self.is_open => self.suspect((key.span, &key.value), no_kind(&key.value), &key.value, faults),
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

    /// Parameters that the arguments of something use that nobody knows here.
    fn look_through(&mut self, item: Item<'_>, scope: &Scope<'_>, faults: &mut Faults) {
        if item.is_scalar() {
            scope.fill(item, Type::Text, &mut self.used, faults);
        }
        let values: Vec<_> = item.keys().filter_map(|key| item.value_of(key)).chain(item.each()).collect();
        values.into_iter().for_each(|value| self.look_through(value, scope, faults));
    }

    /// Warns of what nobody knows here and is nearly something that is known.
    fn suspect(&self, at: (SourceSpan, &str), message: String, found: &str, faults: &mut Faults) {
        if let Some(meant) = nearest(found, self.words()) {
            faults.warn(at, message, Some(format!("did you mean `{meant}`?")));
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
        Some(Call { stop: kind.stop(&arguments, self.starts), types: kind.types(&arguments, find), kind, arguments })
    }

    /// Reads a subtree where it is used.
    fn insert(&mut self, item: Item<'_>, span: SourceSpan, wish: Option<&Name>, under: Under<'_>, faults: &mut Faults) {
        let Some((subtree, values)) = self.used_subtree(item, span, faults) else {
            if self.is_open {
                self.look_through(item, under.scope, faults);
            }
            return;
        };
        let declared = &subtree.name;
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
        let label = subtree.label(first);
        let scope = Scope::of(&subtree.parameters, nodes);
        let saved = std::mem::take(&mut self.used);
        let inner = Under { scope: &scope, level: under.level + 1, wish: Some(wish.unwrap_or(&label)), ..under };
        self.add(subtree.task(), inner, faults);
        self.used = saved;
    }

    /// The subtree that a `use` names, and its arguments as written: `use: tidy` or `use: {deliver: {object: cup}}`.
    fn used_subtree<'i>(
        &self,
        item: Item<'i>,
        span: SourceSpan,
        faults: &mut Faults,
    ) -> Option<(&'a Part, Vec<Option<Item<'i>>>)> {
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
            let message = no_subtree(&name.value);
            if self.is_open {
                if let Some(meant) = nearest(&name.value, self.subtrees.names()) {
                    faults.warn((name.span, USE), message, Some(format!("did you mean `{meant}`?")));
                }
                return None;
            }
            faults.push_with((name.span, USE), message, || self.subtrees.suggestion(&name.value));
            return None;
        };
        let values = assign(&found.name, &found.parameters, arguments, name.span, faults)?;
        Some((found, values))
    }
}

/// That there is no subtree of a name.
pub(crate) fn no_subtree(found: &str) -> String {
    format!("there is no subtree `{found}`")
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
    for subtree in subtrees.unchecked() {
        flat.uses = Some(Vec::new());
        flat.used.clear();
        let before = faults.errors();
        let scope = Scope::open(&subtree.parameters);
        flat.add(subtree.task(), Under::root(&scope), faults);
        warn_of_unused(&subtree.parameters, &flat.used, before, faults);
        uses.insert(subtree.name.value.clone(), flat.uses.take().unwrap_or_default());
    }
    uses
}
