//! Values that parameters of a mission get when it is started, from outside of its files.

use std::str::FromStr;

use crate::document::{self, Located, Node, SourceSpan, Value};
use crate::fault::Faults;
use crate::parameter::{Known, Parameter, example_value};
use crate::reader::Item;
use crate::types::Type;
use ambidex_model::{Source, suggestion};

/// The value of one parameter, as the command line tells it: `object=mug`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The parameter.
    pub name: String,
    /// Its value as in a file; an offset as `[1 m, 0 m]`.
    pub value: String,
}

/// Why a text is no setting.
#[derive(Debug, thiserror::Error)]
#[error("write NAME=VALUE, such as object=cup")]
pub struct NoSetting;

/// The parameters of a mission with what they stand for.
#[derive(Debug, Default)]
pub(crate) struct Given {
    pub(crate) parameters: Vec<Parameter>,
    /// None for one that is lacking or wrong, which is a fault.
    pub(crate) values: Vec<Option<Node>>,
}

impl FromStr for Setting {
    type Err = NoSetting;

    fn from_str(text: &str) -> Result<Self, NoSetting> {
        let (name, value) = text.split_once('=').ok_or(NoSetting)?;
        let (name, value) = (name.trim().to_owned(), value.trim().to_owned());
        if name.is_empty() { Err(NoSetting) } else { Ok(Self { name, value }) }
    }
}

impl Setting {
    /// Those with which something was made.
    pub(crate) fn all_of(source: &Source) -> Vec<Self> {
        let setting = |(name, value): &(String, String)| Self { name: name.clone(), value: value.clone() };
        source.settings.iter().map(setting).collect()
    }

    /// Names and values, to be kept.
    pub(crate) fn pairs(settings: &[Self]) -> Vec<(String, String)> {
        settings.iter().map(|setting| (setting.name.clone(), setting.value.clone())).collect()
    }

    /// How it was told, as the place of what is wrong with it.
    fn open(&self, faults: &mut Faults) -> (String, SourceSpan) {
        let written = format!("--set {}={}", self.name, self.value);
        let file = faults.open(&written, String::new());
        (written, SourceSpan { file, ..SourceSpan::default() })
    }

    /// Which of some parameters it is for; a fault if there is none.
    fn index(
        &self,
        what: &str,
        parameters: &[Parameter],
        (span, written): (SourceSpan, &String),
        faults: &mut Faults,
    ) -> Option<usize> {
        let names = || parameters.iter().map(|parameter| parameter.name.value.as_str());
        let found = names().position(|name| name == self.name);
        if found.is_none() {
            let help = || suggestion(&self.name, "parameter", names());
            faults.push_with((span, written), format!("{what} has no parameter `{}`", self.name), help);
        }
        found
    }
}

/// Says of settings for the task of a world that nobody does it.
pub(crate) fn warn_of_settings(parameters: &[Parameter], settings: &[Setting], faults: &mut Faults) {
    for setting in settings {
        let (written, span) = setting.open(faults);
        if setting.index("the world", parameters, (span, &written), faults).is_some() {
            let help = "tell it to the tasks that are submitted";
            faults.warn((span, &written), "the task of a world is not done".to_owned(), Some(help.to_owned()));
        }
    }
}

impl Given {
    /// What is set, else the default; every value means something.
    pub(crate) fn of(
        what: &str,
        parameters: Vec<Parameter>,
        settings: &[Setting],
        known: &Known<'_>,
        faults: &mut Faults,
    ) -> Self {
        let mut values: Vec<Option<(String, Node)>> = vec![None; parameters.len()];
        for setting in settings {
            let (written, span) = setting.open(faults);
            let Some(index) = setting.index(what, &parameters, (span, &written), faults) else { continue };
            let value = value(parameters[index].ty, &setting.value, span);
            if values[index].replace((written.clone(), value)).is_some() {
                faults.push((span, &written), format!("`{}` is set twice", setting.name));
            }
        }
        for (parameter, value) in parameters.iter().zip(&mut values).filter(|(_, value)| value.is_none()) {
            let name = &parameter.name.value;
            match parameter.defaults.as_ref().and_then(|defaults| defaults.first()) {
                Some(default) => *value = Some((name.clone(), default.clone())),
                None => {
                    let help =
                        format!("tell it with `--set {name}={}`, or give it a `default`", example_value(parameter.ty));
                    faults.push_with(&parameter.name, format!("nothing tells {}: `{name}`", parameter.ty.what()), help);
                }
            }
        }
        let mut right = |(parameter, value): (&Parameter, Option<(String, Node)>)| {
            let (written, value) = value?;
            let before = faults.errors();
            known.argument(Item::of(&written, &value), parameter.ty, faults);
            (faults.errors() == before).then_some(value)
        };
        let values = parameters.iter().zip(values).map(&mut right).collect();
        Self { parameters, values }
    }

    /// Whether each parameter has a value.
    pub(crate) fn is_whole(&self) -> bool {
        self.values.iter().all(Option::is_some)
    }
}

/// A value that stands in no file: nothing in it has a line.
fn value(ty: Type, text: &str, span: SourceSpan) -> Node {
    let plain = || Value::Scalar { text: text.to_owned(), number: None };
    let value = match ty {
        Type::Offset => document::parse(span.file, text).map_or_else(|_| plain(), |node| node.value),
        Type::Object | Type::Place | Type::Resource | Type::Kind | Type::Number | Type::Text => plain(),
    };
    placed(value, span)
}

fn placed(value: Value, span: SourceSpan) -> Node {
    let value = match value {
        Value::List(items) => Value::List(items.into_iter().map(|item| placed(item.value, span)).collect()),
        Value::Null | Value::Scalar { .. } | Value::Map(_) => value,
    };
    Located { value, span }
}
