//! Speed planning beside COPP 0.2 and clarabel 0.11 in one run: six joints, velocity and acceleration (and jerk), from
//! the path's derivatives to squared speeds, rows included (COPP evaluates the derivatives itself, six sines a point).
//!
//! Medians on an idle 2-core AMD EPYC VM:
//!
//! | N | both ends | reachability | COPP reachability | certified | jerk-limited | COPP third order, one program | clarabel | clarabel with jerk |
//! |---|---|---|---|---|---|---|---|---|
//! | 100 | 10.2 us | 15.3 us | 129 us | 0.14 ms | 1.4 ms | 24 ms | 26 ms | 0.16 s |
//! | 500 | 48.6 us | 69.6 us | 595 us | 0.66 ms | 6.9 ms | 203 ms | 137 ms | 1.1 s |
//! | 1000 | 99.2 us | 140 us | 1154 us | 1.39 ms | 13.1 ms | 477 ms | 282 ms | 2.5 s |
//!
//! Durations at N = 1000: reachability 13.63565 s by both, clarabel's optimum the same, certified 13.63201 s; jerk-limited 13.73663 s,
//! clarabel in sequence (up to eight programs of the same rows) 13.73614 s, COPP 13.78687 s after two programs (which do not keep
//! the limits between the points).
#![allow(missing_docs)]
use std::hint::black_box;

use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{
    ClarabelBaseline, FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability, JerkLimited,
    Reachability,
};
use copp::path::{Jet3, Path, sin};
use copp::robot::Robot;
use copp::solver::topp2_ra::{ReachSet2OptionsBuilder, Topp2ProblemBuilder, s_to_t_topp2, topp2_ra};
use copp::solver::topp3_socp::{ClarabelOptionsBuilder, Topp3ProblemBuilder, s_to_t_topp3, topp3_socp};
use criterion::{Criterion, criterion_group, criterion_main};

const JOINTS: usize = 6;
const V_MAX: [f64; JOINTS] = [1.02, 0.77, 1.16, 1.25, 1.25, 1.86];
const A_MAX: [f64; JOINTS] = [3.06, 2.31, 3.47, 3.74, 3.74, 5.5];
const J_MAX: [f64; JOINTS] = [30.6, 23.1, 34.7, 37.4, 37.4, 55.0];
/// Amplitude, frequency and phase of `q_j = a sin(f s + p)`.
const WAVES: [[f64; 3]; JOINTS] =
    [[1.0, 11.0, 0.0], [0.8, 17.0, 0.7], [0.6, 23.0, 1.9], [0.9, 14.0, 2.6], [0.5, 29.0, 0.4], [1.1, 8.0, 1.1]];

fn grid(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// First, second and third derivatives, row-major.
fn derivatives(grid: &[f64]) -> [Vec<f64>; 3] {
    let at = |order: i32| {
        let one = move |s: f64| {
            WAVES.map(|[a, f, p]| {
                let angle = f * s + p + f64::from(order) * std::f64::consts::FRAC_PI_2;
                a * f.powi(order) * angle.sin()
            })
        };
        grid.iter().flat_map(|&s| one(s)).collect()
    };
    [at(1), at(2), at(3)]
}

fn ours(
    grid: &[f64],
    [first, second, third]: &[Vec<f64>; 3],
    planner: &dyn FeedPlanner,
    jerk: bool,
    between: bool,
) -> f64 {
    let path = arcfeed_feedrate::constraint::PathDerivatives::new(JOINTS, first, second)
        .and_then(|path| path.with_third(third))
        .expect("arrays of equal length");
    let velocity = JointVelocity::new(path, &V_MAX).expect("valid limits");
    let acceleration = JointAcceleration::new(path, &A_MAX).expect("valid limits");
    let limit = JointJerk::new(path, &J_MAX).expect("valid limits");
    let problem = match (jerk, between) {
        (true, _) => FeedProblem::between_points(grid, &[&velocity, &acceleration, &limit]),
        (false, true) => FeedProblem::between_points(grid, &[&velocity, &acceleration]),
        (false, false) => FeedProblem::at_points(grid, &[&velocity, &acceleration]),
    };
    problem.and_then(|problem| planner.plan(&problem)).expect("a feasible problem").duration()
}

fn path() -> Path {
    Path::from_parametric(|s: Jet3| WAVES.iter().map(|&[a, f, p]| a * sin(f * s + p)).collect(), 0.0, 1.0)
        .expect("a smooth path")
}

/// Rows of COPP, those on jerk too where it is limited.
fn copp_robot(grid: &[f64], path: &Path, jerk: bool) -> Robot<usize> {
    let n = grid.len();
    let low = |limits: [f64; JOINTS]| limits.map(|limit| -limit);
    let mut robot = Robot::with_capacity(JOINTS, n);
    let rows = robot.with_s(grid).expect("a grid");
    let rows = if jerk { rows.with_q_from_path_3rd(path, 0, n) } else { rows.with_q_from_path_2nd(path, 0, n) };
    rows.expect("derivatives")
        .with_axial_velocity((&V_MAX[..], n), (&low(V_MAX)[..], n), 0)
        .and_then(|robot| robot.with_axial_acceleration((&A_MAX[..], n), (&low(A_MAX)[..], n), 0))
        .and_then(
            |robot| if jerk { robot.with_axial_jerk((&J_MAX[..], n), (&low(J_MAX)[..], n), 0) } else { Ok(robot) },
        )
        .expect("rows");
    robot
}

/// Squared speeds at the grid points without limits on jerk, by COPP.
fn copp_squared_speeds(robot: &Robot<usize>, n: usize) -> Vec<f64> {
    let problem = Topp2ProblemBuilder::new(robot, (0, n - 1), (0.0, 0.0)).build().expect("a problem");
    topp2_ra(&problem, &ReachSet2OptionsBuilder::new().build().expect("options")).expect("a solution")
}

/// Rows and solution by COPP: duration.
fn copp_second(grid: &[f64], path: &Path) -> f64 {
    let x = copp_squared_speeds(&copp_robot(grid, path, false), grid.len());
    s_to_t_topp2(grid, &x, 0.0).expect("times").0
}

/// Third order by COPP (conic programs of clarabel), the given number of them: duration.
fn copp_third(grid: &[f64], path: &Path, programs: usize) -> f64 {
    let mut robot = copp_robot(grid, path, true);
    let mut near = copp_squared_speeds(&robot, grid.len());
    robot.constraints.amax_substitute(&near, 0).expect("a bound");
    let options = ClarabelOptionsBuilder::new().allow_almost_solved(true).build().expect("options");
    let mut duration = f64::NAN;
    for _ in 0..programs {
        let problem = Topp3ProblemBuilder::new(&mut robot, 0, &near, (0.0, 0.0), (0.0, 0.0))
            .build_with_linearization()
            .expect("a problem");
        let profile = topp3_socp(&problem, &options).expect("a solution");
        duration = s_to_t_topp3(grid, profile.as_parts(), 0.0).expect("times").0;
        near = profile.a.clone();
    }
    duration
}

fn scheduling(c: &mut Criterion) {
    let path = path();
    for n in [100, 500, 1000] {
        let grid = grid(n);
        let samples = derivatives(&grid);
        let (jerk_limited, third) = (JerkLimited::default(), copp_third(&grid, &path, 2));
        let reachability = ours(&grid, &samples, &Reachability, false, false);
        // The same problem for both, or the times mean nothing.
        let ratio = reachability / copp_second(&grid, &path);
        assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
        println!(
            "{n}: both ends {:.5} s, reachability {reachability:.5} s, COPP {:.5} s, certified {:.5} s; jerk-limited {:.5} s, COPP {third:.5} s",
            ours(&grid, &samples, &ForwardBackwardScan, false, false),
            copp_second(&grid, &path),
            ours(&grid, &samples, &InterpolatedReachability, false, true),
            ours(&grid, &samples, &jerk_limited, true, true),
        );
        println!(
            "{n}: clarabel {:.5} s, with jerk {:.5} s",
            ours(&grid, &samples, &ClarabelBaseline, false, false),
            ours(&grid, &samples, &ClarabelBaseline, true, true),
        );
        let mut group = c.benchmark_group(n.to_string());
        group.bench_function("both ends", |b| {
            b.iter(|| ours(black_box(&grid), &samples, &ForwardBackwardScan, false, false))
        });
        group.bench_function("reachability", |b| {
            b.iter(|| ours(black_box(&grid), &samples, &Reachability, false, false))
        });
        group.bench_function("COPP reachability", |b| b.iter(|| copp_second(black_box(&grid), &path)));
        group.bench_function("certified", |b| {
            b.iter(|| ours(black_box(&grid), &samples, &InterpolatedReachability, false, true));
        });
        group.sample_size(10);
        group
            .bench_function("jerk-limited", |b| b.iter(|| ours(black_box(&grid), &samples, &jerk_limited, true, true)));
        group.bench_function("COPP third order, one program", |b| b.iter(|| copp_third(black_box(&grid), &path, 1)));
        group.bench_function("clarabel", |b| {
            b.iter(|| ours(black_box(&grid), &samples, &ClarabelBaseline, false, false));
        });
        group.bench_function("clarabel with jerk", |b| {
            b.iter(|| ours(black_box(&grid), &samples, &ClarabelBaseline, true, true));
        });
        group.finish();
    }
}

criterion_group!(benches, scheduling);
criterion_main!(benches);
