//! What a session takes for granted, and what for a doubt.

use thiserror::Error;

use super::recent::MOST_RECENT;

/// Times in s, angles in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SendSettings {
    /// The time between two setpoints.
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
    /// [`SettingsError`] unless the period is from 4 ms to 0.2 s.
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
            ("tolerance at the start", self.start_tolerance, 1e-6, 0.1),
            ("tolerance of the following error", self.following_tolerance, 1e-4, 0.5),
            ("lag", self.lag, self.period, most_lag),
            ("time without feedback", self.feedback_timeout, 0.016, 1.0),
            ("lateness", self.lateness, 0.0, self.period),
        ];
        for (what, value, least, most) in values {
            if !(least..=most).contains(&value) {
                return Err(SettingsError { what, value, least, most });
            }
        }
        Ok(())
    }
}

/// A setting is outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{what}: {value} is not from {least:.6} to {most:.6} (s, rad): choose a value in this range")]
pub struct SettingsError {
    /// The setting.
    pub what: &'static str,
    /// Its value.
    pub value: f64,
    /// The least value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
}
