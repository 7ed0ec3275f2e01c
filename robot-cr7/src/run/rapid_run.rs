//! Consecutive rapid moves of a program, as the joints make them.

use std::sync::Arc;

use arcfeed_interp::{
    CompileError, CompiledPlan, JointLines, JointTrajectory, MotionCertificate, MotionPath, PathArm, PlanError,
};
use arcfeed_kinematics::{Joints, KinematicsError};
use nalgebra::{Isometry3, Vector3};

use super::joint_move::{JointMove, Leaves, Passed};
use super::task::Task;

/// Distance (m) and angle (rad) from one place to the next at which the inverse is asked along a line.
const STRIDE: [f64; 2] = [0.01, 0.05];
/// Most of such places on one line.
const MOST_STRIDES: f64 = 200.0;
/// Joints closer than this are the same, rad.
pub(crate) const SAME: f64 = 1e-9;
/// A joint that is further than this from where the line leads it is in another configuration, rad.
const ANOTHER: f64 = 0.1;
/// A joint that moves further from one such place to the next changes the configuration, rad.
const JUMP: f64 = 1.0;
/// A blend takes this part of the shorter line beside it at most.
const OF_LINE: f64 = 0.5;
/// The middle of a blend is so far from its way-point, times its half length and the change of the direction.
const MIDDLE: f64 = 0.1875;
/// A blend shorter than this is a stop, rad.
const SHORTEST: f64 = 1e-6;
/// Rounds in which a blend is made short enough; two do, unless the tool is near a singular pose.
const ROUNDS: usize = 60;
/// Places on each line at which the tool is compared with it.
const LOOKS: usize = 400;

/// Consecutive rapid moves of a program, with the poses of the tool in the base.
#[derive(Debug, Clone)]
pub(crate) struct RapidRun {
    /// The pose in which the run starts.
    pub start: Isometry3<f64>,
    pub ends: Vec<RapidEnd>,
    /// How high it is above both ends of the rapid moves, m.
    pub lift: f64,
    /// Distance within which ends are passed, m.
    pub blend: f64,
}

/// The end of a rapid move.
#[derive(Debug, Clone)]
pub(crate) struct RapidEnd {
    pub line: usize,
    pub number: Option<u32>,
    pub pose: Isometry3<f64>,
    /// The tool stops there.
    pub stop: bool,
}

/// The joints that a run leads through, from rest to rest.
#[derive(Debug, Clone)]
pub(crate) struct WayPoints<const N: usize> {
    /// At the start, then at the end of each move.
    pub joints: Vec<Joints<N>>,
    /// The joints at the end are not those to which the moves lead, but another configuration.
    pub reconfigured: bool,
}

/// Polynomials of a motion, and what they make of its limits.
type Compiled<const N: usize> = (JointTrajectory<N>, MotionCertificate);

impl RapidRun {
    /// A change of the joints at one place, before a line of the file.
    pub fn turn(pose: Isometry3<f64>, line: usize) -> Self {
        let ends = vec![RapidEnd { line, number: None, pose, stop: false }];
        Self { start: pose, ends, lift: 0.0, blend: 0.0 }
    }

    /// The first and the last line.
    pub fn lines(&self) -> [usize; 2] {
        [self.ends.first(), self.ends.last()].map(|end| end.map_or(0, |end| end.line))
    }

    /// The joints at the end of each move, near those before; or the move whose end cannot be reached.
    pub fn way_points<const N: usize>(
        &self,
        arm: &dyn PathArm<N>,
        from: &Joints<N>,
    ) -> Result<WayPoints<N>, (usize, KinematicsError)> {
        let (mut joints, mut before) = (vec![*from], &self.start);
        let (mut near, mut reconfigured) = (*from, false);
        for (i, end) in self.ends.iter().enumerate() {
            let (there, jumps) = along_line(arm, [before, &end.pose], &near).map_err(|error| (i, error))?;
            joints.push(there);
            (near, before) = (there, &end.pose);
            reconfigured |= jumps;
        }
        Ok(WayPoints { joints, reconfigured })
    }

    /// The motion through the way-points; `None` where the joints do not move. With a tolerance (rad) as polynomials too, with what these
    /// make of the limits.
    pub fn plan<'t, A: PathArm<N>, const N: usize>(
        &self,
        task: &'t Task<A, N>,
        way: &WayPoints<N>,
        tolerance: Option<f64>,
    ) -> Result<Option<(JointMove<'t, N>, Option<Compiled<N>>)>, CompileError> {
        let Some((path, place)) = self.joint_lines(task.arm(), &way.joints)? else { return Ok(None) };
        let at: Vec<f64> = place.iter().map(|&i| path.parameters()[i]).collect();
        let seen = self.look(task.arm(), &path, &at)?;
        let (planner, path) = (task.joint_planner()?, Arc::new(path));
        let (trajectory, pieces) = match tolerance {
            None => (planner.plan_shared(path)?, None),
            Some(tolerance) => {
                let CompiledPlan { trajectory, compiled, certificate } = planner.plan_compiled(path, tolerance)?;
                (trajectory, Some((compiled, certificate)))
            }
        };
        let ends = self.ends.iter().zip(&seen.nearest).zip(&at[1..]);
        let passed = ends.map(|((end, &distance), &parameter)| Passed {
            line: end.line,
            number: end.number,
            distance_m: distance,
            parameter,
        });
        let motion = JointMove {
            trajectory,
            passed: passed.collect(),
            leaves: seen.leaves,
            lift_m: self.lift,
            reconfigured: way.reconfigured,
            way: seen.way,
        };
        Ok(Some((motion, pieces)))
    }

    /// The lines of the joints, and which of their way-points each one of `joints` is.
    fn joint_lines<const N: usize>(
        &self,
        arm: &dyn PathArm<N>,
        joints: &[Joints<N>],
    ) -> Result<Option<(JointLines<N>, Vec<usize>)>, PlanError> {
        let mut points: Vec<Joints<N>> = Vec::with_capacity(joints.len());
        let mut place = Vec::with_capacity(joints.len());
        // The end of the move that each way-point is; the start has none.
        let mut ends: Vec<Option<&RapidEnd>> = Vec::with_capacity(joints.len());
        for (i, q) in joints.iter().enumerate() {
            if points.last().is_none_or(|last| (q - last).norm() > SAME) {
                points.push(*q);
                ends.push(i.checked_sub(1).and_then(|end| self.ends.get(end)));
            }
            place.push(points.len() - 1);
        }
        if points.len() < 2 {
            return Ok(None);
        }
        let blend = |i: usize| match ends[i] {
            Some(end) if !end.stop => self.blend_at(arm, [&points[i - 1], &points[i], &points[i + 1]], &end.pose),
            _ => 0.0,
        };
        let blends: Vec<f64> = (1..points.len() - 1).map(blend).collect();
        Ok(Some((JointLines::through(&points, &blends)?, place)))
    }

    /// Half the length of the blend at the second of three way-points, rad: as long as the tool passes its pose within the blend distance.
    fn blend_at<const N: usize>(&self, arm: &dyn PathArm<N>, [a, b, c]: [&Joints<N>; 3], pose: &Isometry3<f64>) -> f64 {
        let (before, after) = (b - a, c - b);
        let turn = after.normalize() - before.normalize();
        let mut half = OF_LINE * before.norm().min(after.norm());
        for _ in 0..ROUNDS {
            let middle = arm.forward(&(b + turn * (MIDDLE * half)));
            let off = (middle.translation.vector - pose.translation.vector).norm();
            if off <= self.blend {
                return if half >= SHORTEST { half } else { 0.0 };
            }
            half *= (0.99 * self.blend / off).min(0.9);
        }
        0.0
    }

    /// The tool along the lines of the joints, whose way-points are at `at`.
    fn look<const N: usize>(&self, arm: &dyn PathArm<N>, path: &JointLines<N>, at: &[f64]) -> Result<Seen, PlanError> {
        let corners = self.corners();
        let tool = |s: f64| -> Result<Vector3<f64>, PlanError> {
            Ok(arm.forward(&path.jet(s, &Joints::zeros())?.q).translation.vector)
        };
        let mut nearest = vec![f64::INFINITY; self.ends.len()];
        let mut way = vec![(0.0, 0.0)];
        let mut last = tool(0.0)?;
        // Where the tool is farthest from its lines: distance, line, and the places before and after it.
        let mut farthest = (0.0, 0, [0.0; 2]);
        for i in 0..self.ends.len() {
            let (from, to) = (at[i], at[i + 1]);
            let mut places: Vec<f64> = (0..=LOOKS).map(|k| from + (to - from) * (k as f64 / LOOKS as f64)).collect();
            places.extend(path.knots().iter().copied().filter(|s| (from..=to).contains(s)));
            places.sort_by(f64::total_cmp);
            for (k, &s) in places.iter().enumerate() {
                let point = tool(s)?;
                let off = off_lines(&point, &corners, i);
                if off > farthest.0 {
                    farthest = (off, i, [places[k.saturating_sub(1)], places[(k + 1).min(places.len() - 1)]]);
                }
                for k in i.saturating_sub(1)..=i {
                    nearest[k] = nearest[k].min((point - corners[k + 1]).norm());
                }
                let (_, travelled) = way[way.len() - 1];
                way.push((s, travelled + (point - last).norm()));
                last = point;
            }
        }
        let (mut distance_m, i, [from, to]) = farthest;
        for k in 0..=LOOKS {
            let point = tool(from + (to - from) * (k as f64 / LOOKS as f64))?;
            distance_m = distance_m.max(off_lines(&point, &corners, i));
        }
        let leaves = Leaves { distance_m, line: self.ends.get(i).map_or(0, |end| end.line) };
        Ok(Seen { nearest, leaves, way })
    }

    /// The tool points between the lines of the program, m.
    fn corners(&self) -> Vec<Vector3<f64>> {
        let poses = std::iter::once(&self.start).chain(self.ends.iter().map(|end| &end.pose));
        poses.map(|pose| pose.translation.vector).collect()
    }
}

/// What the tool does along a joint move.
struct Seen {
    /// Distance at which each end is passed, m.
    nearest: Vec<f64>,
    leaves: Leaves,
    /// Parameter of the path, and the way of the tool up to it, m.
    way: Vec<(f64, f64)>,
}

impl<const N: usize> WayPoints<N> {
    /// Ends in `joints` instead.
    pub fn ending_in(mut self, joints: Joints<N>) -> Self {
        if let Some(last) = self.joints.last_mut() {
            self.reconfigured |= (joints - *last).amax() > ANOTHER;
            *last = joints;
        }
        self
    }

    /// The joints at the end.
    pub fn end(&self) -> &Joints<N> {
        &self.joints[self.joints.len() - 1]
    }
}

/// The joints at the end of a line, followed along it so far as the arm can, so that the configuration stays the same; and whether it
/// does not.
fn along_line<const N: usize>(
    arm: &dyn PathArm<N>,
    [from, to]: [&Isometry3<f64>; 2],
    near: &Joints<N>,
) -> Result<(Joints<N>, bool), KinematicsError> {
    let distance = (to.translation.vector - from.translation.vector).norm();
    let angle = from.rotation.angle_to(&to.rotation);
    let strides = (distance / STRIDE[0]).max(angle / STRIDE[1]).ceil().clamp(1.0, MOST_STRIDES) as usize;
    let (mut near, mut jumps) = (*near, false);
    let mut step = |pose: &Isometry3<f64>, near: &mut Joints<N>| {
        let joints = arm.inverse(pose, near)?;
        jumps |= (joints - *near).amax() > JUMP;
        *near = joints;
        Ok(())
    };
    for k in 1..strides {
        if let Some(between) = from.try_lerp_slerp(to, k as f64 / strides as f64, 1e-9) {
            // The line may lead out of reach, where the joints do not.
            let _: Result<(), KinematicsError> = step(&between, &mut near);
        }
    }
    step(to, &mut near)?;
    Ok((near, jumps))
}

/// Distance of a point from line `i` of those between `corners`, or from the one before or after it: in a blend the tool is between
/// two of them.
fn off_lines(point: &Vector3<f64>, corners: &[Vector3<f64>], i: usize) -> f64 {
    let beside = i.saturating_sub(1)..(i + 2).min(corners.len() - 1);
    beside.map(|k| off_line(point, [&corners[k], &corners[k + 1]])).fold(f64::INFINITY, f64::min)
}

/// Distance of a point from the straight line between two others, m.
fn off_line(point: &Vector3<f64>, [from, to]: [&Vector3<f64>; 2]) -> f64 {
    let (along, off) = (to - from, point - from);
    let length = along.norm_squared();
    let part = if length > 0.0 { (off.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (off - along * part).norm()
}
