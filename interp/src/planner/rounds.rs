//! The rounds of planning: a law on a grid, its verification, and what is changed where it exceeds a limit.

use std::time::{Duration, Instant};

use arcfeed_feedrate::{
    ContinuousAccelerationScan, Fallback, FeedPlanner, JerkLimited, JerkLimitedOrScan, LimitId, SpeedLaw,
};

use super::windows::Chosen;
use super::{Planner, unverified};
use crate::error::{LimitError, PlanError};
use crate::lowering::{TOLERANCE, exceeded_stretches, fraction, lower_where_exceeded, lowerable};
use crate::method::Method;
use crate::problem::{
    Held, LimitFractions, MOST_INTERVALS, PathProblem, RowsNeeded, Settings, parts_by_cost, resolved,
};
use crate::trajectory::{PlanInfo, Timings, Trajectory};
use crate::verify::Verification;

/// Rounds of planning until the verification passes.
const ROUNDS: usize = 12;
/// A limit that is exceeded by more than this, relative to it, asks for a finer grid; by less, for less of the limit: that costs a third of
/// it in time at the most for a jerk, and a finer grid often shows more to hold.
const COARSE: f64 = 1e-2;
/// Intervals on which a limit is exceeded are divided into so many parts.
const FINER: usize = 4;
/// Rounds in which a limit is lowered only where it is exceeded; later ones lower it everywhere.
const LOCAL_ROUNDS: usize = 6;
/// On a grid of more intervals than this, a motion that exceeds a limit by no more than this part is slowed down as a whole: another
/// round would take long.
const LARGE: usize = 6000;
const SLIGHT: f64 = 1e-4;
/// The same on any grid in late rounds: limits that are lowered everywhere can be exceeded by more the next time.
const SLIGHT_AT_LAST: f64 = 1e-3;

/// A motion is slowed down by what it exceeds a limit by and by this, twice as much each time, as often as it is below that.
const MARGIN: f64 = 1.2 * SLIGHT;
const MOST_MARGIN: f64 = 8.0 * SLIGHT;

/// Motions that were slowed down as a whole.
struct Slowing {
    margin: f64,
    /// The part of its speed that the motion has.
    part: f64,
    /// The motion before the first time, and by what it exceeded a limit.
    before: Option<(SpeedLaw, f64)>,
}

impl<'a, const N: usize> Planner<'a, N> {
    /// Plans until a verified trajectory exceeds nothing that `exceeded` looks for: limits, and the ratios to them.
    pub(crate) fn plan_until<'p, E: From<PlanError>>(
        &self,
        path: Held<'p, N>,
        mut exceeded: impl FnMut(&Trajectory<'p, N>) -> Result<Vec<(LimitId, f64)>, E>,
    ) -> Result<Trajectory<'p, N>, E>
    where
        'a: 'p,
    {
        // Part of the excess that is left after a round in which a limit was lowered where it was exceeded, for lack of grid points there.
        const STUCK: f64 = 0.9;
        // Rounds in which the grid is made finer: what two of them do not mend, less of all limits does.
        const FINER_ROUNDS: usize = 2;
        self.check_ends_of_whole_cycles()?;
        let begin = Instant::now();
        let mut problem = self.laid_out(path)?;
        let mut used = LimitFractions::default();
        let mut chosen = match self.choose_by_draft(&mut problem) {
            Some(chosen) => chosen,
            None => self.choose_over_grids(&mut problem)?,
        };
        let (mut verifying, mut refined, mut finer_for_stuck) = (Duration::ZERO, 1, 0);
        let mut slowing = Slowing { margin: MARGIN, part: 1.0, before: None };
        let (mut rounds, mut last_excess) = (0, f64::INFINITY);
        let verification = loop {
            rounds += 1;
            chosen.law = self.in_whole_cycles(&problem, chosen.law)?;
            let started = Instant::now();
            let verification = self.verify(&problem, &chosen.law, self.method.limits_jerk())?;
            verifying += started.elapsed();
            if verification.holds(TOLERANCE) {
                let [grid, joint_path] = problem.times();
                let speed = begin.elapsed().saturating_sub(verifying + grid + joint_path);
                let timings = Timings { grid, joint_path, speed, verification: verifying };
                let info = self.info(&problem, &chosen, (rounds, refined), (&used, slowing.part));
                let window = chosen.window();
                let trajectory = Trajectory::new(problem, chosen.law, info, verification, timings);
                let more = exceeded(&trajectory)?;
                if more.is_empty() || rounds == ROUNDS {
                    return Ok(trajectory);
                }
                more.into_iter().for_each(|(id, ratio)| used.lower(id, fraction(ratio)));
                problem = trajectory.into_problem();
                chosen = self.choose(&problem, &used, window)?;
                continue;
            }
            let Some(exceeded) = lowerable(&verification, self.method.limits_jerk()) else { break verification };
            if rounds == ROUNDS {
                break verification;
            }
            let excess = verification.worst().ratio - 1.0;
            if let Some(slower) = self.slower_as_a_whole(&problem, &chosen.law, (excess, rounds), &mut slowing)? {
                (chosen.law, last_excess) = (slower, excess);
                continue;
            }
            (slowing.part, slowing.before) = (1.0, None);
            let local = rounds <= LOCAL_ROUNDS && self.method == Method::JerkLimited;
            // What a lower limit does not mend may be seen by a finer grid; what that does not mend either, less of all limits does.
            let stuck = excess > STUCK * last_excess && finer_for_stuck < FINER_ROUNDS;
            last_excess = excess;
            finer_for_stuck += usize::from(stuck);
            let finer = (excess > COARSE && rounds <= FINER_ROUNDS) || stuck;
            let parts = || self.parts_where_exceeded(&problem, &verification, &chosen.law);
            let parts = finer.then(parts).flatten();
            if let Some(parts) = parts {
                problem = problem.refined(|k| parts[k])?;
                refined *= FINER;
            } else if excess > COARSE && !local {
                // Far too much of one limit is a place that the grid does not see: a slower motion is slower there as well.
                used.lower_all(less_of_all(excess));
            } else if local {
                lower_where_exceeded(&mut used, &verification, &chosen.law, self.settings.period);
            } else {
                exceeded.into_iter().for_each(|(id, ratio)| used.lower(id, fraction(ratio)));
            }
            // A speed at an end may go with the limits that were asked for and with none below.
            let Ok(again) = self.choose_near(&problem, &used, &chosen.law, chosen.window()) else { break verification };
            chosen = again;
        };
        Err(unverified(&problem, &verification, self.method.needs() > RowsNeeded::Points).into())
    }

    /// The problem of a path on its first grid.
    fn laid_out<'p>(&self, path: Held<'p, N>) -> Result<PathProblem<'p, N>, PlanError>
    where
        'a: 'p,
    {
        let problem = PathProblem::new(&self.settings, path, self.method.needs(), self.method.is_by_interval())?;
        let has_tool_curve = problem.path().tool_curve().is_some();
        if self.method == Method::JerkLimited && has_tool_curve {
            Ok(resolved(problem, self.most_rows_at_once())?)
        } else {
            Ok(problem)
        }
    }

    fn check_ends_of_whole_cycles(&self) -> Result<(), PlanError> {
        if self.settings.whole_cycles && self.settings.ends != [0.0; 2] {
            return Err(PlanError::Limit(LimitError::Unsuited {
                limit: "a whole number of control periods",
                problem: "is reached by slowing the motion down, which would change the speeds at its ends",
                remedy: "begin and end at rest, or leave out with_whole_cycles",
            }));
        }
        Ok(())
    }

    /// The law, slowed down to a whole number of control periods where that is asked for.
    pub(super) fn in_whole_cycles(&self, problem: &PathProblem<'_, N>, law: SpeedLaw) -> Result<SpeedLaw, PlanError> {
        if !self.settings.whole_cycles {
            return Ok(law);
        }
        self.check_ends_of_whole_cycles()?;
        // A duration that is whole but for rounding stays.
        let cycles = law.duration() / self.settings.period;
        let whole = (cycles * (1.0 - 1e-12)).ceil();
        if cycles >= whole {
            return Ok(law);
        }
        Ok(law.scaled(cycles / whole).map_err(|error| problem.explained(error))?)
    }

    /// A motion that exceeds limits slightly, slower as a whole, on a large grid or in a late round. Where that does not help, as friction
    /// can carry what brakes, the motion before, and none slower any more.
    fn slower_as_a_whole(
        &self,
        problem: &PathProblem<'_, N>,
        law: &SpeedLaw,
        (excess, rounds): (f64, usize),
        slowing: &mut Slowing,
    ) -> Result<Option<SpeedLaw>, PlanError> {
        if slowing.margin >= MOST_MARGIN {
            // A slower motion has its samples elsewhere: only the last one tells.
            let before = slowing.before.take_if(|(_, first)| excess >= *first);
            slowing.part = if before.is_some() { 1.0 } else { slowing.part };
            return Ok(before.map(|(law, _)| law));
        }
        let most = if rounds > LOCAL_ROUNDS { SLIGHT_AT_LAST } else { SLIGHT };
        let is_late = rounds > LOCAL_ROUNDS || problem.intervals() > LARGE;
        let slight = excess <= most && is_late;
        if !slight || self.settings.ends != [0.0; 2] || self.method != Method::JerkLimited {
            return Ok(None);
        }
        // Accelerations and jerks fall by more. The margin is for the setpoints of the slower motion, which lie elsewhere.
        let part = 1.0 - excess - slowing.margin;
        let slower = law.scaled(part).map_err(|error| problem.explained(error))?;
        slowing.before.get_or_insert_with(|| (law.clone(), excess));
        (slowing.margin, slowing.part) = (2.0 * slowing.margin, part * slowing.part);
        Ok(Some(slower))
    }

    /// The law with a part of each limit; in windows of the length that an earlier round found, where it did.
    pub(super) fn choose(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
        window: Option<usize>,
    ) -> Result<Chosen, PlanError> {
        if self.plans_in_windows(problem.intervals()) {
            return self.choose_in_windows(problem, used, window);
        }
        self.choose_at_once(problem, used)
    }

    /// The law of the whole path, planned at once.
    pub(super) fn choose_at_once(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
    ) -> Result<Chosen, PlanError> {
        let rows = problem.rows_within(used, self.method.needs())?;
        Ok(self.method.choose(&rows).map_err(|error| problem.explained(error))?.into())
    }

    /// Parts into which to divide the intervals on which a law exceeds limits; none where that makes too many.
    fn parts_where_exceeded(
        &self,
        problem: &PathProblem<'_, N>,
        verification: &Verification,
        law: &SpeedLaw,
    ) -> Option<Vec<usize>> {
        // As long as the grid has no more than that many intervals, or no more than so many times as many as before.
        const FINEST: usize = 4_000;
        const MOST_FINER: usize = 2;
        let mut parts = vec![1; problem.intervals()];
        for [from, to] in exceeded_stretches(verification, law, self.settings.period) {
            parts[problem.intervals_between(from, to)].fill(FINER);
        }
        let (before, after) = (problem.intervals(), parts.iter().sum::<usize>());
        let most = FINEST.max(MOST_FINER * before).min(MOST_INTERVALS);
        (before < after && after <= most).then_some(parts)
    }

    /// The same, from the law of a problem that is almost the same.
    fn choose_near(
        &self,
        problem: &PathProblem<'_, N>,
        used: &LimitFractions,
        law: &SpeedLaw,
        window: Option<usize>,
    ) -> Result<Chosen, PlanError> {
        if self.plans_in_windows(problem.intervals()) {
            return self.choose_in_windows(problem, used, window);
        }
        let rows = problem.rows_within(used, self.method.needs())?;
        Ok(self.method.choose_near(&rows, law).map_err(|error| problem.explained(error))?.into())
    }

    /// The law; where the planner did not converge on a grid of equal steps, the fastest of several grids.
    fn choose_over_grids(&self, problem: &mut PathProblem<'_, N>) -> Result<Chosen, PlanError> {
        // Another attempt of a planner that did not converge does not take a finer grid than this.
        const MOST_AGAIN: usize = 8000;
        let full = LimitFractions::default();
        let mut best = self.choose(problem, &full, None);
        if problem.path().tool_curve().is_some() {
            return best;
        }
        let n = self.settings.intervals;
        for intervals in [n + 1, 2 * n, 2 * n + 1, 4 * n].into_iter().filter(|n| *n <= MOST_AGAIN) {
            let doubtful = match &best {
                Ok(chosen) => !chosen.converged,
                Err(PlanError::Speed(error)) => error.is_not_converged(),
                Err(_) => false,
            };
            if !doubtful {
                break;
            }
            let settings = Settings { intervals, ..problem.settings.clone() };
            let other = PathProblem::new(&settings, problem.path.clone(), self.method.needs(), false)?;
            let again = self.choose(&other, &full, None);
            let faster = match (&again, &best) {
                (Ok(again), Ok(best)) => again.law.duration() < best.law.duration(),
                (again, best) => again.is_ok() && best.is_err(),
            };
            if faster {
                (*problem, best) = (other, again);
            }
        }
        best
    }

    /// The law on a grid whose intervals are divided where a draft says that their length costs time, from that draft, or the scan's
    /// where that is shorter; none where the planner makes no drafts or did not converge.
    fn choose_by_draft(&self, problem: &mut PathProblem<'_, N>) -> Option<Chosen> {
        // On grids of fewer intervals a finer one may lose: limits hold at more points there, and its first and last interval are shorter.
        const FEW: usize = 50;
        if self.method != Method::JerkLimited || self.plans_in_windows(problem.intervals()) {
            return None;
        }
        let full = LimitFractions::default();
        let rows = problem.rows_within(&full, self.method.needs()).ok()?;
        let draft = JerkLimited::draft(&rows).ok()?;
        let coarse = if rows.intervals() < FEW { JerkLimited::default().plan(&rows).ok() } else { None };
        // On grids of more intervals the planner is not compared with the scan.
        let is_coarse = rows.intervals() <= JerkLimitedOrScan::COARSE_INTERVALS;
        let scanned = if is_coarse { ContinuousAccelerationScan.plan(&rows).ok() } else { None };
        if let Some(parts) = parts_by_cost(&draft.grid_costs, draft.law.duration())
            && let Ok(finer) = problem.refined(|k| parts[k])
        {
            // Where the path cannot be followed on a finer grid, there is this one.
            *problem = finer;
        }
        let mut chosen = self.choose_near(problem, &full, &draft.law, None).ok()?;
        if let Some(law) = coarse.filter(|law| law.duration() < chosen.law.duration()) {
            chosen = Chosen { law, fallback: None, converged: chosen.converged, windows: None };
        }
        if let Some(law) = scanned.filter(|law| law.duration() < chosen.law.duration()) {
            let fallback = chosen.fallback.or(Some(Fallback::Slower { duration: chosen.law.duration() }));
            chosen = Chosen { law, fallback, converged: chosen.converged, windows: None };
        }
        self.choose_shorter_than_scan(problem, &mut chosen);
        chosen.converged.then_some(chosen)
    }

    /// Where the scan's law is the shorter one, jerk changes between the grid points: halves all intervals, as long as that makes the
    /// law shorter.
    fn choose_shorter_than_scan(&self, problem: &mut PathProblem<'_, N>, chosen: &mut Chosen) {
        // As long as the grid has no more intervals than that.
        const MOST_HALVED: usize = 4000;
        while matches!(chosen.fallback, Some(Fallback::Slower { .. })) && problem.intervals() <= MOST_HALVED {
            let Ok(finer) = problem.refined(|_| 2) else { return };
            let Ok(again) = self.choose_near(&finer, &LimitFractions::default(), &chosen.law, None) else { return };
            if again.law.duration() >= chosen.law.duration() {
                return;
            }
            (*problem, *chosen) = (finer, again);
        }
    }

    fn info(
        &self,
        problem: &PathProblem<'_, N>,
        chosen: &Chosen,
        (rounds, refined): (usize, usize),
        (used, slower): (&LimitFractions, f64),
    ) -> PlanInfo {
        let method = if chosen.fallback.is_some() { Method::ContinuousAcceleration } else { self.method };
        PlanInfo {
            method: Some(method),
            fallback: chosen.fallback,
            rounds,
            intervals: problem.intervals(),
            windows: chosen.windows.clone(),
            refined,
            lowered: used.lowered(),
            slowed: used.everywhere(),
            slower,
        }
    }
}

/// The part of all limits that is used where one is exceeded by far.
fn less_of_all(excess: f64) -> f64 {
    // By how much more all limits are lowered than the worst was exceeded, and by what at the most in one round.
    const SLOWER: f64 = 0.999;
    const MOST_SLOWER: f64 = 1.5;
    SLOWER / (1.0 + excess).min(MOST_SLOWER)
}
