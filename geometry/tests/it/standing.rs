//! Curves that stand still at an end or at a knot, because control points coincide there.
#![allow(clippy::unwrap_used)]

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_geometry::{ArcLengthCurve, Blending, Curve, GeometryError, JoinedPath, JoinedPathBuilder, NurbsCurve};
use arcfeed_testing::{Random, cases};

use crate::common::polylines::{Point, Seen, continuity};

fn bezier(points: &[Point], weights: Vec<f64>) -> NurbsCurve<3> {
    let degree = points.len() - 1;
    NurbsCurve::new(degree, points.to_vec(), weights, [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat()).unwrap()
}

fn joined(curve: &NurbsCurve<3>, tolerance: f64) -> Result<JoinedPath, GeometryError> {
    let mut builder = JoinedPathBuilder::new(curve.control_points()[0], 1e-9).unwrap();
    builder.curve_within(curve, tolerance, 1)?;
    builder.build()
}

/// Parameters of a curve, denser towards both ends.
fn parameters(curve: &NurbsCurve<3>, count: u32) -> Vec<f64> {
    let (start, end) = curve.domain();
    let at = |i: u32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / f64::from(count)).cos();
    (0..=count).map(|i| start + (end - start) * at(i)).collect()
}

/// Points of a curve, denser towards both ends.
fn samples(curve: &NurbsCurve<3>, count: u32) -> Vec<Point> {
    parameters(curve, count).into_iter().map(|u| curve.point(u)).collect()
}

/// Largest distance of points of a curve from another one, whose nearest place is looked for between samples of it.
fn farthest(curve: &NurbsCurve<3>, from: &NurbsCurve<3>) -> f64 {
    let at = parameters(from, 1500);
    let known: Vec<Point> = at.iter().map(|&u| from.point(u)).collect();
    let distance = |p: &Point| {
        let near = (0..known.len()).min_by(|&i, &k| (known[i] - p).norm().total_cmp(&(known[k] - p).norm())).unwrap();
        let (mut low, mut high) = (at[near.saturating_sub(1)], at[(near + 1).min(at.len() - 1)]);
        let off = |u: f64| (from.point(u) - p).norm();
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if off(a) < off(b) { high = b } else { low = a }
        }
        off(low).min((known[near] - p).norm())
    };
    samples(curve, 1000).iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn a_quadratic_with_two_equal_points_is_a_line() {
    for (points, weights) in [
        ([[0.0, 0.0], [0.0, 0.0], [30.0, 40.0]], vec![1.0; 3]),
        ([[0.0, 0.0], [30.0, 40.0], [30.0, 40.0]], vec![1.0, 5.0, 0.3]),
    ] {
        let points = points.map(|[x, y]| vector![x, y, 0.0]);
        let path = joined(&bezier(&points, weights), 1e-6).unwrap();
        assert_eq!((path.pieces().len(), path.pieces()[0].deviation, path.length()), (1, 0.0, 50.0));
        assert_eq!(path.to_curve().unwrap().control_points(), [points[0], points[2]]);
    }
}

/// The cubic with the points 0, 0, a, b is `3 t^2 (1 - t) a + t^3 b`, here `y = (x / 3)^(3/2)`.
#[test]
fn a_semicubical_parabola_is_followed_within_the_tolerance() {
    let curve =
        bezier(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [3.0, 1.0]].map(|[x, y]| vector![x, y, 0.0]), vec![1.0; 4]);
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-5, 1e-8] {
        let path = joined(&curve, tolerance).unwrap();
        let deviation = path.pieces()[0].deviation;
        assert!(deviation <= tolerance && deviation > 0.4 * tolerance.min(0.02), "{deviation} of {tolerance}");
        let curve = path.to_curve().unwrap();
        let (start, end) = curve.domain();
        let first = curve.jet(start).by_arc_length();
        assert!((first.d1 - Vector3::x()).norm() < 1e-12 && first.d2.norm() < 1e-7 / tolerance, "{first:?}");
        assert_eq!((curve.point(start), curve.point(end)), (Vector3::zeros(), vector![3.0, 1.0, 0.0]));
        let mut attained = 0.0f64;
        for p in samples(&curve, 4000) {
            // The distance along y is no less than the distance, and the slope is 1/2 at most.
            let off = (p.y - (p.x / 3.0).max(0.0).powf(1.5)).abs();
            attained = attained.max(off);
        }
        assert!(attained <= 1.12 * deviation + 1e-15 && attained > 0.9 * deviation, "{attained} of {deviation}");
        // The exact length of the curve, 8 ((1 + 9 c^2 x / 4)^(3/2) - 1) / (27 c^2) with c^2 = 1 / 27.
        let exact = 8.0 * ((1.0f64 + 0.25).powf(1.5) - 1.0);
        let length = ArcLengthCurve::new(curve, 1e-12).unwrap().length();
        assert!((length - exact).abs() < 3.0 * tolerance, "{length}, {exact}");
    }
}

#[test]
fn random_curves_that_stand_still_at_their_ends() {
    let mut both = 0;
    for seed in 1..=150 {
        let r = &mut Random::new(seed);
        let degree = 2 + r.below(5);
        let flat = if r.chance(0.5) { 0.0 } else { 1.0 };
        let size = r.log(1e-2, 1e3);
        let mut points: Vec<Point> =
            (0..=degree).map(|_| vector![r.signed(), r.signed(), flat * r.signed()] * size).collect();
        let [leading, trailing] = [r.below(degree), r.below(degree)];
        let (first, last) = (points[0], points[degree]);
        points.iter_mut().take(1 + leading).for_each(|p| *p = first);
        points.iter_mut().rev().take(1 + trailing.min(degree - 1 - leading)).for_each(|p| *p = last);
        both += usize::from(leading > 0 && trailing.min(degree - 1 - leading) > 0);
        let weights = (0..=degree).map(|_| if r.chance(0.5) { 1.0 } else { r.log(0.2, 5.0) }).collect();
        let curve = bezier(&points, weights);
        let tolerance = size * r.log(1e-7, 1e-2);
        let path = joined(&curve, tolerance).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let deviation = path.pieces().iter().map(|p| p.deviation).fold(0.0, f64::max);
        assert!(deviation <= tolerance, "seed {seed}: {deviation} of {tolerance}");
        let made = path.to_curve().unwrap();
        // Weights cost the last digit.
        let ends = [made.point(made.domain().0) - first, made.point(made.domain().1) - last];
        assert!(ends.iter().all(|off| off.norm() <= 8.0 * f64::EPSILON * size), "seed {seed}: {ends:?}");
        continuity(&made, &[], &mut Seen::default()).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let (new, old) = (farthest(&made, &curve), farthest(&curve, &made));
        let bound = deviation + 1e-12 * size;
        assert!(new <= bound && old <= bound, "seed {seed}: {new}, {old} of {deviation}");
    }
    assert!(both > 30, "{both}");
}

/// A cusp at a knot: the curve arrives along x, stands still, and leaves at 60 degrees.
#[test]
fn a_curve_that_stands_still_at_a_knot_has_a_joint_there() {
    let (sine, cosine) = (60f64.to_radians().sin(), 60f64.to_radians().cos());
    let points =
        [[-20.0, 3.0], [-10.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [10.0 * cosine, 10.0 * sine], [20.0, 9.0]];
    let points = points.map(|[x, y]| vector![x, y, 0.0]);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let curve = NurbsCurve::bspline(3, points.to_vec(), knots).unwrap();
    let path = joined(&curve, 1e-3).unwrap();
    assert_eq!(path.pieces().len(), 2);
    let joint = path.joints()[0];
    assert!((joint.angle - 60f64.to_radians()).abs() < 1e-9 && joint.curvature == [0.0; 2], "{joint:?}");
    assert!(path.pieces().iter().all(|p| p.deviation > 0.0 && p.deviation <= 1e-3));
    let blended = path.blended(&Blending::within(0.01)).unwrap();
    assert!(ArcLengthCurve::new(blended.path.to_curve().unwrap(), 1e-9).unwrap().corners(1e-6).is_empty());

    // A spline of degree 3 with a control point four times stays in it over a whole span: the span is left out.
    let four = [[-20.0, 3.0], [-10.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [10.0, 0.0], [20.0, 9.0]];
    let four = four.map(|[x, y]| vector![x, y, 0.0]);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0];
    let path = joined(&NurbsCurve::bspline(3, four.to_vec(), knots).unwrap(), 1e-3).unwrap();
    let curve = ArcLengthCurve::new(path.to_curve().unwrap(), 1e-9).unwrap();
    assert!(curve.length() > 40.0 && curve.length() < 45.0, "{}", curve.length());
}

#[test]
fn a_tolerance_below_rounding_is_refused() {
    let curve =
        bezier(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [3.0, 1.0]].map(|[x, y]| vector![x, y, 0.0]), vec![1.0; 4]);
    assert!(matches!(joined(&curve, 1e-300), Err(GeometryError::StandsStill { u: 0.0, .. })));
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(joined(&curve, tolerance).is_err());
    }
}

/// A curve that stands still in its start, runs up to a tip at y = 0.108 and back, and goes on along x: a replacement
/// along y = 0 would be near to it everywhere, and would leave the tip out.
#[test]
fn a_tip_beside_the_end_is_not_cut_off() {
    // x = 24 (t^2 / 2 - 8 t^3 / 3 + 4 t^4), y = 100 t^3 (1/2 - t)^2, as Bernstein coefficients.
    let powers = [[0.0; 2], [0.0; 2], [12.0, 0.0], [-64.0, 25.0], [96.0, -100.0], [0.0, 100.0]];
    let choose = |n: usize, k: usize| (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>();
    let sum = |i: usize, axis: usize| (0..=i).map(|k| choose(i, k) / choose(5, k) * powers[k][axis]).sum::<f64>();
    let points: Vec<Point> = (0..6).map(|i| vector![sum(i, 0), sum(i, 1), 0.0]).collect();
    let curve = bezier(&points, vec![1.0; 6]);
    assert!((curve.point(0.3).y - 0.108).abs() < 1e-12 && curve.point(0.5).y.abs() < 1e-9);
    let path = joined(&curve, 0.07).unwrap();
    let off = farthest(&curve, &path.to_curve().unwrap());
    assert!(off <= path.pieces()[0].deviation && path.pieces()[0].deviation <= 0.07, "{off}");
}

/// A cubic that turns back in a cusp is two pieces that meet there at an angle of half a turn, or of the cusp.
#[test]
fn a_curve_is_divided_at_its_cusps() {
    let mut random = Random::new(11);
    for _ in 0..40 {
        let mut number = || 20.0 * random.signed();
        // C'(t) = (t - c) (A (1 - t) + B t), integrated.
        let (a, b) = (vector![number(), number(), number()], vector![number(), number(), number()]);
        let c = 0.5 + 0.02 * number();
        // Bernstein coefficients of the derivative, of degree 2.
        let d = [-c * a, 0.5 * ((1.0 - c) * a - c * b), (1.0 - c) * b];
        let mut points = vec![Point::zeros()];
        d.iter().for_each(|d| points.push(points[points.len() - 1] + d / 3.0));
        let curve = bezier(&points, vec![1.0; 4]);
        let path = joined(&curve, 0.01).unwrap();
        let joints = path.joints();
        let sharpest = joints.iter().map(|joint| joint.angle).fold(0.0, f64::max);
        assert!((sharpest - std::f64::consts::PI).abs() < 1e-6, "{c} {sharpest} {curve:?}");
        let whole = path.to_curve().unwrap();
        ArcLengthCurve::new(whole.clone(), 1e-9).unwrap();
        assert!(farthest(&curve, &whole) < 0.0101 && farthest(&whole, &curve) < 0.0101);
    }
}

/// The product of two polynomials by their Bernstein coefficients.
fn product<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::AddAssign>(zero: T, a: &[T], b: &[f64]) -> Vec<T> {
    let choose = |n: usize, k: usize| (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>();
    let (n, m) = (a.len() - 1, b.len() - 1);
    let mut out = vec![zero; n + m + 1];
    for (i, &x) in a.iter().enumerate() {
        for (k, &y) in b.iter().enumerate() {
            out[i + k] += x * (y * choose(n, i) * choose(m, k) / choose(n + m, i + k));
        }
    }
    out
}

/// A curve with the derivative `V(t)` times `t - c` for each cusp `c`, where `V` does not vanish, over `weights` of its own.
fn with_cusps(r: &mut Random, cusps: &[f64], weights: &[f64]) -> NurbsCurve<3> {
    let mut number = || 20.0 * r.signed();
    // V keeps a part along one direction.
    let main = vector![30.0 + number(), number(), number()];
    let [v0, v1] = [(); 2].map(|()| vector![30.0 + number().abs(), number(), number()]);
    let mut derivative = vec![v0 + main * 0.1, v1];
    for &c in cusps {
        derivative = product(Point::zeros(), &derivative, &[-c, 1.0 - c]);
    }
    let mut points = vec![vector![number(), number(), number()]];
    let share = 1.0 / derivative.len() as f64;
    derivative.iter().for_each(|d| points.push(points[points.len() - 1] + d * share));
    let ones = vec![1.0; points.len()];
    let (numerator, weights) = (product(Point::zeros(), &points, weights), product(0.0, &ones, weights));
    let points: Vec<Point> = numerator.iter().zip(&weights).map(|(p, w)| p / *w).collect();
    bezier(&points, weights)
}

/// A place in a span: anywhere, or as near to an end as 1e-9 of it.
fn any_place(r: &mut Random) -> f64 {
    let near = r.log(1e-9, 0.5);
    if r.chance(0.5) { near } else { 1.0 - near }
}

/// Points of a curve, dense towards each of the parameters `breaks`.
fn dense(curve: &NurbsCurve<3>, breaks: &[f64]) -> Vec<Point> {
    let turn = |i: u32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / 800.0).cos();
    let spans = breaks.windows(2).filter(|w| w[1] > w[0]);
    spans.flat_map(|w| (0..=800).map(|i| curve.point(w[0] + (w[1] - w[0]) * turn(i)))).collect()
}

/// Largest distance of points from the lines between others.
fn farthest_of(points: &[Point], others: &[Point]) -> f64 {
    let off = |p: &Point, pair: &[Point]| {
        let (along, from) = (pair[1] - pair[0], p - pair[0]);
        let share = (from.dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (from - along * share).norm()
    };
    let distance = |p: &Point| others.windows(2).map(|pair| off(p, pair)).fold(f64::INFINITY, f64::min);
    points.iter().step_by(7).map(distance).fold(0.0, f64::max)
}

/// Cusps anywhere are found: the path turns back there, or a speck shorter than a thousandth of the tolerance is left out. The
/// curvature has a bound in any case.
#[test]
fn cusps_are_found_as_near_to_an_end_as_they_may_be() {
    let (mut turned, mut specks, seeds) = (0, 0, cases(50));
    for seed in seeds.clone() {
        let r = &mut Random::new(seed);
        let mut cusps: Vec<f64> = (0..1 + r.below(2)).map(|_| any_place(r)).collect();
        cusps.sort_by(f64::total_cmp);
        let weights: Vec<f64> =
            if r.chance(0.5) { vec![1.0] } else { (0..2 + r.below(2)).map(|_| r.log(0.3, 3.0)).collect() };
        let curve = with_cusps(r, &cusps, &weights);
        let tolerance = r.log(1e-5, 1e-2);
        let path = joined(&curve, tolerance).unwrap_or_else(|e| panic!("seed {seed}, {cusps:?}: {e}"));
        let ends: Vec<f64> = [0.0].into_iter().chain(cusps.iter().copied()).chain([1.0]).collect();
        // Each part is straight enough that its ends tell how long it is.
        let is_long = |i: &usize| (curve.point(ends[i + 1]) - curve.point(ends[*i])).norm() > 2e-3 * tolerance;
        let long: Vec<usize> = (0..ends.len() - 1).filter(is_long).collect();
        let tips = path.joints().iter().filter(|joint| joint.angle > 3.1).count();
        // Two cusps with a speck between them turn the path back twice.
        let expected = long.windows(2).filter(|w| (w[1] - w[0]) % 2 == 1).count();
        assert!(tips >= expected, "seed {seed}, {cusps:?}: {tips} of {expected}");
        turned += expected;
        specks += cusps.len() - expected;
        let made = path.to_curve().unwrap();
        ArcLengthCurve::new(made.clone(), 1e-9).unwrap_or_else(|e| panic!("seed {seed}, {cusps:?}: {e}"));
        let size = path.pieces().iter().map(|piece| piece.length).fold(tolerance, f64::min);
        let knots: Vec<f64> =
            made.decompose().iter().flat_map(|piece| [piece.interval().0, piece.interval().1]).collect();
        for pair in knots.chunks(2) {
            for i in 1..100 {
                let u = pair[0] + (pair[1] - pair[0]) * (0.5 - 0.5 * (f64::from(i) * 0.0314).cos());
                let curvature = made.jet(u).by_arc_length().d2.norm();
                assert!(curvature * size < 500.0, "seed {seed}, {cusps:?}: curvature {curvature} at {u}");
            }
        }
        let deviation = path.pieces().iter().map(|p| p.deviation).fold(0.0, f64::max);
        assert!(deviation <= tolerance, "seed {seed}: {deviation} of {tolerance}");
        if seed % 25 == 0 {
            let [a, b] = [dense(&made, &knots), dense(&curve, &ends)];
            let (new, old) = (farthest_of(&a, &b), farthest_of(&b, &a));
            let bound = deviation + 1e-5;
            assert!(new <= bound && old <= bound, "seed {seed}, {cusps:?}: {new}, {old} of {deviation}");
        }
    }
    let few = (seeds.end - seeds.start) as usize / 3;
    assert!(turned > few && specks > few, "{turned}, {specks}");
}
