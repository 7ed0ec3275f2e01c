//! Every limit that a plan was asked to keep, on the polynomials that were made of it.

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::ForwardKinematics;

use super::certified_limit::CertifiedLimit;
use super::error::CompileError;
use super::joint_trajectory::JointTrajectory;
use super::table_certificate::{TableBound, TableCertificate};
use super::tool_certificate::ToolCertificate;
use super::tool_search::ToolBound;
use super::torque_certificate::TorqueBound;
use crate::limits::{Section, TableKind, TorqueLimits};
use crate::place::PathParameter;
use crate::trajectory::Trajectory;
use crate::verify::JointRates;

/// What a compiled motion makes of the limits that its plan was asked to keep: a [`CertifiedLimit`] for each of them.
///
/// Position, velocity, acceleration and jerk of the joints, torque, tables of all three; feed, angular speed, tangential and normal
/// acceleration of the tool, and the magnitudes of its acceleration and jerk. Limits on tangential and normal jerk and on the chord error
/// are those of the plan alone.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionCertificate {
    tool: ToolCertificate,
    feeds: Vec<CertifiedFeed>,
    limits: Vec<CertifiedLimit>,
}

/// A part of a motion with one programmed feed, and what the motion does not exceed there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedFeed {
    /// The time at which the plan comes to this part of the path, s.
    pub from: f64,
    /// The time at which it leaves it, s.
    pub to: f64,
    /// The feed of the section, or that of the limits where no section is.
    pub limit: CertifiedLimit,
}

impl MotionCertificate {
    /// Of `compiled`, made from `plan` for `arm`.
    pub(super) fn of<const N: usize>(
        arm: &dyn ForwardKinematics<N>,
        plan: &Trajectory<'_, N>,
        compiled: &JointTrajectory<N>,
    ) -> Result<Self, CompileError> {
        let tool = compiled.certify_tool(arm);
        let mut limits = of_joints(plan, compiled);
        if let Some(torque) = plan.limits().torque() {
            limits.extend(of_torque(torque, compiled)?);
        }
        limits.extend(of_tables(plan, compiled)?);
        let feeds = feeds(arm, plan, compiled, &tool);
        let by_ratio = |a: &&CertifiedFeed, b: &&CertifiedFeed| a.limit.ratio().total_cmp(&b.limit.ratio());
        limits.extend(feeds.iter().max_by(by_ratio).map(|feed| feed.limit));
        limits.extend(of_tool(plan, &tool));
        limits.extend(of_magnitudes(arm, plan, compiled));
        Ok(Self { tool, feeds, limits })
    }

    /// Bounds on the motion of the tool, limited or not, and on its deviation from the plan.
    pub fn tool(&self) -> &ToolCertificate {
        &self.tool
    }

    /// The programmed feeds in the order of the path: those of its sections, and that of the limits elsewhere.
    pub fn feeds(&self) -> &[CertifiedFeed] {
        &self.feeds
    }

    /// One for each limit that was asked for; of the feeds the one that is used most.
    pub fn limits(&self) -> &[CertifiedLimit] {
        &self.limits
    }

    /// The constant limit `id`.
    pub fn of_limit(&self, id: LimitId) -> Option<&CertifiedLimit> {
        self.limits.iter().find(|limit| limit.table.is_none() && limit.id == id)
    }

    /// The limits that are exceeded by more than `tolerance`, relative.
    pub fn exceeded(&self, tolerance: f64) -> impl Iterator<Item = &CertifiedLimit> {
        self.limits.iter().filter(move |limit| !limit.holds(tolerance))
    }

    /// True where all limits are kept but for `tolerance`, relative.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.exceeded(tolerance).next().is_none()
    }
}

fn of_joints<const N: usize>(plan: &Trajectory<'_, N>, compiled: &JointTrajectory<N>) -> Vec<CertifiedLimit> {
    let joints = plan.limits().joints();
    let certificate = compiled.certify(joints.range(), &JointRates::from(joints));
    let limited = certificate.bounds().iter().filter(|bound| bound.limit != f64::INFINITY);
    limited.map(|bound| CertifiedLimit::from(*bound)).collect()
}

fn of_torque<const N: usize>(
    torque: &TorqueLimits<'_, N>,
    compiled: &JointTrajectory<N>,
) -> Result<Vec<CertifiedLimit>, CompileError> {
    let limits = torque.limits();
    if limits.iter().all(|limit| *limit == f64::INFINITY) {
        return Ok(Vec::new());
    }
    let certificate = compiled.certify_torque(torque.dynamics()).ok_or(CompileError::UnboundedTorque)?;
    let limited = certificate.bounds().iter().filter(|bound| limits[bound.joint] != f64::INFINITY);
    let line = |of: &TorqueBound| CertifiedLimit {
        id: LimitId::joint(Quantity::JointTorque, of.joint),
        table: None,
        attained: of.attained,
        t: of.t,
        bound: of.bound,
        limit: limits[of.joint],
    };
    Ok(limited.map(line).collect())
}

fn of_tables<const N: usize>(
    plan: &Trajectory<'_, N>,
    compiled: &JointTrajectory<N>,
) -> Result<Vec<CertifiedLimit>, CompileError> {
    let Some(tables) = plan.limits().tables() else { return Ok(Vec::new()) };
    let lines = |certificate: &TableCertificate| -> Vec<CertifiedLimit> {
        let line = |of: &TableBound| CertifiedLimit {
            id: LimitId::joint(of.kind.quantity(), of.joint),
            table: Some(of.kind),
            attained: of.attained,
            t: of.t,
            bound: of.bound,
            limit: 1.0,
        };
        certificate.bounds().iter().map(line).collect()
    };
    let mut all = lines(&compiled.certify_tables(tables));
    // Without dynamics there is no torque to limit.
    if let Some(torque) = plan.limits().torque().filter(|_| tables.has(TableKind::TorqueBySpeed)) {
        let certificate = compiled.certify_torque_tables(torque.dynamics(), tables);
        all.extend(lines(&certificate.ok_or(CompileError::UnboundedTorque)?));
    }
    Ok(all)
}

fn of_tool<const N: usize>(plan: &Trajectory<'_, N>, tool: &ToolCertificate) -> Vec<CertifiedLimit> {
    let limits = plan.limits().tool();
    let by_length = |limit: Option<f64>| limit.filter(|_| plan.path().parameter() == PathParameter::ArcLength);
    let all = [
        (Quantity::AngularSpeed, limits.angular_speed()),
        (Quantity::TangentialAcceleration, by_length(limits.tangential_acceleration())),
        (Quantity::NormalAcceleration, by_length(limits.normal_acceleration())),
    ];
    all.into_iter().filter_map(|(quantity, limit)| Some(tool_line(tool.of(quantity)?, limit?))).collect()
}

/// The feeds that are programmed along the path, each with the times between which the plan is there: those of its sections, and the
/// one of the limits elsewhere.
fn feeds<const N: usize>(
    arm: &dyn ForwardKinematics<N>,
    plan: &Trajectory<'_, N>,
    compiled: &JointTrajectory<N>,
    whole: &ToolCertificate,
) -> Vec<CertifiedFeed> {
    // A gap this small between sections is rounding.
    const GAP: f64 = 1e-9;
    let elsewhere = plan.limits().tool().feed();
    let certified = |[from, to]: [f64; 2], bound: &ToolBound, limit: f64| CertifiedFeed {
        from,
        to,
        limit: tool_line(bound, limit),
    };
    if plan.sections().is_empty() {
        let feed = whole.of(Quantity::Feed).zip(elsewhere);
        return feed.map(|(bound, limit)| certified([0.0, compiled.duration()], bound, limit)).into_iter().collect();
    }
    let (length, mut from, mut stretches) = (plan.path().length(), 0.0, Vec::new());
    let end = Section { from: length, to: length, feed: f64::INFINITY };
    for section in plan.sections().iter().chain([&end]) {
        if section.from - from > GAP * length {
            stretches.extend(elsewhere.map(|feed| Section { from, to: section.from, feed }));
        }
        if section.to > section.from {
            stretches.push(*section);
        }
        from = section.to;
    }
    let at = |s: f64| plan.law().time_at_position(s);
    let times: Vec<[f64; 2]> = stretches.iter().map(|section| [at(section.from), at(section.to)]).collect();
    let bounds = compiled.certify_feeds(arm, &times);
    let lines = times.iter().zip(&bounds).zip(&stretches);
    lines.map(|((times, bound), section)| certified(*times, bound, section.feed)).collect()
}

fn of_magnitudes<const N: usize>(
    arm: &dyn ForwardKinematics<N>,
    plan: &Trajectory<'_, N>,
    compiled: &JointTrajectory<N>,
) -> Vec<CertifiedLimit> {
    let limits = plan.limits().tool();
    let limits = [limits.acceleration(), limits.jerk()];
    if limits == [None; 2] {
        return Vec::new();
    }
    let bounds = compiled.certify_tool_magnitudes(arm);
    bounds.iter().zip(limits).filter_map(|(bound, limit)| Some(tool_line(bound, limit?))).collect()
}

fn tool_line(of: &ToolBound, limit: f64) -> CertifiedLimit {
    let ToolBound { quantity, attained, t, bound } = *of;
    CertifiedLimit { id: LimitId::path(quantity), table: None, attained, t, bound, limit }
}
