//! Why a finished plan breaks a limit: what is special about the path or the arm where it happens.

use std::fmt;

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::smallest_singular_value;

use crate::arm::{MIN_SINGULAR_VALUE, PathArm};
use crate::plan::Plan;

/// A pose counts as nearly singular below this many times the smallest singular value that is followed at all.
const NEARLY: f64 = 10.0;
/// A bend counts as sharp when the tool covers its radius in fewer control periods than this, at the feed.
const PERIODS: f64 = 2.0;
/// Halvings of the distance in which the sharpest place of a bend is narrowed down.
const NARROWING: usize = 40;

/// What is special about the place where a finished trajectory breaks a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Cause {
    /// The path has a bend there that the tool would pass within two control periods at the feed.
    Bend {
        /// Arc length of its sharpest place, m.
        s: f64,
        /// Radius there, m.
        radius: f64,
    },
    /// The arm is nearly singular there.
    NearlySingular {
        /// Smallest singular value of the Jacobian, rows in m and rad.
        sigma: f64,
    },
    /// Nothing: planner and verification contradict each other.
    Contradiction,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Bend { s, radius } => write!(
                f,
                "the path has a bend of radius {} at s = {s:.6} m: round it to a larger radius, make it a true corner \
                 (where the tool stops), or raise that limit",
                length(radius)
            ),
            Self::NearlySingular { sigma } => write!(
                f,
                "the arm is nearly singular there (smallest singular value {sigma:.2e}): move the path, or start from \
                 another configuration"
            ),
            Self::Contradiction => f.write_str("the planner kept it by its own account: please report the job"),
        }
    }
}

/// A length in the unit that suits it.
fn length(m: f64) -> String {
    match m {
        m if m < 1e-6 => format!("{:.3} nm", m * 1e9),
        m if m < 1e-3 => format!("{:.3} um", m * 1e6),
        m => format!("{:.3} mm", m * 1e3),
    }
}

/// What is special near the arc length `s` of `plan`, where its tool runs at `feed` (m/s) at most.
pub(crate) fn cause<A, const N: usize>(arm: &A, plan: &Plan<N>, s: f64, feed: f64) -> Cause
where
    A: PathArm<N> + ?Sized,
{
    let window = PERIODS * feed * plan.period();
    let (place, radius) = sharpest(plan.path(), s, window);
    if radius < window {
        return Cause::Bend { s: place, radius };
    }
    let sigma = smallest_singular_value(&arm.jacobian(&plan.joint_path().near(s)));
    if sigma < NEARLY * MIN_SINGULAR_VALUE { Cause::NearlySingular { sigma } } else { Cause::Contradiction }
}

/// Place and radius of the sharpest bend within `window` of `s`, m.
fn sharpest(path: &PosePath, s: f64, window: f64) -> (f64, f64) {
    let radius = |s: f64| path.curve().jet(s).d2.norm().recip();
    let (low, high) = ((s - window).max(0.0), (s + window).min(path.length()));
    // Between two ends of the arc length map no bend hides.
    let (mut best, mut before) = ((s, radius(s)), low);
    let mut step = 0.0;
    let inside = path.curve().map_ends().filter(|end| (low..high).contains(end));
    for end in inside.chain([high]) {
        for place in [before, 0.5 * (before + end), end] {
            let here = radius(place);
            if here < best.1 {
                (best, step) = ((place, here), 0.5 * (end - before));
            }
        }
        before = end;
    }
    for _ in 0..NARROWING {
        for place in [best.0 - step, best.0 + step] {
            let here = radius(place.max(low).min(high));
            if here < best.1 {
                best = (place.max(low).min(high), here);
            }
        }
        step *= 0.5;
    }
    best
}

#[cfg(test)]
mod tests {
    use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath};
    use nalgebra::{UnitQuaternion, vector};

    use super::*;

    #[test]
    fn the_sharpest_place_of_a_bend_is_found_from_beside_it() {
        // A right angle rounded by a parabola that begins and ends 2 um from the corner: radius 2 um / sqrt(2).
        let cut = 2e-6;
        let points = vec![
            vector![-0.1, 0.0, 0.0],
            vector![-0.05, 0.0, 0.0],
            vector![-cut, 0.0, 0.0],
            vector![0.0, 0.0, 0.0],
            vector![0.0, cut, 0.0],
            vector![0.0, 0.05, 0.0],
            vector![0.0, 0.1, 0.0],
        ];
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0];
        let curve = ArcLengthCurve::new(NurbsCurve::bspline(2, points, knots).expect("valid"), 1e-15).expect("valid");
        let path = PosePath::new(curve, OrientationPath::Constant(UnitQuaternion::identity()));
        let (s, radius) = sharpest(&path, 0.1 - 7e-5, 1e-4);
        assert!((radius / (cut / 2f64.sqrt()) - 1.0).abs() < 1e-6, "{radius}");
        assert!((s - 0.5 * path.length()).abs() < 1e-9, "{s}");
        let text = Cause::Bend { s, radius }.to_string();
        assert!(text.contains("bend of radius 1.414 um at s = 0.100000"), "{text}");
        assert!(!text.contains("report") && Cause::Contradiction.to_string().contains("please report the job"));
    }
}
