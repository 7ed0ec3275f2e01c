//! Random polylines with blends, checked by code that knows nothing of how blends are made.
#![allow(dead_code)]

use arcfeed_geometry::nalgebra::{Rotation3, Unit, Vector3, vector};
use arcfeed_geometry::{ArcLengthCurve, Blending, Curve, JoinedPath, JoinedPathBuilder, JointOutcome, NurbsCurve};
use arcfeed_testing::Random;

pub type Point = Vector3<f64>;

/// What a run over many polylines has seen.
#[derive(Debug, Default, Clone, Copy)]
pub struct Seen {
    pub blends: usize,
    pub kept: usize,
    /// Largest certified deviation over the sampled one.
    pub pessimism: f64,
    /// Blends whose certified deviation is more than a tenth above the sampled one.
    pub loose: usize,
    /// Largest jumps of the tangent, and of the curvature times the length of the shorter neighbour, above rounding.
    pub tangent: f64,
    pub curvature: f64,
}

/// A polyline with right angles, near-reversals, collinear points, and segments of very different lengths, in mm.
pub fn polyline(r: &mut Random) -> Vec<Point> {
    let plane = r.chance(0.5);
    let direction = |r: &mut Random| loop {
        let d = vector![r.signed(), r.signed(), if plane { 0.0 } else { r.signed() }];
        if (0.1..1.0).contains(&d.norm()) {
            return d.normalize();
        }
    };
    let (shortest, longest) =
        *[(1e-3, 1e3), (1e-1, 1e1), (1.0, 1.0), (1e-3, 1e-1)].get(r.below(4)).unwrap_or(&(1.0, 2.0));
    let mut at = vector![r.between(-500.0, 500.0), r.between(-500.0, 500.0), if plane { 0.0 } else { 100.0 }];
    let mut along = direction(r);
    let mut points = vec![at];
    for _ in 0..2 + r.below(20) {
        at += along * r.log(shortest, longest);
        points.push(at);
        let turn = match r.below(6) {
            0 => std::f64::consts::FRAC_PI_2,
            1 => std::f64::consts::PI - r.log(1e-4, 0.3),
            2 => 0.0,
            3 => r.log(1e-7, 1e-1),
            _ => r.between(0.0, std::f64::consts::PI),
        };
        let across = along.cross(&if plane { Vector3::z() } else { direction(r) });
        if across.norm() > 1e-3 {
            let axis = Unit::new_normalize(if plane { Vector3::z() } else { across });
            along = Rotation3::from_axis_angle(&axis, turn * r.sign()) * along;
        }
    }
    points
}

pub fn joined(points: &[Point]) -> JoinedPath {
    let mut builder = JoinedPathBuilder::new(points[0], 1e-6).unwrap();
    for (i, p) in points[1..].iter().enumerate() {
        builder.line_to(*p, i).unwrap();
    }
    builder.build().unwrap()
}

fn to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let ab = b - a;
    let part = ((p - a).dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
    (p - a - ab * part).norm()
}

fn to_polyline(p: &Point, points: &[Point]) -> f64 {
    points.windows(2).map(|w| to_segment(p, &w[0], &w[1])).fold(f64::INFINITY, f64::min)
}

/// Tangent and curvature on both sides of every knot of the one curve, except where joints were kept (`stops`).
/// Rounding of the coordinates is allowed for: it turns the legs of the control polygon next to a knot.
pub fn continuity(curve: &NurbsCurve<3>, stops: &[Point], seen: &mut Seen) -> Result<(), String> {
    let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.amax()));
    let knots: Vec<f64> = curve.knots().runs().map(|run| run.1).collect();
    for around in knots.windows(3) {
        let u = around[1];
        let (left, right) = (curve.jet_left(u).by_arc_length(), curve.jet(u).by_arc_length());
        if (left.point - right.point).norm() > 1e-14 * size {
            return Err(format!("a gap at u = {u}"));
        }
        if stops.iter().any(|p| (p - right.point).norm() <= 1e-14 * size) {
            continue;
        }
        // The parameter is close to the arc length.
        let shorter = (u - around[0]).min(around[2] - u);
        let bend = (0..=16)
            .map(|k| around[0] + (around[2] - around[0]) * f64::from(k) / 16.0)
            .map(|u| curve.jet(u).curvature())
            .fold(0.0, f64::max);
        // A leg of the control polygon is a twentieth of a blend at least.
        let rounding = f64::EPSILON * size / (0.05 * shorter);
        let tangent = (left.d1 - right.d1).norm();
        let curvature = (left.d2 - right.d2).norm() * shorter / (1.0 + bend * shorter);
        seen.tangent = seen.tangent.max(tangent - 4.0 * rounding);
        seen.curvature = seen.curvature.max(curvature - 100.0 * rounding);
        if !(tangent <= 1e-9 + 4.0 * rounding && curvature <= 1e-9 + 100.0 * rounding) {
            return Err(format!("at u = {u}: tangent {tangent:e}, curvature {curvature:e}, rounding {rounding:e}"));
        }
    }
    Ok(())
}

/// All that has to hold for the polyline of a seed.
pub fn check(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let r = &mut Random::new(seed);
    let points = polyline(r);
    let tolerance = r.log(1e-3, 5.0);
    let radius = if r.chance(0.3) { r.log(1e-3, 10.0) } else { f64::INFINITY };
    let path = joined(&points);
    let blended = path.blended(&Blending { radius, ..Blending::within(tolerance) }).map_err(|e| e.to_string())?;
    let curve = blended.path.to_curve().map_err(|e| e.to_string())?;
    let size = points.iter().fold(0.0f64, |m, p| m.max(p.amax()));
    let (start, end) = curve.domain();
    if curve.point(start) != points[0] || curve.point(end) != points[points.len() - 1] {
        return Err("the ends moved".into());
    }
    let stay = |i: &usize| matches!(blended.joints[*i].1, JointOutcome::Kept(_));
    let stops: Vec<Point> = (0..blended.joints.len()).filter(stay).map(|i| points[i + 1]).collect();
    continuity(&curve, &stops, seen)?;
    for (i, (joint, outcome)) in blended.joints.iter().enumerate() {
        let JointOutcome::Blended { deviation, taken, piece } = *outcome else {
            seen.kept += 1;
            let straight = joint.angle < 1e-9 || joint.angle > std::f64::consts::PI - 0.0201;
            if straight {
                continue;
            } else {
                return Err(format!("joint {i} of {} rad stayed: {outcome:?}", joint.angle));
            }
        };
        seen.blends += 1;
        let own = &blended.path.pieces()[piece];
        let legs = &points[i..i + 3];
        let (mut near, mut whole) = (0.0f64, 0.0f64);
        for k in 0..=200 {
            let p = curve.point(own.start + (own.end - own.start) * f64::from(k) / 200.0);
            near = near.max(to_polyline(&p, legs));
            whole = whole.max(to_polyline(&p, &points));
        }
        let rounding = 16.0 * f64::EPSILON * size;
        if whole > deviation || near > deviation || deviation > tolerance || taken.iter().any(|&t| t > radius) {
            return Err(format!(
                "joint {i}: {near:e} of the certified {deviation:e} of {tolerance:e}, takes {taken:?}"
            ));
        }
        seen.pessimism = seen.pessimism.max((deviation - 2.0 * rounding) / near.max(rounding));
        if deviation > 1.1 * near + 2.0 * rounding {
            return Err(format!("joint {i}: certified {deviation:e}, sampled {near:e}"));
        }
    }
    // Nothing else has moved.
    for k in 0..=500 {
        let p = curve.point(start + (end - start) * f64::from(k) / 500.0);
        if to_polyline(&p, &points) > tolerance {
            return Err(format!("sample {k} of 500 is too far off"));
        }
    }
    let length: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let curve = ArcLengthCurve::new(curve, 1e-9).map_err(|e| e.to_string())?;
    if curve.length() > length * (1.0 + 1e-12) + 4.0 * f64::EPSILON * size * points.len() as f64 {
        return Err(format!("length {} of {length}", curve.length()));
    }
    Ok(())
}
