//! A run once more from what its log says that root was told, with every decision compared: the same machines, one
//! message after the other, no controllers.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::tree::{Effect, Input, Node, Outbox, Root, Settings, Up, build};
use ambidex_model::{Header, MissionEnd, MissionSpec, NodeId, Record, Time, Told, Topology};

/// A log that is taken record by record, the header first.
#[derive(Debug)]
pub struct Replay {
    nodes: Vec<Node>,
    topology: Topology,
    /// Whether decisions are logged with every refusal.
    has_refusals: bool,
    /// What root made and the log has not told yet.
    made: VecDeque<Record>,
    /// Messages of the last turn, with the records that root made of it in between.
    turn: Option<Vec<Record>>,
    inbox: VecDeque<(NodeId, Input)>,
    told_to_end: Vec<MissionEnd>,
    decisions: u64,
}

/// A record of the log that does not follow from those before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// What the log says; none where it goes on without what follows.
    pub found: Option<Box<Record>>,
    /// What follows; none where nothing does.
    pub expected: Option<Box<Record>>,
}

impl Replay {
    /// Before the first turn of a mission that was run as its log's header says.
    pub fn new(mission: &Arc<MissionSpec>, settings: &Settings, header: &Header) -> Self {
        Self {
            nodes: build(mission, settings),
            topology: mission.tree.topology.clone(),
            has_refusals: header.has_messages,
            made: VecDeque::new(),
            turn: None,
            inbox: VecDeque::new(),
            told_to_end: Vec::new(),
            decisions: 0,
        }
    }

    /// The same, which gives what each turn came to with all its messages.
    #[must_use]
    pub fn with_messages(mut self) -> Self {
        self.turn = Some(Vec::new());
        self
    }

    /// Root as it is after what was taken.
    pub fn root(&self) -> &Root {
        match &self.nodes[0] {
            Node::Root(root) => root,
            Node::Composite(_) | Node::Leaf(_) => unreachable!("node 0 is root"),
        }
    }

    /// How many decisions were compared.
    pub fn decisions(&self) -> u64 {
        self.decisions
    }

    /// Takes the next record of the log.
    ///
    /// # Errors
    /// When it does not follow from those before it.
    pub fn take(&mut self, record: &Record) -> Result<(), Difference> {
        match record {
            Record::Header(_) | Record::Sent { .. } | Record::Controller { .. } => Ok(()),
            Record::Told { at, input } => {
                if let Told::End { end } = input {
                    self.told_to_end.push(*end);
                }
                self.give(*at, Input::Told(Box::new(input.clone())));
                Ok(())
            }
            Record::Turn { at } => match self.made.pop_front() {
                Some(expected) => Err(Difference { found: None, expected: Some(Box::new(expected)) }),
                None => {
                    self.give(*at, Input::Turn);
                    Ok(())
                }
            },
            // It comes before its turn, of which it is made.
            Record::Observed { change, .. } => {
                self.nodes[0].handle(record.at(), Input::Observed(*change), &mut Outbox::default());
                Ok(())
            }
            Record::Began { .. } | Record::Stopped { .. } | Record::World { .. } => self.compare(record),
            Record::Decided { .. } | Record::Released { .. } | Record::Resource { .. } => self.compare(record),
            // Not all ends are root's word: a defect ends a mission without it, and so does a grace that is over.
            Record::Ended { end: MissionEnd::NodeLost(_) | MissionEnd::TaskLost, .. } => Ok(()),
            Record::Ended { end, .. } if self.made.is_empty() && self.told_to_end.contains(end) => Ok(()),
            Record::Ended { .. } => self.compare(record),
        }
    }

    /// What the last turn came to, with its messages; nothing where there was none since this was asked last.
    pub fn take_turn(&mut self) -> Vec<Record> {
        self.turn.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The machines as they are now, and what follows from the last turn and the log does not tell, as of a writer that
    /// was killed.
    pub fn finish(self) -> (Vec<Node>, Vec<Record>) {
        (self.nodes, self.made.into())
    }

    fn compare(&mut self, found: &Record) -> Result<(), Difference> {
        let expected = self.made.pop_front();
        if expected.as_ref().is_some_and(|expected| self.is_same(expected, found)) {
            self.decisions += u64::from(matches!(found, Record::Decided { .. }));
            return Ok(());
        }
        Err(Difference { found: Some(Box::new(found.clone())), expected: expected.map(Box::new) })
    }

    /// Whether the log tells what follows. When an answer came up is no part of it.
    fn is_same(&self, made: &Record, found: &Record) -> bool {
        let (mut made, mut found) = (made.clone(), found.clone());
        for record in [&mut made, &mut found] {
            record.set_at(Time::ZERO);
            if !self.has_refusals {
                record.forget_refusals();
            }
        }
        made == found
    }

    fn give(&mut self, at: Time, input: Input) {
        let mut out = Outbox::default();
        self.inbox.push_back((NodeId(0), input));
        while let Some((node, input)) = self.inbox.pop_front() {
            self.nodes[node.index()].handle(at, input, &mut out);
            for effect in out.drain() {
                if let Some(turn) = &mut self.turn
                    && let Some(message) = effect.message(at, node, &self.topology)
                {
                    turn.push(message);
                }
                match effect {
                    Effect::Down(to, down) => self.inbox.push_back((to, Input::Down(down))),
                    Effect::Up(up @ (Up::Answer(_) | Up::Release(_))) => {
                        self.inbox.push_back((self.topology.parent(node), Input::Up(node, up)));
                    }
                    Effect::Record(record) => self.make(*record),
                    Effect::Start(_) | Effect::Stop(_) | Effect::Finished(_) => {}
                }
            }
        }
    }

    fn make(&mut self, record: Record) {
        let is_copied = matches!(record, Record::Told { .. } | Record::Turn { .. } | Record::Observed { .. });
        if !is_copied {
            if let Some(turn) = &mut self.turn {
                turn.push(record.clone());
            }
            self.made.push_back(record);
        }
    }
}
