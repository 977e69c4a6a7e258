//! The reference of the file formats as Markdown, made from the same description as the schemas.

use std::fmt::Write;

use crate::format::Format;
use crate::quantity::Quantity;
use crate::shape::{Field, Form, Shape};

/// Every key of every format, for people.
pub fn reference() -> String {
    let mut text =
        "# Reference of the file formats\n\nEvery key that a file may have, as `ambidex check` reads it. How \
                    to write with them is in [missions.md](missions.md).\n\n*Made from the descriptions that files are \
                    read by; `AMBIDEX_BLESS=1 cargo test -p ambidex-files reference` writes it anew.*\n"
            .to_owned();
    let mut shapes: Vec<&'static Shape> =
        [Format::Mission, Format::World, Format::Task, Format::Behaviors, Format::Robot, Format::Failures]
            .map(Format::shape)
            .to_vec();
    let mut next = 0;
    while let Some(shape) = shapes.get(next).copied() {
        section(shape, &mut text);
        for form in shape.fields.iter().map(|field| &field.form) {
            below(form, &mut shapes);
        }
        next += 1;
    }
    text
}

fn section(shape: &Shape, text: &mut String) {
    let title = title(shape);
    writeln!(text, "\n## {title}\n\n{}\n", shape.doc).expect("a string takes all");
    if !shape.one_of.is_empty() {
        let keys: Vec<_> = shape.one_of.iter().map(|key| format!("`{key}`")).collect();
        writeln!(text, "Exactly one of {} stands in it.\n", keys.join(", ")).expect("a string takes all");
    }
    text.push_str("| key | value | |\n|---|---|---|\n");
    let known = shape.others.iter().flat_map(|others| &others.known);
    for Field { key, doc, is_required, form } in shape.fields.iter().chain(known) {
        let mark = if *is_required { ", required" } else { "" };
        let row = format!("| `{key}` | {}{mark} | {} |", value(form), doc.replace('|', "\\|"));
        writeln!(text, "{row}").expect("a string takes all");
    }
    if let Some(others) = &shape.others {
        writeln!(text, "| any other | {} | A name that the files declare. |", value(&others.form))
            .expect("a string takes all");
    }
}

/// "a place" has the title "Place".
fn title(shape: &Shape) -> String {
    let name = shape.what.split_once(' ').map_or(shape.what, |(_, name)| name);
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn value(form: &Form) -> String {
    match form {
        Form::Word => "a word".to_owned(),
        Form::Words(words) => words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "),
        Form::Flag => "`true` or `false`".to_owned(),
        Form::Count(most) => format!("a whole number up to {most}"),
        Form::Whole(most) => format!("a whole number, -{most} to {most}"),
        Form::Quantity(quantity) => number(quantity),
        Form::Vector(least, most, quantity) if least == most => format!("{least} times {}", number(quantity)),
        Form::Vector(least, most, quantity) => format!("{least} or {most} times {}", number(quantity)),
        Form::List(inner) => format!("a list: {}", value(inner)),
        Form::Each(inner) => format!("a map of your names: {}", value(inner)),
        Form::Map(shape) => {
            let title = title(shape());
            format!("[{}](#{})", shape().what, title.to_lowercase().replace('\'', "").replace(' ', "-"))
        }
        Form::Either(forms) => forms.iter().map(value).collect::<Vec<_>>().join(", or "),
        Form::Arguments => "arguments".to_owned(),
    }
}

/// What is measured, with the bounds in its SI unit.
fn number(quantity: &Quantity) -> String {
    let unit = quantity.dimension.units()[0].0;
    let [from, to] = [quantity.range.start(), quantity.range.end()].map(|bound| (bound * 1e5).round() / 1e5);
    format!("{}, {from} to {to} {unit}", quantity.dimension.example()).trim_end().to_owned()
}

/// Adds the maps that a value can hold and that are not there yet.
fn below(form: &Form, shapes: &mut Vec<&'static Shape>) {
    match form {
        Form::Map(shape) if shapes.iter().all(|known| known.what != shape().what) => shapes.push(shape()),
        Form::List(inner) | Form::Each(inner) => below(inner, shapes),
        Form::Either(forms) => forms.iter().for_each(|form| below(form, shapes)),
        Form::Map(_) | Form::Word | Form::Words(_) | Form::Flag | Form::Count(_) | Form::Whole(_) => {}
        Form::Quantity(_) | Form::Vector(..) | Form::Arguments => {}
    }
}
