//! Where everything of a tree stands, before anything is drawn.

use ambidex_model::NodeId;

use super::label::Label;
use crate::svg::page::{Frame, MARGIN, PAGE_HEIGHT, PAGE_WIDTH};

/// Side of the square that a sign takes.
pub(super) const MARK: f64 = 12.0;

/// A tree whose upper left corner is the origin.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) nodes: Vec<Placed>,
    pub(super) edges: Vec<Edge>,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// A node in its place.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) node: NodeId,
    pub(super) frame: Frame,
    pub(super) label: Label,
    pub(super) is_leaf: bool,
    /// Drawn once more, as the top of a further column.
    pub(super) is_again: bool,
    /// The sign stands below the text, not before it.
    pub(super) has_mark_below: bool,
}

/// A line from parent to child.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    pub(super) way: Vec<(f64, f64)>,
    /// The child's number, where order matters.
    pub(super) order: Option<usize>,
    pub(super) order_at: (f64, f64),
}

impl Plan {
    /// How much the picture must be made smaller to fit a page; 1 where it fits as it is.
    pub(super) fn shrink(&self) -> f64 {
        let width = (self.width + 2.0 * MARGIN) / PAGE_WIDTH;
        let height = (self.height + 2.0 * MARGIN) / PAGE_HEIGHT;
        width.max(height).max(1.0)
    }

    /// The same, elsewhere.
    pub(super) fn moved(mut self, right: f64, down: f64) -> Self {
        let shift = |(x, y): (f64, f64)| (x + right, y + down);
        for placed in &mut self.nodes {
            (placed.frame.x, placed.frame.y) = shift((placed.frame.x, placed.frame.y));
        }
        for edge in &mut self.edges {
            edge.way.iter_mut().for_each(|point| *point = shift(*point));
            edge.order_at = shift(edge.order_at);
        }
        self
    }
}

impl Placed {
    /// Where the text stands.
    pub(super) fn text_frame(&self, has_mark: bool) -> Frame {
        let frame = self.frame;
        match (has_mark, self.has_mark_below) {
            (false, _) => frame,
            (true, true) => Frame { height: frame.height - MARK, ..frame },
            (true, false) => Frame { x: frame.x + MARK - 2.0, width: frame.width - MARK + 2.0, ..frame },
        }
    }

    /// The middle of the sign.
    pub(super) fn mark_at(&self) -> (f64, f64) {
        let Frame { x, y, width, height } = self.frame;
        match self.has_mark_below {
            true => (x + width / 2.0, y + height - MARK / 2.0 - 1.0),
            false => (x + MARK / 2.0 + 1.0, y + height / 2.0),
        }
    }
}
