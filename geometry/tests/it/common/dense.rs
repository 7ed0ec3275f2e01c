//! Polylines of machine programs, and an independent check of the curves fitted to them.

use std::f64::consts::{PI, TAU};

use arcfeed_geometry::nalgebra::{SVector, UnitQuaternion, Vector2, Vector3, vector};
use arcfeed_geometry::{Curve, FittedStretch, StretchShape};
use arcfeed_testing::Random;

/// Rounds to 1 um, for coordinates in mm.
pub fn rounded<const D: usize>(point: SVector<f64, D>) -> SVector<f64, D> {
    point.map(|x| (x * 1e3).round() / 1e3)
}

/// A polyline with the indices of its corners, both ends included.
pub struct Program {
    pub points: Vec<Vector3<f64>>,
    pub corners: Vec<usize>,
    pub tolerance: f64,
}

/// Lines, arcs and waves, joined by the tangent or by corners of 40 to 150 degrees, in a random plane or on a
/// cylinder, rounded to 1 um. Radii are at least 40 tolerances, and chord errors at most 0.4 tolerances.
pub fn program(seed: u64) -> Program {
    let mut random = Random::new(seed);
    let tolerance = random.log(2e-3, 4e-2);
    let (mut at, mut heading) = (Vector2::zeros(), random.between(0.0, TAU));
    let (mut plane, mut corners) = (vec![at], vec![0]);
    for _ in 0..1 + random.below(5) {
        if plane.len() > 1 && random.chance(0.5) {
            heading += random.sign() * random.between(0.7, 2.6);
            corners.push(plane.len() - 1);
        }
        let least = 100.0 * tolerance;
        match random.below(4) {
            0 => {
                // One long chord.
                at += vector![heading.cos(), heading.sin()] * random.log(least, 100.0);
                plane.push(at);
            }
            1 => {
                let length = random.log(least, 60.0);
                let n = ((length / random.log(0.02, 0.5)) as usize).max(1);
                let step = vector![heading.cos(), heading.sin()] * (length / n as f64);
                plane.extend((1..=n).map(|i| at + step * i as f64));
                at += step * n as f64;
            }
            2 => {
                let radius = random.log(40.0 * tolerance, 50.0);
                let sweep = random.sign() * (random.between(0.3, 3.0)).max(least / radius).min(6.0);
                let step = random.log(0.02, 0.5).min((3.2 * tolerance * radius).sqrt());
                let n = ((radius * sweep.abs() / step) as usize).max(3);
                let side = sweep.signum();
                let to_centre = vector![-heading.sin(), heading.cos()] * (side * radius);
                let centre = at + to_centre;
                for i in 1..=n {
                    let a = sweep * i as f64 / n as f64;
                    let (s, c) = a.sin_cos();
                    let arm = -to_centre;
                    plane.push(centre + vector![c * arm.x - s * arm.y, s * arm.x + c * arm.y]);
                }
                at = plane[plane.len() - 1];
                heading += sweep;
            }
            _ => {
                // A wave that starts and ends along the heading.
                let length = random.between(5.0, 60.0).max(least);
                let waves = (1 + random.below(4)) as f64;
                let wave = TAU * waves / length;
                // Curvature at the crests: amplitude * wave^2 / 2.
                let amplitude = random.between(0.0, 4.0).min(2.0 / (40.0 * tolerance * wave * wave));
                let radius = 2.0 / (amplitude * wave * wave).max(1e-3);
                let n = (length / random.log(0.02, 0.5).min((3.2 * tolerance * radius).sqrt())) as usize;
                let (s, c) = heading.sin_cos();
                for i in 1..=n {
                    let x = length * i as f64 / n as f64;
                    let y = 0.5 * amplitude * (1.0 - (wave * x).cos());
                    plane.push(at + vector![c * x - s * y, s * x + c * y]);
                }
                at = plane[plane.len() - 1];
            }
        }
    }
    corners.push(plane.len() - 1);
    let axis = Vector3::new(random.signed(), random.signed(), random.signed());
    let turn = UnitQuaternion::from_scaled_axis(axis * PI);
    let shift = Vector3::new(random.signed(), random.signed(), random.signed()) * 200.0;
    let cylinder = random.chance(0.3).then(|| random.between(300.0, 900.0));
    let place = |p: &Vector2<f64>| {
        let flat = match cylinder {
            Some(r) => Vector3::new(r * (p.x / r).sin(), p.y, r * (p.x / r).cos()),
            None => Vector3::new(p.x, p.y, 0.0),
        };
        rounded(turn * flat + shift)
    };
    Program { points: plane.iter().map(place).collect(), corners, tolerance }
}

fn distance_to_chord<const D: usize>(p: &SVector<f64, D>, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let chord = b - a;
    let share = ((p - a).dot(&chord) / chord.norm_squared()).max(0.0).min(1.0);
    (p - (a + chord * share)).norm()
}

trait Widths {
    fn first_width(&self) -> f64;
    fn last_width(&self) -> f64;
}

/// Widths of the spans at both ends.
impl<const D: usize> Widths for FittedStretch<D> {
    fn first_width(&self) -> f64 {
        let (knots, p) = (self.curve.knots().as_slice(), self.curve.degree());
        knots[p + 1] - knots[p]
    }

    fn last_width(&self) -> f64 {
        let (knots, n) = (self.curve.knots().as_slice(), self.curve.control_points().len());
        knots[n] - knots[n - 1]
    }
}

/// Checks what every fit promises, by sampling that knows nothing of how the fit was made.
pub fn check<const D: usize>(
    points: &[SVector<f64, D>],
    stretches: &[FittedStretch<D>],
    tolerance: f64,
) -> Result<(), String> {
    let size = points.iter().fold(0.0f64, |m, p| m.max(p.amax()));
    let require = |holds: bool, what: String| if holds { Ok(()) } else { Err(what) };
    let ends = (stretches.first().map(|s| s.first), stretches.last().map(|s| s.last));
    require(ends == (Some(0), Some(points.len() - 1)), format!("points {ends:?} of {}", points.len()))?;
    for (i, s) in stretches.iter().enumerate() {
        require(s.max_deviation <= tolerance, format!("stretch {i}: bound {} above {tolerance}", s.max_deviation))?;
        if let Some(next) = stretches.get(i + 1) {
            require(
                next.first <= s.last && s.last <= next.first + 1,
                format!("stretch {i}: {} {}", s.last, next.first),
            )?;
            let (end, start) = (s.curve.jet_left(f64::MAX), next.curve.jet(f64::MIN));
            require(end.point == start.point, format!("stretch {i} does not end where the next one starts"))?;
            if next.continues {
                let (width, rounding) = (s.last_width().min(next.first_width()), 100.0 * f64::EPSILON * size);
                let arc = [s.shape, next.shape].contains(&StretchShape::Arc);
                let [a, b] = [end, start].map(|jet| if arc { jet.by_arc_length() } else { jet });
                let gaps = ((a.d1 - b.d1).norm(), (a.d2 - b.d2).norm());
                let bounds = (1e-9 + rounding / width, 1e-9 * a.d2.norm() + rounding / (width * width));
                require(gaps.0 <= bounds.0 && gaps.1 <= bounds.1, format!("stretch {i}: jumps {gaps:?} at its end"))?;
            }
        }
        check_deviation(points, s, size).map_err(|e| format!("stretch {i} of points {}..={}: {e}", s.first, s.last))?;
        check_knots(s, size).map_err(|e| format!("stretch {i}: {e}"))?;
    }
    Ok(())
}

/// Curve against polyline, in both directions.
fn check_deviation<const D: usize>(points: &[SVector<f64, D>], s: &FittedStretch<D>, size: f64) -> Result<(), String> {
    let part = &points[s.first..=s.last];
    let (begin, end) = s.curve.domain();
    let rounding = 1e-13 * size;
    // Length along the polyline; the stretch may start within its first chord.
    let offset = (s.curve.point(begin) - part[0]).norm();
    let (mut before, mut worst) = (-offset, (0.0f64, 0.0f64));
    for (j, chord) in part.windows(2).enumerate() {
        let length = (chord[1] - chord[0]).norm();
        let samples = if part.len() > 3000 { 3 } else { 12 };
        for k in 0..=samples {
            let u = before + length * f64::from(k) / f64::from(samples);
            if u < begin || u > end {
                continue;
            }
            let point = s.curve.point(u);
            if offset == 0.0 && s.shape != StretchShape::Arc {
                // The bound holds at the same parameter.
                let place = chord[0] + (chord[1] - chord[0]) * (f64::from(k) / f64::from(samples));
                worst.0 = worst.0.max((point - place).norm());
            }
            // An arc has another parameter inside.
            let wide = if s.shape == StretchShape::Arc { 4 + part.len() / 20 } else { 4 };
            let near = part[j.saturating_sub(wide)..(j + 2 + wide).min(part.len())].windows(2);
            let distance = near.map(|c| distance_to_chord(&point, &c[0], &c[1])).fold(f64::INFINITY, f64::min);
            worst.0 = worst.0.max(distance);
        }
        if j > 0 && before >= begin && s.shape == StretchShape::Arc {
            if before <= end {
                worst.1 = worst.1.max(distance_to_circle(&part[j], s));
            }
        } else if j > 0 && before >= begin {
            worst.1 = worst.1.max(distance_to_curve(&part[j], s, (before, 0.5 * length)));
        }
        before += length;
    }
    if worst.0.max(worst.1) > s.max_deviation + rounding {
        return Err(format!("deviations {worst:?} above the bound {}", s.max_deviation));
    }
    Ok(())
}

/// Point and two derivatives from both sides of each knot.
fn check_knots<const D: usize>(s: &FittedStretch<D>, size: f64) -> Result<(), String> {
    let (knots, degree) = (s.curve.knots(), s.curve.degree());
    if s.shape == StretchShape::Arc {
        return check_arc(s, size);
    }
    if s.shape != StretchShape::Curve {
        return if degree == 1 && knots.spans().count() == 1 { Ok(()) } else { Err("no line".into()) };
    }
    let (begin, end) = s.curve.domain();
    let runs: Vec<_> = knots.runs().collect();
    let bend = runs.iter().fold(0.0f64, |m, r| m.max(s.curve.jet(r.1).d2.norm()));
    for w in runs.windows(3) {
        let (u, multiplicity) = (w[1].1, w[1].2);
        if multiplicity != 1 || u <= begin || u >= end {
            return Err(format!("knot {u} stands {multiplicity} times"));
        }
        let (left, right) = (s.curve.jet_left(u), s.curve.jet(u));
        // What the rounding of the coordinates does to the second derivative.
        let width = (w[1].1 - w[0].1).min(w[2].1 - w[1].1);
        let rounding = 100.0 * f64::EPSILON * size;
        let gaps = [
            ((left.point - right.point).norm(), rounding),
            ((left.d1 - right.d1).norm(), 1e-9 * right.d1.norm() + rounding / width),
            ((left.d2 - right.d2).norm(), 1e-9 * bend + rounding / (width * width)),
        ];
        if let Some((gap, bound)) = gaps.iter().find(|(gap, bound)| gap > bound) {
            return Err(format!("jump {gap} above {bound} at knot {u}"));
        }
    }
    Ok(())
}

/// Distance from the curve near a parameter: the nearest of some places, more closely around the best one.
fn distance_to_curve<const D: usize>(p: &SVector<f64, D>, s: &FittedStretch<D>, (near, mut reach): (f64, f64)) -> f64 {
    let (begin, end) = s.curve.domain();
    let mut best = (f64::INFINITY, near);
    for _ in 0..3 {
        let middle = best.1;
        for u in (-16..=16).map(|k| middle + reach * f64::from(k) / 16.0).filter(|u| (begin..=end).contains(u)) {
            let distance = (s.curve.point(u) - p).norm();
            if distance < best.0 {
                best = (distance, u);
            }
        }
        reach /= 16.0;
    }
    best.0
}

/// Distance from the circle of an arc.
fn distance_to_circle<const D: usize>(p: &SVector<f64, D>, s: &FittedStretch<D>) -> f64 {
    let jet = s.curve.jet(s.curve.domain().0).by_arc_length();
    let radius = 1.0 / jet.d2.norm();
    let centre = jet.point + jet.d2 * (radius * radius);
    let off = p - centre;
    let in_plane = jet.d1 * off.dot(&jet.d1) + jet.d2 * (off.dot(&jet.d2) * radius * radius);
    (off - in_plane * (radius / in_plane.norm())).norm()
}

/// One curvature everywhere, in one plane.
fn check_arc<const D: usize>(s: &FittedStretch<D>, size: f64) -> Result<(), String> {
    let (begin, end) = s.curve.domain();
    let at = |i: i32| s.curve.jet(begin + (end - begin) * f64::from(i) / 200.0).by_arc_length();
    let first = at(0);
    let curvature = first.d2.norm();
    let centre = |i: i32| at(i).point + at(i).d2 / at(i).d2.norm_squared();
    for i in 0..=200 {
        let jet = at(i);
        let off = (centre(i) - centre(0)).norm();
        if (jet.d2.norm() / curvature - 1.0).abs() > 1e-7 || off > 1e-7 / curvature + 1e-11 * size {
            return Err(format!("no arc: curvature {} and {curvature}, centre off by {off}", jet.d2.norm()));
        }
    }
    Ok(())
}

/// Indices of the corners between stretches, both ends included.
pub fn corners<const D: usize>(stretches: &[FittedStretch<D>]) -> Vec<usize> {
    let mut corners: Vec<usize> = stretches.iter().filter(|s| !s.continues).map(|s| s.first).collect();
    corners.extend(stretches.last().map(|s| s.last));
    corners
}
