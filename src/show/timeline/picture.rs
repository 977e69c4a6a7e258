//! The picture of one run, or of two on one axis.

use super::heading;
use super::legend;
use super::panel::Panel;
use crate::svg::fit::{self, NOTE, TEXT, TITLE};
use crate::svg::page::{MARGIN, PAGE_WIDTH, Shape, page};
use crate::svg::scale::Scale;
use ambidex_record::History;

/// Widest label at the left; longer names are cut and shown in full where a pointer rests.
const MAX_LABEL: f64 = 150.0;
/// Height of the axis with its caption.
const AXIS: f64 = 34.0;

/// The timeline of a run.
pub fn picture(history: &History) -> String {
    let scale = |left, width| Scale::new(history.last_moment(), left, width);
    let head = [history.header().mission.clone(), heading::figures(history)];
    let description = format!("Timeline of the mission {}: {}.", head[0], head[1]);
    draw(&[Panel::new(history, None)], head, &description, scale)
}

/// Two runs one above the other.
pub fn compare(upper: &History, lower: &History) -> String {
    let scale = |left, width| Scale::new(upper.last_moment().max(lower.last_moment()), left, width);
    let head = [heading::missions(upper, lower), heading::ratio(upper, lower)];
    let description = format!("Timelines of two runs, one above the other. {}: {}.", head[0], head[1]);
    let panels = [upper, lower].map(|history| Panel::new(history, Some(heading::run(history))));
    draw(&panels, head, &description, scale)
}

fn draw(panels: &[Panel], [title, note]: [String; 2], description: &str, scale: impl Fn(f64, f64) -> Scale) -> String {
    let room = PAGE_WIDTH - 2.0 * MARGIN;
    let labels = panels.iter().flat_map(Panel::labels).map(|label| fit::width(label, TEXT));
    let left = MARGIN + labels.fold(40.0, f64::max).min(MAX_LABEL) + 8.0;
    // The last tick's label is written around its place.
    let scale = scale(left, PAGE_WIDTH - MARGIN - 8.0 - left);
    let mut shapes = vec![
        Shape::text("title", (MARGIN, MARGIN + 12.0), &fit::clip(&title, TITLE, room)),
        Shape::text("note", (MARGIN, MARGIN + 26.0), &fit::clip(&note, NOTE, room)),
    ];
    let mut y = MARGIN + 32.0;
    let mut drawn = Vec::new();
    for panel in panels {
        drawn.push(panel.draw(&scale, y));
        y = drawn.last().map_or(y, |drawn| drawn.bottom);
    }
    let is_thinned = drawn.iter().any(|drawn| drawn.is_thinned);
    shapes.extend(drawn.into_iter().map(|drawn| drawn.shape));
    shapes.push(axis(&scale, y));
    let (legend, bottom) = legend::draw(panels, is_thinned, y + AXIS);
    shapes.push(legend);
    page(&title, description, (PAGE_WIDTH, bottom + MARGIN), shapes)
}

fn axis(scale: &Scale, y: f64) -> Shape {
    let caption = "seconds of robot time since the mission began";
    let mut shapes = vec![Shape::line("line", (scale.left, y), (scale.right(), y))];
    for (x, label) in scale.ticks() {
        shapes.push(Shape::line("line tick", (x, y), (x, y + 4.0)));
        shapes.push(Shape::text("small middle", (x, y + 13.5), &label));
    }
    shapes.push(Shape::text("note middle", (scale.left + scale.width / 2.0, y + 25.5), caption));
    Shape::group("axis", shapes)
}
