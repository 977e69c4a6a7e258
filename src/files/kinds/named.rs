//! What terms of a behavior name: things, claims, and texts with arguments in them.

use super::{NameOrParam, Piece, Text};
use crate::describe::{Custom, Reads};
use crate::reader::Item;
use crate::scope::Reading;
use crate::shape::Form;
use crate::template;
use crate::types::Type;
use ambidex_model::suggestion;

pub(super) const PLACE: NameOf = NameOf(Type::Place);
pub(super) const OBJECT: NameOf = NameOf(Type::Object);

/// The name of a claim, as which one it is.
pub(super) const CLAIMED: Custom<usize> = Custom(
    || Form::Word,
    |item, reading| {
        let name = item.name("the name of a claim", reading.faults)?;
        let claims = reading.scope.claims.iter().map(|claim| claim.value.as_str());
        let found = claims.clone().position(|claim| claim == name.value);
        if found.is_none() {
            let help = || suggestion(&name.value, "claim", claims);
            reading.faults.push_with(&name, format!("there is no claim `{}`", name.value), help);
        }
        found
    },
);

/// Text in which `$name` stands for an argument.
pub(super) const TEMPLATE: Custom<Text> = Custom(
    || Form::Word,
    |item, reading| {
        let written = item.name("a text", reading.faults)?;
        let mut pieces = Vec::new();
        for piece in template::pieces(&written.value) {
            pieces.push(match piece {
                template::Piece::Plain(text) => Piece::Plain(text.to_owned()),
                template::Piece::Parameter(name) => Piece::Parameter(reading.parameter(name, &written)?),
            });
        }
        Some(Text { pieces, written })
    },
);

/// A name, or a parameter of that type.
pub(super) struct NameOf(pub(super) Type);

impl<'a> Reads<'a> for NameOf {
    type Out = NameOrParam;

    fn form(&self) -> Form {
        Form::Word
    }

    fn read(&self, item: Item<'a>, reading: &mut Reading<'_>) -> Option<NameOrParam> {
        let written = item.name(self.0.what(), reading.faults)?;
        let Some(name) = template::parameter(&written.value) else {
            return Some(NameOrParam { written, parameter: None });
        };
        let index = reading.parameter(name, &written)?;
        let found = reading.scope.parameters[index].1;
        if found != self.0 {
            reading.faults.push(&written, format!("`${name}` is {}, not {}", found.what(), self.0.what()));
            return None;
        }
        Some(NameOrParam { written, parameter: Some(index) })
    }
}
