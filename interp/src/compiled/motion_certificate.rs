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
/// acceleration of the tool, and the magnitudes of its acceleration and jerk. Limits on tangential and normal jerk, on the chord error and
/// feeds of single sections are those of the plan alone.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionCertificate {
    tool: ToolCertificate,
    limits: Vec<CertifiedLimit>,
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
        limits.extend(of_tool(plan, &tool));
        limits.extend(of_magnitudes(arm, plan, compiled));
        Ok(Self { tool, limits })
    }

    /// Bounds on the motion of the tool, limited or not, and on its deviation from the plan.
    pub fn tool(&self) -> &ToolCertificate {
        &self.tool
    }

    /// One for each limit that was asked for.
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
        (Quantity::Feed, highest_feed(plan)),
        (Quantity::AngularSpeed, limits.angular_speed()),
        (Quantity::TangentialAcceleration, by_length(limits.tangential_acceleration())),
        (Quantity::NormalAcceleration, by_length(limits.normal_acceleration())),
    ];
    all.into_iter().filter_map(|(quantity, limit)| Some(tool_line(tool.of(quantity)?, limit?))).collect()
}

/// The highest feed that is programmed anywhere: sections take the place of the feed of the limits.
fn highest_feed<const N: usize>(plan: &Trajectory<'_, N>) -> Option<f64> {
    // A gap this small between sections is rounding.
    const GAP: f64 = 1e-9;
    let (sections, slack) = (plan.sections(), GAP * plan.path().length());
    let follows = |to: f64, section: &Section| (section.from <= to + slack).then_some(section.to);
    let covered = sections.iter().try_fold(0.0, follows).is_some_and(|to| to >= plan.path().length() - slack);
    let elsewhere = plan.limits().tool().feed();
    let highest = sections.iter().map(|section| section.feed).reduce(f64::max);
    if covered { highest } else { [elsewhere, highest].into_iter().flatten().reduce(f64::max) }
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
