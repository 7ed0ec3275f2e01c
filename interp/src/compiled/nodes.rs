//! Samples of a planned motion at the times between which pieces may run.

use std::collections::VecDeque;

use super::piece::State;
use super::steps::Step;
use crate::error::PlanError;
use crate::trajectory::{Setpoints, Trajectory};
use arcfeed_kinematics::Joints;

/// Knots of the law that are nearer to each other than this part of the spacing count as one.
const NEAREST: f64 = 1.0 / 16.0;
/// The jerk before a knot is that at so much of the spacing before it.
const JUST: f64 = 1e-6;
/// The spacing of samples, s: at least, at most.
const SPACING: [f64; 2] = [5e-5, 1e-3];
/// Part of the tolerance that may be lost between two samples.
const LOST: f64 = 0.05;
/// The time by which the change of a planned acceleration may exceed the jerk limit, s: the largest distance of the samples on which a
/// plan is verified.
pub(super) const PEAK: f64 = 1.25e-4;

/// The meaning of a sample for the pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A piece may begin and end here.
    Free,
    /// A knot of the law, where the jerk jumps.
    Knot,
    /// A piece has to end here: the motion rests, or a step has been spread.
    Border,
    /// A piece that spreads a step has to begin here.
    StepBegins,
    /// A step inside such a piece.
    Step(usize),
}

impl Kind {
    /// True where no piece passes.
    pub fn is_border(self) -> bool {
        matches!(self, Self::Border | Self::StepBegins)
    }
}

/// The planned motion at one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<const N: usize> {
    pub t: f64,
    pub kind: Kind,
    pub state: State<N>,
    /// The jerk just before and just after; none at a step of the acceleration, and where nobody asks for it.
    pub jerk: Option<[Joints<N>; 2]>,
    /// The acceleration just before.
    pub before: Joints<N>,
}

/// Samples of a trajectory in the order of time, made when they are asked for.
pub(super) struct Nodes<'t, 'p, const N: usize> {
    setpoints: Setpoints<'t, 'p, N>,
    steps: Vec<Step<N>>,
    marks: Vec<(f64, Kind)>,
    spacing: f64,
    has_jerk: bool,
    /// The next mark to be reached, and the number of parts left before it.
    next: (usize, usize),
    made: VecDeque<Node<N>>,
    /// Number of samples that were made and dropped.
    dropped: usize,
}

impl<'t, 'p, const N: usize> Nodes<'t, 'p, N> {
    /// Samples for pieces within `tolerance` (rad).
    pub fn new(
        trajectory: &'t Trajectory<'p, N>,
        steps: Vec<Step<N>>,
        tolerance: f64,
        jerk_limited: bool,
    ) -> Result<Self, PlanError> {
        let spacing = spacing(trajectory, tolerance, jerk_limited);
        let marks = marks(trajectory, &steps, NEAREST * spacing);
        let setpoints = trajectory.setpoints(trajectory.period())?;
        let made = VecDeque::new();
        Ok(Self { setpoints, steps, marks, spacing, has_jerk: false, next: (0, 0), made, dropped: 0 })
    }

    /// The same with the jerk.
    pub fn with_jerk(self, has_jerk: bool) -> Self {
        Self { has_jerk, ..self }
    }

    /// The sample `i`; `None` after the end.
    pub fn get(&mut self, i: usize) -> Result<Option<&Node<N>>, PlanError> {
        while i >= self.dropped + self.made.len() {
            let (mark, left) = self.next;
            let Some(&(t, kind)) = self.marks.get(mark) else { return Ok(None) };
            let last = self.made.back().map_or(0.0, |node| node.t);
            let left = if left == 0 { ((t - last) / self.spacing).ceil().max(1.0) as usize } else { left };
            if left == 1 {
                self.next = (mark + 1, 0);
                self.make(t, kind)?;
            } else {
                self.next = (mark, left - 1);
                self.make(last + (t - last) / left as f64, Kind::Free)?;
            }
        }
        Ok(self.made.get(i - self.dropped))
    }

    /// The samples `from..=to` that were made.
    pub fn made(&self, from: usize, to: usize) -> impl Iterator<Item = &Node<N>> + Clone + '_ {
        self.made.range(from - self.dropped..=to - self.dropped)
    }

    /// Forgets all samples before `i`.
    pub fn drop_before(&mut self, i: usize) {
        self.made.drain(..i - self.dropped);
        self.dropped = i;
    }

    fn make(&mut self, t: f64, kind: Kind) -> Result<(), PlanError> {
        let node = match kind {
            Kind::Step(i) => {
                let step = &self.steps[i];
                Node { t, kind, state: step.after, jerk: None, before: step.before.qdd }
            }
            _ => {
                // Between two knots of the law the jerk does not jump.
                let jumps = self.has_jerk && kind != Kind::Free && t > 0.0;
                let before = if jumps { Some(self.setpoints.at(t - JUST * self.spacing)?.jerk) } else { None };
                let at = self.setpoints.at(t)?;
                let jerk = self.has_jerk.then(|| [before.unwrap_or(at.jerk), at.jerk]);
                Node { t, kind, state: State { q: at.q, qd: at.qd, qdd: at.qdd }, jerk, before: at.qdd }
            }
        };
        self.made.push_back(node);
        Ok(())
    }
}

/// The spacing at which a small part of the tolerance may be lost between two samples, s.
fn spacing<const N: usize>(trajectory: &Trajectory<'_, N>, tolerance: f64, jerk_limited: bool) -> f64 {
    let (limits, lost) = (trajectory.limits().joints(), LOST * tolerance);
    let spacing = if jerk_limited {
        let jerk = limits.jerk().max();
        // (P + J) d^3 / 16 and J PEAK d^2 / 8, with P = J.
        (8.0 * lost / jerk).cbrt().min((8.0 * lost / (jerk * PEAK)).sqrt())
    } else {
        // (P + A) d^2 / 8, with P = A.
        (4.0 * lost / limits.acceleration().max()).sqrt()
    };
    spacing.max(SPACING[0]).min(SPACING[1])
}

/// Times at which samples have to be, increasing: ends, knots of the law, rests, steps.
fn marks<const N: usize>(trajectory: &Trajectory<'_, N>, steps: &[Step<N>], nearest: f64) -> Vec<(f64, Kind)> {
    let duration = trajectory.duration();
    let mut firm: Vec<(f64, Kind)> = vec![(0.0, Kind::Border), (duration, Kind::Border)];
    firm.extend(trajectory.stops().map(|s| (trajectory.law().time_at_position(s), Kind::Border)));
    for (i, step) in steps.iter().enumerate() {
        firm.extend([(step.window[0], Kind::StepBegins), (step.t, Kind::Step(i)), (step.window[1], Kind::Border)]);
    }
    // Where one step is spread until the next one begins, the beginning counts.
    firm.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| (a.1 == Kind::Border).cmp(&(b.1 == Kind::Border))));
    firm.dedup_by(|later, earlier| later.0 == earlier.0 && later.1 == Kind::Border);
    let mut marks: Vec<(f64, Kind)> = Vec::with_capacity(firm.len() + trajectory.law().knots().len());
    let mut knots = trajectory.law().knots().map(|(t, _)| t).peekable();
    for &(t, kind) in &firm {
        let spreading = matches!(kind, Kind::Step(_)) || matches!(marks.last(), Some((_, Kind::Step(_))));
        while let Some(knot) = knots.next_if(|knot| *knot <= t) {
            let apart = marks.last().is_none_or(|last| knot - last.0 > nearest) && t - knot > nearest;
            if apart && !spreading {
                marks.push((knot, Kind::Knot));
            }
        }
        marks.push((t, kind));
    }
    marks
}
