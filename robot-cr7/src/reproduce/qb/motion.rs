//! One motion of Huang et al. 2025, planned and sampled, and judged from the joint positions of its
//! samples.

use arcfeed_feedrate::{FeedPlanner, FeedProblem, SpeedLaw};
use arcfeed_interp::{Limits, Method, PathProblem, Planner, PoseMove, Setpoint};
use arcfeed_kinematics::{Arm, JointLimits, Joints};
use nalgebra::{Isometry3, Translation3};

use super::data::{QbError, Way};
use super::lagrange::Links;
use super::published::PublishedScan;
use super::scan::ScanRun;
use crate::input::toml_check::rotation;
use crate::reproduce::Reproduction;
use crate::reproduce::spline::off_segment;

/// The grid of the plans whose places are compared: fine enough for three digits.
pub(super) const FINE: usize = 500;
/// What may be left between the grid points of a certified plan at 500 intervals: the inverse
/// kinematics is no polynomial, and the error of its interpolation falls with the third power of
/// the interval.
const BETWEEN: f64 = 1e-5;
/// Error of the torque from differences, as a share of the limit: the mean over 4 ms moves by this
/// much where the acceleration jumps.
const TORQUE: f64 = 5e-3;

/// A motion of the paper, ready to be planned by any planner.
pub(super) struct Case<'a> {
    pub(super) path: PoseMove<'a>,
    pub(super) planner: Planner<'a>,
}

impl<'a> Case<'a> {
    pub(super) fn new(
        arm: &'a Arm<6>,
        way: &Way,
        joints: JointLimits<6>,
        torque: Option<Joints<6>>,
    ) -> Result<Self, QbError> {
        let path = PoseMove::starting_near(arm, way.motion()?, &Joints::from(way.near_rad))?;
        let mut limits = Limits::new(joints);
        if let Some((dynamics, torque)) = arm.dynamics().zip(torque) {
            limits = limits.with_torque(dynamics, torque)?;
        }
        Ok(Self { path, planner: Planner::new(arm, limits) })
    }

    /// Problem, rows and law of one planner on one grid.
    pub(super) fn plan(
        &self,
        method: Method,
        intervals: usize,
    ) -> Result<(PathProblem<'_>, FeedProblem, SpeedLaw), QbError> {
        self.plan_with(&method, method, intervals)
    }

    /// The same by the published scan.
    pub(super) fn published(&self, intervals: usize) -> Result<(PathProblem<'_>, FeedProblem, SpeedLaw), QbError> {
        self.plan_with(&PublishedScan, Method::ForwardBackward, intervals)
    }

    fn plan_with(
        &self,
        by: &dyn FeedPlanner,
        like: Method,
        intervals: usize,
    ) -> Result<(PathProblem<'_>, FeedProblem, SpeedLaw), QbError> {
        let planner = self.planner.clone().with_intervals(intervals)?;
        let problem = planner.prepare(&self.path, like.needs())?;
        let rows = problem.rows(like.needs())?;
        let law = by.plan(&rows)?;
        Ok((problem, rows, law))
    }
}

/// A planned motion by its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseRun {
    /// Time between samples, s.
    pub period: f64,
    /// Path parameter of each sample, m or rad.
    pub s: Vec<f64>,
    /// Joint positions, rad.
    pub q: Vec<Joints<6>>,
    /// Torques by the library's dynamics, N m; empty where they are not limited.
    pub torque: Vec<Joints<6>>,
    /// Limits: velocity, acceleration, and torque where it is limited.
    pub limits: (Joints<6>, Joints<6>, Option<Joints<6>>),
    /// Limit of the jerk, rad/s^3, where there is one.
    pub jerk: Option<f64>,
    /// The links.
    pub links: Links,
    /// Printed start and goal: position in m, Euler angles in degrees.
    pub poses: [[f64; 6]; 2],
    /// Duration, s.
    pub duration: f64,
}

/// Largest shares of the limits, from positions alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shares {
    /// First differences.
    pub velocity: f64,
    /// Second differences.
    pub acceleration: f64,
    /// Third differences.
    pub jerk: f64,
    /// Lagrange's equation.
    pub torque: f64,
    /// Largest difference between that and the library's torque, as a share of the limit.
    pub difference: f64,
}

pub(super) fn pose_of(p: &[f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(p[0], p[1], p[2]), rotation([p[3], p[4], p[5]]))
}

impl PoseRun {
    pub(super) fn sampled(
        arm: &Arm<6>,
        way: &Way,
        problem: &PathProblem<'_>,
        law: &SpeedLaw,
        period: f64,
    ) -> Result<Self, QbError> {
        let points: Vec<Setpoint> = problem.setpoints(law, period)?.collect::<Result<_, _>>()?;
        // The last cycle is shorter than the others, so its end is left out of the differences.
        let whole = points.iter().enumerate().take_while(|(i, p)| (p.t - period * *i as f64).abs() < 1e-9).count();
        let points = &points[..whole];
        let limits = problem.limits();
        let torque = limits.torque().map(|torque| *torque.limits());
        Ok(Self {
            period,
            s: points.iter().map(|p| p.s).collect(),
            q: points.iter().map(|p| p.q).collect(),
            torque: points.iter().filter_map(|p| problem.torque_at(p)).collect(),
            limits: (*limits.joints().velocity(), *limits.joints().acceleration(), torque),
            jerk: None,
            links: Links::new(arm).ok_or(QbError::StandIn)?,
            poses: [way.start, way.goal],
            duration: arcfeed_feedrate::MotionLaw::duration(law),
        })
    }

    /// Shares of the limits; torque at every `stride`-th sample.
    pub fn shares(&self, stride: usize) -> Shares {
        let (q, h) = (&self.q, self.period);
        let share = |x: Joints<6>, limit: &Joints<6>| x.component_div(limit).amax();
        let mut most = Shares::default();
        for w in q.windows(2) {
            most.velocity = most.velocity.max(share((w[1] - w[0]) / h, &self.limits.0));
        }
        for w in q.windows(3) {
            most.acceleration = most.acceleration.max(share((w[2] - w[1] * 2.0 + w[0]) / (h * h), &self.limits.1));
        }
        if let Some(limit) = self.jerk {
            for w in q.windows(4) {
                let jerk = (w[3] - w[2] * 3.0 + w[1] * 3.0 - w[0]) / h.powi(3);
                most.jerk = most.jerk.max(jerk.amax() / limit);
            }
        }
        let Some(limit) = self.limits.2 else { return most };
        // Near rest the direction of Coulomb friction is lost in the rounding of differences.
        for i in (8..q.len().saturating_sub(8)).step_by(stride) {
            let torque = self.links.torque(&[q[i - 2], q[i - 1], q[i], q[i + 1], q[i + 2]], h);
            most.torque = most.torque.max(share(torque, &limit));
            if let Some(own) = self.torque.get(i) {
                let off = (torque - own).component_div(&limit).abs();
                // A joint that stands has no direction of friction.
                let stands = (q[i + 1] - q[i - 1]) / (2.0 * h);
                let off = off.zip_map(&stands, |off, v| if v.abs() < 1e-6 { 0.0 } else { off });
                most.difference = most.difference.max(off.amax());
            }
        }
        most
    }

    /// Adds the rows that every motion has.
    pub fn judge(&self, r: &mut Reproduction, place: &str, name: &str) {
        let shares = self.shares(5);
        let row = |r: &mut Reproduction, what: &str, share: f64, slack: f64| {
            r.independent(place, format!("{name}: {what}"), "at most 1", format!("{share:.6}"), share <= 1.0 + slack);
        };
        row(r, "velocity by differences / limit", shares.velocity, BETWEEN);
        row(r, "acceleration by differences / limit", shares.acceleration, BETWEEN);
        if self.jerk.is_some() {
            row(r, "jerk by differences / limit", shares.jerk, BETWEEN);
        }
        if self.limits.2.is_some() {
            row(r, "torque by Lagrange's equation / limit", shares.torque, TORQUE);
        }
        let (first, last) = (self.links.tool(&self.q[0]), self.links.tool(&self.q[self.q.len() - 1]));
        let [start, goal] = self.poses.map(|p| pose_of(&p));
        let off = |a: &Isometry3<f64>, b: &Isometry3<f64>| {
            (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
        };
        let error = off(&first, &start);
        r.independent(place, format!("{name}: tool off the printed start"), "0", format!("{error:.1e}"), error < 1e-9);
        // Less than a cycle is left after the last whole one, and the motion ends at rest.
        let (error, v) = (off(&last, &goal), 1e-2);
        let near = error < v * self.period;
        r.independent(place, format!("{name}: tool off the printed goal"), "0", format!("{error:.1e}"), near);
        let line = self.q.iter().step_by(10).map(|q| {
            off_segment(&self.links.tool(q).translation.vector, &start.translation.vector, &goal.translation.vector)
        });
        let line = line.fold(0.0, f64::max);
        r.independent(place, format!("{name}: tool off its line, m"), "0", format!("{line:.1e}"), line < 1e-9);
        let back = self.s.windows(2).filter(|w| w[1] < w[0]).count();
        r.independent(place, format!("{name}: cycles that go back"), "0", back.to_string(), back == 0);
        r.information(place, format!("{name}: duration, s"), "", format!("{:.4}", self.duration));
    }

    /// First and last parameter at which a joint has at least 99.9 % of its velocity limit.
    pub fn velocity_binds(&self, joint: usize) -> Option<(f64, f64)> {
        let limit = self.limits.0[joint];
        let at = |w: &[Joints<6>]| ((w[1][joint] - w[0][joint]) / self.period).abs() >= 0.999 * limit;
        let places: Vec<usize> = self.q.windows(2).enumerate().filter(|(_, w)| at(w)).map(|(i, _)| i).collect();
        Some((self.s[*places.first()?], self.s[*places.last()? + 1]))
    }

    /// Share of the samples before `from` and after `to` at which a joint has at least 99 % of its
    /// acceleration limit.
    pub fn acceleration_binds(&self, joint: usize, (from, to): (f64, f64)) -> f64 {
        let (limit, h) = (self.limits.1[joint], self.period);
        let outside = (1..self.q.len() - 1).filter(|&i| self.s[i + 1] < from || self.s[i - 1] > to);
        let at = |i: &usize| {
            let a = (self.q[i + 1][joint] - 2.0 * self.q[*i][joint] + self.q[i - 1][joint]) / (h * h);
            a.abs() >= 0.99 * limit
        };
        let all = outside.clone().count();
        outside.filter(at).count() as f64 / all.max(1) as f64
    }
}

/// Largest difference between the scan of the paper, written a second time, and the library's
/// speeds, as a share of the highest speed.
pub fn scan_difference(scan: &ScanRun, speeds: &[f64]) -> f64 {
    let most = speeds.iter().copied().fold(0.0, f64::max);
    let off = speeds.iter().enumerate().map(|(i, v)| (scan.speed(i) - v).abs() / most);
    off.fold(if speeds.len() == scan.s.len() { 0.0 } else { f64::INFINITY }, f64::max)
}
