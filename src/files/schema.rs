//! JSON Schema of the file formats, made from the shapes that files are read by, so that editors complete and underline.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::format::Format;
use crate::quantity::Quantity;
use crate::shape::{Form, Shape};

/// The JSON Schema (draft 2020-12) of a format.
///
/// What it refuses the reader refuses too; names that do not exist only the reader finds.
pub fn schema(format: Format) -> Value {
    let mut definitions = BTreeMap::new();
    let shape = format.shape();
    define(shape, &mut definitions);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": shape.what,
        "$ref": reference(shape),
        "$defs": definitions,
    })
}

fn reference(shape: &Shape) -> String {
    format!("#/$defs/{}", key(shape))
}

/// "a place" is defined as `a_place`.
fn key(shape: &Shape) -> String {
    shape.what.replace(|letter: char| !letter.is_ascii_alphanumeric(), "_")
}

fn define(shape: &'static Shape, definitions: &mut BTreeMap<String, Value>) {
    if definitions.contains_key(&key(shape)) {
        return;
    }
    definitions.insert(key(shape), Value::Null);
    let mut properties = serde_json::Map::new();
    for field in shape.fields.iter().chain(shape.others.iter().flat_map(|others| &others.known)) {
        let mut property = form(&field.form, definitions);
        property["description"] = field.doc.into();
        properties.insert(field.key.into(), property);
    }
    let required = shape.fields.iter().filter(|field| field.is_required).map(|field| field.key);
    let others = match &shape.others {
        Some(others) => form(&others.form, definitions),
        None => false.into(),
    };
    let mut schema = json!({
        "type": "object",
        "description": shape.doc,
        "properties": properties,
        "required": required.collect::<Vec<_>>(),
        "additionalProperties": others,
    });
    if !shape.one_of.is_empty() {
        schema["oneOf"] = shape.one_of.iter().map(|key| json!({"required": [key]})).collect();
    }
    definitions.insert(key(shape), schema);
}

fn form(form: &Form, definitions: &mut BTreeMap<String, Value>) -> Value {
    let of = |inner: &Form, definitions: &mut _| self::form(inner, definitions);
    match form {
        Form::Word => json!({"type": ["string", "number", "boolean"]}),
        Form::Words(words) => json!({"enum": words}),
        Form::Flag => json!({"enum": [true, false, "yes", "no"]}),
        Form::Count(most) => json!({"type": "integer", "minimum": 0, "maximum": most}),
        Form::Whole(most) => json!({"type": "integer", "minimum": -most, "maximum": most}),
        Form::Quantity(quantity) => number(quantity),
        Form::Vector(least, most, quantity) => {
            json!({"type": "array", "items": number(quantity), "minItems": least, "maxItems": most})
        }
        Form::List(inner) => json!({"type": "array", "items": of(inner, definitions), "minItems": 1}),
        Form::Each(inner) => json!({"type": "object", "additionalProperties": of(inner, definitions)}),
        Form::Map(shape) => {
            define(shape(), definitions);
            json!({"$ref": reference(shape())})
        }
        Form::Either(forms) => {
            let forms: Vec<Value> = forms.iter().map(|inner| of(inner, definitions)).collect();
            json!({"anyOf": forms})
        }
        Form::Arguments => json!({
            "anyOf": [
                {"type": ["string", "number", "boolean", "null"]},
                {"type": "array", "items": {"type": ["string", "number", "boolean"]}},
                {"type": "object"},
            ],
        }),
    }
}

/// A plain number in the SI unit, or text with a unit.
fn number(quantity: &Quantity) -> Value {
    let units: Vec<_> = quantity.dimension.units().iter().map(|(unit, _)| unit.replace('^', r"\^")).collect();
    let text = format!(r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*({})\s*$", units.join("|"));
    let plain = json!({"type": "number", "minimum": quantity.range.start(), "maximum": quantity.range.end()});
    json!({"anyOf": [plain, {"type": "string", "pattern": text}]})
}
