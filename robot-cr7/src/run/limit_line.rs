//! One limit and how far a motion uses it.

use serde::Serialize;

/// By how much a value may exceed its limit through rounding, relative to the limit.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// Unit of a limited quantity; [`Report`](crate::Report) keeps SI, its text shows millimetres and degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum LimitUnit {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Metre per second.
    #[serde(rename = "m/s")]
    MetrePerSecond,
    /// Metre per second squared.
    #[serde(rename = "m/s^2")]
    MetrePerSecond2,
    /// Metre per second cubed.
    #[serde(rename = "m/s^3")]
    MetrePerSecond3,
    /// Radian.
    #[serde(rename = "rad")]
    Radian,
    /// Radian per second.
    #[serde(rename = "rad/s")]
    RadianPerSecond,
    /// Radian per second squared.
    #[serde(rename = "rad/s^2")]
    RadianPerSecond2,
    /// Radian per second cubed.
    #[serde(rename = "rad/s^3")]
    RadianPerSecond3,
    /// Newton metre.
    #[serde(rename = "N m")]
    NewtonMetre,
    /// A plain number.
    #[serde(rename = "1")]
    One,
}

impl LimitUnit {
    /// Factor and unit for people: mm and degrees.
    pub(crate) fn for_people(self) -> (f64, &'static str) {
        let degrees = 180.0 / std::f64::consts::PI;
        match self {
            Self::Metre => (1e3, "mm"),
            Self::MetrePerSecond => (1e3, "mm/s"),
            Self::MetrePerSecond2 => (1e3, "mm/s^2"),
            Self::MetrePerSecond3 => (1e3, "mm/s^3"),
            Self::Radian => (degrees, "deg"),
            Self::RadianPerSecond => (degrees, "deg/s"),
            Self::RadianPerSecond2 => (degrees, "deg/s^2"),
            Self::RadianPerSecond3 => (degrees, "deg/s^3"),
            Self::NewtonMetre => (1.0, "N m"),
            Self::One => (1.0, ""),
        }
    }
}

/// One limit and how far the finished trajectory uses it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitLine {
    /// The limited quantity, such as "feed" or "joint velocity"; the lines of all joints of one kind share it.
    pub name: String,
    /// The joint, from 1, for limits that each joint has of its own.
    pub joint: Option<usize>,
    /// Unit of `value` and `limit`.
    pub unit: LimitUnit,
    /// Value at the worst place, with its sign.
    pub value: f64,
    /// The limit there.
    pub limit: f64,
    /// The part of the limit that is used: 1 is all of it, above 1 it is broken.
    pub ratio: f64,
    /// Arc length of the worst place in m; none for a motion that follows no path.
    pub at_s_m: Option<f64>,
    /// Its time in s.
    pub at_t_s: f64,
    /// The line of the path file there, twice, or the two lines whose corner is blended there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<[usize; 2]>,
}

impl LimitLine {
    /// True if the limit holds to within 1e-6 of itself, which is rounding. A value that is not a number does not.
    pub fn holds(&self) -> bool {
        self.ratio <= 1.0 + TOLERANCE
    }
}

/// The line that uses most of its limit; lines with a ratio that is not a number count as the worst.
pub(crate) fn worst<'l>(limits: impl IntoIterator<Item = &'l LimitLine>) -> Option<&'l LimitLine> {
    limits.into_iter().max_by(|a, b| badness(a).total_cmp(&badness(b)))
}

fn badness(line: &LimitLine) -> f64 {
    if line.ratio.is_nan() { f64::INFINITY } else { line.ratio }
}
