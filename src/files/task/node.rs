//! A node of a task as it is written.

use crate::describe::{Count, Custom, Described, Later, Reads, Whole, Word, described};
use crate::kinds::MAX_RETRIES;
use crate::quantity::{BACKOFF, Quantity, TIMEOUT};
use crate::reader::Item;
use crate::shape::Form;
use ambidex_model::PRIORITY_MAX;

/// The key of an AND, and what it is called without a name.
pub(crate) const AND: &str = "and";
/// That of an OR.
pub(crate) const OR: &str = "or";
/// That of a THEN.
pub(crate) const THEN: &str = "then";
/// The key of a subtree that is used.
pub(crate) const USE: &str = "use";
/// The key of a cleanup, and what its node is called without a name.
pub(crate) const CLEANUP: &str = "cleanup";
/// The key of a node's name.
pub(super) const NAME: &str = "name";
/// The key of how long a node may take.
pub(super) const TIMEOUT_KEY: &str = "timeout";

pub(super) const NAMED: Word = Word("a name");
pub(super) const RETRIES: Count = Count(MAX_RETRIES);
pub(super) const URGENT: Whole = Whole(PRIORITY_MAX);
pub(super) const MAY_RUN: &Quantity = &TIMEOUT;
pub(super) const WAITS: &Quantity = &BACKOFF;
pub(super) const PERIOD: &Quantity = &TIMEOUT;

/// How often something may be done that is not done forever.
const MAX_REPEATS: u32 = 1_000_000;
/// Most times that something is done in a row without a pause, with all that is repeated around it.
pub(super) const MAX_AT_ONCE: u64 = 1_000;
/// The key of how often a node is done.
pub(super) const REPEAT: &str = "repeat";
const FOREVER: [&str; 1] = ["forever"];

/// How often something is done; none without end.
pub(super) const TIMES: Custom<Option<u32>> = Custom(
    || Form::Either(vec![Form::Count(MAX_REPEATS), Form::Words(&FOREVER)]),
    |item, reading| {
        if item.text() == Some(FOREVER[0]) {
            return Some(None);
        }
        let found = item.text().and_then(|text| text.parse().ok()).filter(|times| (1..=MAX_REPEATS).contains(times));
        if found.is_none() {
            item.wrong(&format!("a whole number from 1 to {MAX_REPEATS}, or `forever`"), reading.faults);
        }
        found.map(Some)
    },
);

const NODES: Later = Later(|| Form::List(Box::new(node_form())));
const ARGUMENTS: Later = Later(|| Form::Arguments);

described! {
    /// A node of a task; what stands in it is read once it is known what it is.
    pub(super) struct Node<'a>: "a node of the task",
    "Exactly one of `and`, `or`, `then`, `use`, or a kind of behavior with its arguments: `move: shelf`. A kind that needs \
     no argument may stand alone, as a word.",
    others ARGUMENTS, known [
        ("move", "Drive to a place: `to`, `offset`, `scale_by`.", ARGUMENTS),
        ("pick", "Take an object: `object`, `at`.", ARGUMENTS),
        ("place", "Set an object down: `object`, `at`.", ARGUMENTS),
    ] {
        and: Option<Item<'a>> = maybe(AND, "All of them, in any order.", NODES),
        or: Option<Item<'a>> = maybe(OR, "One of them.", NODES),
        then: Option<Item<'a>> = maybe(THEN, "All of them, in this order.", NODES),
        subtree: Option<Item<'a>> =
            maybe(USE, "A subtree with its arguments: `use: {deliver: {object: cup}}`.", ARGUMENTS),
        of_all: OfAll<'a> = all(OfAll),
    }
}

described! {
    /// What may stand beside whatever a node is.
    pub(super) struct OfAll<'a>: "a node of the task", "What may be told of any node." {
        name: Option<Item<'a>> =
            maybe(NAME, "What it is called; without one after what it is.", Later(|| NAMED.form())),
        retries: Option<Item<'a>> = maybe(
            "retries",
            "How often it is tried again after it failed; 2 for behaviors, 0 for `and`, `or`, `then`.",
            Later(|| RETRIES.form())
        ),
        backoff: Option<Item<'a>> = maybe(
            "backoff",
            "How long it waits before it is tried again, twice as long each further time; 0.5 s.",
            Later(|| WAITS.form())
        ),
        timeout: Option<Item<'a>> = maybe(
            TIMEOUT_KEY,
            "How long an attempt may take; of `and`, `or` and `then` from the first start below it.",
            Later(|| MAY_RUN.form())
        ),
        priority: Option<Item<'a>> = maybe(
            "priority",
            "How urgent it is, with all below it that tell none; the more urgent comes first and interrupts; 0.",
            Later(|| URGENT.form())
        ),
        repeat: Option<Item<'a>> = maybe(
            REPEAT,
            "How often it is done, or `forever`; once. More than 1000 times in a row need `every`.",
            Later(|| TIMES.form())
        ),
        every: Option<Item<'a>> = maybe(
            "every",
            "With `repeat`: how long after one time began the next begins, or at once if that is past.",
            Later(|| PERIOD.form())
        ),
        cleanup: Option<Item<'a>> = maybe(
            CLEANUP,
            "What is done where it has failed for good, is canceled or left, once something of it was begun.",
            Later(node_form)
        ),
    }
}

/// How a node is written: a map, or the kind of a behavior alone.
pub(crate) fn node_form() -> Form {
    Form::Either(vec![Form::Word, Form::Map(Node::shape)])
}

/// What other tools call what a task can say.
const ELSEWHERE: &[(&str, &[&str])] = &[
    (THEN, &["sequence", "sequential", "seq", "serial", "steps", "chain"]),
    (OR, &["fallback", "selector", "select", "choice", "alternative", "alternatives", "any", "one_of", "either"]),
    (AND, &["parallel", "concurrent", "concurrence", "concurrently", "all", "both", "simultaneous", "unordered"]),
    (USE, &["subtree", "subtask", "call", "run", "include"]),
    ("move", &["navigate", "navigate_to", "goto", "go_to", "go", "drive", "drive_to", "move_to", "move_base"]),
    ("pick", &["grasp", "grab", "take", "pick_up", "pickup", "get", "fetch"]),
    ("place", &["put", "put_down", "drop", "set_down", "release"]),
];

/// The word for what another tool calls otherwise, however that is written.
pub(super) fn word_for(elsewhere: &str) -> Option<&'static str> {
    let plain = |text: &str| text.to_lowercase().replace(['_', '-', ' '], "");
    let is_meant = |words: &&[&str]| words.iter().any(|word| plain(word) == plain(elsewhere));
    ELSEWHERE.iter().find(|(_, words)| is_meant(words)).map(|(word, _)| *word)
}
