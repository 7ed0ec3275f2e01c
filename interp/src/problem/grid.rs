//! The places of a path at which limits are evaluated: its knots, borders within it, and more points where a curve bends.

use arcfeed_geometry::PosePath;
use nalgebra::Vector3;

/// Neighbouring grid points differ in what the bend allows by no more than this factor (natural logarithm).
const RATIO: f64 = 0.2;
/// Part of the jerk limit that a path between two grid points may need more than its ends say; its middle is in the rows too, so that
/// what is left is far less.
const WRONG: f64 = 0.014;
/// An interval is halved at most this often for the sake of both: down to 1e-11 of the path.
const HALVINGS: u32 = 30;
/// Borders this close to a knot or to each other are one, as a part of the length.
const CLOSE: f64 = 1e-9;

/// The measure of the density of a grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measure {
    /// Highest feed, m/s.
    pub feed: f64,
    /// Normal acceleration, m/s^2.
    pub normal_acceleration: f64,
    /// Jerk of the tool, m/s^3.
    pub jerk: f64,
    /// No interval that takes less time than this is divided, s.
    pub shortest: f64,
}

/// The time below which no interval is divided, s, on a grid of about so many intervals.
///
/// Thousands of blends of short lines are passed in a few control periods each. Finer intervals cost much time of planning and make
/// the motion less than a thousandth shorter.
pub(crate) fn shortest(intervals: usize, period: f64) -> f64 {
    // On a grid of more intervals than this none is divided that takes less than a control period.
    const LARGE: usize = 6000;
    if intervals > LARGE { period } else { 0.0 }
}

/// The fewest intervals between two knots, and between two stops: a motion with limits on jerk needs these.
const LEAST_PIECES: f64 = 2.0;
pub(crate) const BETWEEN_STOPS: usize = 4;

/// Values from 0 to `length` in equal steps between the `places`, at some of which there are `corners`; about `intervals` in all.
pub(crate) fn equal_steps(length: f64, places: &[f64], corners: &[f64], intervals: usize) -> Vec<f64> {
    let mut grid = Vec::with_capacity(intervals + BETWEEN_STOPS * (places.len() + 1));
    let is_corner = |s: f64| corners.iter().any(|corner| (corner - s).abs() <= CLOSE * length);
    // The ends of a path without corners are as near as its length says.
    let (mut from, mut from_stop) = (0.0, !corners.is_empty());
    for &to in places.iter().chain([&length]) {
        let is_stop = is_corner(to) || (to == length && !corners.is_empty());
        let least = if from_stop && is_stop { BETWEEN_STOPS as f64 } else { LEAST_PIECES };
        let pieces = ((to - from) / length * intervals as f64).round().max(least) as usize;
        grid.extend((0..pieces).map(|i| from + (to - from) * (i as f64 / pieces as f64)));
        (from, from_stop) = (to, is_stop);
    }
    grid.push(length);
    // Between places that are a few roundings apart there are not so many others.
    grid.dedup();
    grid
}

/// The same grid with interval `k` divided into `parts(k)`.
pub(crate) fn refined(grid: &[f64], parts: impl Fn(usize) -> usize) -> Vec<f64> {
    let mut fine = Vec::with_capacity(2 * grid.len());
    for (k, pair) in grid.windows(2).enumerate() {
        let parts = parts(k);
        fine.extend((0..parts).map(|i| pair[0] + (pair[1] - pair[0]) * (i as f64 / parts as f64)));
    }
    fine.extend(grid.last());
    // Between knots that are a few roundings apart there are not so many places.
    fine.dedup();
    fine
}

/// The grid with intervals halved until none is more than [`STEEPEST`] times as long as one next to it.
pub(crate) fn graded(mut grid: Vec<f64>) -> Vec<f64> {
    // Ratio of the lengths of neighbouring intervals.
    const STEEPEST: f64 = 3.0;
    for _ in 0..HALVINGS {
        let h = |k: usize| grid[k + 1] - grid[k];
        let intervals = grid.len() - 1;
        let beside = |k: usize| {
            let before = if k > 0 { h(k - 1) } else { f64::INFINITY };
            before.min(if k + 1 < intervals { h(k + 1) } else { f64::INFINITY })
        };
        let parts: Vec<usize> = (0..intervals).map(|k| 1 + usize::from(h(k) > STEEPEST * beside(k))).collect();
        if parts.iter().all(|parts| *parts == 1) {
            break;
        }
        grid = refined(&grid, |k| parts[k]);
    }
    grid
}

/// Increasing arc lengths from 0 to the path's length: `knots` and `breaks` (borders of sections, chord segments), refined where
/// the path bends.
///
/// The measure is the speed that curvature and its derivative allow, capped at the feed: where the feed is the limit
/// anyway no points are spent. It is looked at wherever the arc length of the curve needed a piece of its own, so that no
/// bend hides between two points.
pub(crate) fn along_curve(path: &PosePath, knots: &[f64], breaks: &[f64], measure: &Measure) -> Vec<f64> {
    // At least so many intervals, so that the arm's own nonlinearity is seen on straight paths.
    const LEAST: usize = 100;
    let length = path.length();
    let merged = borders(knots, breaks, length);
    let mut probes = Vec::new();
    let mut before = 0.0;
    for end in path.curve().map_ends() {
        probes.extend([0.5 * (before + end), end].map(|s| Place::at(path, s, measure)));
        before = end;
    }
    let mut grid = Refinement { path, measure, probes, out: vec![0.0] };
    for pair in merged.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let parts = ((b - a) / length * LEAST as f64).ceil().max(1.0) as usize;
        // Inside the knots, so that one-sided derivatives belong to this interval.
        let inset = (CLOSE * length).min(0.25 * (b - a));
        let mut left = Place { s: a, ..grid.look(a + inset) };
        for i in 1..=parts {
            let end = if i == parts { b } else { a + (b - a) * i as f64 / parts as f64 };
            let right = Place { s: end, ..grid.look(end - inset) };
            grid.refine(&left, &right, HALVINGS);
            left = right;
        }
    }
    grid.out
}

/// The knots and corners of a path without a curve that are inside it, increasing; of several that stand next to each other, one.
pub(crate) fn places(knots: &[f64], corners: &[f64], length: f64) -> Vec<f64> {
    let mut places = borders(knots, corners, length);
    places.retain(|s| *s > CLOSE * length && *s < length - CLOSE * length);
    places
}

/// All knots, and the breaks that do not stand next to one of them or to each other.
fn borders(knots: &[f64], breaks: &[f64], length: f64) -> Vec<f64> {
    let is_knot = |s: f64| knots.binary_search_by(|k| k.total_cmp(&s)).is_ok();
    let mut base: Vec<f64> = knots.iter().chain(breaks).copied().filter(|s| *s >= 0.0 && *s <= length).collect();
    base.sort_by(f64::total_cmp);
    let mut merged: Vec<f64> = Vec::with_capacity(base.len());
    for s in base {
        match merged.last_mut() {
            Some(last) if s == *last => {}
            Some(last) if s - *last <= CLOSE * length && !(is_knot(s) && is_knot(*last)) => {
                if is_knot(s) {
                    *last = s;
                }
            }
            _ => merged.push(s),
        }
    }
    merged
}

/// The grid points nearest to `corners`, increasing and each once: corners closer together than the grid keeps apart are one. None of
/// them is an end, where the tool stops anyway.
pub(crate) fn stops(grid: &[f64], corners: impl Iterator<Item = f64>) -> Vec<usize> {
    let mut stops: Vec<usize> = corners
        .map(|s| {
            let after = grid.partition_point(|&g| g < s).min(grid.len() - 1);
            let before = after.saturating_sub(1);
            if s - grid[before] < grid[after] - s { before } else { after }
        })
        .filter(|&i| i > 0 && i + 1 < grid.len())
        .collect();
    stops.sort_unstable();
    stops.dedup();
    stops
}

/// The shape of the path at one place.
#[derive(Clone, Copy)]
struct Place {
    s: f64,
    /// Speed that the bend and its change allow, capped at the feed.
    pace: f64,
    /// Third derivative of the tool point.
    third: Vector3<f64>,
}

impl Place {
    fn at(path: &PosePath, s: f64, limits: &Measure) -> Self {
        // Speed at which the bend uses the normal acceleration, or the same acceleration per time constant feed /
        // acceleration by its change.
        let reach = limits.feed / limits.normal_acceleration;
        let jet = path.jet(s);
        let bend = jet.d2.fixed_rows::<3>(0).norm();
        let third = jet.d3.fixed_rows::<3>(0).into_owned();
        let by_bend = (limits.normal_acceleration / bend).sqrt();
        let by_change = (limits.normal_acceleration / reach / third.norm()).cbrt();
        // 0 bend divides to infinity, which the feed caps.
        let pace = by_bend.min(by_change).min(limits.feed).max(1e-9 * limits.feed);
        Self { s, pace, third }
    }
}

/// A grid in the making.
struct Refinement<'a> {
    path: &'a PosePath,
    measure: &'a Measure,
    /// Places where a bend would show, by arc length.
    probes: Vec<Place>,
    out: Vec<f64>,
}

impl Refinement<'_> {
    fn look(&self, s: f64) -> Place {
        Place::at(self.path, s, self.measure)
    }

    /// Appends the points after `a` up to `b`.
    fn refine(&mut self, a: &Place, b: &Place, halvings: u32) {
        // Places this close together are the same knot, as a part of the length.
        const SAME: f64 = 2e-12;
        let m = self.look(0.5 * (a.s + b.s));
        // Not at the ends, where the derivatives may jump.
        let close = (SAME * self.path.length()).min(0.25 * (b.s - a.s));
        let [from, to] = [a.s + close, b.s - close].map(|s| self.probes.partition_point(|p| p.s < s));
        let seen = self.probes[from..to].iter().chain([&m]);
        let (slowest, fastest) = seen
            .clone()
            .chain([a, b])
            .fold((f64::INFINITY, 0.0f64), |(low, high), p| (low.min(p.pace), high.max(p.pace)));
        // Between grid points the third derivative is taken as linear: the jerk by which that is wrong, against the limit,
        // or against the jerk of the bend itself where its pace makes more than that.
        let wrong = seen.fold(0.0f64, |most, p| {
            let x = (p.s - a.s) / (b.s - a.s);
            most.max((p.third - (a.third * (1.0 - x) + b.third * x)).norm() * p.pace.powi(3))
        });
        let jerk = self.measure.jerk.max(self.measure.normal_acceleration.powi(2) / self.measure.feed);
        let coarse = (fastest / slowest).ln() > RATIO || wrong > WRONG * jerk;
        let long = b.s - a.s > self.measure.shortest * fastest;
        if coarse && long && halvings > 0 && a.s < m.s && m.s < b.s {
            self.refine(a, &m, halvings - 1);
            self.refine(&m, b, halvings - 1);
        } else {
            self.out.push(b.s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_is_twice_in_a_grid_between_places_one_rounding_apart() {
        let (knot, next) = (0.5, 0.5_f64.next_up());
        let grid = equal_steps(1.0, &[knot, next], &[], 10);
        let finer = refined(&grid, |_| 3);
        for grid in [grid, finer] {
            assert!(grid.windows(2).all(|pair| pair[0] < pair[1]), "{grid:?}");
            assert!(grid.contains(&knot) && grid.contains(&next));
        }
    }
}
