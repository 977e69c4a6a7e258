//! A snapshot as text: head, resources, controllers, world, tree.

use ambidex_model::{LeaseKind, Level, Mode};
use anstyle::Style;

use crate::Palette;
use crate::text::{MIN_WIDTH, clip, columns, count, fit, flow, hang, listed, of_end};

use super::outline::Outline;
use super::page::{Page, Row};
use super::snapshot::{ControllerRow, Daemon, FactRow, HolderRow, Phase, ResourceRow, Snapshot, WorldRow};
use crate::text::table::{Cell, Column, NARROW, head, line, rest};

/// Columns behind a bar: `" 100 %"`.
const PERCENT: usize = 6;

impl Snapshot {
    /// The snapshot in at most so many lines of at most so many columns; what matters least is left out.
    pub fn lines(&self, width: usize, height: usize, palette: &Palette) -> Vec<String> {
        let width = width.max(MIN_WIDTH);
        let page = Page {
            head: self.head(width, palette),
            resources: self.resource_lines(width, palette),
            controllers: self.controller_lines(width, palette),
            world: world_lines(&self.world, width),
            outline: Outline::new(&self.nodes, width, *palette),
        };
        page.lines(height)
    }

    /// Which mission it is, how far, and at what it ended.
    fn head(&self, width: usize, palette: &Palette) -> Vec<String> {
        let mission = clip(&self.mission, width / 3);
        let (style, word) = self.stage(palette);
        let word = clip(&word, width - columns(&mission) - 2);
        let room = width.saturating_sub(columns(&mission) + 2 + columns(&word));
        let figures = format!(
            " · {:.2} s · round {} · step {} · {} of {} done",
            self.time_s, self.rounds, self.step, self.done, self.of
        );
        let figures = clip(&figures, room);
        let first = format!("{}  {}{figures}", Palette::paint(palette.strong, mission), Palette::paint(style, word));
        let messages = count(self.messages, "message");
        let about = format!("{}, {} · {} · {messages} between nodes", self.robot, self.allocator, self.daemon_words());
        let mut lines = vec![first, Palette::paint(palette.faint, clip(&about, width))];
        lines.extend(
            self.why.iter().flat_map(|why| hang("", 0, why, width).lines().map(str::to_owned).collect::<Vec<_>>()),
        );
        lines
    }

    /// How far it is, in a word.
    fn stage(&self, palette: &Palette) -> (Style, String) {
        if let Some(outcome) = self.outcome {
            return (palette.of(of_end(outcome)), outcome.word().into());
        }
        match self.phase {
            Phase::Ended | Phase::Gone => (palette.failed, "the daemon is gone (crashed or killed)".into()),
            Phase::Running => (palette.active, "running".into()),
            Phase::Waiting => {
                let absent = self.controllers.iter().filter(|row| row.health != Level::Ok);
                let absent: Vec<&str> = absent.map(|row| row.name.as_str()).collect();
                (palette.waiting, format!("waiting for {}", absent.join(", ")))
            }
        }
    }

    fn daemon_words(&self) -> String {
        match self.daemon {
            Daemon::Running { pid: Some(pid) } => format!("daemon pid {pid}"),
            Daemon::Running { pid: None } => "its journal is being written".into(),
            Daemon::Gone => "no daemon".into(),
        }
    }

    fn resource_lines(&self, width: usize, palette: &Palette) -> Vec<Row> {
        let is_narrow = width < NARROW;
        let mut table = vec![
            Column::of("resource", self.resources.iter().map(|row| row.name.as_str()), width / 5),
            Column::of("type", self.resources.iter().map(|row| row.ty.as_str()), width / 8),
            Column::number(if is_narrow { "own" } else { "owners" }, 1),
            Column::wide("channel", (width / 8).clamp(7, 16)),
            if is_narrow { Column::wide("lock", 4) } else { Column::wide("locked", 6) },
        ];
        table.push(Column::wide("held by", rest(&table, width)));
        let row = |resource: &ResourceRow| Row {
            rank: u8::from(!resource.locked && resource.unavailable.is_none()),
            text: line(&table, &resource_cells(resource, palette)),
        };
        let rows = self.resources.iter().map(row);
        std::iter::once(Row { rank: 0, text: head(&table, palette) }).chain(rows).collect()
    }

    fn controller_lines(&self, width: usize, palette: &Palette) -> Vec<Row> {
        let mut table = vec![
            Column::of("controller", self.controllers.iter().map(|row| row.name.as_str()), width / 5),
            Column::wide("health", 6),
        ];
        let has_gaps = width >= NARROW && self.controllers.iter().any(|row| gap(row).is_some());
        if has_gaps {
            table.push(Column::number("gap ms", 4));
        }
        table.push(Column::wide("why, and its goal", rest(&table, width)));
        let row = |controller: &ControllerRow| Row {
            rank: u8::from(controller.health == Level::Ok),
            text: controller_line(controller, has_gaps, &table, palette),
        };
        let rows = self.controllers.iter().map(row);
        std::iter::once(Row { rank: 0, text: head(&table, palette) }).chain(rows).collect()
    }
}

fn resource_cells(row: &ResourceRow, palette: &Palette) -> [Cell; 6] {
    let plain = Palette::plain().strong;
    let style = match row.holders.iter().any(|holder| holder.kind == LeaseKind::Running) {
        true => palette.active,
        false => plain,
    };
    let channel = match (&row.channel, row.locked) {
        (Some(channel), _) => channel.clone(),
        (None, true) => "alone".into(),
        (None, false) => String::new(),
    };
    let outage = row.unavailable.as_ref().map(|outage| format!("unavailable since {:.1} s", outage.since_s));
    let style = if outage.is_some() { palette.failed } else { style };
    let held = [row.holds.iter().map(|object| format!("holds {object}")).collect(), holders(&row.holders)];
    let held = outage.into_iter().chain(held);
    [
        (plain, row.name.clone()),
        (palette.faint, row.ty.clone()),
        (plain, row.owners.to_string()),
        (plain, channel),
        (if row.locked { plain } else { palette.faint }, if row.locked { "yes" } else { "no" }.into()),
        (style, held.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ")),
    ]
}

/// `pick 1 + pick 2 running, object 3 keeps an intention (move 3-1)`.
fn holders(holders: &[HolderRow]) -> String {
    let of = |kind| holders.iter().filter(move |holder| holder.kind == kind);
    let names = |kind| listed(of(kind).map(|holder| holder.node.as_str()));
    let running =
        Some(names(LeaseKind::Running)).filter(|names| !names.is_empty()).map(|names| format!("{names} (running)"));
    let kept = |kind: LeaseKind, word: &'static str| {
        of(kind).map(move |holder| format!("{} ({word} since {})", holder.node, holder.behavior))
    };
    let kept = kept(LeaseKind::Intention, "intention").chain(kept(LeaseKind::Physical, "physical"));
    running.into_iter().chain(kept).collect::<Vec<_>>().join(", ")
}

/// The longest time without a sign of life, as its daemon told it of the last second.
fn gap(row: &ControllerRow) -> Option<u32> {
    row.diagnostics.as_ref().filter(|told| told.live)?.values.worst_gap_ms
}

fn controller_line(row: &ControllerRow, has_gaps: bool, table: &[Column], palette: &Palette) -> String {
    let style = match row.health {
        Level::Ok => palette.done,
        Level::Warn => palette.active,
        Level::Error => palette.failed,
        Level::Stale => palette.waiting,
    };
    let behaviors = row.goals.iter().flat_map(|goal| &goal.behaviors);
    let mut behaviors: Vec<&str> = behaviors.map(String::as_str).collect();
    behaviors.dedup();
    let said = match behaviors.is_empty() {
        true => row.why.clone(),
        false => format!("{} · {}", row.why, listed(behaviors.into_iter())),
    };
    let plain = Palette::plain().strong;
    let front = |said: String| -> Vec<Cell> {
        let gap = has_gaps.then(|| (palette.faint, gap(row).map_or(String::new(), |gap| gap.to_string())));
        let head = [(plain, row.name.clone()), (style, row.health.word().into())];
        head.into_iter().chain(gap).chain([(plain, said)]).collect()
    };
    let Some(goal) = row.goals.iter().find(|goal| goal.mode == Mode::Achieve) else {
        return line(table, &front(said));
    };
    let room = table.last().map_or(0, |column| column.width);
    let cells = (room / 3).clamp(4, 30);
    let said = fit(&said, room.saturating_sub(cells + PERCENT + 2));
    let percent = (goal.progress * 100.0).floor();
    format!("{}  {} {percent:>3.0} %", line(table, &front(said)), palette.bar(goal.progress, cells))
}

/// Base, objects by place, facts; each with its label.
fn world_lines(world: &WorldRow, width: usize) -> Vec<String> {
    const LABEL: usize = 9;
    let labeled = |label: &str, items: Vec<String>| -> Vec<String> {
        let last = items.len().saturating_sub(1);
        let items: Vec<String> = items
            .iter()
            .enumerate()
            .map(|(at, item)| if at < last { format!("{item} ·") } else { item.clone() })
            .collect();
        let text = flow(&fit(label, LABEL), LABEL, items.iter().map(String::as_str), width);
        text.lines().map(str::to_owned).collect()
    };
    let base =
        world.base.map(|[x, y, heading]| format!("base at ({x:.2}, {y:.2}), heading {:.0}°", heading.to_degrees()));
    let mut lines = labeled("world", vec![base.unwrap_or_else(|| "nobody knows where the base is".into())]);
    if !world.objects.is_empty() {
        lines.extend(labeled("objects", objects(world)));
    }
    if !world.facts.is_empty() {
        let holds = |holds: bool| if holds { "holds" } else { "does not hold" };
        let how = |fact: &FactRow| fact.how.as_ref().map_or(String::new(), |how| format!(", {how}"));
        let facts = world.facts.iter().map(|fact| format!("{} {}{}", fact.name, holds(fact.holds), how(fact)));
        lines.extend(labeled("facts", facts.collect()));
    }
    lines
}

/// Where objects are, those of one place together.
fn objects(world: &WorldRow) -> Vec<String> {
    let mut spots: Vec<(String, Vec<&str>)> = Vec::new();
    for object in &world.objects {
        let spot = match (&object.at, object.held_by.as_slice()) {
            (Some(place), _) => format!("at {place}"),
            (None, []) => "nobody knows where".into(),
            (None, holders) => format!("in {}", holders.join(" and ")),
        };
        let spot = object.how.as_ref().map_or(spot.clone(), |how| format!("{spot}, {how}"));
        match spots.iter_mut().find(|(known, _)| *known == spot) {
            Some((_, objects)) => objects.push(&object.name),
            None => spots.push((spot, vec![&object.name])),
        }
    }
    spots.into_iter().map(|(spot, objects)| format!("{} {spot}", objects.join(", "))).collect()
}
