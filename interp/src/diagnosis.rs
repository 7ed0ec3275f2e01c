//! Why a finished motion breaks a limit: what is special about the path or the arm where it happens.

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::smallest_singular_value;

use crate::arm::MIN_SINGULAR_VALUE;
use crate::error::Cause;
use crate::problem::PathProblem;

/// A pose counts as nearly singular below this many times the smallest singular value that is followed at all.
const NEARLY: f64 = 10.0;
/// A bend counts as sharp when the tool covers its radius in fewer control periods than this, at the feed.
const PERIODS: f64 = 2.0;
/// Halvings of the distance in which the sharpest place of a bend is narrowed down.
const NARROWING: usize = 40;

/// The feature of the path near `s`. `between` tells whether the planner knew the limits between the points of its grid.
pub(crate) fn cause<const N: usize>(problem: &PathProblem<'_, N>, s: f64, between: bool) -> Cause {
    if let Some(curve) = problem.path().tool_curve() {
        let reachable = problem.settings.reachable(curve.length());
        let window = PERIODS * problem.feed_at(s).min(reachable) * problem.settings.period;
        let (place, radius) = sharpest(curve, s, window);
        if radius < window {
            return Cause::Bend { s: place, radius };
        }
    }
    let by_joints = problem.path().tool(0.0).is_none();
    let sigma = smallest_singular_value(&problem.settings.arm.jacobian(&problem.joint_path().near(s).q));
    match (sigma < NEARLY * MIN_SINGULAR_VALUE && !by_joints, between) {
        (true, _) => Cause::NearlySingular { sigma },
        (false, false) => Cause::CoarseGrid { intervals: problem.intervals() },
        (false, true) => Cause::Contradiction,
    }
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
