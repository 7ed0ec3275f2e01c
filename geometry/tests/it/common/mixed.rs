//! Random paths of lines, arcs, helices and curves, with blends, checked against dense samples of the programmed
//! path.
#![allow(dead_code)]

use arcfeed_geometry::nalgebra::{Unit, vector};
use arcfeed_geometry::{
    ArcLengthCurve, ArcTo, Blending, Curve, JoinedPath, JoinedPathBuilder, JointOutcome, KeptJoint, NurbsCurve,
};
use arcfeed_testing::Random;

use super::polylines::{Point, Seen, continuity};

fn direction(r: &mut Random) -> Point {
    loop {
        let d = vector![r.signed(), r.signed(), r.signed()];
        if (0.1..1.0).contains(&d.norm()) {
            return d.normalize();
        }
    }
}

/// Appends a piece that leaves along `along`, or anywhere else; the direction at its end.
fn append(builder: &mut JoinedPathBuilder, r: &mut Random, along: &Point, source: usize) -> Point {
    let at = builder.position();
    let smooth = r.chance(0.4);
    let leave = if smooth { *along } else { (along + direction(r) * r.log(1e-3, 3.0)).normalize() };
    let size = r.log(0.3, 100.0);
    match r.below(4) {
        0 => {
            builder.line_to(at + leave * size, source).unwrap();
            leave
        }
        kind @ (1 | 2) => {
            let across = leave.cross(&direction(r)).normalize();
            let normal = leave.cross(&across);
            let sweep = *[r.log(1e-2, 6.0), std::f64::consts::TAU].get(r.below(8) / 7).unwrap();
            let (radius, turns) = (size, if r.chance(0.1) { 2 } else { 0 });
            let centre = at + across * radius;
            let out = -across * sweep.cos() + leave * sweep.sin();
            let rise = if kind == 2 { r.log(1e-2, 1.0) * size * sweep } else { 0.0 };
            let end = centre + out * radius + normal * rise;
            let to = ArcTo { centre, normal: Unit::new_normalize(normal), end, turns };
            let whole = sweep + std::f64::consts::TAU * f64::from(turns);
            if kind == 1 {
                let end = if sweep > 6.2 { at } else { end };
                builder.arc(&ArcTo { end, ..to }, source).unwrap();
            } else {
                builder.helix(&to, 1e-6, source).unwrap();
            }
            let turning = across * sweep.sin() + leave * sweep.cos();
            (turning * (radius * whole) + normal * rise).normalize()
        }
        _ => {
            let step = |r: &mut Random| (leave + direction(r) * 0.7) * (0.4 * size);
            let mut points = vec![at, at + leave * (0.3 * size)];
            for i in 1..6 {
                points.push(points[i] + step(r));
            }
            let knots = vec![0.0, 0.0, 0.0, 0.0, 0.2, 0.5, 0.7, 1.0, 1.0, 1.0, 1.0];
            let weights = (0..7).map(|_| r.log(0.5, 2.0)).collect();
            let last = (points[6] - points[5]).normalize();
            builder.curve(&NurbsCurve::new(3, points, weights, knots).unwrap(), source).unwrap();
            last
        }
    }
}

pub fn path(r: &mut Random) -> JoinedPath {
    let start = vector![r.signed(), r.signed(), r.signed()] * 100.0;
    let mut builder = JoinedPathBuilder::new(start, 1e-6).unwrap();
    let mut along = direction(r);
    for source in 0..3 + r.below(8) {
        along = append(&mut builder, r, &along, source);
    }
    builder.build().unwrap()
}

/// Distance of a point from a part of a curve: samples, and golden sections around the nearest ones.
fn distance(p: &Point, curve: &NurbsCurve<3>, (a, b): (f64, f64), samples: &[Point]) -> f64 {
    let n = samples.len() - 1;
    let at = |i: usize| a + (b - a) * i as f64 / n as f64;
    let nearest = (0..=n).min_by(|&i, &j| (samples[i] - p).norm().total_cmp(&(samples[j] - p).norm())).unwrap();
    let (mut low, mut high) = (at(nearest.saturating_sub(1)), at((nearest + 1).min(n)));
    let f = |u: f64| (curve.point(u) - p).norm();
    let g = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..40 {
        let (x, y) = (high - g * (high - low), low + g * (high - low));
        if f(x) > f(y) { low = x } else { high = y }
    }
    f(0.5 * (low + high)).min((samples[nearest] - p).norm())
}

pub fn check(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let r = &mut Random::new(seed);
    let path = path(r);
    let tolerance = r.log(1e-3, 2.0);
    let radius = if r.chance(0.3) { r.log(1e-2, 10.0) } else { f64::INFINITY };
    let setting = Blending { radius, ..Blending::within(tolerance) };
    let blended = path.blended(&setting).map_err(|e| e.to_string())?;
    let (before, after) =
        (path.to_curve().map_err(|e| e.to_string())?, blended.path.to_curve().map_err(|e| e.to_string())?);
    if after.point(0.0) != path.start() || after.point(after.domain().1) != path.end() {
        return Err("the ends moved".into());
    }
    let by_length = ArcLengthCurve::new(before.clone(), 1e-9).map_err(|e| e.to_string())?;
    let mut stops = Vec::new();
    for (i, (joint, outcome)) in blended.joints.iter().enumerate() {
        let JointOutcome::Blended { deviation, taken, piece } = *outcome else {
            seen.kept += 1;
            stops.push(before.point(joint.parameter));
            if *outcome == JointOutcome::Kept(KeptJoint::NotCertified) {
                return Err(format!("joint {i} is not blended: {joint:?}"));
            }
            continue;
        };
        seen.blends += 1;
        let own = &blended.path.pieces()[piece];
        let pieces = &path.pieces()[joint.piece..joint.piece + 2];
        let at = by_length.arc_length_at(joint.parameter);
        let part = (by_length.parameter(at - 1.1 * taken[0]), by_length.parameter(at + 1.1 * taken[1]));
        let part = (part.0.max(pieces[0].start), part.1.min(pieces[1].end));
        let samples: Vec<Point> =
            (0..=400).map(|k| before.point(part.0 + (part.1 - part.0) * f64::from(k) / 400.0)).collect();
        let sampled = (0..=60)
            .map(|k| after.point(own.start + (own.end - own.start) * f64::from(k) / 60.0))
            .map(|p| distance(&p, &before, part, &samples))
            .fold(0.0, f64::max);
        if sampled > deviation || deviation > tolerance || taken.iter().any(|&t| t > radius * (1.0 + 1e-9)) {
            return Err(format!("joint {i}: {sampled:e} of the certified {deviation:e} of {tolerance:e}, {taken:?}"));
        }
        seen.pessimism = seen.pessimism.max(deviation / sampled);
        // Only where the nearest point of the path is on the far side of a bend, or beyond what the blend replaces.
        seen.loose += usize::from(deviation > 1.1 * sampled + 1e-12);
    }
    continuity(&after, &stops, seen)
}
