//! Numbers with units: SI when none is written.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dimension {
    Length,
    Angle,
    Time,
    Speed,
    Acceleration,
    TurnSpeed,
    TurnAcceleration,
    /// A number without a unit.
    Plain,
}

/// A dimension and the values that make sense.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Quantity {
    pub(crate) dimension: Dimension,
    pub(crate) range: RangeInclusive<f64>,
}

/// Coordinates within ten kilometers of the origin of the map.
pub(crate) const COORDINATE: Quantity = quantity(Dimension::Length, -10_000.0, 10_000.0);
/// Within the robot's surroundings.
pub(crate) const NEAR: Quantity = quantity(Dimension::Length, -10.0, 10.0);
/// A length that is not zero.
pub(crate) const EXTENT: Quantity = quantity(Dimension::Length, 0.01, 10.0);
/// A length that may be zero.
pub(crate) const LIFT: Quantity = quantity(Dimension::Length, 0.0, 10.0);
/// How near counts as there: no less than the base settles within.
pub(crate) const TOLERANCE: Quantity = quantity(Dimension::Length, 0.02, 10.0);
/// A direction, up to a whole turn either way.
pub(crate) const HEADING: Quantity = quantity(Dimension::Angle, -2.0 * PI, 2.0 * PI);
/// How long a behavior may take: up to a day.
pub(crate) const TIMEOUT: Quantity = quantity(Dimension::Time, 0.01, 86_400.0);
/// How long a behavior waits after it failed.
pub(crate) const BACKOFF: Quantity = quantity(Dimension::Time, 0.0, 3_600.0);
/// How long a controller may take to end what it was told to end.
pub(crate) const GRACE: Quantity = quantity(Dimension::Time, 0.1, 600.0);
/// How long a gripper takes.
pub(crate) const GRIP: Quantity = quantity(Dimension::Time, 0.0, 600.0);
/// How long a behavior takes at least; nothing by itself.
pub(crate) const DURATION: Quantity = quantity(Dimension::Time, 0.0, 86_400.0);
/// An activation potential; 0 means not to ask.
pub(crate) const POTENTIAL: Quantity = quantity(Dimension::Plain, 0.0, 1e9);
/// A top speed along a line; one that is 0 would never arrive.
pub(crate) const SPEED: Quantity = quantity(Dimension::Speed, 0.001, 100.0);
/// A top acceleration along a line, likewise above 0.
pub(crate) const ACCELERATION: Quantity = quantity(Dimension::Acceleration, 0.001, 100.0);
/// A top turning speed, above 0.
pub(crate) const TURN_SPEED: Quantity = quantity(Dimension::TurnSpeed, 0.001, 20.0);
/// A top turning acceleration, above 0.
pub(crate) const TURN_ACCELERATION: Quantity = quantity(Dimension::TurnAcceleration, 0.001, 100.0);

const fn quantity(dimension: Dimension, from: f64, to: f64) -> Quantity {
    Quantity { dimension, range: from..=to }
}

impl Quantity {
    /// What was probably meant by a text that is none, or one that is out of bounds: the same number in another unit.
    pub(crate) fn meant(&self, text: &str) -> Option<String> {
        let text = text.trim();
        let end = text.find(|letter: char| !(letter.is_ascii_digit() || "+-.".contains(letter))).unwrap_or(text.len());
        let (written, found) = (&text[..end], text[end..].trim());
        let number: f64 = written.parse().ok()?;
        let named =
            UNITS.iter().find(|(words, _)| words.contains(&found.to_lowercase().as_str())).map(|(_, unit)| *unit);
        let is_meant = |unit: &str, size: f64| unit != found && self.range.contains(&(number * size));
        let units = self.dimension.units().iter();
        // A unit that is only called otherwise is no guess; another one is, where none stands, or radians do.
        let fitting = match named {
            Some(named) => units.filter(|(unit, _)| *unit == named).find(|(unit, size)| is_meant(unit, *size)),
            None if found.is_empty() || found.starts_with("rad") => {
                units.filter(|(unit, _)| !unit.is_empty()).find(|(unit, size)| is_meant(unit, *size))
            }
            None => None,
        };
        fitting.map(|(unit, _)| format!("did you mean `{written} {unit}`?"))
    }
}

/// How else units are called, and their names in the files.
const UNITS: &[(&[&str], &str)] = &[
    (&["degree", "degrees"], "deg"),
    (&["radian", "radians"], "rad"),
    (&["meter", "meters", "metre", "metres"], "m"),
    (&["centimeter", "centimeters", "centimetre", "centimetres"], "cm"),
    (&["millimeter", "millimeters", "millimetre", "millimetres"], "mm"),
    (&["sec", "secs", "second", "seconds"], "s"),
    (&["msec", "millisecond", "milliseconds"], "ms"),
    (&["minute", "minutes", "mins"], "min"),
    (&["hour", "hours", "hr"], "h"),
];

impl Dimension {
    /// Units by name, each with its size in the SI unit, which comes first.
    pub(crate) fn units(self) -> &'static [(&'static str, f64)] {
        const DEGREE: f64 = PI / 180.0;
        match self {
            Self::Length => &[("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("km", 1000.0)],
            Self::Angle => &[("rad", 1.0), ("deg", DEGREE), ("°", DEGREE)],
            Self::Time => &[("s", 1.0), ("ms", 0.001), ("min", 60.0), ("h", 3600.0)],
            Self::Speed => &[("m/s", 1.0), ("cm/s", 0.01), ("mm/s", 0.001)],
            Self::Acceleration => &[("m/s^2", 1.0), ("m/s²", 1.0), ("cm/s^2", 0.01)],
            Self::TurnSpeed => &[("rad/s", 1.0), ("deg/s", DEGREE)],
            Self::TurnAcceleration => &[("rad/s^2", 1.0), ("rad/s²", 1.0), ("deg/s^2", DEGREE), ("deg/s²", DEGREE)],
            Self::Plain => &[("", 1.0)],
        }
    }

    /// What it is called, with an example.
    pub(crate) fn example(self) -> &'static str {
        match self {
            Self::Length => "a length such as `0.25 m`",
            Self::Angle => "an angle such as `90 deg`",
            Self::Time => "a time such as `10 s`",
            Self::Speed => "a speed such as `0.5 m/s`",
            Self::Acceleration => "an acceleration such as `0.5 m/s^2`",
            Self::TurnSpeed => "a turning speed such as `60 deg/s`",
            Self::TurnAcceleration => "a turning acceleration such as `90 deg/s^2`",
            Self::Plain => "a number such as `4.5`",
        }
    }

    /// The number in SI units; `number` is what YAML makes of the text, which already turned angles into radians.
    pub(crate) fn si(self, text: &str, number: Option<f64>) -> Result<f64, String> {
        if let Some(number) = number {
            let plain = text.parse() == Ok(number) || number == number.trunc();
            return if plain || self == Self::Angle {
                Ok(number)
            } else {
                Err(format!("`{text}` is not {}", self.example()))
            };
        }
        let plain = text.parse().ok();
        let in_unit = |&(unit, size): &(&str, f64)| {
            let value: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
            Some(value * size)
        };
        plain
            .or_else(|| self.units().iter().find_map(in_unit))
            .ok_or_else(|| format!("`{text}` is not {}", self.example()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_si() {
        let table = [
            (Dimension::Length, "25 cm", 0.25),
            (Dimension::Length, "0.25m", 0.25),
            (Dimension::Length, "-3 mm", -0.003),
            (Dimension::Angle, "90 deg", PI / 2.0),
            (Dimension::Angle, "180°", PI),
            (Dimension::Time, "80 ms", 0.08),
            (Dimension::Time, "1e1 s", 10.0),
            (Dimension::Speed, "50 cm/s", 0.5),
            (Dimension::Acceleration, "0.5 m/s^2", 0.5),
            (Dimension::Acceleration, "0.5 m/s²", 0.5),
            (Dimension::TurnAcceleration, "180 deg/s^2", PI),
        ];
        for (dimension, text, expected) in table {
            let found = dimension.si(text, None).unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn what_is_no_number_of_the_dimension_is_refused() {
        let table = [
            (Dimension::Length, "25 deg", "`25 deg` is not a length"),
            (Dimension::Length, "far", "`far` is not a length"),
            (Dimension::Length, "1 2 m", "`1 2 m` is not a length"),
            (Dimension::Length, "", "`` is not a length"),
            (Dimension::Speed, "^2", "`^2` is not a speed"),
        ];
        for (dimension, text, expected) in table {
            let found = dimension.si(text, None).unwrap_err();
            assert!(found.contains(expected), "{found}");
        }
    }
}
