//! One lane per resource: who holds it, running or kept, and above it on which channel it is shared.

use std::collections::BTreeSet;

use crate::model::{Header, Hold, ResourceId};

use super::super::fit::{self, SMALL};
use super::super::history::{Held, Lane};
use super::super::marks::{Mark, mark};
use super::super::page::{Frame, Shape};
use super::super::scale::Scale;
use super::bounds::{MAX_SLOTS, thinned};

/// Height of a lease.
const SLOT: f64 = 13.0;
/// Height of the strip for channels.
const STRIP: f64 = 12.0;
/// Free space below a lane.
const GAP: f64 = 6.0;

/// A lane with its height.
#[derive(Debug)]
pub(super) struct Place<'a> {
    pub(super) resource: ResourceId,
    pub(super) lane: &'a Lane,
}

impl Place<'_> {
    fn slots(&self) -> usize {
        let most = self.lane.leases.iter().map(|held| held.slot + 1).max();
        most.unwrap_or(1).min(MAX_SLOTS)
    }

    /// Whether more leases were there at once than are drawn.
    pub(super) fn is_crowded(&self) -> bool {
        self.lane.leases.iter().any(|held| held.slot >= MAX_SLOTS)
    }

    /// How leases were held that occur.
    pub(super) fn holds(&self) -> BTreeSet<Hold> {
        self.lane.leases.iter().map(|held| held.hold).collect()
    }

    pub(super) fn is_shared(&self) -> bool {
        !self.lane.channels.is_empty()
    }

    fn strip(&self) -> f64 {
        if self.is_shared() { STRIP } else { 0.0 }
    }

    pub(super) fn height(&self) -> f64 {
        self.strip() + self.slots() as f64 * SLOT + GAP
    }

    /// The middle of its leases.
    pub(super) fn middle(&self) -> f64 {
        self.strip() + (self.slots() as f64 * SLOT - 1.0) / 2.0
    }

    /// Everything that happened on the lane, and whether some of it is left out.
    pub(super) fn draw(&self, header: &Header, scale: &Scale, y: f64) -> (Shape, bool) {
        let place = |held: &Held| (scale.x(held.from), held.to.map_or(scale.right(), |to| scale.x(to)), held.slot);
        let leases = self.lane.leases.iter().filter(|held| held.slot < MAX_SLOTS).copied().collect();
        let (leases, some_left_out) = thinned(leases, place);
        let begun = |to: Option<_>| to.map_or(scale.right(), |to| scale.x(to));
        let channels = self.lane.channels.clone();
        let (channels, more_left_out) = thinned(channels, |(_, from, to)| (scale.x(*from), begun(*to), 0));
        let top = y + self.strip();
        let height = self.slots() as f64 * SLOT;
        let free = Frame { x: scale.left, y: top, width: scale.width, height: height - 1.0 };
        let mut shapes = vec![Shape::rect("free", free, 0.0)];
        for (channel, from, to) in channels {
            let (from, to) = (scale.x(from), begun(to));
            let name = header.names.channel(channel);
            let resource = header.names.resource(self.resource);
            let line = Shape::line("channel", (from, top - 1.5), (to, top - 1.5));
            shapes.push(line.titled(&format!("{resource}: shared on the channel {name}")));
            let text = fit::clip(name, SMALL, to - from);
            if to > from && text.chars().count() > 2 {
                shapes.push(Shape::text("channel-name", (from, top - 4.0), &text));
            }
        }
        shapes.extend(leases.iter().map(|held| lease(header, self.resource, held, scale, top)));
        (Shape::group("lane", shapes), some_left_out || more_left_out)
    }
}

pub(super) fn class(hold: Hold) -> &'static str {
    match hold {
        Hold::Running => "active",
        Hold::Physical => "kept-physical",
        Hold::Intention => "kept-intention",
    }
}

fn lease(header: &Header, resource: ResourceId, held: &Held, scale: &Scale, top: f64) -> Shape {
    let (from, to) = (scale.x(held.from), held.to.map_or(scale.right(), |to| scale.x(to)));
    let frame = Frame { x: from, y: top + held.slot as f64 * SLOT, width: to - from, height: SLOT - 1.0 };
    let mut shapes = vec![Shape::rect(class(held.hold), frame, 1.5)];
    let holder = header.names.node(held.holder);
    let (texts, ink) = match held.hold {
        Hold::Running => (vec![header.names.node(held.behavior).to_owned()], "inner-active"),
        Hold::Physical | Hold::Intention => (vec![format!("kept by {holder}"), holder.to_owned()], "inner"),
    };
    if let Some(text) = fit::first_that_fits(&texts, SMALL, frame.width - 3.0) {
        let at = (from + frame.width / 2.0, frame.y + SLOT - 4.0);
        shapes.push(Shape::text(&format!("{ink} middle"), at, text));
    }
    if held.to.is_none() && held.hold == Hold::Running {
        shapes.push(mark(Mark::RunsOn, (to - 4.2, frame.y + SLOT / 2.0 - 0.5), 4.2));
    }
    Shape::group("lease", shapes).titled(&said(header, resource, held))
}

/// What is said where a pointer rests on a lease.
fn said(header: &Header, resource: ResourceId, held: &Held) -> String {
    let name = |node| header.names.node(node);
    let (holder, behavior) = (name(held.holder), name(held.behavior));
    let what = match held.hold {
        Hold::Running => format!("used by {behavior}"),
        Hold::Physical => format!("kept by {holder} since the world is so after {behavior}"),
        Hold::Intention => format!("kept by {holder} for what {behavior} was done for"),
    };
    let inherited = held.inherited.map_or_else(String::new, |from| format!(", inherited from {}", name(from)));
    let until = held.to.map_or_else(|| "the end".to_owned(), |to| to.to_string());
    format!("{}: {what}{inherited}, from {} to {until}", header.names.resource(resource), held.from)
}
