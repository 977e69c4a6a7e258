//! Calls: what a controller offers beyond what its kind can do, and what a behavior tells it.

use serde_json::Value;

use super::bind::Bound;
use super::terms::CallValue;
use crate::document::Node;
use crate::fault::Faults;
use crate::parameter::{Argument, Meaning, Parameter, example_value};
use crate::reader::{Item, Name};
use crate::robot::Offer;
use crate::text::scalar;
use crate::types::Type;
use ambidex_model::{ARGUMENTS_MAX, Call, Claim, ControllerId, suggestion};

impl Bound<'_, '_> {
    /// The call of a behavior with its arguments; `None` when it has faults.
    pub(super) fn call(&mut self, name: &Name, with: &[(Name, Option<CallValue>)], claim: &Claim) -> Option<Call> {
        let offer = self.offer(name, claim)?;
        let before = self.faults.errors();
        for (given, _) in with {
            if !offer.parameters.iter().any(|parameter| parameter.name.value == given.value) {
                let allowed = offer.parameters.iter().map(|parameter| parameter.name.value.as_str());
                let message = format!("`{}` has no parameter `{}`", offer.name, given.value);
                self.faults.push_with(given, message, || suggestion(&given.value, "parameter", allowed));
            }
        }
        let mut arguments = serde_json::Map::new();
        for parameter in &offer.parameters {
            let given = with.iter().find(|(given, _)| given.value == parameter.name.value);
            let value = match given {
                Some((key, value)) => self.value(key, value.as_ref()?, parameter.ty),
                None => self.default(&offer, parameter, name),
            };
            arguments.extend(value.map(|value| (parameter.name.value.clone(), value)));
        }
        let with = Value::Object(arguments).to_string();
        if with.len() > ARGUMENTS_MAX {
            let message = format!("the arguments of `{}` take {} bytes as JSON", offer.name, with.len());
            self.faults.push_with(name, message, format!("at most {ARGUMENTS_MAX} are sent"));
        }
        (self.faults.errors() == before).then_some(Call { name: offer.name, with, takes: offer.takes })
    }

    /// What all offer alike that could serve the claim; `None` where one does not, which is a fault.
    fn offer(&mut self, name: &Name, claim: &Claim) -> Option<Offer> {
        let controllers = self.callees(claim);
        if controllers.is_empty() {
            let help = "give it a `controller` in the robot file, which offers the call".to_owned();
            self.faults.push_with(name, "no controller moves what is claimed, so that nobody can be called", help);
            return None;
        }
        let mut common: Option<(&str, &Offer)> = None;
        let (file, faults) = (self.binder.robot, &mut *self.faults);
        for controller in controllers {
            let whose = &file.robot.controllers[controller.index()].name;
            let offers = &file.offers[controller.index()];
            let Some(offer) = offers.iter().find(|offer| offer.name == name.value) else {
                let help = || suggestion(&name.value, "call", offers.iter().map(|offer| offer.name.as_str()));
                faults.push_with(name, format!("controller `{whose}` offers no call `{}`", name.value), help);
                return None;
            };
            match common {
                Some((other, first)) if !first.is_like(offer) => {
                    let message =
                        format!("`{other}` and `{whose}` offer `{}` with other parameters or times", offer.name);
                    faults.push_with(name, message, "either may be granted: let both offer it alike");
                    return None;
                }
                Some(_) => {}
                None => common = Some((whose, offer)),
            }
        }
        common.map(|(_, offer)| offer.clone())
    }

    /// The controllers of all that could serve a claim, each once.
    fn callees(&self, claim: &Claim) -> Vec<ControllerId> {
        let robot = self.robot();
        let resources = robot.could_serve(claim.selector);
        let mut controllers: Vec<_> =
            resources.into_iter().filter_map(|resource| robot.resources[resource.index()].controller).collect();
        controllers.sort_unstable();
        controllers.dedup();
        controllers
    }

    fn value(&mut self, key: &Name, value: &CallValue, ty: Type) -> Option<Value> {
        let argument = match value {
            CallValue::Told(index, written) => {
                let found = self.kind.parameters[*index].ty;
                if found != ty {
                    let message = format!("`{}` is {}, not {}", written.value, found.what(), ty.what());
                    self.faults.push(written, message);
                    return None;
                }
                let told = self.arguments[*index].clone();
                if told.is_none() {
                    self.faults.push(written, format!("`{}` stands for nothing here", written.value));
                }
                told?
            }
            CallValue::Made(text) => {
                if matches!(ty, Type::Number | Type::Offset) {
                    self.faults.push(&text.written, format!("a text is not {}", ty.what()));
                    return None;
                }
                let name = Name { value: text.filled(&self.arguments), ..text.written.clone() };
                let value = self.binder.known.named(&name, ty, self.faults)?;
                Argument { text: name.value, value }
            }
            CallValue::Written(node) => self.binder.known.argument(Item::of(&key.value, node), ty, self.faults)?,
        };
        Some(json(&argument))
    }

    /// What a parameter is without an argument; a fault where it needs one.
    fn default(&mut self, offer: &Offer, parameter: &Parameter, at: &Name) -> Option<Value> {
        let known = &self.binder.known;
        match parameter.defaults.as_deref().and_then(<[Node]>::first) {
            Some(default) => {
                let item = Item::of(&parameter.name.value, default);
                known.argument(item, parameter.ty, self.faults).map(|argument| json(&argument))
            }
            None => {
                lacks(offer, parameter, at, self.faults);
                None
            }
        }
    }
}

fn lacks(offer: &Offer, parameter: &Parameter, at: &Name, faults: &mut Faults) {
    let needed = offer.parameters.iter().filter(|parameter| parameter.defaults.is_none());
    let example: Vec<_> =
        needed.map(|parameter| format!("{}: {}", scalar(&parameter.name.value), example_value(parameter.ty))).collect();
    let (name, what) = (&parameter.name.value, parameter.ty.what());
    let message = format!("`{}` lacks its parameter `{name}`, {what}", offer.name);
    faults.push_with(at, message, format!("write `with: {{{}}}` beside it", example.join(", ")));
}

/// Names as they are, numbers and lengths in SI units.
fn json(argument: &Argument) -> Value {
    match argument.value {
        Meaning::Number(number) => Value::from(number),
        Meaning::Offset(offset) => Value::from(offset.to_vec()),
        Meaning::Object(_)
        | Meaning::Place(_)
        | Meaning::PlaceOf(_)
        | Meaning::Resource(_)
        | Meaning::Kind(_)
        | Meaning::Text => Value::from(argument.text.as_str()),
    }
}
