//! Rounds that ask only what has changed, beside plain recursion over the whole tree: every node says the same.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use ambidex::model::{MissionSpec, NodeId, NodeRange, Reason, Time};
use ambidex::tree::{Activation, Answer, Down, Effect, Input, Machines, News, Outbox, Scope, Settings, Up};
use ambidex::world::View;

const TOP: NodeId = NodeId(1);

/// What every node said last, and whether plain recursion says so.
pub struct Lockstep {
    mission: Arc<MissionSpec>,
    settings: Settings,
    view: Option<Arc<View>>,
    said: BTreeMap<NodeId, Answer>,
    reasons: BTreeMap<NodeId, Reason>,
    /// The first thing that was said otherwise.
    pub difference: Option<String>,
}

impl Lockstep {
    pub fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        Self {
            mission: Arc::clone(mission),
            settings: settings.clone(),
            view: None,
            said: BTreeMap::new(),
            reasons: BTreeMap::new(),
            difference: None,
        }
    }

    /// The tree is another one: who is gone says nothing.
    pub fn know(&mut self, mission: &Arc<MissionSpec>) {
        self.mission = Arc::clone(mission);
        let topology = &mission.tree.topology;
        self.said.retain(|node, _| topology.has(*node));
        self.reasons.retain(|node, _| topology.has(*node));
    }

    pub fn said_down(&mut self, child: NodeId, down: &Down) {
        if let Down::Activation(Activation { view, scope, .. }) = down {
            self.view = Some(Arc::clone(view));
            if child == TOP && *scope == Scope::Anew {
                self.reasons.clear();
            }
        }
    }

    pub fn said_up(&mut self, node: NodeId, up: &Up) {
        let Up::Answer { answer, news, .. } = up else { return };
        self.said.insert(node, Answer::clone(answer));
        if node == TOP {
            fold(&mut self.reasons, answer, news.as_deref());
            let view = self.view.take().expect("the top answers what it was asked");
            self.compare(&view);
        }
    }

    fn compare(&mut self, view: &Arc<View>) {
        if self.difference.is_some() {
            return;
        }
        let (plain, plain_reasons) = self.plainly(view);
        let differing = plain.iter().find(|(node, answer)| self.said.get(node) != Some(*answer));
        let name = |node: NodeId| self.mission.names.node(node).to_owned();
        if let Some((&node, answer)) = differing {
            let said = self.said.get(&node);
            let text = format!("{} in round {} said {said:?}, plainly {answer:?}", name(node), view.round);
            self.difference = Some(text);
            return;
        }
        // Root says why of what comes up to it, and of what it granted.
        let asking = &self.said[&TOP].requests;
        let is_below_root = |leaf: &NodeId| {
            !view.state.running().contains_key(leaf) && asking.iter().all(|request| request.leaf != *leaf)
        };
        let below = |reasons: &BTreeMap<NodeId, Reason>| -> Vec<(NodeId, Reason)> {
            let below = reasons.iter().filter(|(leaf, _)| is_below_root(leaf));
            below.map(|(&leaf, reason)| (leaf, reason.clone())).collect()
        };
        let (told, plain) = (below(&self.reasons), below(&plain_reasons));
        if told != plain {
            self.difference = Some(format!("reasons of round {}: {told:?}, plainly {plain:?}", view.round));
        }
    }

    /// Machines that have never been asked anything, asked all.
    fn plainly(&self, view: &Arc<View>) -> (BTreeMap<NodeId, Answer>, BTreeMap<NodeId, Reason>) {
        let mut nodes = Machines::new(&self.mission, &self.settings);
        let view = Arc::new(View { touched: None, ..View::clone(view) });
        let activation = Activation { view, skips: Arc::default(), scope: Scope::Anew };
        let mut inbox = VecDeque::from([(TOP, Input::Down(Down::Activation(activation)))]);
        let (mut answers, mut reasons) = (BTreeMap::new(), BTreeMap::new());
        let mut out = Outbox::default();
        while let Some((node, input)) = inbox.pop_front() {
            nodes.handle(Time::ZERO, node, input, &mut out);
            for effect in out.drain() {
                match effect {
                    Effect::Down(child, down) => inbox.push_back((child, Input::Down(down))),
                    Effect::Up(up) => {
                        let Up::Answer { answer, news, .. } = &up else { panic!("nothing ran") };
                        answers.insert(node, Answer::clone(answer));
                        if node == TOP {
                            fold(&mut reasons, answer, news.as_deref());
                        } else {
                            inbox.push_back((self.mission.tree.topology.parent(node), Input::Up(up)));
                        }
                    }
                    other => panic!("an answer is all that comes of it: {other:?}"),
                }
            }
        }
        (answers, reasons)
    }
}

fn fold(reasons: &mut BTreeMap<NodeId, Reason>, answer: &Answer, news: Option<&News>) {
    for &NodeRange { from, to } in news.iter().flat_map(|news| &news.withdrawn) {
        reasons.retain(|leaf, _| !(from..to).contains(leaf));
    }
    let of_leaf = (TOP, answer.reason.clone());
    for (leaf, reason) in news.iter().flat_map(|news| news.reasons.clone()).chain([of_leaf]) {
        match reason {
            Some(reason) => drop(reasons.insert(leaf, reason)),
            None => drop(reasons.remove(&leaf)),
        }
    }
}
