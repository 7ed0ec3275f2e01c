//! A grid fine enough for a motion: intervals are short in time where the speed changes, and short where the third derivatives of the
//! joints bend.

use arcfeed_feedrate::{ContinuousAccelerationScan, FeedPlanner, FeedProblem, MotionState, SpeedLaw};

use super::fractions::LimitFractions;
use super::grid;
use super::path_problem::PathProblem;
use super::settings::MOST_INTERVALS;
use crate::error::PlanError;

/// Parts of the duration: what the lengths of all intervals cost together where a finer grid is worth its time, and what one may
/// cost.
const WORTH: f64 = 3e-4;
const COSTS_LITTLE: f64 = 8e-7;
/// No interval is divided into more parts for that, nor the grid into more intervals per interval.
const MOST_PARTS_BY_COST: f64 = 8.0;
const MOST_BY_COST: usize = 4;
/// The jerk-limited planner takes no longer grid.
const MOST_PLANNED: usize = 200_000;

/// A place of a law.
#[derive(Debug, Clone, Copy)]
struct Place {
    s: f64,
    v: f64,
    /// Time to its neighbours that is aimed at, s.
    apart: f64,
}

impl Place {
    /// True if the other one comes later, and not too soon.
    fn is_apart(&self, later: &Self) -> bool {
        // Two grid points are no closer together than this part of the time to their neighbours.
        const CLOSEST: f64 = 0.5;
        later.s - self.s > CLOSEST * self.apart.max(later.apart) * 0.5 * (self.v + later.v)
    }
}

/// The problem on a finer grid, by the law of the continuous-acceleration scan; the same problem where that finds none. Longer grids are
/// looked at in parts of `most` intervals, each from rest to rest. At a seam that is no stop of the path the scan's law is slower than the
/// motion will be, and the grid coarser than elsewhere: what it does not see there the verification does.
pub(crate) fn resolved<const N: usize>(
    problem: PathProblem<'_, N>,
    most: usize,
) -> Result<PathProblem<'_, N>, PlanError> {
    let (mut grid, mut is_finer) = (vec![0.0], false);
    let parts = problem.for_parts(&LimitFractions::default(), most, |from, rows| {
        let finer = ContinuousAccelerationScan.plan(&rows).ok().map(|law| finer(&problem, &rows, &law, from));
        is_finer |= finer.is_some();
        grid.pop();
        grid.extend(finer.unwrap_or_else(|| rows.grid().to_vec()));
        Ok(())
    });
    parts.map_err(|error| problem.explained(error))?;
    if is_finer && grid.len() <= MOST_INTERVALS { problem.on_grid(grid) } else { Ok(problem) }
}

/// A finer grid for the intervals of `rows`, the first of which is the interval `first` of the problem.
fn finer<const N: usize>(problem: &PathProblem<'_, N>, rows: &FeedProblem, law: &SpeedLaw, first: usize) -> Vec<f64> {
    // Part of the time in which a joint's acceleration builds up that an interval takes at the most where the speed changes.
    const OF_BUILD_UP: f64 = 0.1;
    // Part of a limit on jerk by which the middle of an interval may be off the mean of its ends: its middle is in the rows, and what is left
    // is a tenth of that.
    const MISFIT: f64 = 2e-3;
    // The fastest motion is so much faster than the scan's.
    const FASTER: f64 = 1.3;
    // No interval is divided into more parts.
    const MOST_PARTS: f64 = 100.0;
    // As many intervals are made for the sake of bends, unless the grid has half as many before.
    const MOST_BENDS: usize = 20_000;
    let joints = problem.settings.limits.joints();
    let build_up = joints.acceleration().component_div(joints.jerk());
    let build_up = build_up.iter().copied().filter(|time| *time > 0.0).fold(f64::INFINITY, f64::min);
    let grid = grid::graded(with_changes(rows.grid(), law, OF_BUILD_UP * build_up));
    let speeds: Vec<f64> = rows.grid().iter().map(|&s| law.v_at_s(s)).collect();
    let shortest = grid::shortest(grid.len(), problem.settings.period);
    let mut k = 0;
    let parts: Vec<usize> = grid
        .windows(2)
        .map(|pair| {
            while rows.grid()[k + 1] <= pair[0] {
                k += 1;
            }
            let fastest = FASTER * speeds[k].max(speeds[k + 1]);
            let of = (pair[1] - pair[0]) / rows.h(k);
            let by_bend = of * (problem.third_misfit(first + k) * fastest.powi(3) / MISFIT).sqrt();
            let by_time = (pair[1] - pair[0]) / (shortest * fastest);
            by_bend.min(by_time).ceil().max(1.0).min(MOST_PARTS) as usize
        })
        .collect();
    // Where bends ask for more than can be planned at once, verification will ask for less of the limits.
    if parts.iter().sum::<usize>() > MOST_BENDS.max(2 * grid.len()) {
        return grid;
    }
    grid::refined(&grid, |k| parts[k])
}

/// The grid with places of the law in between, where its speed changes: at most `longest` (s) apart, or a little more on a motion that
/// changes its speed for long.
fn with_changes(grid: &[f64], law: &SpeedLaw, longest: f64) -> Vec<f64> {
    // As many intervals are made, about, at the least and at the most where the speed changes.
    const LEAST: f64 = 400.0;
    const MOST: f64 = 4000.0;
    // Part of the time from one constant speed to the next that an interval takes at the most.
    const OF_CHANGE: f64 = 1.0 / 24.0;
    // But not less than this part of the longest time.
    const LEAST_PART: f64 = 0.3;
    let knots: Vec<(f64, MotionState)> = law.knots().collect();
    let changes = |pair: &[(f64, MotionState)]| pair[0].1.a != 0.0 || pair[1].1.a != 0.0 || pair[0].1.j != 0.0;
    let changing: f64 = knots.windows(2).filter(|pair| changes(pair)).map(|pair| pair[1].0 - pair[0].0).sum();
    let longest = longest.min(changing / LEAST).max(changing / MOST);
    let mut places: Vec<Place> = Vec::new();
    let mut cursor = law.cursor();
    // From one constant speed or rest to the next.
    for change in
        knots.windows(2).collect::<Vec<_>>().chunk_by(|a, b| changes(a) == changes(b)).filter(|run| changes(run[0]))
    {
        let (from, to) = (change[0][0].0, change[change.len() - 1][1].0);
        let apart = longest.min(OF_CHANGE * (to - from)).max(LEAST_PART * longest);
        let rests = |state: &MotionState| state.v == 0.0;
        for pair in change {
            if rests(&pair[0].1) || rests(&pair[1].1) {
                // With constant jerk from or to rest: the planner does that in one interval.
                let place = if rests(&pair[0].1) { &pair[1].1 } else { &pair[0].1 };
                places.push(Place { s: place.p, v: place.v, apart });
                continue;
            }
            let time = pair[1].0 - pair[0].0;
            let parts = (time / apart).ceil().max(1.0);
            let mut part = 0.0;
            while part <= parts {
                let state = cursor.at(pair[0].0 + time * (part / parts));
                places.push(Place { s: state.p, v: state.v, apart });
                part += 1.0;
            }
        }
    }
    let mut fine = Vec::with_capacity(grid.len() + places.len());
    let mut places = places.into_iter().peekable();
    for pair in grid.windows(2) {
        fine.push(pair[0]);
        let at = |s: f64| Place { s, v: law.v_at_s(s), apart: 0.0 };
        let (mut last, end) = (at(pair[0]), at(pair[1]));
        while let Some(place) = places.next_if(|place| place.s < end.s) {
            if last.is_apart(&place) && place.is_apart(&end) {
                fine.push(place.s);
                last = place;
            }
        }
    }
    fine.extend(grid.last());
    fine
}

/// Into how many parts to divide each interval, by what its length costs (s) of a motion of some duration (s); none where little is
/// to be gained. Half as long, an interval costs half as much.
pub(crate) fn parts_by_cost(costs: &[f64], duration: f64) -> Option<Vec<usize>> {
    let all: f64 = costs.iter().sum();
    let most_intervals = (MOST_BY_COST * costs.len()).min(MOST_PLANNED);
    // Written so that NaN ends it.
    if !(duration > 0.0 && all > WORTH * duration && costs.len() < most_intervals) {
        return None;
    }
    let mut most = COSTS_LITTLE * duration;
    loop {
        let of = |cost: &f64| (cost / most).sqrt().ceil().max(1.0).min(MOST_PARTS_BY_COST) as usize;
        let parts: Vec<usize> = costs.iter().map(of).collect();
        if parts.iter().sum::<usize>() <= most_intervals {
            return parts.iter().any(|parts| *parts > 1).then_some(parts);
        }
        most *= 1.5;
    }
}
