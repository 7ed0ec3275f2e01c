//! Limits of the joints' acceleration and jerk as tables, along a path.
//!
//! A table by speed becomes rows of the lines below it (module `concave`): for acceleration and torque with `y = |q' v|`, for jerk with
//! `y = (q' v)^2`. Of a table by position the least value over the joint's way on an interval counts, at a grid point that of both
//! intervals beside it.

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink, Within};
use arcfeed_feedrate::{IntervalBound, JerkRow, LimitId, Quantity, Row};
use arcfeed_kinematics::Joints;

use super::bounds::DerivativeBounds;
use super::concave::{Line, LineBy, lines_below};
use super::fractions::LimitFractions;
use crate::limits::{JointTables, Limits, TableKind};
use crate::path::{JointJet, JointPath};

/// Lines below the tables by speed of one kind, joint by joint.
pub(crate) type JointLines<const N: usize> = [Vec<Line>; N];

/// The tables of a path's limits, made ready for its grid.
#[derive(Debug, Clone)]
pub(crate) struct TablePath<const N: usize> {
    acceleration: JointLines<N>,
    jerk: JointLines<N>,
    pub torque: JointLines<N>,
    /// The least limits by position on every interval; infinite without a table.
    acceleration_at: Vec<Joints<N>>,
    jerk_at: Vec<Joints<N>>,
}

impl<const N: usize> TablePath<N> {
    /// On a path whose feed is at most `feed` where that is known.
    pub fn of(
        limits: &Limits<'_, N>,
        tables: &JointTables<N>,
        joints: &JointPath<N>,
        bounds: &DerivativeBounds<N>,
        feed: f64,
    ) -> Self {
        let [d1, ..] = bounds.joints();
        let steepest: [f64; N] = std::array::from_fn(|j| d1.iter().skip(j).step_by(N).copied().fold(0.0, f64::max));
        let fastest = |j: usize| {
            let by_feed = if feed.is_finite() { steepest[j] * feed } else { f64::INFINITY };
            limits.joints().velocity()[j].min(by_feed)
        };
        // A line above the constant limit at all speeds is no limit.
        let lines = |kind, by: LineBy, constant: Joints<N>| -> JointLines<N> {
            let binds = |j: usize, line: &Line| line.rest - line.slope * by.measure(fastest(j)) < constant[j];
            std::array::from_fn(|j| {
                let all = tables.of(kind, j).map_or(Vec::new(), |table| lines_below(table, fastest(j), by));
                all.into_iter().filter(|line| binds(j, line)).collect()
            })
        };
        let torque = limits.torque().map_or(Joints::repeat(f64::INFINITY), |torque| *torque.limits());
        let at = |kind| (0..joints.intervals()).map(|k| least_on(tables, kind, joints.interval(k))).collect();
        Self {
            acceleration: lines(TableKind::AccelerationBySpeed, LineBy::Speed, *limits.joints().acceleration()),
            jerk: lines(TableKind::JerkBySpeed, LineBy::SquaredSpeed, *limits.joints().jerk()),
            torque: lines(TableKind::TorqueBySpeed, LineBy::Speed, torque),
            acceleration_at: at(TableKind::AccelerationByPosition),
            jerk_at: at(TableKind::JerkByPosition),
        }
    }
}

/// The least limits of a table by position on an interval.
fn least_on<const N: usize>(
    tables: &JointTables<N>,
    kind: TableKind,
    (start, end): (&JointJet<N>, &JointJet<N>),
) -> Joints<N> {
    let third = (end.s - start.s) / 3.0;
    Joints::from_fn(|j, _| {
        let Some(table) = tables.of(kind, j) else { return f64::INFINITY };
        // The Bernstein coefficients of the cubic through both ends.
        let way = [start.q[j], start.q[j] + third * start.d1[j], end.q[j] - third * end.d1[j], end.q[j]];
        let [from, to] = way.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], q| [a.min(*q), b.max(*q)]);
        table.least_between(from, to)
    })
}

/// Derivatives of the joints along a path, as the limits of joints take them: joint by joint at every place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointDerivatives<'a> {
    pub after: &'a [Vec<f64>; 3],
    pub before: &'a [Vec<f64>; 3],
    pub middle: &'a [Vec<f64>; 3],
    pub bounds: &'a [Vec<f64>; 3],
    /// Jumps of the second derivatives over the time that they are spread over, interval by interval.
    pub steps: &'a [f64],
}

impl JointDerivatives<'_> {
    /// True if the direction jumps at point `i` of `n` joints.
    fn has_corner(&self, i: usize, n: usize) -> bool {
        (i * n..(i + 1) * n).any(|at| self.after[0][at] != self.before[0][at])
    }

    /// True if the curvature does.
    fn has_jump(&self, i: usize, n: usize) -> bool {
        (i * n..(i + 1) * n).any(|at| self.after[1][at] != self.before[1][at])
    }
}

/// `|q' u + q'' x| <= a` with a limit by tables.
#[derive(Debug)]
pub(crate) struct TabledAcceleration<'a, const N: usize> {
    tables: &'a TablePath<N>,
    along: JointDerivatives<'a>,
    limits: Joints<N>,
    used: Joints<N>,
}

impl<'a, const N: usize> TabledAcceleration<'a, N> {
    /// With constant `limits`, and the fractions of all of them that may be used.
    pub fn new(
        tables: &'a TablePath<N>,
        along: JointDerivatives<'a>,
        limits: &Joints<N>,
        used: &LimitFractions,
    ) -> Self {
        Self { tables, along, limits: *limits, used: used.joints(Quantity::JointAcceleration) }
    }

    fn at_interval(&self, k: usize, j: usize) -> f64 {
        self.used[j] * self.limits[j].min(self.tables.acceleration_at[k][j])
    }

    /// The least of both intervals beside point `i`.
    fn at_point(&self, i: usize, j: usize) -> f64 {
        let last = self.tables.acceleration_at.len() - 1;
        self.at_interval(i.saturating_sub(1), j).min(self.at_interval(i.min(last), j))
    }

    fn push(&self, j: usize, [a, b]: [f64; 2], limit: f64, out: &mut RowSink<'_>) {
        let source = LimitId::joint(Quantity::JointAcceleration, j);
        out.row(Row::symmetric(a, b, limit, source));
        for line in &self.tables.acceleration[j] {
            push_line(Row::symmetric(a, b, self.used[j] * line.rest, source), self.used[j] * line.slope, a, out);
        }
    }
}

/// A row whose bounds fall by `slope` times the speed of a joint, which moves by `rate` along the path. Always as many rows for one
/// line.
pub(super) fn push_line(row: Row, slope: f64, rate: f64, out: &mut RowSink<'_>) {
    if slope == 0.0 {
        out.row(row);
        return;
    }
    // The other bound of each follows from the other row.
    let fall = slope * rate.abs();
    out.row(Row { c: row.c + fall, ..row });
    out.row(Row { c: row.c - fall, ..row });
}

impl<const N: usize> PathConstraint for TabledAcceleration<'_, N> {
    fn points(&self) -> Option<usize> {
        Some(self.along.after[0].len() / N)
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let JointDerivatives { after, before, middle, .. } = self.along;
        match place {
            Place::Point(i) => {
                let side = |of: &[Vec<f64>; 3], j: usize| [of[0][i * N + j], of[1][i * N + j]];
                (0..N).for_each(|j| self.push(j, side(after, j), self.at_point(i, j), out));
                if self.along.has_corner(i, N) {
                    out.cap(0.0, LimitId::path(Quantity::Corner));
                } else if self.along.has_jump(i, N) {
                    (0..N).for_each(|j| self.push(j, side(before, j), self.at_point(i, j), out));
                }
            }
            Place::Middle { k, .. } => (0..N).for_each(|j| {
                self.push(j, [middle[0][k * N + j], middle[1][k * N + j]], self.at_interval(k, j), out);
            }),
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        for j in 0..N {
            let [a, b] = [0, 1].map(|order| self.along.bounds[order][k * N + j]);
            let source = LimitId::joint(Quantity::JointAcceleration, j);
            let mut push = |c: f64, limit: f64| {
                if limit.is_finite() {
                    out.push(IntervalBound::Acceleration { a, b, c, rest: 0.0, limit, source });
                }
            };
            push(0.0, self.at_interval(k, j));
            for line in &self.tables.acceleration[j] {
                push(self.used[j] * line.slope * a, self.used[j] * line.rest);
            }
        }
    }
}

/// `|(q' w + 3 q'' u + q''' x) sdot| <= jerk` with a limit by tables.
#[derive(Debug)]
pub(crate) struct TabledJerk<'a, const N: usize> {
    tables: &'a TablePath<N>,
    along: JointDerivatives<'a>,
    limits: Joints<N>,
    used: Joints<N>,
    /// Part of each limit that rows may use.
    of_rows: f64,
}

impl<'a, const N: usize> TabledJerk<'a, N> {
    /// With constant `limits`, the fractions that may be used, and the part `margin` that rows keep back.
    pub fn new(
        tables: &'a TablePath<N>,
        along: JointDerivatives<'a>,
        limits: &Joints<N>,
        used: &LimitFractions,
        margin: f64,
    ) -> Self {
        Self { tables, along, limits: *limits, used: used.joints(Quantity::JointJerk), of_rows: 1.0 - margin }
    }

    /// All limits of joint `j` on interval `k`: at rest, and by how much each falls with the squared speed along the path.
    fn limits(&self, k: usize, j: usize) -> impl Iterator<Item = [f64; 2]> + '_ {
        let steepest = self.along.bounds[0][k * N + j];
        let constant = self.limits[j].min(self.tables.jerk_at[k][j]);
        let lines = self.tables.jerk[j].iter().map(move |line| [line.rest, line.slope * steepest * steepest]);
        std::iter::once([constant, 0.0]).chain(lines).map(move |both| both.map(|value| self.used[j] * value))
    }
}

impl<const N: usize> PathConstraint for TabledJerk<'_, N> {
    fn points(&self) -> Option<usize> {
        Some(self.along.after[0].len() / N)
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        if let Place::Point(i) = place
            && self.along.has_corner(i, N)
        {
            out.cap(0.0, LimitId::path(Quantity::Corner));
        }
    }

    fn jerk_rows(&self, k: usize, _h: f64, within: Within, out: &mut Vec<JerkRow>) {
        let (of, place) = match within {
            Within::Start => (self.along.after, k),
            Within::Middle => (self.along.middle, k),
            Within::End => (self.along.before, k + 1),
        };
        for j in 0..N {
            let [alpha, second, gamma] = [0, 1, 2].map(|order| of[order][place * N + j]);
            let (source, jump) = (LimitId::joint(Quantity::JointJerk, j), self.along.steps[k * N + j]);
            out.extend(self.limits(k, j).map(|[rest, fall]| JerkRow {
                alpha,
                beta: 3.0 * second,
                gamma,
                step: jump + fall,
                limit: self.of_rows * rest,
                source,
            }));
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        for j in 0..N {
            let [alpha, second, gamma] = [0, 1, 2].map(|order| self.along.bounds[order][k * N + j]);
            let (source, jump) = (LimitId::joint(Quantity::JointJerk, j), self.along.steps[k * N + j]);
            out.extend(self.limits(k, j).filter(|[rest, _]| rest.is_finite()).map(|[rest, fall]| {
                let (beta, step) = (3.0 * second, jump + fall);
                IntervalBound::Jerk { alpha, beta, gamma, step, limit: rest, source }
            }));
        }
    }
}
