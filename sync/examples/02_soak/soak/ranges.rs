//! One axis from state to state inside a range of positions, and three of them together.
//!
//! Judged phase by phase: the end state and the limits as in `states`; the positions stay inside, once they are. A refusal must be
//! true: there is a motion where a stop, a motion from rest to rest and a stop of the target played backwards stay inside. Motions that
//! take longer than these three are counted. A motion of a random longer duration takes that long, or a longer one is named that
//! is possible.
use arcfeed_sync::feedrate::{
    AxisLimits, AxisState, BoundedProblem, FeedError, MotionLaw, PositionLimits, StateToState,
};
use arcfeed_sync::{MotionOptions, SyncError, Trajectory};

use arcfeed_testing::Random;

use super::states::{Input, any_input, judge};
use super::{Failure, Outcome, random};

/// A problem and its range.
#[derive(Debug, Clone, Copy)]
struct Case {
    input: Input,
    positions: PositionLimits,
}

impl Case {
    fn new(rng: &mut Random) -> (Self, &'static str) {
        let (mut input, name) = any_input(rng);
        if rng.chance(0.5) {
            input.target = AxisState::rest(input.target.p);
        }
        let (from, to) = (input.start.p, input.target.p);
        let reach = (to - from).abs();
        // What the motion without a range takes on both sides, or a part of it.
        let way = StateToState::new(&input.start, &input.target, &input.limits()).map(|m| m.position_range());
        let (least, most) = way.map_or((from, to), |way| (way.min, way.max));
        let mut side = |beyond: f64| match rng.below(8) {
            0 => 0.0,
            1 => f64::INFINITY,
            2 => reach * rng.log(1e-6, 3.0),
            3 => beyond * (1.0 + rng.log(1e-15, 1.0)),
            4 => beyond * (1.0 - rng.log(1e-15, 1.0)),
            5 => beyond * rng.unit(),
            // What harder braking saves.
            _ => beyond * (1.0 - rng.log(1e-4, 0.3)),
        };
        let (below, above) = (side(from.min(to) - least), side(most - from.max(to)));
        let (mut lower, mut upper) = (from.min(to) - below, from.max(to) + above);
        // Some starts are outside.
        if rng.chance(0.1) && reach > 0.0 {
            let x = from + (to - from) * rng.log(1e-6, 0.9);
            if to > from { lower = x } else { upper = x }
        }
        let positions = PositionLimits::new(lower, upper).unwrap_or(PositionLimits::ALL);
        (Self { input, positions }, name)
    }

    fn code(&self) -> String {
        format!("{} inside {:?} to {:?}", self.input.code(), self.positions.lower(), self.positions.upper())
    }

    fn solve(&self) -> Result<BoundedProblem, FeedError> {
        BoundedProblem::new(&self.input.start, &self.input.target, &self.input.limits(), &self.positions)
    }

    fn judge(&self, motion: &StateToState) -> Result<(), String> {
        judge(&self.input, motion)?;
        let inside = self.positions.contain(self.input.start.p);
        if inside { self.positions.check(motion).map_err(|e| e.to_string()) } else { Ok(()) }
    }

    /// The duration of a motion in three parts: a stop, a motion from rest to rest, and a stop played backwards.
    fn in_parts(&self) -> Option<f64> {
        let range = (self.positions.lower(), self.positions.upper());
        let limits = self.input.limits();
        if !self.positions.contain(self.input.start.p) || !limits.contain(&self.input.start) {
            return None;
        }
        let back = self.input.reversed();
        let rests = |s: &AxisState, l: &AxisLimits| StateToState::stop_within(s, l, range).ok();
        let (first, last) = (rests(&self.input.start, &limits)?, rests_backwards(&back, range)?);
        let end = |m: &StateToState| AxisState::rest(m.at(m.duration()).p);
        let (from, to) = (end(&first), AxisState::rest(-end(&last).p));
        let between = StateToState::new(&from, &to, &limits).ok()?;
        Some(first.duration() + between.duration() + last.duration())
    }
}

/// The stop of a problem that is reversed in time, whose positions are mirrored.
fn rests_backwards(back: &Input, (lower, upper): (f64, f64)) -> Option<StateToState> {
    let limits = back.limits();
    limits.contain(&back.start).then(|| StateToState::stop_within(&back.start, &limits, (-upper, -lower)).ok())?
}

fn check(case: &Case, rng: &mut Random) -> Result<&'static str, String> {
    let parts = case.in_parts();
    let problem = match (case.solve(), parts) {
        (Err(e), Some(t)) => return Err(format!("refused: {e}, although parts make {t} s")),
        (
            Err(
                FeedError::StartTrapped { .. }
                | FeedError::TargetTrapped { .. }
                | FeedError::NoMotionInside { .. }
                | FeedError::TargetOutside { .. }
                | FeedError::TargetUnreachable { .. }
                | FeedError::LeavesPositions { .. },
            ),
            None,
        ) => return Ok("refused by name"),
        (Err(e), None) => return Err(format!("refused: {e}")),
        (Ok(problem), _) => problem,
    };
    let motion = problem.shortest();
    case.judge(&motion)?;
    let t = motion.duration();
    let longer = t * (1.0 + rng.log(1e-9, 10.0));
    match problem.with_duration(longer) {
        Ok(m) if m.duration() == longer => case.judge(&m).map_err(|e| format!("in {longer} s: {e}"))?,
        Ok(m) => return Err(format!("takes {} s, not {longer} s", m.duration())),
        Err(FeedError::DurationImpossible { above, .. }) if above > longer => {
            if above.is_finite() {
                let m = problem.with_duration(above).map_err(|e| format!("refused in the possible {above} s: {e}"))?;
                case.judge(&m).map_err(|e| format!("in the possible {above} s: {e}"))?;
            }
        }
        Err(e) => return Err(format!("refused in {longer} s: {e}")),
    }
    // The search does not promise the shortest motion with touches.
    Ok(if parts.is_some_and(|parts| t > parts * (1.0 + 1e-6)) {
        "longer than with two rests"
    } else if t > unlimited(&case.input) {
        "bent by its range"
    } else {
        "not bent"
    })
}

/// The shortest duration without a range (s).
fn unlimited(input: &Input) -> f64 {
    let motion = StateToState::new(&input.start, &input.target, &input.limits());
    motion.map_or(f64::INFINITY, |m| m.duration() * (1.0 + 1e-12))
}

fn together(cases: &[Case; 3]) -> Result<(), String> {
    let limits = cases.map(|c| c.input.limits());
    let (starts, targets) = (cases.map(|c| c.input.start), cases.map(|c| c.input.target));
    let ranges = cases.map(|c| c.positions);
    match Trajectory::inside(&starts, &targets, &limits, (&ranges, &MotionOptions::default())) {
        Ok(motion) => {
            for (k, (case, axis)) in cases.iter().zip(motion.axes()).enumerate() {
                case.judge(axis).map_err(|e| format!("together, axis {k}: {e}"))?;
                if axis.duration() != motion.duration() {
                    return Err(format!("axis {k} arrives at {} s, not at {} s", axis.duration(), motion.duration()));
                }
            }
            Ok(())
        }
        Err(SyncError::State { axis, .. }) if cases[axis].solve().is_err() || cases[axis].in_parts().is_none() => {
            Ok(())
        }
        Err(e) => Err(format!("together: {e}")),
    }
}

/// The case of a seed: one axis, and three axes for every eighth seed.
pub fn case(seed: u64) -> Outcome {
    let mut rng = random(seed);
    let mut outcome = Outcome { counted: 1, ..Outcome::default() };
    let mut fail = |name: &str, e: String, input: String| {
        let kind: String = e.chars().map(|c| if c.is_ascii_digit() { '#' } else { c }).collect();
        let failure = Failure { size: 1.0, seed, input: format!("{e}\n{input}") };
        outcome.failure = Some((format!("{name}: {}", kind.split("##").next().unwrap_or("")), failure));
    };
    let (case, name) = Case::new(&mut rng);
    match check(&case, &mut rng) {
        Err(e) => fail(name, e, case.code()),
        Ok(fact) => {
            if seed.is_multiple_of(8) {
                let cases = [case, Case::new(&mut rng).0, Case::new(&mut rng).0];
                if let Err(e) = together(&cases) {
                    fail("together", e, cases.map(|c| c.code()).join("\n"));
                }
            }
            outcome.see(fact);
        }
    }
    outcome
}
