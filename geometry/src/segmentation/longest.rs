//! Segmentation into the fewest pieces: from the start on, each time the longest piece that keeps the tolerance.

use super::cutter::{Cutter, step};
use crate::chord::{Deviation, three};
use crate::curve::Curve;
use crate::error::GeometryError;

/// A piece is long enough when its deviation lies within this fraction below the tolerance.
const SLACK: f64 = 1e-5;

/// Samples of a piece by which the search beyond it judges where later chords could still pass.
const WITNESSES: usize = 8;

/// So many steps of a `WITNESSES`-th of the piece are looked beyond its end at most.
const LOOK_BEYOND: usize = 64;

/// Cuts the curve into longest pieces, ending at knots or running across them.
pub(super) fn cut<const D: usize>(cutter: &mut Cutter<'_, D>, across_knots: bool) -> Result<(), GeometryError> {
    let (mut u, end) = cutter.curve.domain();
    let mut first = 0;
    let mut cones = Vec::with_capacity(WITNESSES + LOOK_BEYOND);
    while u < end {
        while cutter.beziers[first].interval().1 <= u {
            first += 1;
        }
        let limit = if across_knots { end } else { cutter.beziers[first].interval().1 };
        let (next, deviation) = longest(cutter, first, u, limit, &mut cones)?;
        cutter.push(next, deviation.upper)?;
        u = next;
    }
    Ok(())
}

/// End of the longest piece from `u0` on that keeps the tolerance, and its deviation.
fn longest<const D: usize>(
    cutter: &mut Cutter<'_, D>,
    first: usize,
    u0: f64,
    limit: f64,
    cones: &mut Vec<Cone>,
) -> Result<(f64, Deviation), GeometryError> {
    let tolerance = cutter.tolerance;
    let mut reach = u0;
    let mut reached: Option<Deviation> = None;
    let mut guess = guess(cutter, u0, limit);
    loop {
        // Extend as far as feasible without a gap.
        let (u, deviation) = crossing(cutter, first, u0, (reach, reached), guess, limit);
        let Some(deviation) = deviation else {
            return Err(GeometryError::ParameterTooCoarse { u: u0, tolerance });
        };
        if u == limit {
            return Ok((u, deviation));
        }
        // The deviation may come back under the tolerance farther on, at an inflection for instance.
        match beyond(cutter, first, u0, u, limit, cones) {
            Some((u, deviation)) if u == limit => return Ok((u, deviation)),
            Some((u, deviation)) => {
                (reach, reached) = (u, Some(deviation));
                guess = u + (u - u0) / WITNESSES as f64;
            }
            None => return Ok((u, deviation)),
        }
    }
}

/// First try for the end of a piece: the step by the second derivative in the middle of the piece to be.
fn guess<const D: usize>(cutter: &Cutter<'_, D>, u0: f64, limit: f64) -> f64 {
    let room = limit - u0;
    let h = step(cutter.curve, u0, cutter.tolerance).min(room);
    let h = step(cutter.curve, u0 + 0.5 * h, cutter.tolerance).min(4.0 * h).min(room);
    u0 + h
}

/// Goes on from a feasible end (none yet: the start itself) to the next place where the deviation crosses the tolerance,
/// and returns the last feasible end before it.
///
/// A short piece deviates in proportion to the square of its length, so the search runs on the root of the deviation,
/// which is nearly linear.
fn crossing<const D: usize>(
    cutter: &mut Cutter<'_, D>,
    first: usize,
    u0: f64,
    (mut low, mut reached): (f64, Option<Deviation>),
    guess: f64,
    limit: f64,
) -> (f64, Option<Deviation>) {
    let tolerance = cutter.tolerance;
    // Aim between the tolerance and the slack.
    let target = (tolerance * (1.0 - 0.4 * SLACK)).sqrt();
    let mut root_low = reached.map_or(0.0, |d| d.upper.sqrt());
    let mut high: Option<(f64, f64)> = None;
    // A guess below the resolution of the parameter becomes the smallest step there is.
    let mut u = guess.max(u0.next_up()).min(limit);
    for round in 0.. {
        let deviation = cutter.deviation(first, u0, u);
        let root = deviation.upper.sqrt();
        if deviation.upper <= tolerance {
            (low, reached, root_low) = (u, Some(deviation), root);
            if u == limit || deviation.upper >= tolerance * (1.0 - SLACK) {
                break;
            }
        } else {
            high = Some((u, root));
        }
        u = match high {
            None => (u0 + (u - u0) * (target / root).min(8.0)).min(limit),
            Some((high, root_high)) => {
                let secant = low + (high - low) * (target - root_low) / (root_high - root_low);
                let inside = low < secant && secant < high;
                // Every third round halves, so that a kink in the deviation cannot hold the search up.
                if inside && round % 3 != 2 { secant } else { 0.5 * (low + high) }
            }
        };
        // Neighbouring numbers: nothing is left between feasible and not.
        if !(low < u && high.is_none_or(|(h, _)| u < h)) {
            break;
        }
    }
    (low, reached)
}

/// The directions from the start of a piece into which a chord must point to pass a point of the curve within the
/// tolerance.
struct Cone {
    point: [f64; 3],
    axis: [f64; 3],
    half_angle: f64,
}

impl Cone {
    fn new(origin: &[f64; 3], point: [f64; 3], tolerance: f64) -> Self {
        let v = [point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]];
        let r = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        if r <= tolerance {
            // Any chord passes near enough: its start already does.
            return Self { point: v, axis: [0.0; 3], half_angle: std::f64::consts::PI };
        }
        // asin(x) <= x + (pi / 2 - 1) x^3 on [0, 1], and nearly equal for narrow cones.
        let x = tolerance / r;
        let half_angle = x + (std::f64::consts::FRAC_PI_2 - 1.0) * x * x * x;
        Self { point: v, axis: [v[0] / r, v[1] / r, v[2] / r], half_angle }
    }

    /// True where no direction lies in both cones. The chord of the angle is used instead of the angle, which is never
    /// larger and exact for narrow cones.
    fn excludes(&self, other: &Self) -> bool {
        let d = [self.axis[0] - other.axis[0], self.axis[1] - other.axis[1], self.axis[2] - other.axis[2]];
        let sum = self.half_angle + other.half_angle;
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > sum * sum
    }

    /// Squared distance of this point from the chord that ends in `end`.
    fn distance2_from_chord(&self, end: &[f64; 3]) -> f64 {
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let l2 = dot(end, end);
        let s = if l2 > 0.0 { (dot(&self.point, end) / l2).max(0.0).min(1.0) } else { 0.0 };
        let q = [self.point[0] - s * end[0], self.point[1] - s * end[1], self.point[2] - s * end[2]];
        dot(&q, &q)
    }
}

/// The next feasible end beyond `u`, where the deviation has just crossed the tolerance, if there is one.
///
/// Ends are tried at steps of a fraction of the piece. A try is refused by a look at the samples passed so far. The search
/// is over when the cones of two samples exclude each other: then no chord from this start can pass both, however far it
/// goes.
fn beyond<const D: usize>(
    cutter: &mut Cutter<'_, D>,
    first: usize,
    u0: f64,
    mut u: f64,
    limit: f64,
    cones: &mut Vec<Cone>,
) -> Option<(f64, Deviation)> {
    let curve = cutter.curve;
    let tolerance = cutter.tolerance;
    let origin = three(&curve.point(u0));
    let step = (u - u0) / WITNESSES as f64;
    cones.clear();
    cones.extend((1..=WITNESSES).map(|i| Cone::new(&origin, three(&curve.point(u0 + i as f64 * step)), tolerance)));
    for _ in 0..LOOK_BEYOND {
        let next = (u + step).min(limit);
        if next <= u {
            return None;
        }
        u = next;
        let cone = Cone::new(&origin, three(&curve.point(u)), tolerance);
        if cones.iter().any(|c| c.excludes(&cone)) {
            return None;
        }
        if cones.iter().all(|c| c.distance2_from_chord(&cone.point) <= tolerance * tolerance) {
            let deviation = cutter.deviation(first, u0, u);
            if deviation.upper <= tolerance {
                return Some((u, deviation));
            }
        }
        cones.push(cone);
    }
    None
}
