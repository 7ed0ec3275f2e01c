//! The motion of a program: parts that meet at rest, on one axis of time.

use arcfeed_interp::{Method, PathArm};
use arcfeed_kinematics::{ForwardKinematics, JointLimits, Joints};

use super::joint_move::JointMove;
use super::motion::{Motion, corner_words};
use super::outline::MarkerLine;
use super::program_check::ProgramCheck;
use super::program_part::{PartMotion, ProgramPart};
use super::program_task::ProgramTask;
use super::task::Task;
use crate::text::number;

/// A planned and verified motion of a program.
///
/// [`ProgramTask::plan`] makes it. Each part has passed the verification of its planner. [`ProgramMotion::samples`] gives all parts on
/// one grid of control periods, and [`ProgramCheck`] holds these samples against the limits of the joints once more.
pub struct ProgramMotion<'t, const N: usize = 6> {
    name: &'t str,
    arm: &'t dyn ForwardKinematics<N>,
    limits: JointLimits<N>,
    method: Method,
    period: f64,
    parts: Vec<ProgramPart<'t, N>>,
    warnings: Vec<String>,
}

impl<const N: usize> std::fmt::Debug for ProgramMotion<'_, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ProgramMotion").field("name", &self.name).field("parts", &self.parts).finish_non_exhaustive()
    }
}

impl<'t, const N: usize> ProgramMotion<'t, N> {
    pub(crate) fn new<A: PathArm<N>>(
        task: &'t ProgramTask<A, N>,
        first: &'t Task<A, N>,
        parts: Vec<ProgramPart<'t, N>>,
    ) -> Self {
        let mut warnings = task.warnings.clone();
        let stops = |part: &ProgramPart<'t, N>| match part.motion() {
            PartMotion::Path(motion) => motion.trajectory().stops().len(),
            _ => 0,
        };
        let moves = || parts.iter().filter_map(joint_move);
        warnings.extend(lift_words(moves()));
        warnings.extend(configuration_words(moves()));
        warnings.extend(corner_words(parts.iter().map(stops).sum()));
        let method = first.method();
        Self {
            name: &task.name,
            arm: first.arm(),
            limits: *first.joint_limits(),
            method,
            period: task.period,
            parts,
            warnings,
        }
    }

    /// Name of the path.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The arm, tool included.
    pub fn arm(&self) -> &'t dyn ForwardKinematics<N> {
        self.arm
    }

    /// The parts in their order.
    pub fn parts(&self) -> &[ProgramPart<'t, N>] {
        &self.parts
    }

    /// The paths among them, each with its index.
    pub(crate) fn paths(&self) -> impl Iterator<Item = (&ProgramPart<'t, N>, &Motion<'t, N>)> {
        self.parts.iter().filter_map(|part| match part.motion() {
            PartMotion::Path(motion) => Some((part, &**motion)),
            _ => None,
        })
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.parts.last().map_or(0.0, ProgramPart::end)
    }

    /// The way of the tool, m.
    pub fn length(&self) -> f64 {
        self.parts.last().map_or(0.0, |part| part.from() + part.length())
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Limits of the joints.
    pub fn joint_limits(&self) -> &JointLimits<N> {
        &self.limits
    }

    /// The planner of the speed.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Codes of the program in their order, at their times.
    pub fn markers(&self) -> impl Iterator<Item = &MarkerLine> {
        self.parts.iter().flat_map(ProgramPart::markers)
    }

    /// The part of a time, s.
    pub fn part_at(&self, t: f64) -> Option<&ProgramPart<'t, N>> {
        let i = self.parts.partition_point(|part| part.end() < t);
        self.parts.get(i).or(self.parts.last())
    }

    /// Warnings about the motion.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds what else a person should know, such as an assumption about the arm.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.warnings.extend(warnings);
    }

    /// A check of the samples against the limits of the joints.
    pub fn check(&self) -> ProgramCheck<N> {
        ProgramCheck::new(&self.limits, self.method, self.period)
    }

    /// Joints of a dwell, or of the start of the motion, rad.
    pub(crate) fn rest(part: &ProgramPart<'t, N>) -> Option<Joints<N>> {
        match part.motion() {
            PartMotion::Dwell(joints) => Some(*joints),
            _ => None,
        }
    }
}

fn joint_move<'m, 't, const N: usize>(part: &'m ProgramPart<'t, N>) -> Option<&'m JointMove<'t, N>> {
    match part.motion() {
        PartMotion::Joints(motion) => Some(motion),
        _ => None,
    }
}

/// What is said of joint moves that leave the lines by more than they are lifted.
fn lift_words<'m, 't: 'm, const N: usize>(moves: impl Iterator<Item = &'m JointMove<'t, N>>) -> Option<String> {
    let over: Vec<_> = moves.filter(|motion| motion.exceeds_lift()).collect();
    let worst = over.iter().max_by(|a, b| a.leaves.distance_m.total_cmp(&b.leaves.distance_m))?;
    let mm = |m: f64| number(m * 1e3);
    let (off, line, lift) = (mm(worst.leaves.distance_m), worst.leaves.line, mm(worst.lift_m));
    Some(format!(
        "the tool leaves the lines by up to {off} mm at line {line}, where the lift is {lift} mm; {} joint moves exceed their lift: lift higher, or set feed.rapid = \"line\"",
        over.len()
    ))
}

/// What is said of changes of the configuration.
fn configuration_words<'m, 't: 'm, const N: usize>(
    moves: impl Iterator<Item = &'m JointMove<'t, N>>,
) -> Option<String> {
    let changes: Vec<_> = moves.filter(|motion| motion.reconfigured).collect();
    let line = changes.first()?.passed.last().map_or(0, |end| end.line);
    Some(format!(
        "the arm changes its configuration in {} joint moves, first before the path behind line {line}: that path cannot be followed otherwise",
        changes.len()
    ))
}
