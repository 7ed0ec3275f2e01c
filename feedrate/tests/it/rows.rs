//! Second-order planners against durations made with other programs.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::constraint::{
    JointAcceleration, JointJerk, JointTorque, JointVelocity, PathConstraint, PathDerivatives, TangentialAcceleration,
    TangentialJerk,
};
use arcfeed_feedrate::{
    FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability, Reachability, SpeedLaw,
};

use crate::spline_paths;
use spline_paths::{A_MAX, JOINTS, Path, Spline, TAU_C, V_A, V_B, paths};

fn velocity(case: char) -> &'static [f64; JOINTS] {
    if case == 'B' { &V_B } else { &V_A }
}

fn problem(path: &Path, case: char, grid: &[f64], between: bool) -> FeedProblem {
    let samples = path.spline.samples(grid);
    let velocity = JointVelocity::new(samples.path(), velocity(case)).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let make = if between { FeedProblem::between_points } else { FeedProblem::at_points };
    if case == 'C' {
        let [a, b, d] = &path.torque;
        let torque = JointTorque::new(a, b, &[], d, &TAU_C).unwrap();
        return make(grid, &[&velocity, &acceleration, &torque]).unwrap();
    }
    make(grid, &[&velocity, &acceleration]).unwrap()
}

/// Worst excess over a row at both ends of every interval, in units of its limit.
fn excess_at_grid(problem: &FeedProblem, plan: &SpeedLaw) -> f64 {
    let mut states: Vec<_> = plan.knots().map(|(_, state)| state).collect();
    states.push(plan.end());
    let mut worst = 0.0_f64;
    for k in 0..problem.intervals() {
        for i in [k, k + 1] {
            let x = states[i].v * states[i].v;
            for row in problem.rows(i) {
                worst = worst.max(row.excess(states[k].a, x) / row.hi);
            }
            let cap = problem.cap(i).0;
            worst = worst.max(x / cap - 1.0);
        }
    }
    worst
}

/// The scan as printed (Electronics 2025, 14, 3869, eqs. 16 to 19): each row is tested at the far end of an interval alone.
fn published(problem: &FeedProblem) -> SpeedLaw {
    let n = problem.intervals();
    // The greatest y up to which `p y - shift` stays inside the limit; every row here is symmetric, without c.
    let greatest = |i: usize, p: &dyn Fn(f64, f64) -> f64, shift: &dyn Fn(f64) -> f64, cap: f64| {
        let rows = problem.rows(i).iter();
        rows.fold(cap, |y, row| {
            let p = p(row.a, row.b);
            y.min((row.hi + p.signum() * (shift(row.a) - row.d)) / p.abs())
        })
    };
    let top: Vec<f64> = (0..=n).map(|i| greatest(i, &|_, b| b, &|_| 0.0, problem.cap(i).0)).collect();
    let pass = |order: Vec<usize>| {
        let mut x = vec![0.0; n + 1];
        for w in order.windows(2) {
            let (from, to) = (w[0], w[1]);
            let per_u = 0.5 / (problem.grid()[to] - problem.grid()[from]);
            let old = x[from];
            let reached = greatest(to, &|a, b| a * per_u + b, &|a| a * per_u * old, top[to]);
            x[to] = if top[to] <= old { top[to] } else { reached.max(old) };
        }
        x
    };
    let (up, down) = (pass((0..=n).collect()), pass((0..=n).rev().collect()));
    let v: Vec<f64> = up.iter().zip(&down).map(|(a, b)| a.min(*b).sqrt()).collect();
    SpeedLaw::from_knots(problem.grid(), &v).unwrap()
}

#[test]
fn durations_of_the_reference_programs() {
    for path in paths() {
        for r in path.references.iter().filter(|r| r.case != 'C' || !path.torque[0].is_empty() && r.n == 100) {
            let at = format!("seed {} case {} N = {}", path.seed, r.case, r.n);
            let problem = problem(&path, r.case, &Spline::uniform(r.n), false);
            let reachability = Reachability.plan(&problem).unwrap();
            let ratio = reachability.duration() / r.exact;
            assert!((ratio - 1.0).abs() < 1e-6, "{at}: reachability {ratio}");
            assert!(excess_at_grid(&problem, &reachability) < 1e-9, "{at}");

            let scan = ForwardBackwardScan.plan(&problem).unwrap();
            let ratio = scan.duration() / r.both_ends;
            assert!((ratio - 1.0).abs() < 1e-6, "{at}: both ends {ratio}");
            assert!(scan.duration() <= 1.02 * r.exact && scan.duration() >= r.dual_bound, "{at}");
            assert!(excess_at_grid(&problem, &scan) < 1e-9, "{at}");

            let published = published(&problem);
            let ratio = published.duration() / r.published;
            assert!((ratio - 1.0).abs() < 1e-6, "{at}: published {ratio}");
        }
    }
}

#[test]
fn the_published_scan_breaks_its_limits() {
    let mut worst = 0.0_f64;
    for path in paths() {
        let problem = problem(&path, 'B', &Spline::uniform(100), false);
        worst = worst.max(excess_at_grid(&problem, &published(&problem)));
    }
    assert!(worst > 0.5, "{worst}");
}

#[test]
fn certified_plans_exceed_nothing_between_the_points() {
    let mut slowest = 0.0_f64;
    for path in paths() {
        for fine in &path.fine {
            let grid = path.spline.on_knots(1000);
            let plan = InterpolatedReachability.plan(&problem(&path, fine.case, &grid, true)).unwrap();
            let worst = spline_paths::worst(&path.spline, &grid, &plan, 20, velocity(fine.case), &A_MAX);
            assert!(worst[0] <= 1.0 + 1e-9 && worst[1] <= 1.0 + 1e-9, "seed {} {}: {worst:?}", path.seed, fine.case);
            let ratio = plan.duration() / fine.fine;
            slowest = slowest.max(ratio);
        }
    }
    assert!(slowest <= 1.001, "{slowest}");
}

/// Torque known at twice as many points as the grid has: what the interpolated middle leaves at the points in between.
#[test]
fn certified_torque_between_the_points() {
    let mut worst = [0.0_f64; 2];
    for path in paths().iter().filter(|path| !path.torque[0].is_empty()) {
        let [a, b, d] = &path.torque;
        let every_second =
            |values: &[f64]| -> Vec<f64> { values.chunks(2 * JOINTS).flat_map(|c| &c[..JOINTS]).copied().collect() };
        let (coarse_a, coarse_b, coarse_d) = (every_second(a), every_second(b), every_second(d));
        let grid = Spline::uniform(50);
        let samples = path.spline.samples(&grid);
        let velocity = JointVelocity::new(samples.path(), &V_A).unwrap();
        let torque = JointTorque::new(&coarse_a, &coarse_b, &[], &coarse_d, &TAU_C).unwrap();
        let problem = FeedProblem::between_points(&grid, &[&velocity, &torque]).unwrap();
        for (k, plan) in [Reachability.plan(&problem), InterpolatedReachability.plan(&problem)].into_iter().enumerate()
        {
            let plan = plan.unwrap();
            for i in 0..50 {
                let state = plan.at_position((2 * i + 1) as f64 / 100.0);
                for (j, tau) in TAU_C.iter().enumerate() {
                    let at = (2 * i + 1) * JOINTS + j;
                    let value = a[at] * state.a + b[at] * state.v * state.v + d[at];
                    worst[k] = worst[k].max(value.abs() / tau);
                }
            }
        }
    }
    // 50 intervals for 20 way-points are far too few; still most of the excess goes.
    assert!(worst[0] > 1.2 && worst[1] < 1.1, "{worst:?}");
}

/// The bend of a path jumps at a grid point: the limit holds on both sides of it.
#[test]
fn an_acceleration_limit_holds_before_a_jump_of_the_second_derivative() {
    let grid = [0.0, 0.5, 1.0, 1.5];
    // The sharp bend ends where the second interval begins.
    let (first, second, before) = ([1.0; 4], [8.0, 0.5, 0.5, 0.5], [8.0, 8.0, 0.5, 0.5]);
    let path = PathDerivatives::new(1, &first, &second).unwrap().with_values_before(&[], &before, &[]).unwrap();
    let acceleration = JointAcceleration::new(path, &[2.0]).unwrap();
    let problem = FeedProblem::at_points(&grid, &[&acceleration]).unwrap();
    let factors: Vec<f64> = problem.rows(1).iter().map(|row| row.b).collect();
    assert_eq!(factors, [0.5, 8.0]);
    assert_eq!(problem.rows(2).len(), 1);
    for planner in [&Reachability as &dyn FeedPlanner, &ForwardBackwardScan] {
        // 8 v^2 - a = 2 at least, with the hardest braking of 2.
        let v = planner.plan(&problem).unwrap().at_position(0.5).v;
        assert!(v <= 0.5_f64.sqrt() + 1e-9, "{v}");
    }
}

/// Two joints, of which the second moves twice as fast as the path: the acceleration and the jerk that a standstill leaves along it.
#[test]
fn a_standstill_leaves_what_the_strictest_limit_leaves() {
    let grid = [0.0, 0.5, 1.0];
    let (first, zeros) = ([1.0, 2.0, 1.0, 2.0, 1.0, 2.0], [0.0; 6]);
    let path = PathDerivatives::new(2, &first, &zeros).and_then(|path| path.with_third(&zeros)).unwrap();
    let tangential = (TangentialAcceleration::new(3.0).unwrap(), TangentialJerk::new(7.0).unwrap());
    for ([a1, a2], [j1, j2], expected) in [
        ([9.0, 5.0], [90.0, 10.0], (2.5, 5.0)),
        ([2.0, 5.0], [6.0, 90.0], (2.0, 6.0)),
        ([9.0, 9.0], [90.0, 90.0], (3.0, 7.0)),
    ] {
        let (accelerations, jerks) = ([a1, a2], [j1, j2]);
        let velocity = JointVelocity::new(path, &[1.0, 1.0]).unwrap();
        let acceleration = JointAcceleration::new(path, &accelerations).unwrap();
        let jerk = JointJerk::new(path, &jerks).unwrap();
        let all: [&dyn PathConstraint; 5] = [&velocity, &acceleration, &jerk, &tangential.0, &tangential.1];
        let got = FeedProblem::between_points(&grid, &all).unwrap().rest_limits().unwrap();
        assert!((got.0 - expected.0).abs() < 1e-12 && (got.1 - expected.1).abs() < 1e-12, "{got:?} {expected:?}");
    }
}
