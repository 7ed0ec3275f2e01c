//! One part of the motion of a program, at its time.

use arcfeed_interp::{Trajectory, Verification};
use arcfeed_kinematics::Joints;

use super::joint_move::JointMove;
use super::motion::Motion;
use super::outline::MarkerLine;
use super::program_marks::Marks;
use super::rapid_run::RapidRun;

/// A part of the motion of a program, from rest to rest unless it is at an end of the whole.
#[derive(Debug, Clone)]
pub struct ProgramPart<'t, const N: usize = 6> {
    motion: PartMotion<'t, N>,
    lines: [usize; 2],
    begin: f64,
    duration: f64,
    from: f64,
    length: f64,
    marks: Vec<MarkerLine>,
    /// Lines and N words of rapid moves that leave the joints where they are.
    still: Vec<(usize, Option<u32>)>,
}

/// What a part of a program is.
#[derive(Debug, Clone)]
pub enum PartMotion<'t, const N: usize = 6> {
    /// A path of the tool.
    Path(Box<Motion<'t, N>>),
    /// Rapid moves as one motion of the joints.
    Joints(Box<JointMove<'t, N>>),
    /// The tool waits with these joints (rad).
    Dwell(Joints<N>),
}

impl<'t, const N: usize> ProgramPart<'t, N> {
    pub(crate) fn of_path(before: Option<&Self>, motion: Motion<'t, N>, lines: [usize; 2]) -> Self {
        let trajectory = motion.trajectory();
        let (duration, length) = (trajectory.duration(), trajectory.path().length());
        let mut part = Self::new(before, PartMotion::Path(Box::new(motion)), lines, [duration, length]);
        if let PartMotion::Path(motion) = &part.motion {
            let place = |mark: &MarkerLine| MarkerLine {
                s_m: part.from + mark.s_m,
                t_s: Some(part.begin + motion.trajectory().law().time_at_position(mark.s_m)),
                ..mark.clone()
            };
            part.marks = motion.outline().map(|o| o.markers.iter().map(place).collect()).unwrap_or_default();
        }
        part
    }

    pub(crate) fn of_joints(before: Option<&Self>, motion: JointMove<'t, N>, lines: [usize; 2]) -> Self {
        let size = [motion.trajectory.duration(), motion.way.last().map_or(0.0, |last| last.1)];
        Self::new(before, PartMotion::Joints(Box::new(motion)), lines, size)
    }

    pub(crate) fn of_dwell(before: Option<&Self>, joints: &Joints<N>, seconds: f64, lines: [usize; 2]) -> Self {
        Self::new(before, PartMotion::Dwell(*joints), lines, [seconds, 0.0])
    }

    /// Rapid moves that leave the joints where they are.
    pub(crate) fn of_still(before: Option<&Self>, joints: &Joints<N>, run: &RapidRun) -> Self {
        let still = run.ends.iter().map(|end| (end.line, end.number)).collect();
        Self { still, ..Self::of_dwell(before, joints, 0.0, run.lines()) }
    }

    fn new(before: Option<&Self>, motion: PartMotion<'t, N>, lines: [usize; 2], [duration, length]: [f64; 2]) -> Self {
        let (begin, from) = before.map_or((0.0, 0.0), |part| (part.end(), part.from + part.length));
        Self { motion, lines, begin, duration, from, length, marks: Vec::new(), still: Vec::new() }
    }

    /// Places the codes of a part that is no path.
    pub(crate) fn mark(&mut self, marks: &Marks) {
        self.marks = marks.placed(|done| match (&self.motion, done.checked_sub(1)) {
            (_, None) => (self.begin, self.from),
            (PartMotion::Joints(motion), Some(i)) => motion.passed.get(i).map_or((self.end(), self.from), |passed| {
                let t = motion.trajectory.law().time_at_position(passed.parameter);
                (self.begin + t, self.from + motion.way_at(passed.parameter))
            }),
            _ => (self.end(), self.from + self.length),
        });
    }

    /// What it is.
    pub fn motion(&self) -> &PartMotion<'t, N> {
        &self.motion
    }

    /// The first and the last line of the file that belong to it.
    pub fn lines(&self) -> [usize; 2] {
        self.lines
    }

    /// Its start, in s from the start of the whole motion.
    pub fn begin(&self) -> f64 {
        self.begin
    }

    /// Its duration, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Its end, in s from the start of the whole motion.
    pub fn end(&self) -> f64 {
        self.begin + self.duration
    }

    /// The way of the tool in all parts before it, m.
    pub fn from(&self) -> f64 {
        self.from
    }

    /// The way of the tool in it, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Codes of the program in it, at their times.
    pub fn markers(&self) -> &[MarkerLine] {
        &self.marks
    }

    /// Lines and N words of rapid moves that leave the joints where they are.
    pub(crate) fn still(&self) -> &[(usize, Option<u32>)] {
        &self.still
    }

    /// The trajectory, where it moves.
    pub fn trajectory(&self) -> Option<&Trajectory<'t, N>> {
        match &self.motion {
            PartMotion::Path(motion) => Some(motion.trajectory()),
            PartMotion::Joints(motion) => Some(motion.trajectory()),
            PartMotion::Dwell(_) => None,
        }
    }

    /// The verification that it passed, where it moves.
    pub fn verification(&self) -> Option<&Verification> {
        self.trajectory().map(Trajectory::verification)
    }

    /// The first and last line of the file that belong to a time, s from the start of the whole motion: mostly the same one.
    pub fn lines_at(&self, t: f64) -> [usize; 2] {
        let at = |trajectory: &Trajectory<'t, N>| trajectory.law().cursor().at(t - self.begin).p;
        match &self.motion {
            PartMotion::Path(motion) => {
                motion.outline().map_or(self.lines, |outline| outline.lines_at(at(motion.trajectory())))
            }
            PartMotion::Joints(motion) => {
                let place = at(&motion.trajectory);
                let line =
                    motion.passed.iter().find(|end| end.parameter >= place).map_or(self.lines[1], |end| end.line);
                [line; 2]
            }
            PartMotion::Dwell(_) => self.lines,
        }
    }
}
