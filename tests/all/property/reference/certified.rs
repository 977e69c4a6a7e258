//! What a certificate came to is taken from the core: the page says when somebody may be refused for it, and the search
//! for an order is no part of this model. All else that a round comes to follows here.

use ambidex::model::{Grant, NodeId, Reason, Record};

use super::{Ask, Model, Refusal};

/// What a certificate did to a request in one round.
#[derive(Debug, Clone)]
pub enum Certified {
    Refused(NodeId, Reason),
    /// Granted as it was bound; another way than the cheapest where that would have left no order.
    Bound(Grant),
}

impl Certified {
    /// Of each round that a run decided.
    pub fn of_rounds(records: &[Record]) -> impl Iterator<Item = Vec<Self>> {
        records.iter().filter_map(|record| {
            let Record::Decided { granted, refused, .. } = record else { return None };
            let is_it = |reason: &Reason| matches!(reason, Reason::WouldDeadlock { .. });
            let refused = refused.iter().filter(|blocked| is_it(&blocked.reason));
            let refused = refused.map(|blocked| Self::Refused(blocked.leaf, blocked.reason.clone()));
            Some(refused.chain(granted.iter().cloned().map(Self::Bound)).collect())
        })
    }
}

impl Model<'_> {
    /// What was chosen and would leave no order asks no more in this round, and what was bound otherwise is.
    pub(super) fn drop_what_would_deadlock(&mut self, asks: &mut Vec<Ask>) -> Vec<(NodeId, Refusal)> {
        let mut refused = Vec::new();
        for certified in self.certified.pop_front().unwrap_or_default() {
            match certified {
                Certified::Refused(leaf, _) if self.hidden.contains_key(&leaf) => {}
                Certified::Refused(leaf, reason) => {
                    let before = asks.len();
                    asks.retain(|ask| ask.grant.leaf() != leaf || ask.wish.is_some());
                    assert!(asks.len() < before, "{leaf:?} did not ask");
                    refused.push((leaf, reason.into()));
                }
                Certified::Bound(grant) => {
                    let of_grant = |ask: &&mut Ask| ask.grant.leaf() == grant.leaf() && ask.wish.is_none();
                    if let Some(ask) = asks.iter_mut().find(of_grant) {
                        for (serving, binding) in std::iter::zip(&mut ask.serving, &grant.bindings) {
                            serving.retain(|(id, _)| *id == binding.resource);
                        }
                    }
                }
            }
        }
        refused
    }
}
