//! The ratios of the blend of two lines against a sweep over the whole family.
#![allow(clippy::unwrap_used)]

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_geometry::{Blending, Curve, JoinedPathBuilder, JointOutcome, NurbsCurve};

/// Largest curvature and largest third derivative by arc length, at a deviation of 1.
///
/// At the constant speed `v` through the blend a point mass has the acceleration `v^2 k` and the jerk `v^3 |d3|`,
/// with `|d3|^2 = k'^2 + k^4` in the plane: the first limit allows the speed `k^(-1/2)`, the second one
/// `|d3|^(-1/3)`. They are norms, so that limits per axis allow at least as much however the corner is turned.
#[derive(Debug, Clone, Copy)]
struct Demand {
    acceleration: f64,
    jerk: f64,
}

fn demand(curve: &NurbsCurve<3>, (start, end): (f64, f64), deviation: f64) -> Demand {
    let (mut k, mut d3) = (0.0f64, 0.0f64);
    for i in 0..=150 {
        let jet = curve.jet(start + (end - start) * f64::from(i) / 300.0).by_arc_length();
        k = k.max(jet.d2.norm());
        d3 = d3.max(jet.d3.norm());
    }
    Demand { acceleration: (k * deviation).sqrt(), jerk: (d3 * deviation * deviation).cbrt() }
}

/// The blend with its second and third control point at the parts `b` and `c` of the length taken, and its deviation.
fn member(angle: f64, b: f64, c: f64) -> Demand {
    let before = |part: f64| vector![-part, 0.0, 0.0];
    let after = |part: f64| vector![angle.cos(), angle.sin(), 0.0] * part;
    let points: Vec<Vector3<f64>> = vec![before(1.0), before(b), before(c), after(c), after(b), after(1.0)];
    let knots = [vec![0.0; 6], vec![1.0; 6]].concat();
    let curve = NurbsCurve::bspline(5, points, knots).unwrap();
    // By symmetry the middle is farthest from both lines, and its distance from the first one is its height.
    let deviation = curve.point(0.5).y;
    demand(&curve, (0.0, 1.0), deviation)
}

/// The least demand of the family, by a sweep over both ratios and steps of half the size around the best so far.
fn least(angle: f64, of: fn(&Demand) -> f64) -> f64 {
    let value = |b: f64, c: f64| if c > 0.0 && b > c && b < 1.0 { of(&member(angle, b, c)) } else { f64::INFINITY };
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for (b, c) in (0..15).flat_map(|i| (0..20).map(move |j| (0.27 + 0.05 * f64::from(i), 0.02 + 0.05 * f64::from(j)))) {
        if value(b, c) < best.0 {
            best = (value(b, c), b, c);
        }
    }
    let mut step = 0.03;
    while step > 5e-4 {
        let (mut next, around) = (best, [-1.0, 0.0, 1.0]);
        for (i, j) in around.iter().flat_map(|i| around.iter().map(move |j| (i, j))) {
            let (b, c) = (best.1 + i * step, best.2 + j * step);
            if value(b, c) < next.0 {
                next = (value(b, c), b, c);
            }
        }
        if next == best {
            step *= 0.5;
        }
        best = next;
    }
    best.0
}

/// As [`member`], of the blend that the library makes where the length is bounded and the deviation is not.
fn made(angle: f64) -> Demand {
    let mut builder = JoinedPathBuilder::new(vector![-1e3, 0.0, 0.0], 1e-6).unwrap();
    builder.line_to(Vector3::zeros(), 0).unwrap();
    builder.line_to(vector![angle.cos(), angle.sin(), 0.0] * 1e3, 1).unwrap();
    let blended = builder.build().unwrap().blended(&Blending { radius: 1.0, ..Blending::within(10.0) }).unwrap();
    let JointOutcome::Blended { deviation, piece, .. } = blended.joints[0].1 else { panic!() };
    let own = &blended.path.pieces()[piece];
    demand(&blended.path.to_curve().unwrap(), (own.start, own.end), deviation)
}

#[test]
fn the_ratios_are_nearly_the_best() {
    for degrees in (10..=170).step_by(20) {
        let angle = f64::from(degrees).to_radians();
        let best = Demand { jerk: least(angle, |d| d.jerk), acceleration: least(angle, |d| d.acceleration) };
        let made = made(angle);
        let (jerk, acceleration) = (best.jerk / made.jerk, best.acceleration / made.acceleration);
        println!("{degrees:3} degrees: speed {jerk:.4} of the best under jerk, {acceleration:.4} under acceleration");
        assert!(
            jerk > if degrees <= 130 { 0.99 } else { 0.95 } && acceleration > 0.91,
            "{degrees} degrees: {jerk}, {acceleration}"
        );
        // The sweep does not miss the best.
        assert!(jerk < 1.001 && acceleration < 1.001, "{degrees} degrees: {jerk}, {acceleration}");
    }
}
