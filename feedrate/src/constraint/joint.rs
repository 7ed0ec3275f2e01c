//! Velocity, acceleration and jerk of joints.

use super::interface::{PathConstraint, Place, RowSink, Within};
use super::path::PathDerivatives;
use crate::error::FeedError;
use crate::row::{IntervalBound, JerkRow, LimitId, Quantity, Row};

/// One limit per axis: not negative, may be infinite.
fn per_axis(what: &'static str, path: &PathDerivatives<'_>, limits: &[f64]) -> Result<(), FeedError> {
    if limits.len() != path.axes() {
        return Err(FeedError::LengthMismatch { what, got: limits.len(), expected: path.axes() });
    }
    match limits.iter().find(|&&limit| limit.is_nan() || limit < 0.0) {
        Some(&value) => Err(FeedError::Negative { what, value }),
        None => Ok(()),
    }
}

/// `|q' sdot| <= v` for every joint (Electronics 2025, 14, 3869, eq. 4).
#[derive(Debug, Clone)]
pub struct JointVelocity<'a> {
    path: PathDerivatives<'a>,
    limits: &'a [f64],
    /// Their inverses, so that a point costs one division and not one per joint.
    inverses: Vec<f64>,
}

impl<'a> JointVelocity<'a> {
    /// Limits per joint (rad/s or m/s), not negative; infinity means none.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Negative`].
    pub fn new(path: PathDerivatives<'a>, limits: &'a [f64]) -> Result<Self, FeedError> {
        per_axis("joint velocity limits", &path, limits)?;
        Ok(Self { path, limits, inverses: limits.iter().map(|limit| 1.0 / limit).collect() })
    }

    /// The joint that is fastest in units of its limit decides.
    #[inline]
    fn cap(&self, slopes: impl Iterator<Item = f64> + Clone, out: &mut RowSink<'_>) {
        let (mut most, mut joint, mut sum) = (0.0, 0, 0.0);
        for (j, (slope, inverse)) in slopes.clone().zip(&self.inverses).enumerate() {
            let ratio = slope.abs() * inverse;
            // Which joint is fastest changes along the path: choices, not branches.
            let more = ratio > most;
            most = if more { ratio } else { most };
            joint = if more { j } else { joint };
            sum += ratio;
        }
        // A joint that stands still may have a limit of 0; any other NaN must not get lost.
        if sum.is_nan() && slopes.zip(&self.inverses).any(|(slope, inverse)| slope != 0.0 && (slope * inverse).is_nan())
        {
            most = f64::NAN;
        }
        if most != 0.0 {
            out.cap(1.0 / (most * most), LimitId::joint(Quantity::JointVelocity, joint));
        }
    }
}

impl PathConstraint for JointVelocity<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.path.points())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        match place {
            Place::Point(i) => {
                self.cap(self.path.first(i).iter().copied(), out);
                if let Some(before) = self.path.first_before(i) {
                    self.cap(before.iter().copied(), out);
                }
            }
            Place::Middle { k, h } => self.cap((0..self.path.axes()).map(|j| self.path.mid(k, h, j)[0]), out),
        }
    }

    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        for (j, &limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.is_finite()) {
            let [rate, ..] = self.path.interval(k, h, j);
            if rate > 0.0 {
                out.push(IntervalBound::Speed {
                    most: limit / rate,
                    source: LimitId::joint(Quantity::JointVelocity, j),
                });
            }
        }
    }

    fn axis_speeds(&self, k: usize, h: f64, out: &mut dyn FnMut([f64; 3], f64, LimitId)) {
        for (j, &limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.is_finite()) {
            let (p0, p1) = (self.path.start(k, j)[0], self.path.end(k + 1, j)[0]);
            let middle = 2.0 * self.path.mid(k, h, j)[0] - 0.5 * (p0 + p1);
            out([p0, middle, p1], limit, LimitId::joint(Quantity::JointVelocity, j));
        }
    }
}

/// `|q' u + q'' x| <= a` for every joint (Electronics 2025, 14, 3869, eq. 5).
#[derive(Debug, Clone)]
pub struct JointAcceleration<'a> {
    path: PathDerivatives<'a>,
    limits: &'a [f64],
    /// The row of every joint but for its factors, which are all that changes along the path; empty
    /// if any number of the path or any limit is not finite.
    rows: Vec<Row>,
}

impl<'a> JointAcceleration<'a> {
    /// Limits per joint (rad/s² or m/s²), not negative; infinity means none.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Negative`].
    pub fn new(path: PathDerivatives<'a>, limits: &'a [f64]) -> Result<Self, FeedError> {
        per_axis("joint acceleration limits", &path, limits)?;
        let row = |(j, &limit)| Row::symmetric(0.0, 0.0, limit, LimitId::joint(Quantity::JointAcceleration, j));
        let all_finite = limits.iter().all(|limit| limit.is_finite()) && path.is_finite();
        let rows = if all_finite { limits.iter().enumerate().map(row).collect() } else { Vec::new() };
        Ok(Self { path, limits, rows })
    }

    fn row(&self, j: usize, a: f64, b: f64, out: &mut RowSink<'_>) {
        out.row(Row::symmetric(a, b, self.limits[j], LimitId::joint(Quantity::JointAcceleration, j)));
    }
}

impl PathConstraint for JointAcceleration<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.path.points())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        match place {
            Place::Point(i) => {
                let (first, second) = (self.path.first(i), self.path.second(i));
                if self.rows.is_empty() {
                    first.iter().zip(second).enumerate().for_each(|(j, (&a, &b))| self.row(j, a, b, out));
                } else {
                    let all = self.rows.iter().zip(first.iter().zip(second));
                    out.sound_rows(all.map(|(row, (&a, &b))| Row { a, b, ..*row }));
                }
                let (first_before, second_before) = (self.path.first_before(i), self.path.second_before(i));
                let jumps = first_before.is_some_and(|before| {
                    before.iter().zip(first).zip(self.limits).any(|((p, q), limit)| p != q && limit.is_finite())
                });
                if jumps {
                    out.cap(0.0, LimitId::path(Quantity::Corner));
                } else if let Some(before) = second_before.filter(|before| *before != second) {
                    for (j, (&a, &b)) in first.iter().zip(before).enumerate() {
                        self.row(j, a, b, out);
                    }
                }
            }
            Place::Middle { k, h } => {
                for j in 0..self.path.axes() {
                    let [a, b, _] = self.path.mid(k, h, j);
                    self.row(j, a, b, out);
                }
            }
        }
    }

    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        for (j, &limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.is_finite()) {
            let [a, b, _] = self.path.interval(k, h, j);
            let source = LimitId::joint(Quantity::JointAcceleration, j);
            out.push(IntervalBound::Acceleration { a, b, c: 0.0, rest: 0.0, limit, source });
        }
    }
}

/// `|(q' w + 3 q'' u + q''' x) sdot| <= jerk` for every joint.
#[derive(Debug, Clone, Copy)]
pub struct JointJerk<'a> {
    path: PathDerivatives<'a>,
    limits: &'a [f64],
    /// Part of each limit that rows may use.
    used: f64,
}

impl<'a> JointJerk<'a> {
    /// Limits per joint (rad/s³ or m/s³), above 0; infinity means none.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`], [`FeedError::Negative`], [`FeedError::NotPositive`];
    /// [`FeedError::Empty`] if the path has no third derivatives.
    pub fn new(path: PathDerivatives<'a>, limits: &'a [f64]) -> Result<Self, FeedError> {
        per_axis("joint jerk limits", &path, limits)?;
        if limits.contains(&0.0) {
            return Err(FeedError::NotPositive { what: "joint jerk limits", value: 0.0 });
        }
        if !path.has_third() {
            return Err(FeedError::Empty { what: "third derivatives of the path" });
        }
        Ok(Self { path, limits, used: 1.0 })
    }

    /// Keeps the part `margin` of each limit back in the rows, for what the three places of an
    /// interval do not tell of the rest of it. Bounds over whole intervals need none.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] or [`FeedError::Negative`] for a margin that is not below 1.
    pub fn with_margin(self, margin: f64) -> Result<Self, FeedError> {
        match margin {
            m if !(m >= 0.0) => Err(FeedError::Negative { what: "margin of jerk", value: margin }),
            m if m >= 1.0 => Err(FeedError::AboveLimit { what: "margin of jerk", value: margin, limit: 1.0 }),
            m => Ok(Self { used: 1.0 - m, ..self }),
        }
    }
}

impl PathConstraint for JointJerk<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.path.points())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        // Where the acceleration of a joint would jump, only standing still keeps its jerk, unless the
        // jump is spread over some time.
        let Place::Point(i) = place else { return };
        let jump = |before: Option<&[f64]>, after: &[f64]| {
            before.is_some_and(|before| {
                before.iter().zip(after).zip(self.limits).any(|((p, q), limit)| p != q && limit.is_finite())
            })
        };
        let steps = !self.path.has_steps() && jump(self.path.second_before(i), self.path.second(i));
        if steps || jump(self.path.first_before(i), self.path.first(i)) {
            out.cap(0.0, LimitId::path(Quantity::Corner));
        }
    }

    fn jerk_rows(&self, k: usize, h: f64, within: Within, out: &mut Vec<JerkRow>) {
        for (j, &limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.is_finite()) {
            let [p, s, t] = match within {
                Within::Start => self.path.start(k, j),
                Within::Middle => self.path.mid(k, h, j),
                Within::End => self.path.end(k + 1, j),
            };
            let source = LimitId::joint(Quantity::JointJerk, j);
            let step = self.path.step(k, j);
            out.push(JerkRow { alpha: p, beta: 3.0 * s, gamma: t, step, limit: self.used * limit, source });
        }
    }

    fn interval_bounds(&self, k: usize, h: f64, out: &mut Vec<IntervalBound>) {
        for (j, &limit) in self.limits.iter().enumerate().filter(|(_, limit)| limit.is_finite()) {
            let [alpha, second, gamma] = self.path.interval(k, h, j);
            let (beta, step, source) = (3.0 * second, self.path.step(k, j), LimitId::joint(Quantity::JointJerk, j));
            out.push(IntervalBound::Jerk { alpha, beta, gamma, step, limit, source });
        }
    }
}
