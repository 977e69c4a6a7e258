//! A run as tables: one row per attempt of a behavior, per lease, per command, per round, or per change of the world.

use ambidex_model::{Header, NodeId, Record, ResourceId, Time};
use ambidex_record::{Held, History, Lane, format};

use super::attempts::{Attempt, Attempts, task_of};
use super::commands::{CommandSpan, Commands, Step};
use super::{cells, world};

/// Which table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, strum::EnumString, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Table {
    /// A row per attempt of a behavior.
    #[default]
    Behaviors,
    /// A row per lease of a resource, and per time that it was unavailable.
    Resources,
    /// A row per command of a controller.
    Commands,
    /// A row per round.
    Rounds,
    /// A row per change of the world, made or refused, and how it was when the mission began.
    World,
}

impl Table {
    /// The word for it on a command line.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// What its columns are called. Those that end in `_s` are seconds since the mission began.
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Behaviors => &[
                "task",
                "node",
                "name",
                "kind",
                "attempt",
                "round",
                "granted_s",
                "ended_s",
                "end",
                "fault",
                "waited_for",
                "resources",
                "objects",
                "place",
                "potential",
                "priority",
            ],
            Self::Resources => &["resource", "type", "hold", "holder", "behavior", "channel", "from_s", "to_s", "why"],
            Self::Commands => &[
                "controller",
                "command",
                "does",
                "mode",
                "behaviors",
                "told_s",
                "accepted_s",
                "canceled_s",
                "ended_s",
                "end",
                "why",
                "took_s",
            ],
            Self::Rounds => &["round", "at_s", "granted", "refused", "reopened"],
            Self::World => world::COLUMNS,
        }
    }
}

/// The cells of a row, in the order of the columns.
pub type Row = Vec<String>;

/// Makes the rows of a table of the records of a run.
#[derive(Debug)]
pub struct Rows {
    table: Table,
    history: History,
    attempts: Attempts,
    commands: Commands,
    lanes: Vec<Lane>,
}

impl Rows {
    /// Nothing has happened yet.
    pub fn new(table: Table, header: &Header) -> Self {
        let lanes = vec![Lane::default(); header.names.resources.len()];
        let history = History::new(header);
        Self { table, history, attempts: Attempts::default(), commands: Commands::default(), lanes }
    }

    /// The rows that the next record completes.
    pub fn take(&mut self, record: &Record) -> Vec<Row> {
        let before = match self.table {
            Table::Behaviors => {
                let ended = self.attempts.take(&self.history, record).ended;
                ended.iter().map(|attempt| self.attempt(attempt)).collect()
            }
            Table::Commands => {
                let steps = self.commands.take(&self.history, record);
                steps.iter().filter_map(|step| self.command(step)).collect()
            }
            Table::Resources => self.resource(record),
            Table::Rounds | Table::World => Vec::new(),
        };
        self.history.apply(record);
        match self.table {
            Table::Behaviors | Table::Commands | Table::Resources => before,
            Table::Rounds => self.round(record).into_iter().collect(),
            Table::World => world::rows(&self.history, record),
        }
    }

    /// The rows of what goes on at the end of the log; when and how it ends is empty.
    pub fn finish(mut self) -> Vec<Row> {
        let attempts: Vec<Attempt> = std::mem::take(&mut self.attempts).into_open().collect();
        let commands: Vec<CommandSpan> = std::mem::take(&mut self.commands).into_open().collect();
        let mut rows: Vec<Row> = attempts.iter().map(|attempt| self.attempt(attempt)).collect();
        rows.extend(commands.iter().map(|span| self.span(span)));
        for (index, lane) in std::mem::take(&mut self.lanes).iter().enumerate() {
            rows.extend(self.lane(ResourceId::from(index), lane));
        }
        rows
    }

    fn attempt(&self, attempt: &Attempt) -> Row {
        let (names, grant) = (self.history.names(), &attempt.grant);
        let leaf = grant.leaf();
        let kind = self.history.header().nodes.get(leaf.index()).map_or("?", |node| node.kind.word());
        let waited_for = attempt.waited_for.as_ref().map(|reason| reason.sentence(names));
        vec![
            names.node(task_of(&self.history, leaf)).to_owned(),
            leaf.0.to_string(),
            names.node(leaf).to_owned(),
            kind.to_owned(),
            attempt.number.to_string(),
            attempt.round.to_string(),
            cells::seconds(attempt.granted),
            cells::seconds_of(attempt.ended.map(|(at, _)| at)),
            attempt.ended.map_or("", |(_, end)| cells::end(end)).to_owned(),
            attempt.ended.map_or(String::new(), |(_, end)| cells::fault(end, names)),
            waited_for.unwrap_or_default(),
            cells::resources(grant, names),
            cells::objects(grant, names),
            cells::place(grant, names),
            grant.request.potential.to_string(),
            grant.request.priority.to_string(),
        ]
    }

    fn command(&self, step: &Step) -> Option<Row> {
        match step {
            Step::Begun(_) | Step::Joined(..) => None,
            Step::Ended(span) => Some(self.span(span)),
        }
    }

    fn span(&self, span: &CommandSpan) -> Row {
        let names = self.history.names();
        vec![
            names.controller(span.controller).to_owned(),
            format::goal(span.id).to_string(),
            format::command(&span.command, names).to_string(),
            cells::mode(span.mode).to_owned(),
            cells::nodes(&span.leaves, names),
            cells::seconds(span.told),
            cells::seconds_of(span.accepted),
            cells::seconds_of(span.canceled),
            cells::seconds_of(span.ended.map(|(at, _)| at)),
            span.ended.map_or("", |(_, end)| end.word()).to_owned(),
            span.ended.map_or(String::new(), |(_, end)| end.to_string()),
            span.took_s.map_or(String::new(), |took_s| took_s.to_string()),
        ]
    }

    fn resource(&mut self, record: &Record) -> Vec<Row> {
        let Record::Resource { resource, state, at } = record else { return Vec::new() };
        let now = self.history.moment(*at);
        let Some(lane) = self.lanes.get_mut(resource.index()) else { return Vec::new() };
        lane.change(now, state);
        let past = lane.take_past();
        self.lane(*resource, &past)
    }

    /// What there is of a lane; the history still knows what the resource was shared for.
    fn lane(&self, resource: ResourceId, lane: &Lane) -> Vec<Row> {
        let names = self.history.names();
        let ty = self.history.header().resource_types.get(resource.index());
        let ty = ty.map_or("?", |ty| names.ty(*ty));
        let channel = self.history.resources().get(resource.index()).and_then(|state| state.channel());
        let channel = channel.map_or("", |channel| names.channel(channel));
        let row = |hold: &str, [holder, behavior, channel]: [&str; 3], from: Time, to: Option<Time>, why: String| {
            let head = [names.resource(resource), ty, hold, holder, behavior, channel].map(str::to_owned);
            head.into_iter().chain([cells::seconds(from), cells::seconds_of(to), why]).collect()
        };
        let leases = lane.leases().map(|Held { lease, from, to, .. }| {
            let who = [names.node(lease.holder), names.node(lease.behavior), channel];
            row(cells::lease(lease.kind), who, *from, *to, String::new())
        });
        let outages =
            lane.outages().iter().map(|(why, from, to)| row("unavailable", [""; 3], *from, *to, why.to_string()));
        leases.chain(outages).collect()
    }

    fn round(&self, record: &Record) -> Option<Row> {
        let Record::Decided { round, granted, refused, reopened, .. } = record else { return None };
        let names = self.history.names();
        let granted: Vec<NodeId> = granted.iter().map(|grant| grant.leaf()).collect();
        Some(vec![
            round.to_string(),
            cells::seconds(self.history.now()),
            cells::nodes(&granted, names),
            refused.len().to_string(),
            reopened.as_ref().map_or(String::new(), |reopened| names.node(reopened.node).to_owned()),
        ])
    }
}
