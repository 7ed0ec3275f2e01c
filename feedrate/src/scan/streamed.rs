//! The scan per segment as a stream: a simulated controller that gets its segments while it runs.

use super::on_problem::{fastest, parts};
use super::segment::Segment;
use crate::error::{FeedError, not_negative, positive};
use crate::online::{SegmentStream, StreamStatus};
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scurve::phase::Phase;
use crate::speed_law::{Builder, SpeedLaw};

/// Cycles of a run; more are refused.
const MOST_CYCLES: usize = 20_000_000;

/// A [`SegmentStream`] over the intervals of a problem, as a controller runs it cycle by cycle.
///
/// Needs what [`PerSegmentScan`](crate::PerSegmentScan) needs. At the start the window is full.
/// Afterwards a segment arrives every [`StreamedScan::gap`], or later if the window is full then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamedScan {
    /// Segments behind the present one that the controller holds.
    pub look_ahead: usize,
    /// Time between two arrivals (s); 0 for a window that is filled in every cycle.
    pub gap: f64,
    /// Control period (s).
    pub period: f64,
}

/// What a streamed motion did.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamed {
    /// The motion; waiting is a part of it at rest.
    pub law: SpeedLaw,
    /// Stretches `(from, to)` of the path (m) in which the look-ahead held the motion back.
    pub held_back: Vec<(f64, f64)>,
    /// Place (m) and duration (s) of each wait for a segment.
    pub waits: Vec<(f64, f64)>,
}

impl StreamedScan {
    /// Runs the stream.
    ///
    /// # Errors
    /// As [`SegmentStream::new`]; [`FeedError::WindowEndSpeed`] for a problem with a speed at its
    /// end; [`FeedError::TooMany`] for a motion of more than 2e7 cycles; [`FeedError::NotPositive`]
    /// or [`FeedError::Negative`] for period and gap.
    pub fn run(&self, problem: &FeedProblem) -> Result<Streamed, FeedError> {
        positive("control period", self.period)?;
        not_negative("time between two segments", self.gap)?;
        if problem.v_end() > 0.0 {
            return Err(FeedError::WindowEndSpeed { speed: problem.v_end() });
        }
        let on = |segments: &[Segment]| self.along(problem, segments).map(Some);
        let found = fastest(problem, |run: &Streamed| run.law.duration(), on)?;
        found.ok_or(FeedError::Empty { what: "partitions of the limits" })
    }

    /// Between corners, where the motion rests, each part has a stream of its own.
    fn along(&self, problem: &FeedProblem, segments: &[Segment]) -> Result<Streamed, FeedError> {
        let from = problem.grid()[0];
        let mut all = Recorder { start: from, ..Recorder::default() };
        let mut laws = Vec::new();
        for (part, [v_start, _]) in parts(problem, segments) {
            let law = self.part(part, v_start, &mut all)?;
            all.start += law.end().p;
            laws.push(law);
        }
        Ok(Streamed { law: SpeedLaw::chain(from, laws), held_back: all.held_back, waits: all.waits })
    }

    fn part(&self, segments: &[Segment], v_start: f64, all: &mut Recorder) -> Result<SpeedLaw, FeedError> {
        let most = self.look_ahead.saturating_add(1).min(segments.len());
        let mut stream = SegmentStream::new(&segments[..most], v_start, self.look_ahead)?;
        let (mut next, mut due) = (most, self.gap);
        all.phases.clear();
        for cycle in 0..MOST_CYCLES {
            let t = cycle as f64 * self.period;
            while next < segments.len() && stream.free() > 0 && due <= t {
                stream.push(segments[next])?;
                next += 1;
                due = if self.gap > 0.0 { (due + self.gap).max(t) } else { 0.0 };
            }
            if next == segments.len() {
                stream.finish();
            }
            let before = stream.state().p;
            let mut moving = 0.0;
            let step = stream.step_with(self.period, |phase, dt| {
                moving += dt;
                all.phase(phase, dt);
            })?;
            match step.status {
                StreamStatus::Moving { held_back: false } => {}
                StreamStatus::Moving { held_back: true } => all.hold_back(before, step.state.p),
                StreamStatus::Waiting => all.wait(step.state.p, (self.period - moving).max(0.0)),
                StreamStatus::Reached { .. } => return all.law(step.state.p),
            }
        }
        Err(FeedError::TooMany { what: "cycles of a stream", got: MOST_CYCLES + 1, most: MOST_CYCLES })
    }
}

impl FeedPlanner for StreamedScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        self.run(problem).map(|run| run.law)
    }
}

/// What the cycles of a motion showed, one after the other.
#[derive(Debug, Default)]
struct Recorder {
    /// Place of the start of the present part.
    start: f64,
    phases: Vec<(Phase, f64)>,
    held_back: Vec<(f64, f64)>,
    waits: Vec<(f64, f64)>,
}

impl Recorder {
    /// A phase that goes on with the same jerk is one with the last.
    fn phase(&mut self, phase: Phase, dt: f64) {
        let rests = |phase: &Phase| phase.v == 0.0 && phase.a == 0.0;
        let goes_on = |last: &Phase| last.j == phase.j && (phase.j != 0.0 || rests(last) == rests(&phase));
        match self.phases.last_mut() {
            Some((last, lasts)) if goes_on(last) => *lasts += dt,
            _ => self.phases.push((phase, dt)),
        }
    }

    fn hold_back(&mut self, from: f64, to: f64) {
        let (from, to) = (self.start + from, self.start + to);
        match self.held_back.last_mut() {
            Some(last) if last.1 >= from => last.1 = to,
            _ => self.held_back.push((from, to)),
        }
    }

    fn wait(&mut self, at: f64, dt: f64) {
        self.phase(Phase { s: at, ..Phase::default() }, dt);
        let at = self.start + at;
        match self.waits.last_mut() {
            Some(last) if last.0 == at => last.1 += dt,
            _ => self.waits.push((at, dt)),
        }
    }

    fn law(&self, end: f64) -> Result<SpeedLaw, FeedError> {
        let mut builder = Builder::with_capacity(self.phases.len());
        for (phase, dt) in &self.phases {
            builder.push_phase(phase.s, phase.v, phase.a, phase.j, *dt);
        }
        builder.finish(end, 0.0)
    }
}
