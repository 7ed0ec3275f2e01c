//! Way-points from the tests and the reports of toppra's users: each is planned, keeps its limits, and is as fast as
//! its closed form.
//!
//! Origin: hungpham2511/toppra (MIT), `tests/tests/retime/robustness/problem_suite_1.yaml`,
//! `cpp/tests/test_issue_198.cpp`, and the numbers of its issues 15, 22 and 51. Only numbers are taken; the curve
//! through the points is a natural cubic spline.

use serde::Deserialize;

use crate::cubics::{Cubics, ROUNDING};

const CASES: &str = include_str!("../data/toppra_cases.json");

#[derive(Deserialize)]
struct File {
    line_problems: Vec<LineProblem>,
    issue_198: Hermite,
    issue_22: Sections,
}

/// Points between which all axes move on one line, forth or forth and back: the shortest time is known.
#[derive(Deserialize)]
struct LineProblem {
    name: String,
    points: Vec<Vec<f64>>,
    intervals: Vec<usize>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// The shortest time, s, where the suite states it.
    published: Option<f64>,
}

/// Positions and velocities at equal times: cubics between them.
#[derive(Deserialize)]
struct Hermite {
    duration: f64,
    q: Vec<Vec<f64>>,
    qd: Vec<Vec<f64>>,
    v: f64,
    a_lower: Vec<f64>,
    a_upper: Vec<f64>,
}

/// Velocity limits that are `reduced` between the second and the third point.
#[derive(Deserialize)]
struct Sections {
    points: Vec<Vec<f64>>,
    v: f64,
    a: f64,
    reduced: f64,
}

fn cases() -> File {
    serde_json::from_str(CASES).expect("valid cases")
}

#[test]
fn lines_of_any_size_take_their_shortest_time() {
    for case in cases().line_problems {
        let path = Cubics::natural(&case.points);
        // On a line all axes are in proportion: the time follows from the axis that its limits allow least.
        let reach = |i: usize, j: usize| (case.points[i][j] - case.points[0][j]).abs();
        let (far, back) = (0..case.points.len()).fold((0, false), |(far, _), i| {
            let is_far = (0..path.axes()).any(|j| reach(i, j) > reach(far, j));
            if is_far { (i, false) } else { (far, i > far) }
        });
        let once = (0..path.axes()).map(|j| 2.0 * (reach(far, j) / case.a[j]).sqrt()).fold(0.0, f64::max);
        let shortest = if back { 2.0 * once } else { once };
        if let Some(published) = case.published {
            assert!((shortest / published - 1.0).abs() < 1e-9, "{}: {shortest}", case.name);
        }
        for &intervals in &case.intervals {
            let name = format!("{}, {intervals} intervals", case.name);
            let law = path.planned(&path.grid(intervals), &case.v, &case.a, None, &name);
            let ratio = law.duration() / shortest;
            assert!((1.0 - 1e-9..1.02).contains(&ratio), "{name}: {ratio} of the shortest time {shortest} s");
            let worst = path.worst(&law, |_, j| case.v[j], &case.a);
            assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{name}: {worst:?}");
        }
    }
}

/// Ten joints, cubics with jumps of the second derivative at every point: toppra exceeded an acceleration limit between
/// its grid points.
#[test]
fn ten_joints_keep_their_acceleration_limits() {
    let case = cases().issue_198;
    let n = case.q.len() - 1;
    let knots = (0..=n).map(|i| case.duration * i as f64 / n as f64).collect();
    let path = Cubics::hermite(knots, &case.q, &case.qd);
    let v = vec![case.v; path.axes()];
    // The smaller one of both directions.
    let a: Vec<f64> = case.a_lower.iter().zip(&case.a_upper).map(|(lower, upper)| (-lower).min(*upper)).collect();
    let durations = [90, 360, 1440].map(|intervals| {
        let law = path.planned(&path.grid(intervals), &v, &a, None, "issue 198");
        let worst = path.worst(&law, |_, j| v[j], &a);
        assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{intervals}: {worst:?}");
        assert!(worst[1] > 0.9, "{intervals}: no acceleration binds, {worst:?}");
        law.duration()
    });
    assert!(durations[0] < 1.1 * durations[2] && durations[1] < 1.015 * durations[2], "{durations:?}");
}

/// Velocity limits that are a twentieth on the middle section: toppra's motion was faster there.
#[test]
fn velocity_limits_of_a_section_are_kept_to_its_ends() {
    let case = cases().issue_22;
    let path = Cubics::natural(&case.points);
    let (v, a) = (vec![case.v; path.axes()], vec![case.a; path.axes()]);
    let inside = |s: f64| (1.0 / 3.0..=2.0 / 3.0).contains(&s);
    let limit = |s: f64| if inside(s) { case.v * case.reduced } else { case.v };
    for intervals in [60, 600] {
        let grid = path.grid(intervals);
        let cap = |from: f64, to: f64| {
            let slope = |i: usize| {
                let s = from + (to - from) * i as f64 / 20.0;
                (0..path.axes()).map(|j| path.jet(path.piece(s, true), s, j)[1].abs()).fold(0.0, f64::max)
            };
            limit(0.5 * (from + to)) / (0..=20).map(slope).fold(0.0, f64::max)
        };
        let between: Vec<f64> = grid.windows(2).map(|w| cap(w[0], w[1])).collect();
        let at = |i: usize| between[i.saturating_sub(1)].min(between[i.min(between.len() - 1)]);
        let points: Vec<f64> = (0..grid.len()).map(at).collect();
        let law = path.planned(&grid, &v, &a, Some((&points, &between)), "issue 22");
        let worst = path.worst(&law, |s, _| limit(s), &a);
        let borders = [law.time_at_position(1.0 / 3.0), law.time_at_position(2.0 / 3.0)];
        assert!(worst[0] <= 1.0 + 1e-6 && worst[1] <= 1.0 + ROUNDING, "{intervals}: {worst:?}, borders at {borders:?}");
        // The slow section takes most of the time: 2 units at 0.5.
        assert!(borders[1] - borders[0] > 4.0, "{borders:?}");
    }
}

/// The duration hardly depends on the grid, and goes with the square root of the size: toppra had a floor of 0.2 s
/// (issues 15 and 51).
#[test]
fn small_motions_scale_as_large_ones() {
    for power in [0, 10, 20, 30] {
        // Without rounding in the points.
        let size = f64::powi(0.5, power);
        let points = [[-0.25, 0.25], [-0.25 - size, 0.25 + size], [-0.25, 0.25]].map(Vec::from);
        let path = Cubics::natural(&points);
        let shortest = 4.0 * f64::sqrt(size / 2.0);
        for intervals in [40, 100, 1000] {
            let law = path.planned(&path.grid(intervals), &[1e3, 1e3], &[2.0, 2.0], None, "forth and back");
            let ratio = law.duration() / shortest;
            assert!((1.0 - 1e-6..1.01).contains(&ratio), "{size}, {intervals}: {ratio}");
        }
    }
}
