//! The jerk-limited planner on coarse, fine and long grids, from other laws, and with less of a limit on a part of the path.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathConstraint, Stop, TangentialAcceleration, TangentialJerk,
    Within,
};
use arcfeed_feedrate::{
    ContinuousAccelerationScan, FeedError, FeedPlanner, FeedProblem, JerkLimited, LimitId, Quantity, Reachability,
    SpeedLaw,
};

use crate::spline_paths::{A_MAX, Path, V_A, paths, worst};

fn jerk() -> [f64; 6] {
    A_MAX.map(|a| 10.0 * a)
}

fn problem(path: &Path, grid: &[f64]) -> FeedProblem {
    let (samples, jerk) = (path.spline.samples(grid), jerk());
    let velocity = JointVelocity::new(samples.path(), &V_A).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let jerk = JointJerk::new(samples.path(), &jerk).unwrap();
    FeedProblem::between_points(grid, &[&velocity, &acceleration, &jerk]).unwrap()
}

/// Dividing the intervals that cost most gains most of what they cost, and dividing those that cost least gains little.
#[test]
fn intervals_that_cost_time_are_known() {
    let planner = JerkLimited::new(1e-6).unwrap();
    for path in &paths()[4..5] {
        let grid = path.spline.on_knots(1000);
        let coarse = planner.plan_noting_convergence(&problem(path, &grid)).unwrap();
        let cost: f64 = coarse.grid_costs.iter().sum();
        assert_eq!(coarse.grid_costs.len(), grid.len() - 1);
        let mut order: Vec<usize> = (0..grid.len() - 1).collect();
        order.sort_by(|&a, &b| coarse.grid_costs[b].total_cmp(&coarse.grid_costs[a]));
        let divided = |chosen: &[usize]| {
            let mut fine = Vec::new();
            for (k, pair) in grid.windows(2).enumerate() {
                let parts = if chosen.contains(&k) { 4 } else { 1 };
                fine.extend((0..parts).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(parts)));
            }
            fine.push(1.0);
            coarse.law.duration() - planner.plan(&problem(path, &fine)).unwrap().duration()
        };
        let quarter = order.len() / 4;
        let (dear, cheap) = (divided(&order[..quarter]), divided(&order[order.len() - quarter..]));
        assert!(dear > 3.0 * cheap, "seed {}: {dear} s by the dear quarter, {cheap} s by the cheap one", path.seed);
        assert!(dear > 0.3 * cost, "seed {}: {dear} s of {cost} s", path.seed);
    }
}

#[test]
fn any_law_will_do_to_start_from() {
    let path = &paths()[2];
    let problem = problem(path, &path.spline.on_knots(400));
    let planner = JerkLimited::default();
    let own = planner.plan(&problem).unwrap();
    let others =
        [own.clone(), Reachability.plan(&problem).unwrap(), ContinuousAccelerationScan.plan(&problem).unwrap()];
    for law in others {
        let near = planner.plan_near(&problem, &law).unwrap();
        let ratio = near.law.duration() / own.duration();
        assert!((ratio - 1.0).abs() < 2e-4, "{ratio} from a law of {} s", law.duration());
    }
    // Nor does one lead astray where speeds are given at the ends, so that it cannot be slowed down as a whole.
    let problem = problem.with_end_speeds(0.02, 0.02).unwrap();
    let own = planner.plan(&problem).unwrap();
    let length = problem.grid()[problem.intervals()];
    let resting = SpeedLaw::from_knots(&[0.0, 0.5 * length, length], &[0.02, 0.0, 0.02]).unwrap();
    let spiked: Vec<f64> =
        problem.grid().iter().enumerate().map(|(i, s)| own.v_at_s(*s) * (1.0 + 0.5 * (i % 2) as f64)).collect();
    let spiked = SpeedLaw::from_knots(problem.grid(), &spiked).unwrap();
    let faster = own.scaled(3.0).unwrap();
    for law in [own.clone(), resting, faster, spiked] {
        let near = planner.plan_near(&problem, &law).unwrap();
        let ratio = near.law.duration() / own.duration();
        assert!((ratio - 1.0).abs() < 2e-4, "{ratio} from a law of {} s, with speeds at the ends", law.duration());
    }
}

/// A draft is near the plan, says about the same of the grid, and a plan that starts from it is as short as one of its own.
#[test]
fn a_draft_lays_the_grid_and_is_a_start() {
    let planner = JerkLimited::default();
    for path in paths().iter().take(3) {
        for n in [400, 1200] {
            let problem = problem(path, &path.spline.on_knots(n));
            let own = planner.plan_noting_convergence(&problem).unwrap();
            let draft = JerkLimited::draft(&problem).unwrap();
            let ratio = draft.law.duration() / own.law.duration();
            assert!((ratio - 1.0).abs() < 5e-3, "seed {}, {n}: {ratio}", path.seed);
            let costs = [&draft.grid_costs, &own.grid_costs].map(|costs| costs.iter().sum::<f64>());
            assert!((costs[0] / costs[1] - 1.0).abs() < 0.2, "seed {}, {n}: {costs:?}", path.seed);
            let near = planner.plan_near(&problem, &draft.law).unwrap();
            let ratio = near.law.duration() / own.law.duration();
            assert!((ratio - 1.0).abs() < 2e-4, "seed {}, {n}: {ratio}", path.seed);
        }
    }
}

/// A grid of more than 800 intervals is planned on a part of its points first, and that one likewise: nothing is exceeded, and the
/// motion is no longer than on a coarser grid, but for what shorter intervals at constant jerk next to rest cost.
#[test]
fn long_grids_are_planned_as_well_as_short_ones() {
    for path in [&paths()[1], &paths()[3]] {
        let duration = |n: usize| {
            let grid = path.spline.on_knots(n);
            let plan = JerkLimited::default().plan(&problem(path, &grid)).unwrap();
            let ratios = worst(&path.spline, &grid, &plan, 4, &V_A, &jerk());
            assert!(ratios.iter().all(|ratio| *ratio <= 1.0 + 1e-6), "seed {}, {n}: {ratios:?}", path.seed);
            plan.duration()
        };
        // The shorter one is planned without a coarser one before.
        let [short, long] = [750, 26_000].map(duration);
        assert!(long < short * (1.0 + 5e-4), "seed {}: {long} s, {short} s on the shorter grid", path.seed);
    }
}

/// Less of one limit on a part of the path slows the motion down there and nowhere else.
#[test]
fn less_of_a_limit_is_kept_where_it_is_asked_for() {
    let path = &paths()[4];
    let grid = path.spline.on_knots(500);
    let full = problem(path, &grid);
    let limit = LimitId::joint(Quantity::JointJerk, 1);
    let (from, to) = (200, 230);
    let less = full.clone().with_fraction(limit, from..=to, 0.5).unwrap();
    for k in 0..full.intervals() {
        for within in [Within::Start, Within::Middle, Within::End] {
            for (row, before) in less.jerk_rows(k, within).iter().zip(full.jerk_rows(k, within)) {
                let fraction = if row.source == limit && (from..=to).contains(&k) { 0.5 } else { 1.0 };
                assert_eq!(row.limit, fraction * before.limit, "{k}");
            }
        }
    }
    let [before, after] = [&full, &less].map(|problem| JerkLimited::default().plan(problem).unwrap().duration());
    assert!(after > before, "{after} s, {before} s before");
    let everywhere = full.clone().with_fraction(limit, 0..=full.intervals() - 1, 0.5).unwrap();
    let everywhere = JerkLimited::default().plan(&everywhere).unwrap().duration();
    assert!(after < everywhere, "{after} s, {everywhere} s with less of it everywhere");

    let acceleration = LimitId::joint(Quantity::JointAcceleration, 3);
    let less = full.clone().with_fraction(acceleration, 7..=7, 0.25).unwrap();
    let of = |problem: &FeedProblem, i: usize| {
        problem.rows(i).iter().find(|row| row.source == acceleration).map(|row| [row.lo, row.hi]).unwrap()
    };
    for i in 5..11 {
        let fraction = if i == 7 || i == 8 { 0.25 } else { 1.0 };
        assert_eq!(of(&less, i), of(&full, i).map(|bound| fraction * bound), "{i}");
    }
    let refused = |intervals, fraction| full.clone().with_fraction(limit, intervals, fraction).unwrap_err();
    assert!(matches!(refused(0..=1, 0.0), FeedError::NotPositive { .. }));
    assert!(matches!(refused(0..=1, f64::NAN), FeedError::NotPositive { .. }));
    assert!(matches!(refused(0..=1, 1.5), FeedError::AboveLimit { .. }));
    assert!(matches!(refused(0..=full.intervals(), 0.5), FeedError::LengthMismatch { .. }));
}

/// A grid on which every fourth point is a stop keeps nearly all its points when it is thinned: it is planned all the same.
#[test]
fn many_short_stretches_between_stops_are_planned() {
    let (count, each) = (1000, 4);
    let n = count * each;
    let grid: Vec<f64> = (0..=n).map(|i| i as f64).collect();
    let feeds = vec![1.0; n];
    let feed = Feed::new(&feeds).unwrap();
    let (acceleration, jerk) = (TangentialAcceleration::new(1.0).unwrap(), TangentialJerk::new(1.0).unwrap());
    let stops: Vec<Stop> = (1..count).map(|k| Stop { at: k * each }).collect();
    let mut constraints: Vec<&dyn PathConstraint> = vec![&feed, &acceleration, &jerk];
    constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
    let problem = FeedProblem::between_points(&grid, &constraints).unwrap();
    let plan = JerkLimited::default().plan(&problem).unwrap();
    // One stretch alone.
    let feed = Feed::new(&feeds[..each]).unwrap();
    let one = FeedProblem::between_points(&grid[..=each], &[&feed, &acceleration, &jerk]).unwrap();
    let one = JerkLimited::default().plan(&one).unwrap().duration();
    assert!((plan.duration() / (count as f64 * one) - 1.0).abs() < 1e-6, "{} {one}", plan.duration());
}
