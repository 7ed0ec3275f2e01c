//! The rows of a part of a grid are those of the whole grid on its intervals.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointTorque, JointVelocity, PathConstraint, PathDerivatives, SpeedCap, Stop,
    TangentialAcceleration, Within,
};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, JerkLimited, Quantity, WindowedJerkLimited};
use arcfeed_testing::Random;

const JOINTS: usize = 3;
const INTERVALS: usize = 40;

/// Numbers along a grid, no two alike.
struct Numbers {
    grid: Vec<f64>,
    points: [Vec<f64>; 6],
    middles: [Vec<f64>; 3],
    boxes: [Vec<f64>; 3],
    steps: Vec<f64>,
    caps: [Vec<f64>; 2],
    feeds: Vec<f64>,
}

impl Numbers {
    fn new(seed: u64) -> Self {
        let mut rng = Random::new(seed);
        let mut list = |n: usize, from: f64, to: f64| -> Vec<f64> { (0..n).map(|_| rng.between(from, to)).collect() };
        let (points, intervals) = (INTERVALS + 1, INTERVALS);
        let mut grid = list(points, 0.01, 0.03);
        (1..points).for_each(|i| grid[i] += grid[i - 1]);
        let values = |list: &mut dyn FnMut(usize, f64, f64) -> Vec<f64>, n: usize| list(JOINTS * n, -1.0, 1.0);
        Self {
            grid,
            points: std::array::from_fn(|_| values(&mut list, points)),
            middles: std::array::from_fn(|_| values(&mut list, intervals)),
            boxes: std::array::from_fn(|_| list(JOINTS * intervals, 1.0, 2.0)),
            steps: list(JOINTS * intervals, 0.0, 0.1),
            caps: [list(points, 0.5, 1.0), list(intervals, 0.3, 0.5)],
            feeds: list(intervals, 0.2, 0.9),
        }
    }

    fn derivatives(&self) -> PathDerivatives<'_> {
        let [d1, d2, d3, before1, before2, before3] = &self.points;
        let [m1, m2, m3] = &self.middles;
        let [b1, b2, b3] = &self.boxes;
        let path = PathDerivatives::new(JOINTS, d1, d2).unwrap().with_third(d3).unwrap();
        let path = path.with_values_before(before1, before2, before3).unwrap();
        let path = path.with_middles(m1, m2).unwrap().with_third_in_middles(m3).unwrap();
        path.with_bounds([b1, b2, b3]).unwrap().with_steps(&self.steps).unwrap()
    }

    fn problems(&self, mut each: impl FnMut(&[&dyn PathConstraint])) {
        let path = self.derivatives();
        let velocity = JointVelocity::new(path, &[1.0, 1.1, 1.2]).unwrap();
        let acceleration = JointAcceleration::new(path, &[5.0, 5.1, 5.2]).unwrap();
        let jerk = JointJerk::new(path, &[60.0, 61.0, 62.0]).unwrap().with_margin(1e-3).unwrap();
        let feed = Feed::new(&self.feeds).unwrap();
        let cap = SpeedCap::new(&self.caps[0], Quantity::NormalAcceleration).unwrap();
        let cap = cap.with_intervals(&self.caps[1]).unwrap();
        let [a, b, d, ..] = &self.points;
        let torque = JointTorque::new(a, b, &[], d, &[9.0, 9.1, 9.2]).unwrap();
        let tangential = TangentialAcceleration::new(3.0).unwrap();
        each(&[&velocity, &acceleration, &jerk, &feed, &cap, &torque, &tangential, &Stop { at: 17 }]);
    }
}

#[test]
fn rows_of_a_part_are_those_of_the_whole() {
    for seed in 1..=5 {
        let numbers = Numbers::new(seed);
        numbers.problems(|all| {
            let whole = FeedProblem::between_points(&numbers.grid, all).unwrap();
            for range in [0..INTERVALS, 0..1, 7..30, 16..18, 17..18, 39..40] {
                let part = FeedProblem::between_points_of(&numbers.grid, range.clone(), all).unwrap();
                let what = format!("seed {seed}, {range:?}");
                assert_eq!(part.grid(), &numbers.grid[range.start..=range.end], "{what}");
                for i in 0..=part.intervals() {
                    assert_eq!(part.rows(i), whole.rows(range.start + i), "{what}: point {i}");
                    assert_eq!(part.cap(i), whole.cap(range.start + i), "{what}: point {i}");
                }
                for k in 0..part.intervals() {
                    let of = range.start + k;
                    assert_eq!(part.middle_rows(k), whole.middle_rows(of), "{what}: interval {k}");
                    assert_eq!(part.interval_bounds(k), whole.interval_bounds(of), "{what}: interval {k}");
                    for within in [Within::Start, Within::Middle, Within::End] {
                        assert_eq!(part.jerk_rows(k, within), whole.jerk_rows(of, within), "{what}: interval {k}");
                    }
                    assert!(!part.jerk_rows(k, Within::Middle).is_empty() && !part.interval_bounds(k).is_empty());
                }
            }
        });
    }
}

/// The bounds on the speed inside an interval show in the motion alone: a part that holds all that binds has the motion of the whole.
#[test]
fn a_part_between_stops_has_the_motion_of_the_whole() {
    let grid: Vec<f64> = (0..=200).map(|i| 0.01 * f64::from(i)).collect();
    let point = |f: fn(f64) -> f64| -> Vec<f64> { grid.iter().map(|&s| f(s)).collect() };
    let middle = |f: fn(f64) -> f64| -> Vec<f64> { grid.windows(2).map(|p| f(0.5 * (p[0] + p[1]))).collect() };
    // One joint along a curve that bends more and more.
    let d1 = |s: f64| 1.0 + 0.5 * (s * s).sin();
    let d2 = |s: f64| s * (s * s).cos();
    let d3 = |s: f64| (s * s).cos() - 2.0 * s * s * (s * s).sin();
    let (points, middles) = ([point(d1), point(d2), point(d3)], [middle(d1), middle(d2), middle(d3)]);
    let path = PathDerivatives::new(1, &points[0], &points[1]).unwrap().with_third(&points[2]).unwrap();
    let path = path.with_middles(&middles[0], &middles[1]).unwrap().with_third_in_middles(&middles[2]).unwrap();
    let (velocity, acceleration) =
        (JointVelocity::new(path, &[0.8]).unwrap(), JointAcceleration::new(path, &[4.0]).unwrap());
    let jerk = JointJerk::new(path, &[60.0]).unwrap();
    let all: [&dyn PathConstraint; 4] = [&velocity, &acceleration, &jerk, &Stop { at: 100 }];
    let whole = JerkLimited::default().plan(&FeedProblem::between_points(&grid, &all).unwrap()).unwrap();
    let plan =
        |range| JerkLimited::default().plan(&FeedProblem::between_points_of(&grid, range, &all).unwrap()).unwrap();
    let halves = [plan(0..100), plan(100..200)];
    let sum: f64 = halves.iter().map(|law| law.duration()).sum();
    assert!((sum / whole.duration() - 1.0).abs() < 1e-3, "{sum} and {}", whole.duration());
    assert!((halves[0].duration() - halves[1].duration()).abs() > 0.01, "halves alike show nothing: {halves:?}");
}

/// An error about a part names the place on the whole grid.
#[test]
fn errors_count_from_the_start_of_the_grid() {
    let feed = Feed::new(&[0.2; 300]).unwrap();
    let mut grid: Vec<f64> = (0..=300).map(|i| 0.01 * f64::from(i)).collect();
    let mismatch = FeedProblem::between_points_of(&grid[..300], 0..10, &[&feed]).unwrap_err();
    assert!(matches!(mismatch, FeedError::LengthMismatch { got: 301, expected: 300, .. }), "{mismatch:?}");
    let empty = FeedProblem::between_points_of(&grid, 12..12, &[&feed]);
    assert!(matches!(empty, Err(FeedError::Empty { .. })), "{empty:?}");
    let beyond = FeedProblem::between_points_of(&grid, 290..301, &[&feed]).unwrap_err();
    assert!(matches!(beyond, FeedError::LengthMismatch { got: 301, expected: 300, .. }), "{beyond:?}");
    grid[205] = grid[204];
    let bad = FeedProblem::between_points_of(&grid, 200..210, &[&feed]).unwrap_err();
    assert!(matches!(bad, FeedError::BadGrid { index: 205, .. }), "{bad:?}");
}

/// So does one of a window: the arm cannot stand where the second one begins.
#[test]
fn errors_of_a_window_count_from_the_start_of_the_grid() {
    let grid: Vec<f64> = (0..=300).map(|i| 0.01 * f64::from(i)).collect();
    let (ones, none) = (vec![1.0; 301], vec![0.0; 301]);
    let holding: Vec<f64> = (0..=300).map(|i| if i == 170 { 3.0 } else { 0.0 }).collect();
    let torque = JointTorque::new(&ones, &none, &[], &holding, &[2.0]).unwrap();
    let path = PathDerivatives::new(1, &ones, &none).unwrap().with_third(&none).unwrap();
    let (velocity, jerk) = (JointVelocity::new(path, &[0.2]).unwrap(), JointJerk::new(path, &[40.0]).unwrap());
    let all: [&dyn PathConstraint; 4] = [&torque, &velocity, &jerk, &Stop { at: 170 }];
    let windows = WindowedJerkLimited::new(JerkLimited::default(), 64).unwrap();
    let error = windows.plan(300, |part| FeedProblem::between_points_of(&grid, part, &all)).unwrap_err();
    assert!(matches!(error, FeedError::StaticallyInfeasible { index: 170, .. }), "{error:?}");
}
