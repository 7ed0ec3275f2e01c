//! A smooth way through joint way-points.

use arcfeed_kinematics::{JointRange, Joints};

use super::jet::JointJet;
use super::motion_path::MotionPath;
use super::way_points::distances;
use crate::error::PathError;
use crate::place::PathParameter;

/// The natural cubic spline through joint way-points, twice continuously differentiable; the parameter runs by the straight distance
/// from one to the next. Two way-points give a straight line.
///
/// ```
/// use arcfeed_interp::{JointSpline, MotionPath};
/// use arcfeed_kinematics::Joints;
/// let spline = JointSpline::through(&[Joints::<2>::new(0.0, 0.0), Joints::<2>::new(3.0, 4.0)])?;
/// assert_eq!(spline.length(), 5.0);
/// let repeated = JointSpline::through(&[Joints::<2>::new(0.0, 1.0), Joints::<2>::new(0.0, 1.0)]);
/// assert!(repeated.unwrap_err().to_string().contains("way-point 2 repeats the one before"));
/// # Ok::<(), arcfeed_interp::PathError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointSpline<const N: usize> {
    knots: Vec<f64>,
    values: Vec<Joints<N>>,
    /// Second derivatives at the knots.
    bends: Vec<Joints<N>>,
}

impl<const N: usize> JointSpline<N> {
    /// Through `points` in their order.
    ///
    /// # Errors
    /// [`PathError::TooFewWaypoints`] for fewer than two; [`PathError::Waypoint`] for one that is not finite or repeats the one
    /// before.
    pub fn through(points: &[Joints<N>]) -> Result<Self, PathError> {
        let knots = distances(points)?;
        let bends = natural(&knots, points);
        Ok(Self { knots, values: points.to_vec(), bends })
    }

    /// The way-points.
    pub fn points(&self) -> &[Joints<N>] {
        &self.values
    }

    /// Checks that every joint stays inside `range` all the way, by the extremes of the spline: it may go beyond the
    /// way-points it joins.
    ///
    /// # Errors
    /// [`PathError::SplineRange`] with the place that misses it most.
    pub fn within(&self, range: &JointRange<N>) -> Result<(), PathError> {
        let mut worst: Option<(f64, PathError)> = None;
        let mut see = |s: f64, joint: usize, value: f64, after: usize| {
            let (lower, upper) = (range.lower()[joint], range.upper()[joint]);
            let excess = (value - upper).max(lower - value);
            if excess > 1e-12 && worst.as_ref().is_none_or(|w| excess > w.0) {
                worst = Some((excess, PathError::SplineRange { s, after, joint, value, lower, upper }));
            }
        };
        for i in 0..self.knots.len() - 1 {
            let h = self.knots[i + 1] - self.knots[i];
            let jet = self.on(i, 0.0);
            for joint in 0..N {
                see(self.knots[i], joint, jet.q[joint], i);
                see(self.knots[i + 1], joint, self.values[i + 1][joint], i);
                // Where d1 + d2 x + d3 x^2 / 2 = 0.
                let (a, b, c) = (0.5 * jet.d3[joint], jet.d2[joint], jet.d1[joint]);
                let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
                let q = -0.5 * (b + root.copysign(b));
                for x in [q / a, c / q].into_iter().filter(|x| *x > 0.0 && *x < h) {
                    see(self.knots[i] + x, joint, self.on(i, x).q[joint], i);
                }
            }
        }
        worst.map_or(Ok(()), |(_, error)| Err(error))
    }

    /// The piece in which `s` lies; at a knot the one after it.
    fn piece(&self, s: f64) -> usize {
        self.knots[1..self.knots.len() - 1].partition_point(|&k| k <= s)
    }

    /// Piece `i` a distance `d` from its start.
    fn on(&self, i: usize, d: f64) -> JointJet<N> {
        let h = self.knots[i + 1] - self.knots[i];
        let (m0, m1) = (self.bends[i], self.bends[i + 1]);
        let d3 = (m1 - m0) / h;
        let slope = (self.values[i + 1] - self.values[i]) / h - (m0 * 2.0 + m1) * (h / 6.0);
        JointJet {
            s: self.knots[i] + d,
            q: self.values[i] + (slope + (m0 / 2.0 + d3 * (d / 6.0)) * d) * d,
            d1: slope + (m0 + d3 * (d / 2.0)) * d,
            d2: m0 + d3 * d,
            d3,
        }
    }
}

/// Second derivatives at the knots of the natural spline: Thomas' algorithm on
/// `h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 (slope[i] - slope[i-1])`.
fn natural<const N: usize>(x: &[f64], y: &[Joints<N>]) -> Vec<Joints<N>> {
    let n = x.len();
    let mut m = vec![Joints::<N>::zeros(); n];
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
        upper[i] = h1 / pivot;
        let jump = (y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0;
        m[i] = (jump * 6.0 - m[i - 1] * h0) / pivot;
    }
    for i in (1..n - 1).rev() {
        let after = m[i + 1];
        m[i] -= after * upper[i];
    }
    m
}

impl<const N: usize> MotionPath<N> for JointSpline<N> {
    fn parameter(&self) -> PathParameter {
        PathParameter::JointDistance
    }

    fn length(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    fn start(&self) -> Joints<N> {
        self.values[0]
    }

    fn knots(&self) -> &[f64] {
        &self.knots[1..self.knots.len() - 1]
    }

    fn jet(&self, s: f64, _near: &Joints<N>) -> Result<JointJet<N>, PathError> {
        let s = s.max(0.0).min(self.length());
        let i = self.piece(s);
        Ok(JointJet { s, ..self.on(i, s - self.knots[i]) })
    }

    fn jet_before(&self, after: &JointJet<N>) -> Result<JointJet<N>, PathError> {
        let i = self.piece(after.s);
        let d3 = if i > 0 && self.knots[i] == after.s { self.on(i - 1, 0.0).d3 } else { after.d3 };
        Ok(JointJet { d3, ..*after })
    }
}
