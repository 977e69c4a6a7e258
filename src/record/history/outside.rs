//! What others than behaviors changed in the world: of each fact and object the last, and where the past is kept all.

use std::collections::BTreeMap;

use ambidex_model::{Change, FactId, Names, ObjectId, Origin, Record, Time};

/// A change of the world that no behavior made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideChange {
    /// When root applied it.
    pub at: Time,
    /// What is different.
    pub change: Change,
    /// Who says so.
    pub origin: Origin,
}

/// Who made each fact and object as it is, where that was no behavior.
#[derive(Debug, Clone, Default)]
pub(super) struct Makers {
    pub(super) facts: BTreeMap<FactId, OutsideChange>,
    pub(super) objects: BTreeMap<ObjectId, OutsideChange>,
}

impl Makers {
    /// Takes the next record; ids that nothing is called by are passed over.
    pub(super) fn apply(&mut self, at: Time, record: &Record, names: &Names) {
        match record {
            Record::World { change, origin, .. } => {
                let made = OutsideChange { at, change: *change, origin: *origin };
                match *change {
                    Change::Fact(fact, _) if fact.index() < names.facts.len() => {
                        self.facts.insert(fact, made);
                    }
                    Change::Fact(..)
                    | Change::Base(_)
                    | Change::Emptied(_)
                    | Change::Blocked(_)
                    | Change::Cleared(_) => {}
                    Change::Object(object, _) | Change::Laid(object, ..) | Change::Taken(object, _) => {
                        if object.index() < names.objects.len() {
                            self.objects.insert(object, made);
                        }
                    }
                }
            }
            Record::Released { changes, .. } => changes.iter().for_each(|change| match change {
                Change::Fact(fact, _) => drop(self.facts.remove(fact)),
                Change::Object(object, _) | Change::Laid(object, ..) | Change::Taken(object, _) => {
                    self.objects.remove(object);
                }
                Change::Base(_) | Change::Emptied(_) | Change::Blocked(_) | Change::Cleared(_) => {}
            }),
            Record::Header(_) | Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => {}
            Record::Began { .. } | Record::Sent { .. } | Record::Decided { .. } | Record::Denied { .. } => {}
            Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } => {}
            Record::Overtaken { .. } | Record::Stopped { .. } | Record::Woke { .. } => {}
            Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } => {}
            Record::Served { .. } | Record::Awaited { .. } | Record::Resource { .. } => {}
            Record::Controller { .. } | Record::Ended { .. } => {}
            Record::Added { .. } | Record::Removed { .. } | Record::TaskEnded { .. } => {}
            Record::Granting { .. } | Record::Canceled { .. } | Record::Stalled { .. } => {}
            Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. } => {}
        }
    }
}
