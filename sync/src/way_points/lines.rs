//! Straight lines from point to point, with blends at the corners.
//!
//! On a line all axes move in proportion. A blend leaves the line before a point with the velocities
//! `v1` and joins the one after it with `v2`; in between every axis changes its velocity in two
//! phases of opposite jerk that last half of the duration `T` each
//! ([`StateToState::blend`]). It begins where `v1` would take the axes to the point in `T / 2`, and
//! ends where `v2` takes them from it in `T / 2`, so that it joins both lines. With `d = v2 - v1`
//!
//! ```text
//! distance to the nearer line, at most                   T |d| / 12
//! distance of the point to the blend, at most            T |d| / 12
//! acceleration, jerk of an axis                          2 d / T, 4 d / T²
//! ```
//!
//! In the middle of its time the blend is exactly that far from the point; with different speeds it is
//! nearer before or after. The speeds at a corner are a share of the highest velocities on both lines
//! that are inside the limits of both, the largest share whose blend keeps the deviation, covers at most
//! half of each line, and can be reached and left on them. Where that is slower than a rest in the corner,
//! the axes rest.

use std::ops::Range;

use arcfeed_feedrate::{AxisLimits, AxisProblem, AxisState, MotionLaw, StateToState};

use super::MOST_WAY_POINTS;
use crate::mode::MotionOptions;
use crate::state_to_state::with_least_duration;
use crate::straight::Line;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Most lines of a route.
const LINES: usize = MOST_WAY_POINTS + 1;

/// Halvings of the share of speed that a line can reach.
const HALVINGS: usize = 30;

/// Blends cover less than half of a line by this factor, and what is left is more than needed.
const APART: f64 = 1.01;
const LEFT: f64 = 1.0 - 1e-6;

/// Part of a limit that is none the more by round-off.
const INSIDE: f64 = 1.0 - 8.0 * f64::EPSILON;

/// More than the round-off of a duration.
const ROUND_UP: f64 = 1.0 + 8.0 * f64::EPSILON;

/// A line between two points.
#[derive(Debug, Clone, Copy)]
struct Leg<const N: usize> {
    way: [f64; N],
    /// The velocities at the limits.
    fastest: [f64; N],
    /// These by the way, 1/s.
    rate: f64,
    limits: [AxisLimits; N],
    /// Least duration of the line (s).
    least: f64,
    /// The axis that moves farthest, and the limits of all as its limits.
    reference: usize,
    shared: AxisLimits,
}

impl<const N: usize> Leg<N> {
    fn new(from: &[f64; N], to: &[f64; N], (limits, least): (&[AxisLimits; N], f64)) -> Option<Self> {
        let line = Line::new(&from.map(AxisState::rest), &to.map(AxisState::rest), limits).ok()?;
        let (shared, m) = (line.limits(limits)?, line.reference);
        let way: [f64; N] = std::array::from_fn(|k| to[k] - from[k]);
        let speed = if way[m] > 0.0 { shared.v_max() } else { shared.v_min() };
        let speed = if way[m] == 0.0 { 0.0 } else { INSIDE * speed };
        let rate = if speed == 0.0 { 0.0 } else { speed / way[m] };
        let fastest = line.ratios.map(|ratio| ratio * speed);
        Some(Self { way, fastest, rate, limits: *limits, least, reference: m, shared })
    }

    /// The share of the speed that a velocity along the line is.
    fn share(&self, velocity: &[f64; N]) -> f64 {
        let m = self.reference;
        if self.fastest[m] == 0.0 { 0.0 } else { (velocity[m] / self.fastest[m]).max(0.0) }
    }

    /// The part of the speed that is inside other limits of velocity, too.
    fn part_inside(&self, limits: &[AxisLimits; N]) -> f64 {
        let part = |v: f64, l: &AxisLimits| if v > 0.0 { l.v_max() / v } else { l.v_min() / v };
        let most = self.fastest.iter().zip(limits).filter(|(v, _)| **v != 0.0).map(|(v, l)| part(*v, l));
        let least = most.fold(1.0, f64::min);
        if least < 1.0 { INSIDE * least } else { 1.0 }
    }

    /// Returns true if shares of the speed follow each other on what blends of the durations leave of
    /// the line.
    fn reaches(&self, shares: [f64; 2], durations: [f64; 2]) -> bool {
        let m = self.reference;
        let [v0, v1] = shares.map(|share| share * self.fastest[m]);
        let left = self.left(shares, durations);
        StateToState::to_velocity(&AxisState::new(0.0, v0, 0.0), v1, 0.0, &self.shared)
            .is_ok_and(|change| change.at(change.duration()).p.abs() <= LEFT * left * self.way[m].abs())
    }

    /// The part of the line that blends leave.
    fn left(&self, shares: [f64; 2], durations: [f64; 2]) -> f64 {
        1.0 - 0.5 * self.rate * (shares[0] * durations[0] + shares[1] * durations[1])
    }

    /// The time of what blends leave of the line (s).
    fn time(&self, shares: [f64; 2], durations: [f64; 2]) -> f64 {
        let m = self.reference;
        let [v0, v1] = shares.map(|share| share * self.fastest[m]);
        let end = AxisState::new(self.left(shares, durations) * self.way[m], v1, 0.0);
        let problem = AxisProblem::new(&AxisState::new(0.0, v0, 0.0), &end, &self.shared);
        let options = MotionOptions::default().with_least_duration(self.least);
        let duration = problem.map(|problem| match options {
            // Not every longer duration is possible.
            Ok(options) if self.least > problem.shortest_duration() => {
                with_least_duration(&problem, &options).map_or(f64::INFINITY, |motion| motion.duration())
            }
            _ => problem.shortest_duration(),
        });
        duration.unwrap_or(f64::INFINITY)
    }
}

/// A blend between two lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner<const N: usize> {
    /// States at its begin and its end.
    pub states: [[AxisState; N]; 2],
    pub duration: f64,
    pub limits: [AxisLimits; N],
}

/// A route of straight lines.
pub(super) struct Lines<const N: usize> {
    legs: [Leg<N>; LINES],
    /// Shares of the speed at the corners before the lines; 0 before the first.
    shares: [f64; LINES],
    /// The part of the speed before and after these corners that the limits of both lines allow.
    parts: [[f64; 2]; LINES],
    /// Shares of the speed at the start and in the target.
    ends: [f64; 2],
    count: usize,
}

impl<const N: usize> Lines<N> {
    /// Lines between points, of which there is one more, with velocities at both `ends`, that keep limits and least duration of each
    /// line and pass each inner point within `deviation`, or rest there where that is faster. `None` if the
    /// numbers leave the range of `f64`.
    pub fn new<'a>(
        points: &[[f64; N]],
        ends: &[[f64; N]; 2],
        rules: impl Fn(usize) -> (&'a [AxisLimits; N], f64),
        deviation: impl Fn(usize) -> f64,
    ) -> Option<Self> {
        let count = points.len() - 1;
        let mut legs = [Leg::new(&points[0], &points[1], rules(0))?; LINES];
        for i in 1..count {
            legs[i] = Leg::new(&points[i], &points[i + 1], rules(i))?;
        }
        let mut lines = Self { legs, shares: [0.0; LINES], parts: [[1.0; 2]; LINES], ends: [0.0; 2], count };
        lines.ends = [lines.legs[0].share(&ends[0]), lines.legs[count - 1].share(&ends[1])];
        for i in 1..count {
            let [before, after] = [&lines.legs[i - 1], &lines.legs[i]];
            lines.parts[i] = [before.part_inside(&after.limits), after.part_inside(&before.limits)];
            lines.shares[i] = lines.largest_share(i, deviation(i));
        }
        lines.follow();
        lines.keep_faster();
        Some(lines)
    }

    /// The axes rest at both ends of a line. Returns false if they do so already.
    pub fn rest_beside(&mut self, leg: usize) -> bool {
        let mut changed = false;
        for i in [leg, leg + 1].into_iter().filter(|&i| i < self.count) {
            changed |= std::mem::take(&mut self.shares[i]) > 0.0;
        }
        self.follow();
        self.keep_faster();
        changed
    }

    /// The axes rest in every point.
    pub fn rest(&mut self) {
        self.shares = [0.0; LINES];
    }

    /// Rests in the corners where that is faster than the blend.
    fn keep_faster(&mut self) {
        for i in 1..self.count {
            let (share, legs) = (self.shares[i], i - 1..i + 1);
            if share == 0.0 {
                continue;
            }
            let blended = self.time(legs.clone());
            self.shares[i] = 0.0;
            if !self.reaches(legs.clone()) || self.time(legs) > blended {
                self.shares[i] = share;
            }
        }
        let shares = self.shares;
        let blended = self.time(0..self.count);
        self.rest();
        if !self.reaches(0..self.count) || self.time(0..self.count) > blended {
            self.shares = shares;
        }
    }

    /// Returns true if on these lines each speed follows from the one before.
    fn reaches(&self, mut legs: Range<usize>) -> bool {
        legs.all(|leg| self.legs[leg].reaches(self.shares_on(leg), self.durations_on(leg)))
    }

    /// Time of lines and of the blends before them and between them (s).
    fn time(&self, legs: Range<usize>) -> f64 {
        let blend = |i: usize| if self.shares[i] > 0.0 { self.duration(i) } else { 0.0 };
        legs.map(|leg| blend(leg) + self.legs[leg].time(self.shares_on(leg), self.durations_on(leg))).sum()
    }

    fn shares_on(&self, leg: usize) -> [f64; 2] {
        [0, 1].map(|end| self.share_on(leg, end))
    }

    /// The durations of the blends before and after a line (s).
    fn durations_on(&self, leg: usize) -> [f64; 2] {
        [leg, leg + 1].map(|i| if i < self.count && self.shares[i] > 0.0 { self.duration(i) } else { 0.0 })
    }

    /// The share of the speed on a line at its begin or its end.
    fn share_on(&self, leg: usize, end: usize) -> f64 {
        match leg + end {
            0 => self.ends[0],
            corner if corner == self.count => self.ends[1],
            corner => self.shares[corner] * self.parts[corner][1 - end],
        }
    }

    /// The velocities before and after the corner that begins a line.
    fn velocities(&self, i: usize) -> [[f64; N]; 2] {
        [(i - 1, 1), (i, 0)].map(|(leg, end)| self.legs[leg].fastest.map(|v| self.share_on(leg, end) * v))
    }

    /// The largest share of the speed at a corner whose blend deviates by so much at most and covers
    /// at most half of the lines.
    fn largest_share(&self, i: usize, deviation: f64) -> f64 {
        let [before, after] = [&self.legs[i - 1], &self.legs[i]];
        if before.rate == 0.0 || after.rate == 0.0 || deviation == 0.0 {
            return 0.0;
        }
        // A blend of the full speed takes the larger of 2 a and 2 √b; of a share s, 2 s a and 2 √(s b).
        let parts = self.parts[i];
        let change: [f64; N] = std::array::from_fn(|k| parts[1] * after.fastest[k] - parts[0] * before.fastest[k]);
        let (mut a, mut b) = (0.0_f64, 0.0_f64);
        for (k, d) in change.iter().enumerate() {
            let (most, jerk) = bounds(*d, &before.limits[k], &after.limits[k]);
            (a, b) = (a.max(d.abs() / most), b.max(d.abs() / jerk));
        }
        let distance = change.iter().map(|d| d * d).sum::<f64>().sqrt();
        let rate = APART * f64::max(parts[0] * before.rate, parts[1] * after.rate);
        let within = |factor: f64| {
            // factor s T(s) <= 1
            let (x, y) = (2.0 * a * factor, 2.0 * b.sqrt() * factor);
            let by_acceleration = if x > 0.0 { (1.0 / x).sqrt() } else { 1.0 };
            let by_jerk = if y > 0.0 { (1.0 / (y * y)).cbrt() } else { 1.0 };
            by_acceleration.min(by_jerk)
        };
        let by_deviation = if distance == 0.0 { 1.0 } else { within(distance / (12.0 * deviation)) };
        let share = within(rate).min(by_deviation).min(1.0);
        if share > 0.0 { share } else { 0.0 }
    }

    /// Lowers the shares until each speed follows from the one before, and leads to the one after.
    fn follow(&mut self) {
        for i in 0..self.count - 1 {
            self.lower(i, (i, i + 1));
        }
        for i in (1..self.count).rev() {
            self.lower(i, (i + 1, i));
        }
    }

    /// Lowers the share at one end of a line to what the other end lets it reach.
    fn lower(&mut self, leg: usize, (kept, lowered): (usize, usize)) {
        let high = self.shares[lowered];
        let reaches = |lines: &mut Self, x: f64| {
            lines.shares[lowered] = x;
            lines.legs[leg].reaches(lines.shares_on(leg), lines.durations_on(leg))
        };
        let (low, now) = (self.share_on(leg, kept - leg), self.share_on(leg, lowered - leg));
        if now <= low || reaches(self, high) {
            self.shares[lowered] = high;
            return;
        }
        // With the same speed at both ends nothing changes on the line.
        let (mut inside, mut outside) = (low * high / now, high);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if reaches(self, middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        self.shares[lowered] = inside;
    }

    /// Duration of the blend at the corner that begins a line (s): the shortest within the limits.
    fn duration(&self, i: usize) -> f64 {
        let [v1, v2] = self.velocities(i);
        let mut duration = 0.0_f64;
        for k in 0..N {
            let d = v2[k] - v1[k];
            let (most, jerk) = bounds(d, &self.legs[i - 1].limits[k], &self.legs[i].limits[k]);
            duration = duration.max(2.0 * d.abs() / most).max(2.0 * (d.abs() / jerk).sqrt());
        }
        duration * ROUND_UP
    }

    /// The corner at `point`, which begins line `i`; the axes rest there without a blend.
    pub fn corner(&self, i: usize, point: &[f64; N]) -> Corner<N> {
        let (velocities, duration) = (self.velocities(i), self.duration(i));
        let half = 0.5 * duration * self.shares[i];
        let state = |side: usize, leg: usize, sign: f64| {
            let leg = &self.legs[leg];
            let part = sign * half * self.parts[i][side] * leg.rate;
            std::array::from_fn(|k| AxisState::new(point[k] + part * leg.way[k], velocities[side][k], 0.0))
        };
        let limits = std::array::from_fn(|k| common(&self.legs[i - 1].limits[k], &self.legs[i].limits[k]));
        Corner { states: [state(0, i - 1, -1.0), state(1, i, 1.0)], duration, limits }
    }
}

/// The largest acceleration and jerk of a change of velocity by `d` and back, within the limits of
/// both lines.
fn bounds(d: f64, before: &AxisLimits, after: &AxisLimits) -> (f64, f64) {
    let acceleration = |l: &AxisLimits| if d > 0.0 { l.a_max() } else { -l.a_min() };
    let jerk = |l: &AxisLimits| l.j_max().min(-l.j_min());
    (acceleration(before).min(acceleration(after)), jerk(before).min(jerk(after)))
}

/// Limits in a blend: those of both lines.
fn common(x: &AxisLimits, y: &AxisLimits) -> AxisLimits {
    let velocity = (x.v_min().max(y.v_min()), x.v_max().min(y.v_max()));
    let acceleration = (x.a_min().max(y.a_min()), x.a_max().min(y.a_max()));
    let jerk = (x.j_min().max(y.j_min()), x.j_max().min(y.j_max()));
    AxisLimits::new(velocity, acceleration, jerk).unwrap_or(*x)
}
