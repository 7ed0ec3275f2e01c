//! The seconds that each limit of a job costs.

use std::fmt;
use std::sync::Arc;

use arcfeed_interp::{LimitError, MotionPath, PathArm, PlanError, TableKind, ToolLimits};
use arcfeed_kinematics::Joints;
use serde::Serialize;

use super::error::Cr7Error;
use super::limit_line::{LimitLine, LimitUnit};
use super::limit_lines::limit_lines;
use super::task::Task;
use super::task_limits::TaskLimits;
use crate::text::number;

/// By how much a limit is raised to see what that gains.
const RAISED: f64 = 1.1;
/// As good as no limit.
const LIFTED: f64 = 1e3;
/// A limit of which a motion uses a smaller part does not bind anywhere: without it the motion is the same.
const BINDS: f64 = 0.98;

/// What one limit costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitCost {
    /// The limited quantity, as in the report of the plan.
    pub name: String,
    /// The joint, from 1, for limits of joints.
    pub joint: Option<usize>,
    /// Its key in the job.
    pub key: &'static str,
    /// Unit of `limit`.
    pub unit: LimitUnit,
    /// The limit.
    pub limit: f64,
    /// By how much the motion is shorter with 10 % more of this limit alone, s; none where that cannot be planned.
    pub raised_saves_s: Option<f64>,
    /// By how much it is shorter with a thousand times this limit, s: what the limit costs; none where that cannot be planned.
    pub lifted_saves_s: Option<f64>,
}

/// A limit that binds nowhere.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct IdleLimit {
    /// The limited quantity.
    pub name: String,
    /// The joint, from 1, for limits of joints.
    pub joint: Option<usize>,
}

/// The cost of every limit that binds. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// Name of the path.
    pub name: String,
    /// Duration of the motion within all limits, s.
    pub duration_s: f64,
    /// Every limit with its worst place in that motion.
    pub limits: Vec<LimitLine>,
    /// The limits that bind somewhere, the one first of which 10 % more save most.
    pub costs: Vec<LimitCost>,
    /// What was assumed, and what the duration leaves out.
    pub warnings: Vec<String>,
    /// Limits that bind nowhere: raising one of them alone changes nothing.
    pub idle: Vec<IdleLimit>,
}

/// A limit of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Limit {
    Feed,
    TangentialAcceleration,
    TangentialJerk,
    NormalAcceleration,
    NormalJerk,
    AngularSpeed,
    JointVelocity(usize),
    JointAcceleration(usize),
    JointJerk(usize),
    JointTorque(usize),
    ToolAcceleration,
    ToolJerk,
}

impl Limit {
    /// The limit of a line of the report; `None` for what is no limit of the speed.
    fn of(line: &LimitLine) -> Option<Self> {
        Some(match (line.name.as_str(), line.joint.and_then(|joint| joint.checked_sub(1))) {
            ("feed", _) => Self::Feed,
            ("tangential acceleration", _) => Self::TangentialAcceleration,
            ("tangential jerk", _) => Self::TangentialJerk,
            ("normal acceleration", _) => Self::NormalAcceleration,
            ("normal jerk", _) => Self::NormalJerk,
            ("angular speed", _) => Self::AngularSpeed,
            ("tool acceleration", _) => Self::ToolAcceleration,
            ("tool jerk", _) => Self::ToolJerk,
            ("joint velocity", Some(joint)) => Self::JointVelocity(joint),
            ("joint acceleration", Some(joint)) => Self::JointAcceleration(joint),
            ("joint jerk", Some(joint)) => Self::JointJerk(joint),
            ("joint torque", Some(joint)) => Self::JointTorque(joint),
            _ => return None,
        })
    }

    /// Its key in the job.
    fn key<const N: usize>(self, limits: &TaskLimits<N>, is_program: bool) -> &'static str {
        let tabled = |joint| self.tables().iter().any(|kind| limits.tables.of(*kind, joint).is_some());
        match self {
            Self::Feed if limits.sections.is_empty() => "feed.feed_mm_s",
            Self::Feed if is_program => "F of the program, and feed.feed_mm_s",
            Self::Feed => "feed_mm_s of [[sections]], and feed.feed_mm_s",
            Self::TangentialAcceleration => "feed.tangential_acceleration_mm_s2",
            Self::TangentialJerk => "feed.tangential_jerk_mm_s3",
            Self::NormalAcceleration => "feed.normal_acceleration_mm_s2",
            Self::NormalJerk => "feed.normal_jerk_mm_s3",
            Self::AngularSpeed => "feed.angular_speed_deg_s",
            Self::ToolAcceleration => "feed.tool_acceleration_mm_s2",
            Self::ToolJerk => "feed.tool_jerk_mm_s3",
            Self::JointVelocity(_) => "joints.velocity_deg_s",
            Self::JointAcceleration(joint) if tabled(joint) => "joints.acceleration_deg_s2, and [[tables]]",
            Self::JointAcceleration(_) => "joints.acceleration_deg_s2",
            Self::JointJerk(joint) if tabled(joint) => "joints.jerk_deg_s3, and [[tables]]",
            Self::JointJerk(_) => "joints.jerk_deg_s3",
            Self::JointTorque(joint) if tabled(joint) => "torque.limit_nm, and [[tables]]",
            Self::JointTorque(_) => "torque.limit_nm",
        }
    }

    /// The kinds of tables that state it, too.
    fn tables(self) -> &'static [TableKind] {
        match self {
            Self::JointAcceleration(_) => &[TableKind::AccelerationBySpeed, TableKind::AccelerationByPosition],
            Self::JointJerk(_) => &[TableKind::JerkBySpeed, TableKind::JerkByPosition],
            Self::JointTorque(_) => &[TableKind::TorqueBySpeed],
            _ => &[],
        }
    }

    /// The limits with this one `factor` times as high.
    fn raised<const N: usize>(self, limits: &TaskLimits<N>, factor: f64) -> Result<TaskLimits<N>, PlanError> {
        let mut raised = limits.clone();
        let tool = limits.tool;
        let with = |value: Option<f64>, set: fn(ToolLimits, f64) -> Result<ToolLimits, LimitError>| match value {
            Some(value) => set(tool, value * factor),
            None => Ok(tool),
        };
        if let Self::JointAcceleration(joint) | Self::JointJerk(joint) | Self::JointTorque(joint) = self {
            raised.tables = limits.tables.scaled(self.tables(), joint, factor)?;
        }
        match self {
            Self::ToolAcceleration => raised.tool = with(tool.acceleration(), ToolLimits::with_acceleration)?,
            Self::ToolJerk => raised.tool = with(tool.jerk(), ToolLimits::with_jerk)?,
            Self::Feed => {
                raised.tool = with(tool.feed(), ToolLimits::with_feed)?;
                raised.sections.iter_mut().for_each(|section| section.feed *= factor);
            }
            Self::TangentialAcceleration => {
                raised.tool = with(tool.tangential_acceleration(), ToolLimits::with_tangential_acceleration)?;
            }
            Self::TangentialJerk => raised.tool = with(tool.tangential_jerk(), ToolLimits::with_tangential_jerk)?,
            Self::NormalAcceleration => {
                raised.tool = with(tool.normal_acceleration(), ToolLimits::with_normal_acceleration)?;
            }
            Self::NormalJerk => raised.tool = with(tool.normal_jerk(), ToolLimits::with_normal_jerk)?,
            Self::AngularSpeed => raised.tool = with(tool.angular_speed(), ToolLimits::with_angular_speed)?,
            Self::JointTorque(joint) => raised.torque = raised.torque.map(|torque| scaled(torque, joint, factor)),
            Self::JointVelocity(joint) | Self::JointAcceleration(joint) | Self::JointJerk(joint) => {
                let joints = &limits.joints;
                let [mut v, mut a, mut j] = [*joints.velocity(), *joints.acceleration(), *joints.jerk()];
                let one = match self {
                    Self::JointVelocity(_) => &mut v,
                    Self::JointAcceleration(_) => &mut a,
                    _ => &mut j,
                };
                *one = scaled(*one, joint, factor);
                raised.joints = joints.range().with_rates(v, a, j).map_err(LimitError::from)?;
            }
        }
        Ok(raised)
    }
}

fn scaled<const N: usize>(mut values: Joints<N>, joint: usize, factor: f64) -> Joints<N> {
    values[joint] *= factor;
    values
}

impl Advice {
    /// Plans the task once for each limit that binds, with 10 % more of it, and once without it. `tell` hears which. Durations are those
    /// before they are rounded up to whole control periods, which a warning says where the job asks for these.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] where the task cannot be planned.
    pub fn new<A: PathArm<N>, const N: usize>(task: &Task<A, N>, mut tell: impl FnMut(&str)) -> Result<Self, Cr7Error> {
        let path: Arc<dyn MotionPath<N> + '_> = Arc::new(task.tool_path()?);
        let own = task.own_limits();
        tell("within all limits");
        let plan = task.planner_within(own)?.plan_shared(path.clone()).map_err(|source| task.error(source))?;
        let duration = plan.duration();
        let limits = limit_lines(plan.verification(), plan.path().parameter());
        let (mut costs, mut idle) = (Vec::new(), Vec::new());
        for line in &limits {
            let Some(limit) = Limit::of(line) else { continue };
            if line.ratio < BINDS {
                idle.push(IdleLimit { name: line.name.clone(), joint: line.joint });
                continue;
            }
            tell(&line.joint.map_or(line.name.clone(), |joint| format!("{} J{joint}", line.name)));
            let saved = |factor: f64| {
                let raised = limit.raised(own, factor).ok()?;
                let plan = task.planner_within(&raised).ok()?.plan_shared(path.clone()).ok()?;
                Some(duration - plan.duration())
            };
            costs.push(LimitCost {
                name: line.name.clone(),
                joint: line.joint,
                key: limit.key(own, task.outline().is_some()),
                unit: line.unit,
                limit: line.limit,
                raised_saves_s: saved(RAISED),
                lifted_saves_s: saved(LIFTED),
            });
        }
        let saving = |cost: &LimitCost| cost.raised_saves_s.unwrap_or(f64::NEG_INFINITY);
        costs.sort_by(|a, b| saving(b).total_cmp(&saving(a)));
        let warnings = task.warnings().iter().cloned().chain(task.unrounded_words()).collect();
        Ok(Self { name: task.name().to_owned(), duration_s: duration, limits, costs, warnings, idle })
    }
}

/// A time, or that there is none.
fn seconds(saved: Option<f64>) -> String {
    saved.map_or("-".to_owned(), |s| format!("{s:.4}"))
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} s within all limits", self.name, number(self.duration_s))?;
        writeln!(
            f,
            "\n  {:<24}{:>4}{:>12} {:<9}{:>14}{:>14}  key of the job",
            "limit that binds", "", "limit", "", "10 % more", "without it"
        )?;
        writeln!(f, "  {:<24}{:>4}{:>12} {:<9}{:>14}{:>14}", "", "", "", "", "saves [s]", "saves [s]")?;
        for cost in &self.costs {
            let (factor, unit) = cost.unit.for_people();
            let joint = cost.joint.map(|joint| format!("J{joint}")).unwrap_or_default();
            writeln!(
                f,
                "  {:<24}{joint:>4}{:>12} {unit:<9}{:>14}{:>14}  {}",
                cost.name,
                number(cost.limit * factor),
                seconds(cost.raised_saves_s),
                seconds(cost.lifted_saves_s),
                cost.key
            )?;
        }
        let first = self.costs.first().and_then(|first| Some((first, first.raised_saves_s.filter(|s| *s > 0.0)?)));
        if let Some((first, saves)) = first {
            let joint = first.joint.map(|joint| format!(" of joint {joint}")).unwrap_or_default();
            let share = 100.0 * saves / self.duration_s;
            writeln!(f, "\nRaise the {}{joint} first ({}): 10 % more of it save {share:.2} %.", first.name, first.key)?;
        }
        if !self.idle.is_empty() {
            let kinds = self.idle.chunk_by(|a, b| a.name == b.name).map(|kind| {
                let joints: String =
                    kind.iter().filter_map(|one| one.joint).map(|joint| format!(" J{joint}")).collect();
                format!("{}{joints}", kind[0].name)
            });
            writeln!(f, "Limits that bind nowhere: {}.", kinds.collect::<Vec<_>>().join(", "))?;
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "Note: {warning}"))
    }
}
