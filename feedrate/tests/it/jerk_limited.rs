//! The jerk-limited planner: nothing exceeded on dense samples, durations beside other programs and closed forms.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointVelocity, PathDerivatives, Stop, TangentialAcceleration, TangentialJerk,
};
use arcfeed_feedrate::{
    AxisLimits, FeedError, FeedPlanner, FeedProblem, JerkLimited, MotionLaw, Reachability, SProfile, SpeedLaw,
};

use crate::spline_paths;
use spline_paths::{A_MAX, JOINTS, Path, V_A, V_B, paths, worst};

fn jerk() -> [f64; JOINTS] {
    A_MAX.map(|a| 10.0 * a)
}

fn velocity(case: char) -> &'static [f64; JOINTS] {
    if case == 'B' { &V_B } else { &V_A }
}

fn problem(path: &Path, case: char, grid: &[f64], ends: [f64; 2]) -> FeedProblem {
    let (samples, jerk) = (path.spline.samples(grid), jerk());
    let velocity = JointVelocity::new(samples.path(), velocity(case)).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let jerk = JointJerk::new(samples.path(), &jerk).unwrap();
    let problem = FeedProblem::between_points(grid, &[&velocity, &acceleration, &jerk]).unwrap();
    problem.with_end_speeds(ends[0], ends[1]).unwrap()
}

fn assert_inside(path: &Path, case: char, grid: &[f64], plan: &SpeedLaw) {
    let ratios = worst(&path.spline, grid, plan, 20, velocity(case), &jerk());
    assert!(ratios.iter().all(|ratio| *ratio <= 1.0 + 1e-6), "seed {} {case}: {ratios:?}", path.seed);
}

/// COPP's third-order program on its own, coarser grid exceeds its limits between the points and still is slower; the
/// second-order optimum is a lower bound.
#[test]
fn exceeds_nothing_and_beats_the_reference_program() {
    for path in paths().iter().step_by(if cfg!(debug_assertions) { 3 } else { 1 }) {
        for fine in &path.fine {
            let grid = path.spline.on_knots(1000);
            let plan = JerkLimited::default().plan(&problem(path, fine.case, &grid, [0.0; 2])).unwrap();
            assert_inside(path, fine.case, &grid, &plan);
            let duration = plan.duration();
            assert!(duration > fine.fine, "seed {} {}", path.seed, fine.case);
            assert!(!(duration > fine.jerk), "seed {} {}: {duration} against {}", path.seed, fine.case, fine.jerk);
        }
    }
}

#[test]
fn a_finer_grid_gains_little() {
    for path in &paths()[3..6] {
        let duration = |n: usize| {
            let grid = path.spline.on_knots(n);
            JerkLimited::default().plan(&problem(path, 'A', &grid, [0.0; 2])).unwrap().duration()
        };
        let ratio = duration(1000) / duration(4000);
        // Next to rest a finer grid costs a little: the interval at constant jerk is shorter than the jerk lasts.
        assert!((1.0 - 2e-4..1.005).contains(&ratio), "seed {}: {ratio}", path.seed);
    }
}

#[test]
fn starts_and_ends_in_motion() {
    for path in &paths()[..8] {
        let grid = path.spline.on_knots(600);
        // Speeds well inside what the ends allow.
        let rest = Reachability.plan(&problem(path, 'A', &grid, [0.0; 2])).unwrap();
        let speeds = [0.3 * rest.at_position(0.05).v, 0.3 * rest.at_position(0.95).v];
        let plan = JerkLimited::default().plan(&problem(path, 'A', &grid, speeds)).unwrap();
        assert_inside(path, 'A', &grid, &plan);
        let (first, last) = (plan.at(0.0), plan.at(plan.duration()));
        assert!((first.v - speeds[0]).abs() < 1e-12 && first.a.abs() < 1e-9 * first.v * first.v, "{first:?}");
        assert_eq!(last.v, speeds[1]);
    }
}

/// `q = s` with one joint is the seven-phase profile.
#[test]
fn a_straight_line_is_the_seven_phase_profile() {
    for (v, a, j) in [(0.2, 2.0, 40.0), (1.0, 2.0, 40.0), (0.05, 5.0, 20.0)] {
        let exact = SProfile::new(0.3, 0.0, 0.0, &AxisLimits::symmetric(v, a, j).unwrap()).unwrap().duration();
        for n in [100, 400, 1600] {
            let grid: Vec<f64> = (0..=n).map(|i| 0.3 * f64::from(i) / f64::from(n)).collect();
            let feed = vec![v; n as usize];
            let problem = FeedProblem::between_points(
                &grid,
                &[
                    &Feed::new(&feed).unwrap(),
                    &TangentialAcceleration::new(a).unwrap(),
                    &TangentialJerk::new(j).unwrap(),
                ],
            )
            .unwrap();
            let ratio = JerkLimited::new(1e-6).unwrap().plan(&problem).unwrap().duration() / exact;
            assert!((1.0 - 1e-9..1.003).contains(&ratio), "n = {n}: {ratio}");
        }
    }
}

#[test]
fn the_unit_of_s_does_not_matter() {
    let path = &paths()[2];
    let grid = path.spline.on_knots(200);
    let reference = JerkLimited::default().plan(&problem(path, 'A', &grid, [0.0; 2])).unwrap().duration();
    for scale in [1e-3, 1e3, 1e6] {
        let mut samples = path.spline.samples(&grid);
        let scaled: Vec<f64> = grid.iter().map(|s| s * scale).collect();
        samples.first.iter_mut().for_each(|q| *q /= scale);
        samples.second.iter_mut().for_each(|q| *q /= scale * scale);
        samples.third.iter_mut().chain(&mut samples.third_before).for_each(|q| *q /= scale * scale * scale);
        let jerk = jerk();
        let velocity = JointVelocity::new(samples.path(), &V_A).unwrap();
        let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
        let jerk = JointJerk::new(samples.path(), &jerk).unwrap();
        let problem = FeedProblem::between_points(&scaled, &[&velocity, &acceleration, &jerk]).unwrap();
        let duration = JerkLimited::default().plan(&problem).unwrap().duration();
        assert!((duration / reference - 1.0).abs() < 1e-9, "{scale}: {duration} instead of {reference}");
    }
}

#[test]
fn stops_where_the_cap_is_zero() {
    let path = &paths()[8];
    let grid = path.spline.on_knots(400);
    let (samples, limits) = (path.spline.samples(&grid), jerk());
    let velocity = JointVelocity::new(samples.path(), &V_A).unwrap();
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let jerk = JointJerk::new(samples.path(), &limits).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&velocity, &acceleration, &jerk, &Stop { at: 150 }]).unwrap();
    let plan = JerkLimited::default().plan(&problem).unwrap();
    assert_inside(path, 'A', &grid, &plan);
    let (time, _) = plan.knots().find(|(_, state)| state.p == grid[150] && state.v == 0.0).unwrap();
    // Just before the stop it is nearly at rest, and acceleration comes to 0 with it.
    let before = plan.at(time - 1e-6);
    assert!(before.v < 1e-6 && before.a.abs() < 0.01, "{before:?}");
}

#[test]
fn says_what_is_missing() {
    let path = &paths()[0];
    let grid = path.spline.on_knots(100);
    let samples = path.spline.samples(&grid);
    let acceleration = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
    let planner = JerkLimited::default();
    let without_jerk = FeedProblem::between_points(&grid, &[&acceleration]).unwrap();
    assert!(matches!(planner.plan(&without_jerk), Err(FeedError::Empty { what: "limits on jerk" })));
    let jerk = TangentialJerk::new(10.0).unwrap();
    let at_points = FeedProblem::at_points(&grid, &[&acceleration, &jerk]).unwrap();
    assert!(matches!(planner.plan(&at_points), Err(FeedError::Empty { .. })));
    let unbounded = FeedProblem::between_points(&grid, &[&jerk]).unwrap();
    assert!(matches!(planner.plan(&unbounded), Err(FeedError::Unbounded { .. })));
    let short = FeedProblem::between_points(&grid[..2], &[&jerk, &TangentialAcceleration::new(1.0).unwrap()]).unwrap();
    assert!(matches!(planner.plan(&short), Err(FeedError::Standstill { .. })));
    assert!(JerkLimited::new(0.0).is_err() && JerkLimited::new(f64::NAN).is_err());
    let no_third = PathDerivatives::new(JOINTS, &samples.first, &samples.second).unwrap();
    assert!(JointJerk::new(no_third, &A_MAX).is_err());
}

/// A line and an arc of radius 0.1 after it, as two axes see them, on a grid with a point on both sides of where they meet; lengths in
/// units of `length` and times in units of `time`.
struct LineAndArc {
    grid: Vec<f64>,
    after: [Vec<f64>; 3],
    before: [Vec<f64>; 3],
    steps: Vec<f64>,
    time: f64,
}

const CORNER: f64 = 0.5;
const RADIUS: f64 = 0.1;
const PERIOD: f64 = 2e-3;
const RATES: [f64; 3] = [1.0, 5.0, 50.0];

impl LineAndArc {
    fn new(length: f64, time: f64) -> Self {
        // At this speed the step of the acceleration takes all of the jerk, and the points are as far away as it goes in a period.
        let beside = PERIOD * (RATES[2] * PERIOD * RADIUS).sqrt();
        let mut places: Vec<f64> =
            (0..=400).map(|i| 2e-3 * f64::from(i)).filter(|s| (s - CORNER).abs() > 1e-3).collect();
        places.extend([CORNER - beside, CORNER, CORNER + beside]);
        for away in (1..5).map(|i| beside * 2.5_f64.powi(i)).take_while(|away| *away < 1.5e-3) {
            places.extend([CORNER - away, CORNER + away]);
        }
        places.sort_by(f64::total_cmp);
        let on_arc = |s: f64| {
            let (sin, cos) = ((s - CORNER) / RADIUS).sin_cos();
            [[cos, sin], [-sin / RADIUS, cos / RADIUS], [-cos / RADIUS.powi(2), -sin / RADIUS.powi(2)]]
        };
        let on_line = [[1.0, 0.0], [0.0; 2], [0.0; 2]];
        let flat = |arc_from: &dyn Fn(f64) -> bool| -> [Vec<f64>; 3] {
            let jets = places.iter().map(|&s| if arc_from(s) { on_arc(s) } else { on_line });
            let jets: Vec<_> = jets.collect();
            std::array::from_fn(|n| jets.iter().flat_map(|jet| jet[n].map(|d| d / length.powi(n as i32 + 1))).collect())
        };
        let beside_corner = |pair: &[f64]| pair[0] == CORNER || pair[1] == CORNER;
        let step = 1.0 / RADIUS / length.powi(2) / (PERIOD * time);
        Self {
            steps: places.windows(2).flat_map(|pair| [0.0, if beside_corner(pair) { step } else { 0.0 }]).collect(),
            after: flat(&|s| s >= CORNER),
            before: flat(&|s| s > CORNER),
            grid: places.iter().map(|s| s * length).collect(),
            time,
        }
    }

    fn plan(&self) -> SpeedLaw {
        let [after, before] = [&self.after, &self.before];
        let path = PathDerivatives::new(2, &after[0], &after[1]).and_then(|path| path.with_third(&after[2])).unwrap();
        let path =
            path.with_values_before(&before[0], &before[1], &before[2]).unwrap().with_steps(&self.steps).unwrap();
        let [v, a, j] = [0, 1, 2].map(|n| [RATES[n] / self.time.powi(n as i32 + 1); 2]);
        let velocity = JointVelocity::new(path, &v).unwrap();
        let acceleration = JointAcceleration::new(path, &a).unwrap();
        let jerk = JointJerk::new(path, &j).unwrap();
        let problem = FeedProblem::between_points(&self.grid, &[&velocity, &acceleration, &jerk]).unwrap();
        JerkLimited::default().plan(&problem).unwrap()
    }
}

/// By differences of the accelerations over the time that the step is spread over: no jerk over the limit, and none wasted.
#[test]
fn a_step_of_acceleration_takes_its_part_of_the_jerk() {
    let law = LineAndArc::new(1.0, 1.0).plan();
    let mut cursor = law.cursor();
    let mut acceleration = |t: f64| {
        let at = cursor.at(t);
        let (sin, cos) = ((at.p - CORNER).max(0.0) / RADIUS).sin_cos();
        let bend = if at.p > CORNER { at.v * at.v / RADIUS } else { 0.0 };
        [cos * at.a - sin * bend, sin * at.a + cos * bend]
    };
    let mut most = 0.0_f64;
    for i in 0..100_000 {
        let t = (law.duration() - PERIOD) * f64::from(i) / 1e5;
        let (from, to) = (acceleration(t), acceleration(t + PERIOD));
        most = (0..2).fold(most, |most, k| most.max((to[k] - from[k]).abs() / PERIOD / RATES[2]));
    }
    assert!(most < 1.005, "jerk at {most} of its limit");
    assert!(most > 0.98, "jerk at {most} of its limit");
    let speed = law.v_at_s(CORNER);
    let greatest = (RATES[2] * PERIOD * RADIUS).sqrt();
    assert!(speed <= greatest && speed > 0.95 * greatest, "{speed} m/s of {greatest}");
    assert!(law.v_at_s(CORNER - 0.05) > 1.5 * speed && law.v_at_s(CORNER + 0.05) > 1.5 * speed);
}

/// The same motion in other units of length and time.
#[test]
fn units_do_not_matter() {
    let duration = LineAndArc::new(1.0, 1.0).plan().duration();
    for (length, time) in [(1e-6, 1.0), (1e3, 1.0), (1.0, 1e-3), (1.0, 1e6), (1e-6, 1e6), (1e3, 1e-3), (1e-6, 1e-3)] {
        let other = LineAndArc::new(length, time).plan().duration() / time;
        assert!((other / duration - 1.0).abs() < 1e-6, "{length} m, {time} s: {other} instead of {duration}");
    }
}
