//! Plans the parts of a program one after the other.

use arcfeed_geometry::GeometryError;
use arcfeed_interp::{
    CompileError, JointTrajectory, JointTrajectoryError, MotionCertificate, PathArm, PlanError, Trajectory,
};
use arcfeed_kinematics::{Joints, KinematicsError};

use super::error::Cr7Error;
use super::motion::Motion;
use super::plan_error::plan_error;
use super::program_marks::Marks;
use super::program_motion::ProgramMotion;
use super::program_part::ProgramPart;
use super::program_task::{ProgramStep, ProgramTask};
use super::rapid_run::{RapidRun, SAME, WayPoints};
use super::task::Task;

/// Joints that are no more apart are the same but for the inverse, rad: a joint move makes up for it.
const ROUNDING: f64 = 1e-6;

/// The motion of a program as polynomials of the time.
#[derive(Debug, Clone)]
pub struct CompiledProgram<const N: usize = 6> {
    /// All parts one after the other.
    pub joints: JointTrajectory<N>,
    /// The parts that move: the index of each, its polynomials, and what these make of the limits.
    pub moving: Vec<(usize, JointTrajectory<N>, MotionCertificate)>,
}

impl<A: PathArm<N> + Clone, const N: usize> ProgramTask<A, N> {
    /// The planned and verified motion.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] with the line; [`Cr7Error::Configuration`] for the end of a rapid move that the arm cannot reach.
    pub fn plan(&self) -> Result<ProgramMotion<'_, N>, Cr7Error> {
        Planning::new(self, None).run().map(|(motion, _)| motion)
    }

    /// The same with its motion as polynomials of the time, which keep the limits of the joints, and on the paths those of the tool, and
    /// deviate from the plan by no more than `tolerance` (rad).
    ///
    /// # Errors
    /// As [`ProgramTask::plan`]; [`Cr7Error::Compile`] where no such polynomials are found.
    pub fn plan_compiled(&self, tolerance: f64) -> Result<(ProgramMotion<'_, N>, CompiledProgram<N>), Cr7Error> {
        let (motion, compiled) = Planning::new(self, Some(tolerance)).run()?;
        let compiled = compiled.ok_or_else(|| self.compile_error(CompileError::AccelerationSteps))?;
        Ok((motion, compiled))
    }

    fn compile_error(&self, source: CompileError) -> Cr7Error {
        Cr7Error::Compile { file: self.name.clone(), source: Box::new(source) }
    }

    /// The path that follows a step, with nothing but dwells between.
    fn path_after(&self, index: usize) -> Option<&Task<A, N>> {
        let mut later = self.steps[index + 1..].iter().filter(|step| !matches!(step, ProgramStep::Dwell(..)));
        match later.next() {
            Some(ProgramStep::Path(task)) => Some(task),
            _ => None,
        }
    }

    /// The error of a plan between two lines.
    fn error_at(&self, source: PlanError, [from, to]: [usize; 2]) -> Cr7Error {
        match plan_error(&self.file, source) {
            Cr7Error::Plan { file, source, hint } => {
                let hint = format!("{hint}; that is in the joint move of lines {from} to {to}");
                Cr7Error::Plan { file, source, hint }
            }
            other => other,
        }
    }

    fn without_path(&self) -> Cr7Error {
        Cr7Error::Curve { file: self.file.clone(), source: GeometryError::EmptyPath }
    }

    fn out_of_reach(&self, line: usize, source: &KinematicsError) -> Cr7Error {
        Cr7Error::Configuration {
            file: self.file.clone().into(),
            line: Some(line),
            key: "the end of the rapid move (G0)",
            problem: format!("{source}; a joint move passes the end of each line: move it to where the arm can stand"),
        }
    }
}

/// A path with the polynomials that were asked for.
struct PlannedPath<'t, const N: usize> {
    motion: Motion<'t, N>,
    compiled: Option<(JointTrajectory<N>, MotionCertificate)>,
    /// Joints at its start and at its end.
    ends: [Joints<N>; 2],
}

/// The plan so far.
struct Planning<'t, A, const N: usize> {
    task: &'t ProgramTask<A, N>,
    tolerance: Option<f64>,
    parts: Vec<ProgramPart<'t, N>>,
    /// Where the joints are.
    at: Option<Joints<N>>,
    /// A path that was planned, to know where the rapid moves before it lead.
    ahead: Option<PlannedPath<'t, N>>,
    /// Polynomials of the parts, where they were asked for.
    pieces: Vec<JointTrajectory<N>>,
    moving: Vec<(usize, JointTrajectory<N>, MotionCertificate)>,
}

impl<'t, A: PathArm<N> + Clone, const N: usize> Planning<'t, A, N> {
    fn new(task: &'t ProgramTask<A, N>, tolerance: Option<f64>) -> Self {
        let at = task.first().map(|first| *first.start());
        Self { task, tolerance, parts: Vec::new(), at, ahead: None, pieces: Vec::new(), moving: Vec::new() }
    }

    fn run(mut self) -> Result<(ProgramMotion<'t, N>, Option<CompiledProgram<N>>), Cr7Error> {
        let task = self.task;
        let Some(first) = task.first() else { return Err(task.without_path()) };
        for (index, step) in task.steps.iter().enumerate() {
            let at = self.at.unwrap_or_else(|| *first.start());
            match step {
                ProgramStep::Path(path) => self.path(path, &at)?,
                ProgramStep::Rapids(run, marks) => self.rapids(index, run, marks, &at)?,
                ProgramStep::Dwell(line, seconds, marks) => self.wait([*line; 2], *seconds, marks, &at)?,
            }
        }
        let Self { parts, pieces, moving, .. } = self;
        let joints = joined(pieces).map_err(|source| task.compile_error(source.into()))?;
        let motion = ProgramMotion::new(task, first, parts);
        Ok((motion, joints.map(|joints| CompiledProgram { joints, moving })))
    }

    /// The motion along a path, from the joints nearest to `near` or, where the arm cannot follow it from these and `may_change`, from
    /// its own.
    fn plan_path(
        &self,
        path: &'t Task<A, N>,
        near: &Joints<N>,
        may_change: bool,
    ) -> Result<PlannedPath<'t, N>, Cr7Error> {
        let attempt = |near: &Joints<N>| {
            let (motion, compiled) = match self.tolerance {
                None => (path.plan_near(near)?, None),
                Some(tolerance) => {
                    let (motion, pieces, certificate) = path.plan_compiled_near(near, tolerance)?;
                    (motion, Some((pieces, certificate)))
                }
            };
            let ends = ends(motion.trajectory()).map_err(|source| path.error(source))?;
            Ok(PlannedPath { motion, compiled, ends })
        };
        attempt(near).or_else(|error| {
            let source = match &error {
                Cr7Error::Plan { source, .. } => Some(&**source),
                _ => None,
            };
            if may_change && matches!(source, Some(PlanError::Path(_))) && (near - path.start()).amax() > SAME {
                attempt(path.start()).map_err(|_| error)
            } else {
                Err(error)
            }
        })
    }

    fn path(&mut self, path: &'t Task<A, N>, at: &Joints<N>) -> Result<(), Cr7Error> {
        let planned = match self.ahead.take() {
            Some(planned) => planned,
            None => self.plan_path(path, at, self.parts.is_empty())?,
        };
        let lines = planned.motion.outline().map_or([0; 2], |outline| outline.ends());
        let gap = (planned.ends[0] - at).amax();
        if gap > ROUNDING && !self.parts.is_empty() {
            return Err(self.task.apart(lines[0], gap));
        }
        if gap > SAME && !self.parts.is_empty() {
            let turn = RapidRun::turn(path.path().jet(0.0).pose, lines[0]);
            let way = WayPoints { joints: vec![*at, *at], reconfigured: false }.ending_in(planned.ends[0]);
            self.joint_move(&turn, &way)?;
        }
        self.compiled(planned.compiled);
        let part = ProgramPart::of_path(self.parts.last(), planned.motion, lines);
        self.parts.push(part);
        self.at = Some(planned.ends[1]);
        Ok(())
    }

    fn rapids(&mut self, index: usize, run: &RapidRun, marks: &Marks, at: &Joints<N>) -> Result<(), Cr7Error> {
        let Some(first) = self.task.first() else { return Ok(()) };
        let way = run.way_points(first.arm(), at);
        let mut way = way.map_err(|(i, source)| self.task.out_of_reach(run.ends[i].line, &source))?;
        if let Some(path) = self.task.path_after(index) {
            let planned = self.plan_path(path, way.end(), true)?;
            way = way.ending_in(planned.ends[0]);
            self.ahead = Some(planned);
        }
        if self.joint_move(run, &way)? {
            if let Some(part) = self.parts.last_mut() {
                part.mark(marks);
            }
            return Ok(());
        }
        // The joints are there.
        let mut part = ProgramPart::of_still(self.parts.last(), at, run);
        part.mark(marks);
        self.parts.push(part);
        Ok(())
    }

    /// A motion of the joints; false where they do not move.
    fn joint_move(&mut self, run: &RapidRun, way: &WayPoints<N>) -> Result<bool, Cr7Error> {
        let task = self.task;
        let Some(first) = task.first() else { return Ok(false) };
        let lines = run.lines();
        let planned = run.plan(first, way, self.tolerance).map_err(|source| match source {
            CompileError::Plan(source) => task.error_at(source, lines),
            source => task.compile_error(source),
        })?;
        let Some((planned, pieces)) = planned else { return Ok(false) };
        self.compiled(pieces);
        self.at = Some(*way.end());
        self.parts.push(ProgramPart::of_joints(self.parts.last(), planned, lines));
        Ok(true)
    }

    /// Keeps the polynomials of the part to come.
    fn compiled(&mut self, part: Option<(JointTrajectory<N>, MotionCertificate)>) {
        if let Some((pieces, certificate)) = part {
            self.pieces.push(pieces.clone());
            self.moving.push((self.parts.len(), pieces, certificate));
        }
    }

    fn wait(&mut self, lines: [usize; 2], seconds: f64, marks: &Marks, at: &Joints<N>) -> Result<(), Cr7Error> {
        let seconds = self.task.whole_cycles(seconds);
        if self.tolerance.is_some() && seconds > 0.0 {
            let rest = JointTrajectory::resting(at, seconds);
            self.pieces.push(rest.map_err(|source| self.task.compile_error(source.into()))?);
        }
        let mut part = ProgramPart::of_dwell(self.parts.last(), at, seconds, lines);
        part.mark(marks);
        self.parts.push(part);
        Ok(())
    }
}

/// Polynomials one after the other; they rest where they meet.
fn joined<const N: usize>(
    mut pieces: Vec<JointTrajectory<N>>,
) -> Result<Option<JointTrajectory<N>>, JointTrajectoryError> {
    while pieces.len() > 1 {
        let pairs = pieces.chunks(2).map(|pair| match pair {
            [first, second] => first.clone().then(second),
            rest => Ok(rest[0].clone()),
        });
        pieces = pairs.collect::<Result<_, _>>()?;
    }
    Ok(pieces.pop())
}

/// Joints at the start and at the end of a trajectory.
fn ends<const N: usize>(trajectory: &Trajectory<'_, N>) -> Result<[Joints<N>; 2], PlanError> {
    let mut setpoints = trajectory.setpoints(trajectory.period())?;
    Ok([setpoints.at(0.0)?.q, setpoints.at(trajectory.duration())?.q])
}
