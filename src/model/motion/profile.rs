//! Speeding up, cruising and braking along a line: closed forms of time, so that no error adds up.

/// Rounding must not carry a sample over a limit.
const MARGIN: f64 = 1.0 - 1e-9;

/// What bounds a motion along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    /// Top speed, units per second.
    pub(super) speed: f64,
    /// Top acceleration, units per second squared; braking too.
    pub(super) acceleration: f64,
}

/// A motion over a length that ends at rest; time in seconds since its beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    length: f64,
    acceleration: f64,
    top_speed: f64,
    accelerate_s: f64,
    cruise_s: f64,
    brake_s: f64,
}

impl Profile {
    /// No motion at all.
    pub(super) const STILL: Self =
        Self { length: 0.0, acceleration: 0.0, top_speed: 0.0, accelerate_s: 0.0, cruise_s: 0.0, brake_s: 0.0 };

    /// The fastest motion from rest to rest over `length`.
    pub(super) fn over(length: f64, limits: Limits) -> Self {
        if length == 0.0 {
            return Self::STILL;
        }
        let acceleration = limits.acceleration * MARGIN;
        let top_speed = (limits.speed * MARGIN).min((acceleration * length).sqrt());
        let ramp_s = top_speed / acceleration;
        Self {
            length,
            acceleration,
            top_speed,
            accelerate_s: ramp_s,
            cruise_s: ((length - top_speed * ramp_s) / top_speed).max(0.0),
            brake_s: ramp_s,
        }
    }

    /// The motion that brakes from what this one does at `time_s`; measured from where it is then.
    pub(super) fn braked_at(&self, time_s: f64) -> Self {
        let (_, speed) = self.at(time_s);
        if speed == 0.0 {
            return Self::STILL;
        }
        let brake_s = speed / self.acceleration;
        Self {
            length: speed * brake_s / 2.0,
            acceleration: self.acceleration,
            top_speed: speed,
            accelerate_s: 0.0,
            cruise_s: 0.0,
            brake_s,
        }
    }

    /// How long it takes, seconds; not finite when the length is out of all bounds.
    pub(super) fn duration_s(&self) -> f64 {
        self.accelerate_s + self.cruise_s + self.brake_s
    }

    /// The length at the end.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// How far it has come, and how fast it is.
    pub(super) fn at(&self, time_s: f64) -> (f64, f64) {
        let left_s = self.duration_s() - time_s;
        if left_s <= 0.0 {
            return (self.length, 0.0);
        }
        if time_s < self.accelerate_s {
            let speed = self.acceleration * time_s;
            return (speed * time_s / 2.0, speed);
        }
        if left_s > self.brake_s {
            let ramp = self.top_speed * self.accelerate_s / 2.0;
            let cruised = self.top_speed * (time_s - self.accelerate_s);
            return (ramp + cruised, self.top_speed);
        }
        let speed = self.acceleration * left_s;
        (self.length - speed * left_s / 2.0, speed)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_long_way_cruises_and_a_short_one_does_not() {
        let limits = Limits { speed: 1.0, acceleration: 0.5 };
        for (length, duration_s) in [(8.0, 10.0), (2.0, 4.0), (0.5, 2.0), (0.0, 0.0)] {
            let found = Profile::over(length, limits).duration_s();
            assert!((found - duration_s).abs() < 1e-6, "{length}: {found}");
        }
    }

    proptest! {
        #[test]
        fn never_beyond_limits_or_goal(
            length in 0.0..20.0f64,
            speed in 0.05..3.0f64,
            acceleration in 0.05..5.0f64,
            cut in 0.0..1.0f64,
        ) {
            let profile = Profile::over(length, Limits { speed, acceleration });
            let duration_s = profile.duration_s();
            let ticks = (duration_s / 0.01).ceil() as u32 + 1;
            let mut before = (0.0, 0.0);
            for tick in 0..=ticks {
                let now = profile.at(f64::from(tick) * 0.01);
                prop_assert!(now.1 <= speed && now.0 <= length + 1e-9);
                prop_assert!((now.1 - before.1).abs() <= acceleration * 0.01 + 1e-12);
                prop_assert!(now.0 >= before.0 - 1e-9);
                prop_assert!(((now.0 - before.0) / 0.01 - (now.1 + before.1) / 2.0).abs() <= acceleration * 0.01);
                before = now;
            }
            prop_assert_eq!(before, (length, 0.0));

            let cut_s = cut * duration_s;
            let brake = profile.braked_at(cut_s);
            prop_assert!((brake.at(0.0).1 - profile.at(cut_s).1).abs() < 1e-9);
            prop_assert!(profile.at(cut_s).0 + brake.length() <= length + 1e-6);
        }
    }
}
