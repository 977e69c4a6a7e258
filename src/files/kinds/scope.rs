//! What the terms of a behavior can name beside what is in the world: its parameters and its claims.

use std::collections::BTreeSet;

use super::{NameOrParam, Piece, Text};
use crate::describe::{Context, Describes, Reads};
use crate::fault::Faults;
use crate::parameter::{self, Type};
use crate::reader::{Item, Name};
use crate::shape::Form;
use crate::template;
use ambidex_model::suggestion;

/// What is known of the behavior at hand.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub(super) parameters: Vec<parameter::Parameter>,
    /// Parameters that some term uses.
    pub(super) used: BTreeSet<usize>,
    /// The names of its claims, in their order.
    pub(super) claims: Vec<Name>,
}

/// What terms are read in.
pub(super) trait TermContext: Context {
    /// What is known so far of the behavior that they belong to.
    fn scope(&mut self) -> &mut Scope;
}

/// The terms of one behavior while they are read.
pub(super) struct Terms<'a> {
    pub(super) scope: Scope,
    pub(super) faults: &'a mut Faults,
}

impl Context for Terms<'_> {
    fn faults(&mut self) -> &mut Faults {
        self.faults
    }
}

impl TermContext for Terms<'_> {
    fn scope(&mut self) -> &mut Scope {
        &mut self.scope
    }
}

/// A name, or a parameter of that type.
pub(super) struct Slot(pub(super) Type);

/// Text in which `$name` stands for an argument.
pub(super) struct Template;

/// A parameter, with what faults say was wanted.
pub(super) struct Parameter(pub(super) &'static str);

/// The name of a claim.
pub(super) struct Claimed;

/// Every one of these is a word to an editor.
macro_rules! words {
    ($($form:ty),*) => {
        $(impl Describes for $form {
            fn form(&self) -> Form {
                Form::Word
            }
        })*
    };
}

words!(Slot, Template, Parameter, Claimed);

impl<'a, C: TermContext> Reads<'a, C> for Slot {
    type Out = NameOrParam;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<NameOrParam> {
        let written = item.name(self.0.what(), context.faults())?;
        let Some(name) = template::parameter(&written.value).map(str::to_owned) else {
            return Some(NameOrParam { written, parameter: None });
        };
        let index = find(&name, &written, context)?;
        let found = context.scope().parameters[index].ty;
        if found != self.0 {
            let message = format!("`${name}` is {}, not {}", found.what(), self.0.what());
            context.faults().push(written.span, &written.key, message, None);
            return None;
        }
        Some(NameOrParam { written, parameter: Some(index) })
    }
}

impl<'a, C: TermContext> Reads<'a, C> for Template {
    type Out = Text;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<Text> {
        let written = item.name("a text", context.faults())?;
        let mut pieces = Vec::new();
        for piece in template::pieces(&written.value) {
            pieces.push(match piece {
                template::Piece::Plain(text) => Piece::Plain(text.to_owned()),
                template::Piece::Parameter(name) => Piece::Parameter(find(name, &written, context)?),
            });
        }
        Some(Text { pieces, written })
    }
}

impl<'a, C: TermContext> Reads<'a, C> for Parameter {
    type Out = usize;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<usize> {
        let written = item.name(self.0, context.faults())?;
        if let Some(name) = template::parameter(&written.value) {
            return find(name, &written, context);
        }
        let message = format!("found `{}` instead of {}", written.value, self.0);
        context.faults().push(written.span, &written.key, message, None);
        None
    }
}

impl<'a, C: TermContext> Reads<'a, C> for Claimed {
    type Out = usize;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<usize> {
        let name = item.name("the name of a claim", context.faults())?;
        let claims = &context.scope().claims;
        let found = claims.iter().position(|claim| claim.value == name.value);
        if found.is_none() {
            let message = format!("there is no claim `{}`", name.value);
            let help = suggestion(&name.value, "claim", claims.iter().map(|claim| claim.value.as_str()));
            context.faults().push(name.span, &name.key, message, Some(help));
        }
        found
    }
}

/// Whether a parameter stands where a number could.
pub(super) fn constant_parameter(item: &Item<'_>) -> bool {
    item.text().and_then(template::parameter).is_some()
}

/// The parameter of a name; a fault if there is none.
fn find(name: &str, at: &Name, context: &mut impl TermContext) -> Option<usize> {
    let scope = context.scope();
    let found = scope.parameters.iter().position(|parameter| parameter.name.value == name);
    scope.used.extend(found);
    if found.is_none() {
        let allowed = scope.parameters.iter().map(|parameter| parameter.name.value.as_str());
        let help = suggestion(name, "parameter", allowed);
        context.faults().push(at.span, &at.key, format!("there is no parameter `{name}`"), Some(help));
    }
    found
}
