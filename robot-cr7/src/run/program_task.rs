//! From a job and a program to a verified motion in parts.

use arcfeed_geometry::PosePath;
use arcfeed_interp::{MotionPath, PathArm, PathError, ToolPath};
use arcfeed_kinematics::{AnalyticInverse, JointLimits, Joints, ParallelAxisArm};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::cr7::Cr7;
use super::error::Cr7Error;
use super::feed_notes::FeedNotes;
use super::placed_path::PlacedPath;
use super::program_items::{ProgramItem, check_waits, items};
use super::program_marks::Marks;
use super::programmed::{skipped_words, turn_of};
use super::rapid_run::{RapidEnd, RapidRun};
use super::robot::{Drives, Robot};
use super::stretch::Stretch;
use super::task::{Task, start_near};
use crate::input::gcode::{GcodeProgram, PathControl};
use crate::input::job::{Job, ToolOrientation};
use crate::input::path_file::{PathFile, PathGeometry};

/// A program made ready, in parts that meet at rest: paths of the tool, rapid moves of the joints, and dwells. Nothing is planned yet.
///
/// A dwell (G4) ends a path, and with `feed.rapid = "joints"` each run of rapid moves (G0) does. The next path is planned from the
/// configuration in which the last one ended, where it can be followed in that.
///
/// ```
/// use std::path::Path;
///
/// use robot_cr7::{Job, PathFile, ProgramTask, RapidKind};
///
/// let text = b"G21 G0 X0 Y0 Z5\nG1 Z0 F600\nX40 F3000\nG4 P0.5\nG0 Z5\nX0 Y40\nG1 Z0 F600\nX40 F3000\nG0 Z5\nM2\n";
/// let file = PathFile::from_bytes(text, Path::new("two.ngc"), None)?;
/// let mut job = Job::default();
/// job.rapid.kind = RapidKind::Joints;
/// let task = ProgramTask::of_cr7(&job, &file)?;
/// let motion = task.plan()?;
/// // Two paths with a dwell and a rapid move between them, and a rapid move at the end.
/// assert_eq!(motion.parts().len(), 5);
/// for sample in motion.samples()? {
///     let joints = sample?.row.q; // rad, for the controller, once every control period
/// #   assert!(joints.iter().all(|q| q.is_finite()));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProgramTask<A = ParallelAxisArm, const N: usize = 6> {
    pub(crate) name: String,
    /// The file for messages.
    pub(crate) file: String,
    pub(crate) steps: Vec<ProgramStep<A, N>>,
    pub(crate) period: f64,
    pub(crate) warnings: Vec<String>,
}

/// A part of a program made ready.
#[derive(Debug, Clone)]
pub(crate) enum ProgramStep<A, const N: usize> {
    Path(Box<Task<A, N>>),
    Rapids(RapidRun, Marks),
    /// The line, the time in s, and the codes beside it.
    Dwell(usize, f64, Marks),
}

impl ProgramTask {
    /// True if the motion of `file` has parts: if it is a program that waits, or one with rapid moves of the joints.
    pub fn is_needed(job: &Job, file: &PathFile) -> bool {
        let PathGeometry::Program(program) = &file.geometry else { return false };
        items(program, job.rapid.kind).iter().any(|item| !matches!(item, ProgramItem::Path(_)))
    }

    /// The task of the CR7.
    ///
    /// # Errors
    /// As [`ProgramTask::new`].
    pub fn of_cr7(job: &Job, file: &PathFile) -> Result<Self, Cr7Error> {
        let cr7 = Cr7::of(job)?;
        Self::of_six_joints(job, file, *cr7.arm(), cr7.limits(), Robot::load("cr7", None, None)?.drives::<6>(job)?)
    }
}

impl<A: PathArm<6> + AnalyticInverse<6> + Clone> ProgramTask<A> {
    /// The task of an arm of six joints, tool included. It starts in the configuration that the job asks for, or else in the best one
    /// for the whole program; for the first path alone, where the arm cannot follow all of it with straight rapid moves.
    ///
    /// # Errors
    /// As [`ProgramTask::new`]; [`Cr7Error::JointCount`] for start.near_deg of another length.
    pub fn of_six_joints(
        job: &Job,
        file: &PathFile,
        arm: A,
        limits: &JointLimits<6>,
        drives: Option<Drives<6>>,
    ) -> Result<Self, Cr7Error> {
        let near = start_near(job)?;
        let best = |arm: &A, path: &PosePath| Ok(ToolPath::new(arm, path.clone(), limits.range())?.start());
        let near = near.or_else(|| {
            if job.start_posture.is_some() {
                return None;
            }
            // The best one for the whole program, where the arm can follow that with straight rapid moves.
            let whole = PlacedPath::new(job, file).ok()?;
            Some(ToolPath::new(&arm, whole.path, limits.range()).ok()?.start())
        });
        let first = |path: &PosePath| {
            let start = match (&near, job.start_posture) {
                (Some(near), _) => ToolPath::starting_near(&arm, path.clone(), near)?.start(),
                (None, Some(posture)) => ToolPath::in_posture(&arm, path.clone(), limits.range(), posture)?.start(),
                (None, None) => best(&arm, path)?,
            };
            Ok((arm.clone(), start))
        };
        Self::new(job, file, (limits, drives), first, |arm, path, _| best(arm, path))
    }
}

impl<A: PathArm<N> + Clone, const N: usize> ProgramTask<A, N> {
    /// The task of any arm under joint limits and, where torque is limited, those of its drives.
    ///
    /// `first` gives the arm, tool included, and the joints to start from, once the first path is known. `next` gives joints from which
    /// a later path can be followed, where it cannot from those in which the one before ends; it gets the arm, the path, and the joints
    /// at the start of the path before.
    ///
    /// # Errors
    /// [`Cr7Error`], naming the file and the line: for a file that is no program, for dwells of more than an hour in all, and as
    /// [`Task::new`].
    pub fn new(
        job: &Job,
        file: &PathFile,
        (limits, drives): (&JointLimits<N>, Option<Drives<N>>),
        first: impl Fn(&PosePath) -> Result<(A, Joints<N>), PathError>,
        next: impl Fn(&A, &PosePath, &Joints<N>) -> Result<Joints<N>, PathError>,
    ) -> Result<Self, Cr7Error> {
        let program = program_of(file)?;
        check_waits(program)?;
        let items = items(program, job.rapid.kind);
        check_end_speeds(job, program, &items)?;
        if job.vibrations.iter().any(|vibration| vibration.limit.is_some()) {
            let why = "a program with dwells or joint moves is not made calmer as a whole: remove the limit, or these";
            return Err(Cr7Error::Residual { file: file.file.display().to_string(), why });
        }
        let placed = place(job, file, &items)?;
        let mut notes = FeedNotes::default();
        placed.iter().for_each(|path| notes.and(&path.notes));
        let of_paths: Vec<String> = placed.iter().flat_map(|path| path.own_warnings()).cloned().collect();
        let runs = runs(job, program, &items, &placed);
        let (count, mut at) = (placed.len(), 0);
        let (mut placed, mut runs) = (placed.into_iter(), runs.into_iter());
        let mut before: Option<(A, Joints<N>)> = None;
        let mut steps = Vec::with_capacity(items.len());
        for item in &items {
            let step = match item {
                ProgramItem::Path(_) => {
                    let Some(path) = placed.next() else { continue };
                    let job = job_of(job, at, count);
                    at += 1;
                    let task = Task::placed(&job, file, path, (limits, drives), |path| match &before {
                        Some((arm, start)) => Ok((arm.clone(), next(arm, path, start)?)),
                        None => first(path),
                    })?;
                    before = Some((task.arm().clone(), *task.start()));
                    ProgramStep::Path(Box::new(task))
                }
                ProgramItem::Rapids(stretch) => {
                    let Some(run) = runs.next() else { continue };
                    ProgramStep::Rapids(run, Marks::of_run(stretch))
                }
                ProgramItem::Dwell(wait) => {
                    let line = usize::try_from(wait.line).unwrap_or(usize::MAX);
                    ProgramStep::Dwell(line, wait.seconds, Marks::of_wait(wait))
                }
            };
            steps.push(step);
        }
        let warnings = file.warnings.iter().chain(&job.warnings).cloned();
        let warnings = warnings.chain(notes.words(job)).chain(of_paths).chain(skipped_words(program));
        let warnings = warnings.chain(unused_rotary(job, &items)).chain(unused_rated(job)).collect();
        Ok(Self { name: file.name.clone(), file: file.file.display().to_string(), steps, period: job.period, warnings })
    }

    /// That the path of a line does not start in the joints in which the arm waits before it, by `gap` (rad).
    pub(crate) fn apart(&self, line: usize, gap: f64) -> Cr7Error {
        Cr7Error::Configuration {
            file: self.file.clone().into(),
            line: Some(line),
            key: "the path behind a dwell (G4)",
            problem: format!(
                "starts {:.3} deg from the joints in which the arm waits, and the tool would leave its place: lift it with G0 and set \
                 feed.rapid = \"joints\", or turn it along a path",
                gap.to_degrees()
            ),
        }
    }

    /// Name of the path.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A time (s), or the next that is a whole number of control periods where the motion has to last such.
    pub(crate) fn whole_cycles(&self, seconds: f64) -> f64 {
        let cycles = (seconds / self.period * (1.0 - 1e-12)).ceil();
        if self.first().is_some_and(|first| first.whole_cycles) { cycles * self.period } else { seconds }
    }

    /// Control period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The arm, tool included; `None` for a program without a path, which is refused before it is planned.
    pub fn arm(&self) -> Option<&A> {
        self.first().map(Task::arm)
    }

    /// The task of the first path.
    pub(crate) fn first(&self) -> Option<&Task<A, N>> {
        self.steps.iter().find_map(|step| match step {
            ProgramStep::Path(task) => Some(&**task),
            _ => None,
        })
    }

    /// A time that the motion certainly takes, s: for its paths at their highest feeds, and for its dwells.
    pub fn least_duration(&self) -> f64 {
        let least = |step: &ProgramStep<A, N>| match step {
            ProgramStep::Path(task) => task.least_duration(),
            ProgramStep::Dwell(_, seconds, _) => *seconds,
            ProgramStep::Rapids(..) => 0.0,
        };
        self.steps.iter().map(least).sum()
    }
}

/// That rated torques are not looked at.
fn unused_rated(job: &Job) -> Option<String> {
    let rated = job.torque.as_ref()?.rated.as_ref();
    rated.map(|_| "torque.rated_nm is not looked at: the program has dwells or joint moves".to_owned())
}

/// That rotary words of rapid moves are not used, because the job turns the tool along the paths.
fn unused_rotary(job: &Job, items: &[ProgramItem<'_>]) -> Option<String> {
    if matches!(job.orientation, ToolOrientation::Constant(_)) {
        return None;
    }
    let rapids = items.iter().filter_map(|item| match item {
        ProgramItem::Rapids(stretch) => Some(stretch.moves()),
        _ => None,
    });
    let turned = |pair: &&[crate::input::gcode::GcodeMove]| pair[0].rotary != pair[1].rotary;
    let line = rapids.flat_map(|moves| moves.windows(2)).find(turned)?[1].line;
    Some(format!(
        "rotary words (A, B, C) of rapid moves are not used, first at line {line}: orientation.mode of the job turns the tool; \
         set it to \"constant\" to use them"
    ))
}

fn program_of(file: &PathFile) -> Result<&GcodeProgram, Cr7Error> {
    match &file.geometry {
        PathGeometry::Program(program) => Ok(program),
        _ => {
            let rule = "parts are made of a program alone";
            let remedy = "plan a curve or points as one path (Task)";
            Err(Cr7Error::Input(crate::input::error::InputError::Value {
                file: file.file.clone(),
                line: None,
                key: "the file".to_owned(),
                value: "no program".to_owned(),
                rule,
                remedy,
            }))
        }
    }
}

/// Parts meet at rest, and so do a path and the start or the end of the motion beside a dwell or a rapid move.
fn check_end_speeds(job: &Job, program: &GcodeProgram, items: &[ProgramItem<'_>]) -> Result<(), Cr7Error> {
    let ends = [("feed.start_mm_s of the job", items.first()), ("feed.end_mm_s of the job", items.last())];
    for ((key, item), speed) in ends.into_iter().zip(job.feed.end_speeds) {
        if speed != 0.0 && !matches!(item, Some(ProgramItem::Path(_))) {
            let value = format!("{} mm/s", crate::text::number(speed * 1e3));
            let rule = "the motion is at rest there, because a dwell or a rapid move of the joints stands at that end";
            let remedy = "remove the key, or the dwell, or set feed.rapid = \"line\"";
            return Err(program.wrong(None, key, &value, rule, remedy).into());
        }
    }
    Ok(())
}

/// The paths where the job places them.
fn place(job: &Job, file: &PathFile, items: &[ProgramItem<'_>]) -> Result<Vec<PlacedPath>, Cr7Error> {
    let paths = items.iter().filter_map(|item| match item {
        ProgramItem::Path(stretch) => Some(PlacedPath::of_stretch(job, file, stretch)),
        _ => None,
    });
    let mut placed = paths.collect::<Result<Vec<_>, _>>()?;
    if let ToolOrientation::Slerp { from, to } = job.orientation {
        // In step with the arc length of all paths together.
        let whole: f64 = placed.iter().map(|path| path.path.length()).sum();
        let (from, to) = (job.workpiece.rotation * from, job.workpiece.rotation * to);
        let mut before = 0.0;
        for path in &mut placed {
            let after = before + path.path.length();
            let at = |s: f64| from.try_slerp(&to, (s / whole).min(1.0), 1e-9).unwrap_or(to);
            let [a, b] = [before, after].map(at);
            path.turn(a, b).map_err(|source| Cr7Error::Curve { file: file.file.display().to_string(), source })?;
            before = after;
        }
    }
    Ok(placed)
}

/// The job of one of `count` paths: they meet at rest.
fn job_of(job: &Job, index: usize, count: usize) -> Job {
    let mut own = job.clone();
    let [start, end] = job.feed.end_speeds;
    own.feed.end_speeds = [if index == 0 { start } else { 0.0 }, if index + 1 == count { end } else { 0.0 }];
    own
}

/// The rapid moves of the joints, with the poses at their ends.
fn runs(job: &Job, program: &GcodeProgram, items: &[ProgramItem<'_>], placed: &[PlacedPath]) -> Vec<RapidRun> {
    let mut runs = Vec::new();
    let mut paths = 0usize;
    for (i, item) in items.iter().enumerate() {
        let stretch = match item {
            ProgramItem::Path(_) => {
                paths += 1;
                continue;
            }
            ProgramItem::Dwell(_) => continue,
            ProgramItem::Rapids(stretch) => stretch,
        };
        let turn = |path: &PlacedPath, s: f64| path.path.jet(s).pose.rotation;
        let before = paths.checked_sub(1).and_then(|i| placed.get(i)).map(|path| turn(path, path.path.length()));
        let after = placed.get(paths).map(|path| turn(path, 0.0));
        let between = [before.or(after).unwrap_or_default(), after.or(before).unwrap_or_default()];
        runs.push(run_of(job, (program, foot(program, items, i)), stretch, between));
    }
    runs
}

/// The height above which rapid moves are lifted, m in the workpiece: that of the higher end of all between two paths, dwells among
/// them, or of their start where no path follows.
fn foot(program: &GcodeProgram, items: &[ProgramItem<'_>], index: usize) -> f64 {
    let height = |moves_done: usize| program.start_of(moves_done).z;
    let done_before = items[..index].iter().rev().find_map(|item| match item {
        ProgramItem::Path(stretch) => Some(stretch.range.end),
        _ => None,
    });
    let done_after = items[index..].iter().find_map(|item| match item {
        ProgramItem::Path(stretch) => Some(stretch.range.start),
        _ => None,
    });
    let ends = done_before.into_iter().chain(done_after);
    ends.map(height).fold(f64::NEG_INFINITY, f64::max)
}

/// One run, with the orientation of the tool before and after it.
fn run_of(
    job: &Job,
    (program, foot): (&GcodeProgram, f64),
    stretch: &Stretch<'_>,
    [before, after]: [UnitQuaternion<f64>; 2],
) -> RapidRun {
    let moves = stretch.moves();
    let from = program.start_of(stretch.range.start);
    let mut travelled = vec![0.0];
    let mut last = from;
    for step in moves {
        travelled.push(travelled[travelled.len() - 1] + (step.end() - last).norm());
        last = step.end();
    }
    let whole = travelled[travelled.len() - 1];
    // `count` moves are done. Rotary axes say how the tool is turned; else it turns in step with the way.
    let pose = |count: usize| {
        let (place, rotary) = match count.checked_sub(1) {
            Some(i) => (moves[i].end(), moves[i].rotary),
            None => (from, stretch.start_rotary()),
        };
        let rotation = match job.orientation {
            ToolOrientation::Constant(rotation) => job.workpiece.rotation * turn_of(rotary) * rotation,
            _ => {
                let part = if whole > 0.0 { travelled[count] / whole } else { 1.0 };
                before.try_slerp(&after, part, 1e-9).unwrap_or(after)
            }
        };
        let place = job.workpiece.transform_point(&place.into()).coords;
        Isometry3::from_parts(Translation3::from(place), rotation)
    };
    let end = |(i, step): (usize, &crate::input::gcode::GcodeMove)| RapidEnd {
        line: usize::try_from(step.line).unwrap_or(usize::MAX),
        number: step.number,
        pose: pose(i + 1),
        stop: matches!(step.control, Some(PathControl::ExactPath | PathControl::ExactStop)),
    };
    RapidRun {
        start: pose(0),
        ends: moves.iter().enumerate().map(end).collect(),
        lift: moves.iter().map(|step| step.end().z).fold(from.z, f64::max) - foot,
        blend: job.rapid.blend,
    }
}
