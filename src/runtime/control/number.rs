//! Whole numbers, which JSON may also write as `3.0`.

use serde::de::{Deserialize, Deserializer, Error};

use ambidex_model::PRIORITY_MAX;

/// A number as it may be written.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Written {
    Whole(i64),
    Decimal(f64),
}

impl Written {
    fn whole<T: TryFrom<i64>, E: Error>(self) -> Result<T, E> {
        // Every whole number of 32 bits is one of a double.
        const MOST: f64 = u32::MAX as f64;
        let number = match self {
            Self::Whole(number) => Some(number),
            Self::Decimal(number) => (number.fract() == 0.0 && number.abs() <= MOST).then_some(number as i64),
        };
        let fitting = number.and_then(|number| T::try_from(number).ok());
        fitting.ok_or_else(|| E::custom("a whole number of 32 bits is wanted"))
    }
}

/// A whole number.
pub(super) fn whole<'de, D: Deserializer<'de>, T: TryFrom<i64>>(from: D) -> Result<T, D::Error> {
    Written::deserialize(from)?.whole()
}

/// The same, or none.
pub(super) fn optional<'de, D: Deserializer<'de>, T: TryFrom<i64>>(from: D) -> Result<Option<T>, D::Error> {
    Option::<Written>::deserialize(from)?.map(Written::whole).transpose()
}

/// A priority, or none.
pub(super) fn priority<'de, D: Deserializer<'de>>(from: D) -> Result<Option<i32>, D::Error> {
    let priority = optional(from)?;
    let is_far = |priority: &i32| priority.unsigned_abs() > PRIORITY_MAX.unsigned_abs();
    match priority.filter(is_far) {
        Some(_) => Err(D::Error::custom(format!("a priority is from -{PRIORITY_MAX} to {PRIORITY_MAX}"))),
        None => Ok(priority),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Edit, NameOrId, Submission};
    use serde_json::json;

    #[test]
    fn a_whole_number_is_one_however_it_is_written() {
        let check = |priority: serde_json::Value, expected: Option<Option<i32>>| {
            let source = json!({"mission": "m.yaml", "files": []});
            let submission = json!({"priority": priority, "source": source});
            let read = serde_json::from_value::<Submission>(submission);
            assert_eq!(read.ok().map(|submission| submission.priority), expected, "{priority}");
        };
        check(json!(3), Some(Some(3)));
        check(json!(-3.0), Some(Some(-3)));
        check(json!(null), Some(None));
        check(json!(3.5), None);
        check(json!(-1000), Some(Some(-1000)));
        check(json!(1001), None);
        check(json!(i32::MIN), None);
        check(json!(3_000_000_000_u32), None);
        check(json!(1e300), None);
        check(json!("3"), None);
    }

    #[test]
    fn digits_are_a_number_and_anything_else_a_name() {
        let check = |node: serde_json::Value, expected: Option<NameOrId>| {
            let edit = serde_json::from_value::<Edit>(json!({"remove": {"node": node}}));
            assert_eq!(edit.ok(), expected.map(|node| Edit::Remove { node }), "{node}");
        };
        check(json!(3), Some(NameOrId::Id(3)));
        check(json!(3.0), Some(NameOrId::Id(3)));
        check(json!("pick"), Some(NameOrId::Name("pick".into())));
        check(json!(-1), None);
        check(json!([]), None);
        assert_eq!(NameOrId::from("3".to_owned()), NameOrId::Id(3));
        assert_eq!(NameOrId::from("3 cups".to_owned()), NameOrId::Name("3 cups".into()));
    }
}
