//! One lane per resource: who holds it, running or kept, and above it on which channel it is shared.

use std::collections::BTreeSet;

use ambidex_model::{Header, LeaseKind, ResourceId, Time};

use super::bounds::{MAX_TRACKS, thinned};
use crate::svg::fit::{self, CHANNEL, INNER};
use crate::svg::marks::{Mark, mark};
use crate::svg::page::{Frame, Shape};
use crate::svg::scale::Scale;
use ambidex_record::{Held, Lane};

/// Height of a lease.
const TRACK: f64 = 13.0;
/// Height of the strip for channels.
const STRIP: f64 = 12.0;
/// The class of a resource that nobody can be granted.
pub(super) const UNAVAILABLE: &str = "leaf-failed";
/// Free space below a lane.
const GAP: f64 = 6.0;

/// A lane with its height.
#[derive(Debug)]
pub(super) struct Place<'a> {
    pub(super) resource: ResourceId,
    pub(super) lane: &'a Lane,
    /// When the run ends, and with it what has no other end.
    pub(super) end: Time,
}

impl Place<'_> {
    fn tracks(&self) -> usize {
        let most = self.lane.leases().map(|held| held.track + 1).max();
        most.unwrap_or(1).min(MAX_TRACKS)
    }

    /// Whether more leases were there at once than are drawn.
    pub(super) fn is_crowded(&self) -> bool {
        self.lane.leases().any(|held| held.track >= MAX_TRACKS)
    }

    /// How leases were held that occur.
    pub(super) fn holds(&self) -> BTreeSet<LeaseKind> {
        self.lane.leases().filter(|held| held.track < MAX_TRACKS).map(|held| held.lease.kind).collect()
    }

    pub(super) fn is_shared(&self) -> bool {
        !self.lane.channels().is_empty()
    }

    fn strip(&self) -> f64 {
        if self.is_shared() { STRIP } else { 0.0 }
    }

    pub(super) fn height(&self) -> f64 {
        self.strip() + self.tracks() as f64 * TRACK + GAP
    }

    /// The middle of its leases.
    pub(super) fn middle(&self) -> f64 {
        self.strip() + (self.tracks() as f64 * TRACK - 1.0) / 2.0
    }

    /// Everything that happened on the lane, and whether some of it is left out.
    pub(super) fn draw(&self, header: &Header, scale: &Scale, y: f64) -> (Shape, bool) {
        let leases = self.lane.leases().filter(|held| held.track < MAX_TRACKS).copied().collect();
        let (leases, is_less) = thinned(leases, |held| (scale.x(held.from), self.x(scale, held.to), held.track));
        let (strip, is_strip_less) = self.channels(header, scale, y + self.strip());
        let top = y + self.strip();
        let width = scale.x(self.end) - scale.left;
        let free = Frame { x: scale.left, y: top, width, height: self.tracks() as f64 * TRACK - 1.0 };
        let mut shapes = vec![Shape::rect("free", free, 0.0)];
        shapes.extend(self.outages(header, scale, free));
        shapes.extend(strip);
        shapes.extend(leases.iter().map(|held| self.lease(header, held, scale, top)));
        (Shape::group("lane", shapes), is_less || is_strip_less)
    }

    /// When nobody could be granted it.
    pub(super) fn is_ever_out(&self) -> bool {
        !self.lane.outages().is_empty()
    }

    fn outages(&self, header: &Header, scale: &Scale, free: Frame) -> Vec<Shape> {
        let outages = self.lane.outages().iter().map(|(why, from, to)| {
            let x = scale.x(*from);
            let until = to.map_or_else(|| "the end".to_owned(), |to| to.to_string());
            let resource = header.names.resource(self.resource);
            let said = format!("{resource}: unavailable (its controller: {why}), from {from} to {until}");
            let frame = Frame { x, width: self.x(scale, *to) - x, ..free };
            Shape::rect(UNAVAILABLE, frame, 1.5).titled(&said)
        });
        outages.collect()
    }

    fn x(&self, scale: &Scale, to: Option<Time>) -> f64 {
        scale.x(to.unwrap_or(self.end))
    }

    /// On which channel it was shared, and when; a name may reach to where the next begins.
    fn channels(&self, header: &Header, scale: &Scale, y: f64) -> (Vec<Shape>, bool) {
        let ends = |to| self.x(scale, to);
        let (channels, is_less) =
            thinned(self.lane.channels().to_vec(), |(_, from, to)| (scale.x(*from), ends(*to), 0));
        let nexts = channels.iter().skip(1).map(|(_, from, _)| scale.x(*from) - 4.0).chain([scale.x(self.end)]);
        let mut shapes = Vec::new();
        let mut free = scale.left;
        for ((channel, from, to), next) in channels.iter().zip(nexts) {
            let (begin, end) = (scale.x(*from), ends(*to));
            let name = header.names.channel(*channel);
            let said = format!("{}: shared on the channel {name} from {from}", header.names.resource(self.resource));
            shapes.push(Shape::line("channel", (begin, y - 1.5), (end, y - 1.5)).titled(&said));
            // At the end of a lane a name begins before its line rather than stand out of the lane.
            let x = begin.min(next - fit::width(name, CHANNEL)).max(free);
            if let Some(text) = fit::shortened(name, CHANNEL, next - x + 0.01) {
                shapes.push(Shape::text("channel-name", (x, y - 4.0), &text));
                free = x + fit::width(&text, CHANNEL) + 4.0;
            }
        }
        (shapes, is_less)
    }

    fn lease(&self, header: &Header, held: &Held, scale: &Scale, top: f64) -> Shape {
        let (from, to) = (scale.x(held.from), self.x(scale, held.to));
        let frame = Frame { x: from, y: top + held.track as f64 * TRACK, width: to - from, height: TRACK - 1.0 };
        let mut shapes = vec![Shape::rect(class(held.lease.kind), frame, 1.5)];
        let holder = header.names.node(held.lease.holder);
        let (texts, ink) = match held.lease.kind {
            LeaseKind::Running => (vec![header.names.node(held.lease.behavior).to_owned()], "inner-active"),
            LeaseKind::Physical | LeaseKind::Intention => {
                (vec![format!("kept by {holder}"), holder.to_owned()], "inner")
            }
        };
        let whole = fit::first_that_fits(&texts, INNER, frame.width - 2.0).map(str::to_owned);
        let last = texts.last().map_or("", String::as_str);
        if let Some(text) = whole.or_else(|| fit::shortened(last, INNER, frame.width - 1.0)) {
            let at = (from + frame.width / 2.0, frame.y + TRACK - 4.0);
            shapes.push(Shape::text(&format!("{ink} middle"), at, &text));
        }
        if held.to.is_none() && held.lease.kind == LeaseKind::Running {
            shapes.push(mark(Mark::RunsOn, (to - 4.2, frame.y + TRACK / 2.0 - 0.5), 4.2));
        }
        Shape::group("lease", shapes).titled(&said(header, self.resource, held))
    }
}

pub(super) fn class(kind: LeaseKind) -> &'static str {
    match kind {
        LeaseKind::Running => "active",
        LeaseKind::Physical => "kept-physical",
        LeaseKind::Intention => "kept-intention",
    }
}

/// What is said where a pointer rests on a lease.
fn said(header: &Header, resource: ResourceId, held: &Held) -> String {
    let name = |node| header.names.node(node);
    let (holder, behavior) = (name(held.lease.holder), name(held.lease.behavior));
    let what = match held.lease.kind {
        LeaseKind::Running => format!("used by {behavior}"),
        LeaseKind::Physical => format!("kept by {holder} since the world is so after {behavior}"),
        LeaseKind::Intention => format!("kept by {holder} for what {behavior} was done for"),
    };
    let inherited = held.lease.from.map_or_else(String::new, |from| format!(", inherited from {}", name(from)));
    let until = held.to.map_or_else(|| "the end".to_owned(), |to| to.to_string());
    format!("{}: {what}{inherited}, from {} to {until}", header.names.resource(resource), held.from)
}
