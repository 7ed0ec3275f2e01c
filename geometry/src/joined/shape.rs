//! The shape of a blend: a polynomial of degree 5 that takes over position, tangent and curvature at both ends.

use nalgebra::Vector3;

use super::arcs::rounding;
use super::path::angle_between;
use super::spans::SpanJet;

/// Steps that halve the interval in which the deviation of an asymmetric blend is attained.
const HALVINGS: usize = 30;

/// A piece that replaces a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blend {
    pub points: [Vector3<f64>; 6],
    /// Upper bound on the distance from the path that it replaces.
    pub deviation: f64,
    /// Lengths it was to take before and after the joint, which place its ends.
    pub taken: [f64; 2],
    /// Lengths it replaces: an end close to a border between two spans is on it.
    pub replaced: [f64; 2],
}

/// Distances of the second and the third control point from the joint of two lines, as parts of the length taken,
/// at a corner of `angle`.
///
/// With a `fullness` of 0 they are those of least time where the deviation is bounded and the length is not. Near the
/// corner such a blend is sharper than at constant speed would be best: the tool is slowest there, and the gentle ends
/// let it brake and accelerate on the blend. The example `blend_sweep` compares with a search on an arm: `docs/blends.md`
/// lists the times.
///
/// With 1 they are for a blend whose length is bounded, too. At equal deviation and at equal length these make the
/// largest third derivative by arc length nearly the smallest, and so allow nearly the highest constant speed under a
/// limit on jerk: within 1 % of that of the best pair for corners from 10 to 130 degrees, and within 5 % up to 170.
/// Under a limit on acceleration, where the largest curvature counts, it is within 9 %. The test
/// `the_ratios_are_nearly_the_best` compares with a sweep, to whose best pairs the polynomials are fitted.
pub(super) fn ratios(angle: f64, fullness: f64) -> [f64; 2] {
    // 1 - cos(angle / 2), without cancellation.
    let w = 2.0 * (0.25 * angle).sin().powi(2);
    let squared = w * w;
    let fast = [0.36 + 0.21 * (-20.0 * w).exp(), 0.15 + 0.13 * squared];
    let full = [0.57 + squared * (0.23 + 0.2 * w), 0.15 + w * (0.47 + squared * (0.28 + 0.1 * squared))];
    [0, 1].map(|i| fast[i] + fullness * (full[i] - fast[i]))
}

/// The deviation of the symmetric blend of two lines, as a part of the length taken.
pub(super) fn symmetric_deviation(angle: f64, fullness: f64) -> f64 {
    let [b, c] = ratios(angle, fullness);
    0.5 * angle.sin() * (1.0 + 5.0 * b + 10.0 * c) / 16.0
}

/// The fullness with which a symmetric blend of two lines over the length `taken` deviates by `aim`; the nearer end
/// of the range where none does. The deviation is linear in the fullness.
pub(super) fn fullness(angle: f64, taken: f64, aim: f64) -> f64 {
    let [least, most] = [0.0, 1.0].map(|fullness| taken * symmetric_deviation(angle, fullness));
    ((aim - least) / (most - least)).max(0.0).min(1.0)
}

/// The blend of two lines with the directions `along` that meet in `corner`, and its deviation but for rounding.
///
/// The distance of the blend from the first line is a polynomial whose coefficients rise, and that from the second
/// one is its mirror image. So the smaller of both is largest where they are equal, and there the feet are on the
/// lines.
pub(super) fn of_lines(
    corner: &Vector3<f64>,
    along: &[Vector3<f64>; 2],
    (angle, fullness): (f64, f64),
    taken: [f64; 2],
) -> Blend {
    let [b, c] = ratios(angle, fullness);
    let before = |part: f64| corner - along[0] * (part * taken[0]);
    let after = |part: f64| corner + along[1] * (part * taken[1]);
    let points = [before(1.0), before(b), before(c), after(c), after(b), after(1.0)];
    let rise = |t: f64| {
        let s = 1.0 - t;
        t * t * t * (10.0 * c * s * s + t * (5.0 * b * s + t))
    };
    let (mut low, mut high) = (0.0, 1.0);
    if taken[0] == taken[1] {
        (low, high) = (0.5, 0.5);
    } else {
        for _ in 0..HALVINGS {
            let t = 0.5 * (low + high);
            if taken[1] * rise(t) < taken[0] * rise(1.0 - t) { low = t } else { high = t }
        }
    }
    let largest = (taken[1] * rise(high)).max(taken[0] * rise(1.0 - low));
    let deviation = angle.sin() * largest * (1.0 + 1e-12) + rounding(&[&points[0], &points[5], corner]);
    Blend { points, deviation, taken, replaced: taken }
}

/// The same for a joint without a corner, where the curvature jumps: from a line into an arc these make the largest
/// third derivative the smallest at equal deviation, 37 % below that with the ratios of a flat corner.
const RATIOS_OF_A_JUMP: [f64; 2] = [0.6, 0.2];

/// Control points between two places with given tangents and curvatures, where `taken` is what is replaced on
/// either side and `corner` the part of the turn that is due to the corner and not to the jump of the curvature.
///
/// A curve of degree 5 has the curvature `4/5 d / l^2` at its start, with the length `l` of the first leg of its
/// control polygon and the distance `d` of the third point from the tangent.
pub(super) fn between(ends: &[SpanJet; 2], taken: [f64; 2], corner: f64) -> [Vector3<f64>; 6] {
    let tangents = [ends[0].tangent(), ends[1].tangent()];
    let turn = ratios(angle_between(&tangents[0], &tangents[1]), 1.0);
    let [b, c] = [0, 1].map(|i| RATIOS_OF_A_JUMP[i] + corner * (turn[i] - RATIOS_OF_A_JUMP[i]));
    let legs = |side: usize| {
        let (first, second) = ((1.0 - b) * taken[side], (1.0 - c) * taken[side]);
        let along = tangents[side] * if side == 0 { 1.0 } else { -1.0 };
        let p = ends[side].point;
        (p, p + along * first, p + along * second + ends[side].curvature() * (1.25 * first * first))
    };
    let ((p0, p1, p2), (p5, p4, p3)) = (legs(0), legs(1));
    [p0, p1, p2, p3, p4, p5]
}

/// True where every leg of the control polygon has a part in the direction half-way between the tangents at both
/// ends. The derivative is in the hull of the legs, so the blend neither stands still nor forms a loop.
pub(super) fn leads_on(points: &[Vector3<f64>; 6]) -> bool {
    let along = (points[1] - points[0]).normalize() + (points[5] - points[4]).normalize();
    points.windows(2).all(|leg| (leg[1] - leg[0]).dot(&along) > 0.0)
}
