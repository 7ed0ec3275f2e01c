//! The limits of all coordinates, and the part of them that one part of a motion leaves to the
//! other.

use nalgebra::{SMatrix, SVector};

use super::transverse_brake::{BrakeLimits, Ranges};

/// A derivative of the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Velocity,
    Acceleration,
}

impl Order {
    /// Largest factor of a part of a coordinate with which it and the rest of `whole` keep `bound`; infinite for no part.
    pub fn share(self, [part, whole]: [f64; 2], bound: f64) -> f64 {
        let (p, c, against) = (part.abs(), whole.abs(), part * whole < 0.0);
        let most = match self {
            // A velocity that is braked stays on its side of zero and so leaves the other one free.
            Self::Velocity if against => bound - c,
            Self::Velocity => bound,
            Self::Acceleration if against => (0.5 * (bound - c)).min((1.0 - RESERVE) * bound),
            Self::Acceleration => (0.5 * (bound + c)).min((1.0 - RESERVE) * bound),
        };
        if p > 0.0 { (most / p).max(0.0) } else { f64::INFINITY }
    }
}

/// Bounds of the scalar along the line, as `(lower, upper)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScalarBounds {
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

/// The limits of all coordinates, seen by the two parts of a motion: `u x(t)` along the line and
/// `w(t)`, which brakes to rest.
///
/// All vectors but those of [`FeasibleSet::frame`] are in the frame of the plan.
pub(super) trait FeasibleSet<const M: usize> {
    /// Orthonormal axes, as columns, in which to plan a motion along `u` from a velocity and an
    /// acceleration.
    fn frame(&self, u: &SVector<f64, M>, v: &SVector<f64, M>, a: &SVector<f64, M>) -> SMatrix<f64, M, M>;

    /// The acceleration at the start less what comes from the two parts turning each other.
    fn apart(&self, u: &SVector<f64, M>, alpha: f64, v: &SVector<f64, M>, a: &SVector<f64, M>) -> SVector<f64, M>;

    /// Factor of `u` nearest to `y`, measured in limits so that units do not matter.
    fn project(&self, order: Order, y: &SVector<f64, M>, u: &SVector<f64, M>) -> f64;

    /// Largest factor in `[0, 1]` of `part` with which `part` and the rest of `whole` are inside
    /// the limits together.
    fn share(&self, order: Order, part: &SVector<f64, M>, whole: &SVector<f64, M>) -> f64;

    /// Limits of the transverse part with velocity `v` and acceleration `a`: `share` of what there
    /// is, no more than a line with acceleration `line` leaves, but enough for `a`.
    fn brake_limits(
        &self,
        line: &SVector<f64, M>,
        v: &SVector<f64, M>,
        a: &SVector<f64, M>,
        share: f64,
    ) -> [BrakeLimits; M];

    /// The bounds of `x` while `w` runs through `ranges`. It must not grow narrower while these
    /// shrink. Without zero if `w` alone breaks a limit.
    fn scalar_bounds(&self, u: &SVector<f64, M>, ranges: &[Ranges; M]) -> ScalarBounds;
}

/// The narrowest bounds, but not so little that no motion could be planned: this part of a limit
/// counts as round-off.
pub(super) const FLOOR: f64 = 1e-10;

/// The line leaves at least this part of the acceleration to what has to brake.
const RESERVE: f64 = 0.1;

/// Excess over a bound that counts as round-off.
pub(super) const SLACK: f64 = 1e-11;

/// Bound of a scalar that no coordinate bounds.
pub(super) const WIDEST: f64 = 1e150;

/// No value at all.
pub(super) const NONE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);
