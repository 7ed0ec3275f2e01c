//! A schedule held against its limits on dense samples, and where each limit binds.

use arcfeed_feedrate::{Quantity, RowSource};
use arcfeed_kinematics::Joints;

use super::plan::{Schedule, creeping, setpoint};
use super::{ScheduleLimits, SchedulePath};
use crate::error::PlanError;
use crate::limits::positive;
use crate::trajectory::Setpoint;

/// A limit binds where it is used to this part at the least.
const BINDS: f64 = 1.0 - 1e-3;
/// A sample this near to the end of an interval (in parts of it) counts as lying on the grid point.
const AT_POINT: f64 = 1e-9;

/// How far a motion uses one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitUse {
    /// Which limit.
    pub source: RowSource,
    /// The limit, in its own unit.
    pub limit: f64,
    /// Value at the worst place, with its sign.
    pub value: f64,
    /// Magnitude of the value over the limit: above 1 the limit is broken.
    pub ratio: f64,
    /// Value of the parameter there.
    pub s: f64,
    /// Time there, s.
    pub t: f64,
    /// The worst ratio at the grid points alone, from either side.
    pub ratio_at_points: f64,
}

/// Where one limit binds: uses 99.9 % of its bound or more.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Which limit.
    pub source: RowSource,
    /// From where to where, by the parameter, increasing.
    pub intervals: Vec<(f64, f64)>,
}

impl Binding {
    /// Length of all its intervals, in units of the parameter.
    pub fn length(&self) -> f64 {
        self.intervals.iter().map(|(a, b)| b - a).sum()
    }
}

/// What dense samples of a schedule show.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduleCheck {
    /// Every finite limit, joint by joint.
    pub uses: Vec<LimitUse>,
    /// The limits that bind somewhere, in the same order.
    pub bindings: Vec<Binding>,
    /// Number of samples looked at.
    pub samples: usize,
}

impl ScheduleCheck {
    /// The limit that is used most.
    pub fn worst(&self) -> Option<&LimitUse> {
        self.uses.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// The largest part of a limit that is used; above 1 one is broken.
    pub fn worst_ratio(&self) -> f64 {
        self.worst().map_or(0.0, |worst| worst.ratio)
    }

    /// The use of one limit.
    pub fn of(&self, source: RowSource) -> Option<&LimitUse> {
        self.uses.iter().find(|u| u.source == source)
    }

    /// Where one limit binds; empty where it does not.
    pub fn binding(&self, source: RowSource) -> &[(f64, f64)] {
        self.bindings.iter().find(|b| b.source == source).map_or(&[], |b| &b.intervals)
    }
}

/// One limit that is watched, and the value it is on.
struct Watched {
    used: LimitUse,
    intervals: Vec<(f64, f64)>,
}

/// The values that limits are on, at one sample.
struct Values<'v, const N: usize> {
    at: &'v Setpoint<N>,
    torque: Joints<N>,
    linear: f64,
    angular: f64,
}

impl<const N: usize> Values<'_, N> {
    fn of(&self, source: RowSource) -> f64 {
        let j = usize::from(source.joint.unwrap_or(0));
        match source.quantity {
            Quantity::JointVelocity => self.at.qd[j],
            Quantity::JointAcceleration => self.at.qdd[j],
            Quantity::JointJerk => self.at.jerk[j],
            Quantity::JointTorque => self.torque[j],
            Quantity::LinearSpeed => self.linear,
            _ => self.angular,
        }
    }
}

impl<P: SchedulePath<N> + ?Sized, const N: usize> Schedule<'_, P, N> {
    /// Samples the motion `per_interval` times in every interval of its grid, from just after one grid point to just before the
    /// next, and holds joints, torques and tool against the limits: by the path and the arm's dynamics and Jacobian,
    /// not by the rows of the plan. Jerk is looked at if the planner limits it; otherwise it has no bound where the acceleration
    /// steps.
    ///
    /// # Errors
    /// [`PlanError::Limit`] for no samples, [`PlanError::OnPath`].
    pub fn check(&self, per_interval: usize) -> Result<ScheduleCheck, PlanError> {
        positive("samples per interval", per_interval as f64)?;
        let jerk_limited = self.problem().has_jerk();
        let mut watched: Vec<Watched> = sources(self.limits(), jerk_limited)
            .map(|(source, limit)| Watched {
                used: LimitUse { source, limit, value: 0.0, ratio: 0.0, s: 0.0, t: 0.0, ratio_at_points: 0.0 },
                intervals: Vec::new(),
            })
            .collect();
        let (torques, tool) = (
            self.limits().torque.and(self.dynamics()),
            self.limits().linear_speed.is_some() || self.limits().angular_speed.is_some(),
        );
        let mut cursor = self.law().cursor();
        let mut last = self.nodes()[0];
        let knots: Vec<(f64, f64)> = self.law().knots().map(|(t, state)| (t, state.p)).collect();
        let mut samples = 0;
        for (k, &(t0, s0)) in knots.iter().enumerate() {
            let (t1, s1) = knots.get(k + 1).copied().unwrap_or((self.duration(), self.law().end().p));
            for i in 0..=per_interval {
                let at_point = i == 0 || i == per_interval;
                let share = (i as f64 / per_interval as f64).clamp(AT_POINT, 1.0 - AT_POINT);
                let t = t0 + share * (t1 - t0);
                let state = cursor.at(t);
                let jet = self.path().jet(state.p, &last.ahead(state.p - last.s))?;
                last = jet;
                let at = setpoint(t, &state, &jet, self.arm());
                let twist = if tool { self.arm().jacobian(&at.q) * at.qd } else { Default::default() };
                // At a stop friction is that of the motion: the limit of what comes before or after it.
                let qd = if state.v > 0.0 { at.qd } else { creeping(&jet.d1) };
                // Not the place a hair beside an end, but the end.
                let s = if i == 0 && k == 0 {
                    s0
                } else if i == per_interval && k + 1 == knots.len() {
                    s1
                } else {
                    state.p
                };
                let values = Values {
                    at: &at,
                    torque: torques.map_or(Joints::zeros(), |d| d.torque(&at.q, &qd, &at.qdd)),
                    linear: twist.fixed_rows::<3>(0).norm(),
                    angular: twist.fixed_rows::<3>(3).norm(),
                };
                samples += 1;
                for one in &mut watched {
                    // Gaps of an interval or two are the grid's, not the limit's.
                    one.see(values.of(one.used.source), (s, t), at_point, 1.6 * (s1 - s0));
                }
            }
        }
        let bindings = watched
            .iter()
            .filter(|one| !one.intervals.is_empty())
            .map(|one| Binding { source: one.used.source, intervals: one.intervals.clone() })
            .collect();
        Ok(ScheduleCheck { uses: watched.into_iter().map(|one| one.used).collect(), bindings, samples })
    }
}

impl Watched {
    fn see(&mut self, value: f64, (s, t): (f64, f64), at_point: bool, gap: f64) {
        let used = &mut self.used;
        let ratio = value.abs() / used.limit;
        // A NaN, once seen, stays.
        if !used.ratio.is_nan() && (ratio > used.ratio || ratio.is_nan()) {
            (used.value, used.ratio, used.s, used.t) = (value, ratio, s, t);
        }
        if at_point && (ratio > used.ratio_at_points || ratio.is_nan()) {
            used.ratio_at_points = ratio;
        }
        if ratio >= BINDS {
            match self.intervals.last_mut() {
                Some(last) if s - last.1 <= gap => last.1 = s,
                _ => self.intervals.push((s, s)),
            }
        }
    }
}

/// Every finite limit with its source.
fn sources<const N: usize>(limits: &ScheduleLimits<N>, jerk: bool) -> impl Iterator<Item = (RowSource, f64)> {
    let joints = [
        (Quantity::JointVelocity, limits.velocity),
        (Quantity::JointAcceleration, limits.acceleration),
        (Quantity::JointTorque, limits.torque),
        (Quantity::JointJerk, limits.jerk.filter(|_| jerk)),
    ];
    let tool = [(Quantity::LinearSpeed, limits.linear_speed), (Quantity::AngularSpeed, limits.angular_speed)];
    let of_joints = joints.into_iter().flat_map(|(quantity, limits)| {
        limits.into_iter().flat_map(move |l| (0..N).map(move |j| (RowSource::joint(quantity, j), l[j])))
    });
    let of_tool = tool.into_iter().filter_map(|(quantity, limit)| Some((RowSource::path(quantity), limit?)));
    of_joints.chain(of_tool).filter(|(_, limit)| limit.is_finite())
}
