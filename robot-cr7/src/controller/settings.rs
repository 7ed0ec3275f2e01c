//! What a session takes for granted, and what for a doubt.

use thiserror::Error;

use super::recent::MOST_RECENT;

/// Times in s, angles in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SendSettings {
    /// The time between two setpoints: a whole number of milliseconds, as controllers take no other.
    pub period: f64,
    /// Largest distance of a joint from the start of the motion when it begins.
    pub start_tolerance: f64,
    /// Largest distance of a joint from what was asked of it within the last [`lag`](Self::lag).
    pub following_tolerance: f64,
    /// How long the arm may be behind the setpoints.
    pub lag: f64,
    /// The longest time without a new state of the arm.
    pub feedback_timeout: f64,
    /// How late a setpoint may be sent.
    pub lateness: f64,
    /// True if the drives may be switched on.
    pub enable: bool,
    /// Numbers of the models of arm that the motion is for; empty for any.
    pub models: &'static [u8],
}

impl SendSettings {
    /// A setpoint every `period` (s); the other values are 0.05 deg at the start, 2 deg behind within 0.3 s, 0.1 s without a state, half a
    /// period late, drives not switched on, any model.
    ///
    /// # Errors
    /// [`SettingsError`] unless the period is from 4 ms to 0.2 s and a whole number of milliseconds.
    pub fn new(period: f64) -> Result<Self, SettingsError> {
        let settings = Self {
            period,
            start_tolerance: 0.05f64.to_radians(),
            following_tolerance: 2f64.to_radians(),
            lag: 0.3,
            feedback_timeout: 0.1,
            lateness: 0.5 * period,
            enable: false,
            models: &[],
        };
        settings.check()?;
        Ok(settings)
    }

    /// Checks values that were changed.
    ///
    /// # Errors
    /// [`SettingsError`].
    pub fn check(&self) -> Result<(), SettingsError> {
        let most_lag = (MOST_RECENT - 8) as f64 * self.period;
        let values = [
            ("period", self.period, 0.004, 0.2),
            ("tolerance at the start", self.start_tolerance, 1e-6, 5f64.to_radians()),
            ("tolerance of the following error", self.following_tolerance, 1e-4, 5f64.to_radians()),
            ("lag", self.lag, self.period, most_lag.min(1.0)),
            ("time without feedback", self.feedback_timeout, 0.016, 1.0),
            ("lateness", self.lateness, 0.0, self.period),
        ];
        for (what, value, least, most) in values {
            if !(least..=most).contains(&value) {
                return Err(SettingsError::Range { what, value, least, most });
            }
        }
        let milliseconds = 1e3 * self.period;
        if (milliseconds - milliseconds.round()).abs() > 1e-9 {
            return Err(SettingsError::Fraction { milliseconds });
        }
        Ok(())
    }
}

/// A setting that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// It is outside its range.
    #[error("{what}: {value} is not from {least:.6} to {most:.6} (s, rad): choose a value in this range")]
    Range {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The least value.
        least: f64,
        /// The largest value.
        most: f64,
    },
    /// The period is not a whole number of milliseconds: the arm would be led at another rate than was certified.
    #[error(
        "period: {milliseconds} ms is not a whole number of milliseconds, and controllers take no other: round it up"
    )]
    Fraction {
        /// The period, ms.
        milliseconds: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_a_whole_number_of_milliseconds() {
        for milliseconds in 4..=200 {
            assert!(SendSettings::new(f64::from(milliseconds) * 1e-3).is_ok(), "{milliseconds}");
        }
        for wrong in [4.4, 30.5, 30.001, 3.0, 201.0, f64::NAN] {
            assert!(SendSettings::new(wrong * 1e-3).is_err(), "{wrong}");
        }
    }

    #[test]
    fn guards_cannot_be_set_aside() {
        let settings = SendSettings::new(0.2).expect("a period");
        assert!(SendSettings { lag: 1.0, ..settings }.check().is_ok());
        assert!(SendSettings { lag: 1.1, ..settings }.check().is_err());
        assert!(SendSettings { start_tolerance: 5.1f64.to_radians(), ..settings }.check().is_err());
        assert!(SendSettings { following_tolerance: 5f64.to_radians(), ..settings }.check().is_ok());
        assert!(SendSettings { following_tolerance: 5.1f64.to_radians(), ..settings }.check().is_err());
    }
}
