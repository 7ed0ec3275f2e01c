//! Limits of joints by tables of speed or position, on every piece of a joint trajectory.

use arcfeed_feedrate::Quantity;

use super::bernstein::Bernstein;
use super::certificate::Motion;
use super::joint_trajectory::JointTrajectory;
use crate::limits::{JointTables, LimitTable, TableKind};

/// Bound and largest ratio attained agree to this part where [`MOST_DIVISIONS`] suffice.
const AGREEMENT: f64 = 1e-6;
/// A part of a limit that nobody needs more closely: that of a joint at rest.
const NOTHING: f64 = 1e-12;
/// Divisions of one piece for one table, at most. Where they do not suffice the bound is wider, and still a bound.
const MOST_DIVISIONS: usize = 20_000;
/// Roundings in a limit of a table and in the ratio to it.
const ROUNDINGS: f64 = 32.0 * f64::EPSILON;

/// The largest part of a limit by a table that a joint uses over a whole motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableBound {
    /// Which table.
    pub kind: TableKind,
    /// Of which joint, from 0.
    pub joint: usize,
    /// The largest ratio found of the value to the limit at the same time.
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The ratio that is not exceeded at any time.
    pub bound: f64,
}

/// Which parts of the limits by tables a motion uses at most, at all times; see [`JointTrajectory::certify_tables`] and
/// [`JointTrajectory::certify_torque_tables`].
#[derive(Debug, Clone, PartialEq)]
pub struct TableCertificate {
    bounds: Vec<TableBound>,
}

impl TableCertificate {
    pub(super) fn of_bounds(bounds: Vec<TableBound>) -> Self {
        Self { bounds }
    }

    /// One for each table that was looked at, kind by kind.
    pub fn bounds(&self) -> &[TableBound] {
        &self.bounds
    }

    /// The bound of one table.
    pub fn of(&self, kind: TableKind, joint: usize) -> Option<&TableBound> {
        self.bounds.iter().find(|bound| (bound.kind, bound.joint) == (kind, joint))
    }

    /// True where no limit is exceeded by more than `tolerance`, relative; without tables nothing is.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.bounds.iter().all(|bound| bound.bound <= 1.0 + tolerance)
    }
}

impl<const N: usize> JointTrajectory<N> {
    /// Holds acceleration and jerk against tables of speed or position, at all times. For tables on torque see
    /// [`JointTrajectory::certify_torque_tables`].
    ///
    /// On an interval on which the argument stays on one straight line of a table, value over limit is a rational function, and lies
    /// within the ratios of the Bernstein coefficients of both. On any other interval the largest value counts against the least
    /// limit. Intervals are divided until that is within 1e-6 of a ratio that is attained. A limit by speed counts as falling, as
    /// [`JointTables::with`] says.
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointTables, JointTrajectory, LimitTable, TableKind};
    /// use arcfeed_kinematics::Joints;
    ///
    /// // q = t^3 / 6 from 0 to 1 s: velocity t^2 / 2, acceleration t.
    /// let piece = [0.0, 0.0, 0.0, 1.0 / 6.0, 0.0, 0.0].map(|c| Joints::from([c]));
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// // 2 rad/s^2 at rest, 1 at 1 rad/s, so 1.5 at the end of the motion.
    /// let falling = LimitTable::new(&[[0.0, 2.0], [1.0, 1.0]])?;
    /// let tables = JointTables::<1>::new().with(TableKind::AccelerationBySpeed, 0, falling)?;
    /// let bound = motion.certify_tables(&tables).bounds()[0];
    /// assert!((bound.bound - 1.0 / 1.5).abs() < 1e-6 && bound.t == 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn certify_tables(&self, tables: &JointTables<N>) -> TableCertificate {
        let motion = Motion { times: self.times(), pieces: self.coefficients() };
        let mut bounds = Vec::new();
        for kind in TableKind::ALL {
            let order = match kind.quantity() {
                Quantity::JointAcceleration => 2,
                Quantity::JointJerk => 3,
                _ => continue,
            };
            for joint in 0..N {
                let Some(table) = tables.of(kind, joint) else { continue };
                let law = Law::new(table, kind.is_by_speed());
                let search = search(&motion, joint, order, &law);
                bounds.push(TableBound { kind, joint, attained: search.attained, t: search.t, bound: search.bound });
            }
        }
        TableCertificate { bounds }
    }
}

/// A limit as straight lines through points, constant outside of them.
pub(super) struct Law {
    points: Vec<[f64; 2]>,
    /// The argument is the size of the speed.
    by_speed: bool,
}

impl Law {
    pub fn new(table: &LimitTable, by_speed: bool) -> Self {
        let points = if by_speed { falling(table.points()) } else { table.points().to_vec() };
        Self { points, by_speed }
    }

    /// The place of an argument among the points: the number of those that are not above it.
    fn place(&self, x: f64) -> usize {
        self.points.partition_point(|point| point[0] <= x)
    }

    /// The straight line behind `place` points as its value at an argument, that argument, and its slope.
    fn line(&self, place: usize) -> [f64; 3] {
        let last = self.points.len() - 1;
        match place {
            0 => [self.points[0][1], self.points[0][0], 0.0],
            _ if place > last => [self.points[last][1], self.points[last][0], 0.0],
            _ => {
                let ([x0, y0], [x1, y1]) = (self.points[place - 1], self.points[place]);
                [y0, x0, (y1 - y0) / (x1 - x0)]
            }
        }
    }

    fn at(&self, x: f64) -> f64 {
        let [value, from, slope] = self.line(self.place(x));
        value + slope * (x - from)
    }

    /// The least limit for arguments within a range.
    fn least(&self, [low, high]: [f64; 2]) -> f64 {
        let inside = self.points[self.place(low)..self.place(high)].iter().map(|point| point[1]);
        inside.fold(self.at(low).min(self.at(high)), f64::min)
    }

    /// The same, less what rounding may have done to the limits of the table.
    pub fn certain_least(&self, range: [f64; 2]) -> f64 {
        let greatest = self.points.iter().map(|point| point[1]).fold(0.0, f64::max);
        self.least(range) - 4.0 * ROUNDINGS * greatest
    }

    /// The range of the argument, and the sign that makes the argument of it.
    fn range(&self, x: &Bernstein) -> ([f64; 2], f64) {
        let [low, high] = x.range();
        match (self.by_speed, low >= 0.0, high <= 0.0) {
            (false, ..) | (true, true, _) => ([low, high], 1.0),
            (true, _, true) => ([-high, -low], -1.0),
            _ => ([0.0, high.max(-low)], 0.0),
        }
    }

    /// The part of the limit that `value` does not exceed where the argument is `x`.
    fn bound(&self, value: &Bernstein, x: &Bernstein) -> f64 {
        let (range, sign) = self.range(x);
        let least = self.certain_least(range);
        let coarse = if least > 0.0 { value.bound() / least } else { f64::INFINITY };
        let place = self.place(range[0]);
        if sign == 0.0 || place != self.place(range[1]) {
            return coarse * (1.0 + ROUNDINGS);
        }
        let [limit, from, slope] = self.line(place);
        let size = limit + slope.abs() * (from.abs() + range[0].abs().max(range[1].abs()));
        let error = slope.abs() * x.error() + ROUNDINGS * size;
        let line = x.mapped(|x| limit + slope * (sign * x - from) - error);
        let fine = value.largest_ratio(&line);
        let bound = if fine < coarse { fine } else { coarse };
        bound * (1.0 + ROUNDINGS)
    }

    /// The ratios at both ends, which are attained.
    fn ends(&self, value: &Bernstein, x: &Bernstein) -> [f64; 2] {
        let (value, x) = (value.ends(), x.ends());
        std::array::from_fn(|i| value[i].abs() / self.at(if self.by_speed { x[i].abs() } else { x[i] }))
    }
}

/// The least limit at lower or equal arguments, as points.
fn falling(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut out = vec![points[0]];
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let [last, least] = out[out.len() - 1];
        if y1 >= least {
            continue;
        }
        // Where the line leaves the least limit before it.
        let from = if y0 > least { x0 + (x1 - x0) * ((y0 - least) / (y0 - y1)) } else { x0 };
        if from > last && from < x1 {
            out.push([from, least]);
        }
        out.push([x1, y1]);
    }
    out
}

/// The search for a largest ratio: what is attained so far, and what is not exceeded on the intervals that are done.
struct Search {
    attained: f64,
    t: f64,
    bound: f64,
}

fn search<const N: usize>(motion: &Motion<'_, N>, joint: usize, order: usize, law: &Law) -> Search {
    let argument = usize::from(law.by_speed);
    let mut search = Search { attained: 0.0, t: motion.times[0], bound: 0.0 };
    let both = |piece| [order, argument].map(|order| motion.bernstein(piece, joint, order, 0.0));
    for piece in 0..motion.pieces.len() {
        let [value, x] = both(piece);
        search.see(law.ends(&value, &x), [motion.times[piece], motion.times[piece + 1]]);
    }
    for piece in 0..motion.pieces.len() {
        let (start, duration) = (motion.times[piece], motion.duration(piece));
        let mut open = vec![(both(piece), 0.0, 1.0)];
        let mut divisions = 0;
        while let Some(([value, x], from, width)) = open.pop() {
            let bound = law.bound(&value, &x);
            if bound <= (search.attained * (1.0 + AGREEMENT)).max(NOTHING)
                || divisions == MOST_DIVISIONS
                || !bound.is_finite()
            {
                // Not `max`: a NaN has to show.
                if bound > search.bound || bound.is_nan() {
                    search.bound = if bound.is_nan() { f64::INFINITY } else { bound };
                }
                continue;
            }
            divisions += 1;
            let half = 0.5 * width;
            for (value, (x, from)) in value.halves().into_iter().zip(x.halves().into_iter().zip([from, from + half])) {
                search.see(law.ends(&value, &x), [start + from * duration, start + (from + half) * duration]);
                open.push(([value, x], from, half));
            }
        }
    }
    search
}

impl Search {
    fn see(&mut self, ratios: [f64; 2], times: [f64; 2]) {
        for (ratio, t) in ratios.into_iter().zip(times) {
            if ratio > self.attained {
                (self.attained, self.t) = (ratio, t);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_rises_goes_on_at_its_least() {
        let points = [[1.0, 8.0], [2.0, 4.0], [3.0, 6.0], [5.0, 2.0], [6.0, 3.0], [7.0, 1.0]];
        let (table, law) = (LimitTable::new(&points).expect("a table"), falling(&points));
        let law = Law { points: law, by_speed: true };
        for i in 0..=2000 {
            let x = 0.004 * f64::from(i);
            let least = table.least_between(0.0, x);
            assert!((law.at(x) - least).abs() < 1e-12, "{x}: {} is not {least}", law.at(x));
        }
    }
}
