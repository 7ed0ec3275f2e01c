//! A path as a list of segments, each with its own limits.

use crate::error::FeedError;

/// A piece of path with bounds that are safe anywhere inside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    pub(super) length: f64,
    pub(super) v_max: f64,
    pub(super) a_max: f64,
    pub(super) j_max: f64,
}

impl Segment {
    /// A segment of the given length (m) with bounds on speed (m/s), tangential acceleration (m/s²)
    /// and tangential jerk (m/s³). All are finite and above 0: where the shape of the path gives no
    /// bound on the speed, the feed does.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`] or [`FeedError::NotPositive`] naming the field.
    pub fn new(length: f64, v_max: f64, a_max: f64, j_max: f64) -> Result<Self, FeedError> {
        use crate::error::positive;
        Ok(Self {
            length: positive("length", length)?,
            v_max: positive("v_max", v_max)?,
            a_max: positive("a_max", a_max)?,
            j_max: positive("j_max", j_max)?,
        })
    }

    /// Length (m).
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Bound on the speed (m/s).
    pub const fn v_max(&self) -> f64 {
        self.v_max
    }

    /// Bound on the tangential acceleration, either sign (m/s²).
    pub const fn a_max(&self) -> f64 {
        self.a_max
    }

    /// Bound on the tangential jerk, either sign (m/s³).
    pub const fn j_max(&self) -> f64 {
        self.j_max
    }
}

/// Start positions of the segments and, as the last entry, the length of the path (m).
pub fn boundaries(segments: &[Segment]) -> Vec<f64> {
    let mut s = Vec::with_capacity(segments.len() + 1);
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    s.push(0.0);
    for segment in segments {
        let y = segment.length - lost;
        let next = sum + y;
        lost = (next - sum) - y;
        sum = next;
        s.push(sum);
    }
    s
}

/// The cap on the speed at each boundary: the lower of the two segments that meet there.
pub(super) fn boundary_caps(segments: &[Segment]) -> Vec<f64> {
    let n = segments.len();
    (0..=n)
        .map(|i| match i {
            0 => segments[0].v_max,
            _ if i == n => segments[n - 1].v_max,
            _ => segments[i - 1].v_max.min(segments[i].v_max),
        })
        .collect()
}
