//! Shapes and the page that they stand on. The only file that speaks to the SVG crate.

use svg::node::Text;
use svg::node::element::Element;
use svg::{Document, Node};

use super::style::{SCOPE, sheet};

/// Width of a picture over both columns of a page, user units: at 7 inches 10 units are 7 points.
pub(crate) const PAGE_WIDTH: f64 = 720.0;
/// Height of a picture that fills a page.
pub(crate) const PAGE_HEIGHT: f64 = 1000.0;
/// Free space around everything.
pub(crate) const MARGIN: f64 = 12.0;

/// A shape, or several.
#[derive(Debug, Clone)]
pub(crate) struct Shape(Element);

/// An upright rectangle, user units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Shape {
    fn new(tag: &str, class: &str) -> Self {
        Self(Element::new(tag)).with("class", class)
    }

    fn with(mut self, name: &str, value: &str) -> Self {
        self.0.assign(name, value);
        self
    }

    fn at(self, numbers: &[(&str, f64)]) -> Self {
        numbers.iter().fold(self, |shape, (name, value)| shape.with(name, &number(*value)))
    }

    /// Several shapes as one.
    pub(crate) fn group(class: &str, shapes: impl IntoIterator<Item = Self>) -> Self {
        let mut group = Self::new("g", class);
        shapes.into_iter().for_each(|shape| group.0.append(shape.0));
        group
    }

    /// A rectangle.
    pub(crate) fn rect(class: &str, frame: Frame, round: f64) -> Self {
        let Frame { x, y, width, height } = frame;
        let rect = Self::new("rect", class).at(&[("x", x), ("y", y), ("width", width), ("height", height)]);
        if round > 0.0 { rect.at(&[("rx", round)]) } else { rect }
    }

    /// A straight line.
    pub(crate) fn line(class: &str, from: (f64, f64), to: (f64, f64)) -> Self {
        Self::new("line", class).at(&[("x1", from.0), ("y1", from.1), ("x2", to.0), ("y2", to.1)])
    }

    /// A path through points, with straight lines.
    pub(crate) fn path(class: &str, points: &[(f64, f64)], is_closed: bool) -> Self {
        let mut way = String::new();
        for (index, (x, y)) in points.iter().enumerate() {
            let letter = if index == 0 { 'M' } else { 'L' };
            way.push_str(&format!("{letter}{} {}", number(*x), number(*y)));
        }
        way.push_str(if is_closed { "Z" } else { "" });
        Self::new("path", class).with("d", &way)
    }

    /// A circle.
    pub(crate) fn circle(class: &str, center: (f64, f64), radius: f64) -> Self {
        Self::new("circle", class).at(&[("cx", center.0), ("cy", center.1), ("r", radius)])
    }

    /// A text whose baseline begins at a point, or ends or has its middle there as the class says.
    pub(crate) fn text(class: &str, at: (f64, f64), text: &str) -> Self {
        let mut shape = Self::new("text", class).at(&[("x", at.0), ("y", at.1)]);
        shape.0.append(Text::new(printable(text)));
        shape
    }

    /// Says something where a pointer rests on it.
    pub(crate) fn titled(mut self, title: &str) -> Self {
        let mut element = Element::new("title");
        element.append(Text::new(printable(title)));
        // SVG 1.1 wants it before all else.
        self.0.get_children_mut().insert(0, element.into());
        self
    }
}

/// The whole picture as text.
pub(crate) fn page(
    title: &str,
    description: &str,
    size: (f64, f64),
    shapes: impl IntoIterator<Item = Shape>,
) -> String {
    let (width, height) = size;
    let mut style = Element::new("style");
    style.append(Text::new(sheet()));
    let mut document = Document::new();
    document.assign("class", SCOPE);
    document.assign("role", "img");
    document.assign("viewBox", format!("0 0 {} {}", number(width), number(height)));
    document.assign("width", number(width));
    document.assign("height", number(height));
    for (tag, text) in [("title", title), ("desc", description)] {
        let mut element = Element::new(tag);
        element.append(Text::new(printable(text)));
        document.append(element);
    }
    document.append(style);
    document.append(Shape::rect("paper", Frame { x: 0.0, y: 0.0, width, height }, 0.0).0);
    shapes.into_iter().for_each(|shape| document.append(shape.0));
    document.to_string() + "\n"
}

/// Hundredths are fine enough, and no picture then hangs on the last digits of a sum.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Names are free text: what XML forbids and what turns the reading direction around is shown as a replacement.
fn printable(text: &str) -> String {
    let replace = |letter: char| match letter {
        '\t' | '\n' | '\r' => ' ',
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        letter if letter.is_control() => '\u{fffd}',
        letter => letter,
    };
    text.chars().map(replace).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [(1.0, "1"), (0.125, "0.12"), (-0.001, "0"), (100.0, "100"), (2.5, "2.5")] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn hostile_text_stays_text() {
        let name = "</text><script>&\"'\u{0}\u{1b}[1m\u{202e}\u{ffff}\n]]>";
        let shape = Shape::text("text", (0.0, 0.0), name).titled(name);
        let text = page(name, name, (10.0, 10.0), [shape]);
        let document = roxmltree::Document::parse(&text).unwrap();
        let shown: Vec<_> = document.descendants().filter(|node| node.has_tag_name("text")).collect();
        let expected = "</text><script>&\"'\u{fffd}\u{fffd}[1m\u{fffd}\u{fffd} ]]>";
        assert_eq!(shown[0].last_child().and_then(|text| text.text()), Some(expected));
        assert!(document.descendants().all(|node| !node.has_tag_name("script")));
    }
}
