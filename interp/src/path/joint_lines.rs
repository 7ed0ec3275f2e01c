//! Straight lines between joint way-points, with blends in place of their corners.

use arcfeed_kinematics::Joints;

use super::jet::JointJet;
use super::motion_path::MotionPath;
use super::way_points::distances;
use crate::error::PathError;
use crate::place::PathParameter;

/// Parts of a blend whose borders count as knots, so that every grid sees its bend.
const PARTS: usize = 8;
/// By how much of a line two blends may seem to overlap through rounding.
const OVERLAP: f64 = 1e-12;

/// Straight lines of the joints from way-point to way-point; the parameter runs by their length.
///
/// In place of a corner stands a blend: from a distance `d` before the way-point to `d` after it the direction passes from that of the
/// one line, `u`, to that of the other, `w`, as `u + (w - u) (3 x^2 - 2 x^3)` with `x` from 0 to 1. Direction and second derivative are
/// continuous. The blend stays in the triangle of the way-point and its own ends, so that no joint leaves the range of the way-points.
/// It is nearest to the way-point in its middle, `0.1875 d |w - u|` away. At a way-point without a blend the motion stops.
///
/// ```
/// use arcfeed_interp::{JointLines, MotionPath};
/// use arcfeed_kinematics::Joints;
///
/// let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].map(Joints::<2>::from);
/// let path = JointLines::through(&points, &[0.4])?;
/// assert_eq!(path.length(), 2.0);
/// let middle = path.jet(1.0, &points[1])?.q;
/// assert!(((middle - points[1]).norm() - 0.1875 * 0.4 * 2f64.sqrt()).abs() < 1e-15);
/// // Without a blend the motion stops in the corner.
/// assert_eq!(JointLines::through(&points, &[0.0])?.corners(), [1.0]);
/// # Ok::<(), arcfeed_interp::PathError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointLines<const N: usize> {
    points: Vec<Joints<N>>,
    /// Parameter at each way-point.
    at: Vec<f64>,
    /// Directions of the lines.
    directions: Vec<Joints<N>>,
    /// Half the length of the blend at each way-point, 0 at both ends.
    blends: Vec<f64>,
    knots: Vec<f64>,
    corners: Vec<f64>,
}

impl<const N: usize> JointLines<N> {
    /// Through `points` in their order. `blends` has a number for each way-point between the first and the last: how far before and
    /// after it the blend reaches, rad along the lines; 0 for a stop.
    ///
    /// # Errors
    /// [`PathError::TooFewWaypoints`] for fewer than two; [`PathError::Waypoint`] for one that is not finite or repeats the one before,
    /// and for a blend that is missing, negative, not finite, or overlaps another one.
    pub fn through(points: &[Joints<N>], blends: &[f64]) -> Result<Self, PathError> {
        let at = distances(points)?;
        if blends.len() + 2 != points.len() {
            let problem = format!("{} blends are given, where {} are needed", blends.len(), points.len() - 2);
            return Err(PathError::Waypoint { index: points.len() - 1, problem });
        }
        let mut all = vec![0.0];
        all.extend_from_slice(blends);
        all.push(0.0);
        for index in 1..points.len() {
            let (blend, line) = (all[index], at[index] - at[index - 1]);
            // Not `>`: a NaN has to show.
            let fits = blend >= 0.0 && all[index - 1] + blend <= line * (1.0 + OVERLAP);
            if !fits {
                let index = if index + 1 == points.len() { index - 1 } else { index };
                let problem = format!("has a blend of {} rad, which is negative or meets the next one", all[index]);
                return Err(PathError::Waypoint { index, problem });
            }
        }
        let direction = |i: usize| (points[i + 1] - points[i]) / (at[i + 1] - at[i]);
        let directions = (0..points.len() - 1).map(direction).collect();
        let mut path =
            Self { points: points.to_vec(), at, directions, blends: all, knots: Vec::new(), corners: Vec::new() };
        path.place_knots();
        Ok(path)
    }

    /// The way-points.
    pub fn points(&self) -> &[Joints<N>] {
        &self.points
    }

    /// Value of the parameter at each way-point; in the middle of a blend the path is nearest to it.
    pub fn parameters(&self) -> &[f64] {
        &self.at
    }

    fn place_knots(&mut self) {
        let inner = 1..self.points.len() - 1;
        for i in inner {
            let (at, blend) = (self.at[i], self.blends[i]);
            if blend == 0.0 {
                self.corners.push(at);
                self.knots.push(at);
                continue;
            }
            let border = |k: usize| at - blend + 2.0 * blend * (k as f64 / PARTS as f64);
            self.knots.extend((0..=PARTS).map(border));
        }
        // Blends may meet, and a blend may reach to the end of the path.
        let length = self.at[self.at.len() - 1];
        let same = 1e-9 * length;
        self.knots.retain(|&s| s > same && s < length - same);
        self.knots.dedup_by(|later, earlier| *later - *earlier <= same);
    }

    /// The jet at `s`; `before` chooses the piece that ends there where one does.
    fn on(&self, s: f64, before: bool) -> JointJet<N> {
        let last = self.directions.len() - 1;
        let past = |border: f64| if before { border < s } else { border <= s };
        // The line whose end lies ahead.
        let line = self.at[1..=last].partition_point(|&end| past(end));
        let inside = |i: &usize| {
            let (at, d) = (self.at[*i], self.blends[*i]);
            d > 0.0 && past(at - d) && !past(at + d)
        };
        let Some(near) = [line, line + 1].into_iter().find(inside) else {
            let (u, zero) = (self.directions[line], Joints::zeros());
            return JointJet { s, q: self.points[line] + u * (s - self.at[line]), d1: u, d2: zero, d3: zero };
        };
        let (at, d, u) = (self.at[near], self.blends[near], self.directions[near - 1]);
        let turn = self.directions[near] - u;
        let x = (s - at + d) / (2.0 * d);
        JointJet {
            s,
            q: self.points[near] + u * (s - at) + turn * (2.0 * d * x * x * x * (1.0 - 0.5 * x)),
            d1: u + turn * (x * x * (3.0 - 2.0 * x)),
            d2: turn * (6.0 * x * (1.0 - x) / (2.0 * d)),
            d3: turn * ((6.0 - 12.0 * x) / (4.0 * d * d)),
        }
    }
}

impl<const N: usize> MotionPath<N> for JointLines<N> {
    fn parameter(&self) -> PathParameter {
        PathParameter::JointDistance
    }

    fn length(&self) -> f64 {
        self.at[self.at.len() - 1]
    }

    fn start(&self) -> Joints<N> {
        self.points[0]
    }

    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn jet(&self, s: f64, _near: &Joints<N>) -> Result<JointJet<N>, PathError> {
        Ok(self.on(s.max(0.0).min(self.length()), false))
    }

    fn jet_before(&self, after: &JointJet<N>) -> Result<JointJet<N>, PathError> {
        Ok(self.on(after.s.max(0.0).min(self.length()), true))
    }
}
