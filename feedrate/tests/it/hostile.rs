//! Whatever comes in, planners answer with a sound plan or an error that names a place or a value.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::constraint::{
    Feed, JointAcceleration, JointJerk, JointTorque, JointVelocity, PathConstraint, PathDerivatives, Place, RowSink,
    SpeedCap, Stop, TangentialAcceleration, TangentialJerk, Within,
};
use arcfeed_feedrate::{
    FeedError, FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability, JerkLimited, JerkRow, LimitId,
    MotionLaw, PathEnd, Quantity, Reachability, SpeedLaw,
};
use proptest::prelude::*;

/// Every planner there is.
fn planners() -> Vec<Box<dyn FeedPlanner>> {
    vec![
        Box::new(ForwardBackwardScan),
        Box::new(Reachability),
        Box::new(InterpolatedReachability),
        Box::new(JerkLimited::default()),
        #[cfg(feature = "clarabel")]
        Box::new(arcfeed_feedrate::ClarabelBaseline),
    ]
}

/// A plan that runs forward from the first to the last grid point in a finite time.
fn assert_sound(plan: &SpeedLaw, grid: &[f64]) {
    assert!(plan.duration() > 0.0 && plan.duration().is_finite());
    let mut last = f64::NEG_INFINITY;
    for i in 0..=200 {
        let state = plan.at(plan.duration() * f64::from(i) / 200.0);
        assert!(state.p.is_finite() && state.v.is_finite() && state.a.is_finite() && state.v >= 0.0, "{state:?}");
        // Not even by more than its last digits.
        assert!(state.p >= last - 4.0 * f64::EPSILON * last.abs(), "{state:?} after {last}");
        last = state.p;
    }
    assert_eq!((plan.at(0.0).p, plan.at(plan.duration()).p), (grid[0], grid[grid.len() - 1]));
}

/// Ordinary numbers, and now and then one that breaks things.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        20 => -10.0..10.0,
        2 => Just(0.0),
        1 => prop_oneof![Just(1e-300), Just(1e300), Just(-1e200), Just(f64::NAN), Just(f64::INFINITY), Just(-0.0), Just(5e-324)],
    ]
}

fn limit() -> impl Strategy<Value = f64> {
    prop_oneof![12 => 0.1..100.0, 1 => Just(0.0), 1 => Just(f64::INFINITY), 1 => number()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5000, ..ProptestConfig::default() })]

    #[test]
    fn any_input_is_answered(
        steps in prop::collection::vec(prop_oneof![30 => 0.01..1.0, 1 => Just(0.0), 1 => Just(1e-12), 1 => number()], 0..14),
        values in prop::collection::vec(number(), 15 * 2 * 4),
        velocity in prop::collection::vec(limit(), 2),
        acceleration in prop::collection::vec(limit(), 2),
        jerk in prop::collection::vec(limit(), 2),
        torque in prop::collection::vec(limit(), 2),
        ends in [0.0..1.5, 0.0..1.5],
        moving in any::<bool>(),
        parts in 0_u8..64,
    ) {
        answer(&steps, &values, [&velocity, &acceleration, &jerk, &torque], moving.then_some(ends), parts);
    }
}

/// Every planner either refuses a problem of these numbers or returns a sound plan. The bits of `parts` are the constraints.
fn answer(
    steps: &[f64],
    values: &[f64],
    [velocity, acceleration, jerk, torque]: [&[f64]; 4],
    ends: Option<[f64; 2]>,
    parts: u8,
) {
    let mut grid = vec![0.0];
    steps.iter().for_each(|h| grid.push(grid[grid.len() - 1] + h));
    let n = 2 * grid.len();
    let [first, second, third, d] = [0, 1, 2, 3].map(|k| &values[k * 30..k * 30 + n]);
    let path = PathDerivatives::new(2, first, second).and_then(|path| path.with_third(third));
    let Ok(path) = path else { return };
    let mut all: Vec<Box<dyn PathConstraint + '_>> = Vec::new();
    if let Ok(limit) = JointVelocity::new(path, velocity)
        && parts & 1 != 0
    {
        all.push(Box::new(limit));
    }
    if let Ok(limit) = JointAcceleration::new(path, acceleration)
        && parts & 2 != 0
    {
        all.push(Box::new(limit));
    }
    if let Ok(limit) = JointJerk::new(path, jerk)
        && parts & 4 != 0
    {
        all.push(Box::new(limit));
    }
    if let Ok(limit) = JointTorque::new(first, second, third, d, torque)
        && parts & 8 != 0
    {
        all.push(Box::new(limit));
    }
    if let Ok(limit) = TangentialJerk::new(acceleration[0])
        && parts & 16 != 0
    {
        all.push(Box::new(limit));
    }
    if parts & 32 != 0 {
        all.push(Box::new(Stop { at: 4 }));
    }
    let all: Vec<&dyn PathConstraint> = all.iter().map(|limit| &**limit).collect();
    let Ok(problem) = FeedProblem::between_points(&grid, &all) else { return };
    let problem = match ends {
        Some([start, end]) => problem.with_end_speeds(start, end).unwrap(),
        None => problem,
    };
    // The conic solver is too slow for thousands of cases, and exact to its own tolerance.
    for (which, planner) in planners().into_iter().enumerate().take(4) {
        if let Ok(plan) = planner.plan(&problem) {
            assert_sound(&plan, &grid);
            assert_kept(&problem, &plan, which);
        }
    }
}

/// A braking curve that ends beyond its last segment by round-off, on a last interval of 1e-12: an index out of range in the scan
/// that the jerk-limited planner starts from.
#[test]
fn a_last_interval_of_round_off_is_scanned() {
    let steps = [0.08013252628294584, 0.6986146687047605, 0.4125793696865093, 0.05920789373266602, 0.01, 1e-12];
    let mut values = [0.0; 15 * 2 * 4];
    for (k, value) in [
        (10, -8.858506843667902),
        (33, 7.040629663627967),
        (35, -2.863772638369405),
        (36, -1e200),
        (71, -7.470144581205006),
    ] {
        values[k] = value;
    }
    answer(&steps, &values, [&[0.1, 0.1], &[5.492283009930762, 0.1], &[68.6314846199824, 0.1], &[0.1, 0.1]], None, 54);
}

/// A limit of 1e300 lets the speed grow until its jerk leaves the range of numbers: a law with infinite jerk.
#[test]
fn a_limit_at_the_end_of_the_numbers_is_refused_or_planned() {
    let mut values = [0.0; 15 * 2 * 4];
    (values[5], values[31]) = (-7.155930989913949, -6.367692355252724);
    let small: &[f64] = &[0.1, 0.1];
    answer(&[0.01; 3], &values, [small, &[0.1, 1e300], small, small], None, 18);
}

/// Viscous friction alone uses up a torque limit of 0 at any speed: the scan started at 0.54 regardless.
#[test]
fn friction_without_torque_stands_still() {
    let mut values = [0.0; 15 * 2 * 4];
    (values[33], values[60]) = (-5.890317230092842, 3.3378745098866576);
    let small: &[f64] = &[0.1, 0.1];
    answer(&[0.01], &values, [small, small, small, &[0.0, 20.333929188399004]], Some([0.5427677672294782, 0.0]), 40);
}

/// Every row and cap behind every grid point, as far as numbers can be told apart at all.
fn assert_kept(problem: &FeedProblem, plan: &SpeedLaw, which: usize) {
    let apart = |i: usize| problem.rows(i).iter().any(|row| row.a.abs().max(row.b.abs()).max(row.c.abs()) > 1e9);
    if (0..=problem.intervals()).any(apart) {
        return;
    }
    for i in 0..problem.intervals() {
        let state = plan.at_position(problem.grid()[i]);
        let (u, x) = (state.a, state.v * state.v);
        for row in problem.rows(i) {
            let sum = (row.a * u).abs() + (row.b * x).abs() + (row.c * state.v).abs() + row.d.abs();
            let excess = row.excess(u, x);
            // u is a difference of squared speeds over a length, which may be tiny.
            let round_off = row.a.abs() * 1e-14 * x.max(1e-9) / problem.h(i);
            assert!(
                excess <= 1e-6 * sum.max(1e-9) + round_off,
                "planner {which}, point {i}: {row:?} by {excess} at {state:?}"
            );
        }
        let cap = problem.cap(i).0;
        assert!(x <= cap * (1.0 + 1e-6) + 1e-12, "planner {which}, point {i}: {x} above {cap}");
    }
}

fn grid(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

#[test]
fn bad_grids_are_named() {
    let limit = TangentialAcceleration::new(1.0).unwrap();
    let make = |grid: &[f64]| FeedProblem::at_points(grid, &[&limit]).unwrap_err();
    assert!(matches!(make(&[0.0]), FeedError::Empty { .. }));
    assert!(matches!(make(&[0.0, 1.0, 1.0, 2.0]), FeedError::BadGrid { index: 2, s: 1.0, previous: 1.0 }));
    assert!(matches!(make(&[0.0, f64::NAN]), FeedError::NotFinite { .. }));
    assert!(matches!(make(&[-1e308, 1e308]), FeedError::OutOfRange { .. }));
    let feed = [1.0; 3];
    let feed = Feed::new(&feed).unwrap();
    let error = FeedProblem::at_points(&grid(5), &[&feed]).unwrap_err();
    assert!(matches!(error, FeedError::LengthMismatch { got: 4, expected: 6, .. }));
}

#[test]
fn numbers_that_are_none_are_named() {
    let mut first = vec![1.0; 11];
    let second = vec![0.0; 11];
    first[7] = f64::NAN;
    let path = PathDerivatives::new(1, &first, &second).unwrap();
    let (velocity, acceleration) =
        (JointVelocity::new(path, &[1.0]).unwrap(), JointAcceleration::new(path, &[1.0]).unwrap());
    for limit in [&velocity as &dyn PathConstraint, &acceleration] {
        let error = FeedProblem::at_points(&grid(10), &[limit]).unwrap_err();
        assert!(matches!(error, FeedError::BadRow { index: 7, .. }), "{error}");
    }
    assert!(JointVelocity::new(path, &[-1.0]).is_err() && JointVelocity::new(path, &[f64::NAN]).is_err());
    assert!(JointVelocity::new(path, &[1.0, 1.0]).is_err());
    assert!(SpeedCap::new(&[1.0, -1.0], Quantity::Feed).is_err() && Feed::new(&[0.0]).is_err());
    assert!(PathDerivatives::new(2, &first, &second).is_err() && PathDerivatives::new(0, &first, &second).is_err());
}

/// A corner (jump of q') and limits of zero: the motion stops or says what holds it.
#[test]
fn corners_stop_and_zero_limits_are_named() {
    let grid = grid(40);
    let (mut first, second) = (vec![1.0; 41], vec![0.0; 41]);
    let mut before = first.clone();
    first[20..].fill(-1.0);
    before[21..].fill(-1.0);
    let path = PathDerivatives::new(1, &first, &second)
        .and_then(|path| path.with_third(&second))
        .and_then(|path| path.with_values_before(&before, &[], &[]))
        .unwrap();
    let (acceleration, jerk) = (JointAcceleration::new(path, &[1.0]).unwrap(), JointJerk::new(path, &[10.0]).unwrap());
    let velocity = JointVelocity::new(path, &[10.0]).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&velocity, &acceleration, &jerk]).unwrap();
    for planner in planners() {
        let plan = planner.plan(&problem).unwrap();
        assert_sound(&plan, &grid);
        assert!(plan.at_position(0.5).v < 1e-6);
        // Twice half the way from rest to rest: 2 sqrt(0.5 / 1) each; jerk adds about a / j.
        let extra = plan.duration() - 4.0 * 0.5_f64.sqrt();
        assert!((-1e-9..0.3).contains(&extra), "{extra}");
    }
    let stuck = JointAcceleration::new(path, &[0.0]).unwrap();
    let problem = FeedProblem::between_points(&grid, &[&velocity, &stuck, &jerk]).unwrap();
    for planner in planners() {
        let error = planner.plan(&problem).unwrap_err();
        let FeedError::Standstill { row, .. } = error else { panic!("{error:?}") };
        assert_eq!((row.quantity, row.joint), (Quantity::JointAcceleration, Some(0)));
    }
    // A joint that does not move needs no speed.
    let still = vec![0.0; 41];
    let path = PathDerivatives::new(1, &still, &still).unwrap();
    let (zero, feed) = (JointVelocity::new(path, &[0.0]).unwrap(), TangentialAcceleration::new(1.0).unwrap());
    let problem = FeedProblem::between_points(&grid, &[&zero, &feed]).unwrap();
    assert!((Reachability.plan(&problem).unwrap().duration() - 2.0).abs() < 1e-9);
}

#[test]
fn without_limits_nothing_is_planned() {
    let (grid, jerk) = (grid(10), TangentialJerk::new(10.0).unwrap());
    let problem = FeedProblem::between_points(&grid, &[&jerk]).unwrap();
    for planner in planners() {
        assert!(matches!(planner.plan(&problem), Err(FeedError::Unbounded { .. })));
    }
}

/// A limit of infinity is none: whatever else limits decides, and the plan is the same as without that limit.
#[test]
fn infinite_limits_bind_nothing() {
    let grid = grid(60);
    let first: Vec<f64> = grid.iter().flat_map(|s| [1.0, (3.0 * s).cos()]).collect();
    let second: Vec<f64> = grid.iter().flat_map(|s| [0.0, -3.0 * (3.0 * s).sin()]).collect();
    let third: Vec<f64> = grid.iter().flat_map(|s| [0.0, -9.0 * (3.0 * s).cos()]).collect();
    let path = PathDerivatives::new(2, &first, &second).and_then(|path| path.with_third(&third)).unwrap();
    let none = [f64::INFINITY; 2];
    let (velocity, acceleration) =
        (JointVelocity::new(path, &none).unwrap(), JointAcceleration::new(path, &none).unwrap());
    let (jerk, torque) =
        (JointJerk::new(path, &none).unwrap(), JointTorque::new(&first, &second, &[], &[], &none).unwrap());
    let tool: [&dyn PathConstraint; 2] =
        [&TangentialAcceleration::new(1.0).unwrap(), &TangentialJerk::new(20.0).unwrap()];
    let alone = FeedProblem::between_points(&grid, &tool).unwrap();
    let all =
        FeedProblem::between_points(&grid, &[tool[0], tool[1], &velocity, &acceleration, &jerk, &torque]).unwrap();
    for planner in planners() {
        let (p, q) = (planner.plan(&alone).unwrap(), planner.plan(&all).unwrap());
        assert_sound(&q, &grid);
        assert_eq!(p.duration(), q.duration());
    }
}

/// Gravity that a joint cannot hold over a stretch: planners that may pass in motion find that no motion does, the others that
/// it cannot stand there. All name the place, the joint, and the numbers.
#[test]
fn gravity_that_cannot_be_held_is_named() {
    let grid = grid(100);
    let (one, none, jerk) = (vec![1.0; 202], vec![0.0; 202], TangentialJerk::new(100.0).unwrap());
    let mut gravity = vec![0.5; 202];
    (60..=80).for_each(|i| gravity[2 * i + 1] = 9.0);
    // From the feed of 1, braking at 3 ends after a sixth of the path.
    let (torque, feed) =
        (JointTorque::new(&one, &none, &[], &gravity, &[4.0, 6.0]).unwrap(), Feed::new(&[1.0; 100]).unwrap());
    let problem = FeedProblem::between_points(&grid, &[&torque, &jerk, &feed]).unwrap();
    let motor = (Quantity::JointTorque, Some(1));
    for planner in planners() {
        match planner.plan(&problem).unwrap_err() {
            FeedError::StaticallyInfeasible { s, row, value, limit, .. } => {
                assert_eq!(((row.quantity, row.joint), value, limit), (motor, 9.0, 6.0));
                assert!((0.6..=0.8).contains(&s), "{s}");
            }
            FeedError::Infeasible { s, row, against, excess, limit, .. } => {
                let named = [row, against].map(|row| (row.quantity, row.joint));
                assert!(named.contains(&motor), "{row} {against}");
                assert!((0.55..=0.8).contains(&s) && excess > 0.0 && limit.abs() <= 6.0, "{s} {excess} {limit}");
            }
            error => panic!("{error:?}"),
        }
    }
}

/// Speeds at the ends that cannot be had: the error tells which end, what would do, and what is in the way.
#[test]
fn end_speeds_out_of_reach_are_named() {
    let grid = grid(50);
    let feed = [2.0; 50];
    let (feed, acceleration) = (Feed::new(&feed).unwrap(), TangentialAcceleration::new(1.0).unwrap());
    let jerk = TangentialJerk::new(50.0).unwrap();
    let problem = |v0, v1| {
        let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk]).unwrap();
        problem.with_end_speeds(v0, v1).unwrap()
    };
    for planner in planners() {
        // From 1.5 to rest takes 1.125 of braking, the path is 1 long; 2.5 is above the feed.
        for (v0, v1, most) in [(1.5, 0.0, 2.0_f64.sqrt()), (0.0, 1.5, 2.0_f64.sqrt()), (2.5, 2.0, 2.0)] {
            let error = planner.plan(&problem(v0, v1)).unwrap_err();
            let FeedError::SpeedOutOfReach { end, speed, lowest, highest, row, s } = error else { panic!("{error:?}") };
            // Planners that look back from the end can tell only from where it is reached.
            assert_eq!(speed, if end == PathEnd::Start { v0 } else { v1 }, "{error}");
            assert!((0.0..=1.0).contains(&s) && !(lowest..=highest).contains(&speed), "{error}");
            assert!(highest <= if speed > 0.0 { most + 1e-9 } else { 2.0 }, "{error}");
            let named = [
                Quantity::ControllableSet,
                Quantity::Feed,
                // The jerk-limited planner says what stands against more.
                Quantity::TangentialAcceleration,
                Quantity::TangentialJerk,
            ];
            assert!(named.contains(&row.quantity), "{error}");
        }
    }
    // The scan tells a limit at the end itself from those on the way there.
    for (v0, v1, named) in
        [(2.5, 0.0, Quantity::Feed), (1.5, 0.0, Quantity::ControllableSet), (0.0, 2.5, Quantity::Feed)]
    {
        let error = ForwardBackwardScan.plan(&problem(v0, v1)).unwrap_err();
        let FeedError::SpeedOutOfReach { row, .. } = error else { panic!("{error:?}") };
        assert_eq!(row.quantity, named, "{error}");
    }
    // Less acceleration is needed than there is, but it cannot be taken off and on in time.
    let error = JerkLimited::default().plan(&problem(1.41, 0.0)).unwrap_err();
    let FeedError::SpeedOutOfReach { end: PathEnd::Start, highest, row, .. } = error else { panic!("{error:?}") };
    assert!(highest > 1.3 && highest < 1.41, "{highest}");
    assert!([Quantity::TangentialAcceleration, Quantity::TangentialJerk].contains(&row.quantity), "{row}");
    assert!(JerkLimited::default().plan(&problem(highest, 0.0)).is_ok());
}

/// No length, or twice the same way-point: a grid has to increase, and says where it does not.
#[test]
fn paths_without_length_are_named() {
    let (zeros, jerk) = ([0.0; 4], TangentialJerk::new(10.0).unwrap());
    let make = |grid: &[f64]| FeedProblem::between_points(grid, &[&jerk]).unwrap_err();
    assert!(matches!(make(&[]), FeedError::Empty { what: "grid intervals" }));
    assert!(matches!(make(&[0.0]), FeedError::Empty { what: "grid intervals" }));
    assert!(matches!(make(&zeros), FeedError::BadGrid { index: 1, s: 0.0, previous: 0.0 }));
    assert!(matches!(make(&[0.0, 0.5, 0.5, 1.0]), FeedError::BadGrid { index: 2, s: 0.5, previous: 0.5 }));
    assert!(matches!(make(&[0.0, 0.5, 0.4]), FeedError::BadGrid { index: 2, s: 0.4, previous: 0.5 }));
}

/// A joint that stays where it is although `s` goes on, as between two equal way-points: nothing to plan for it, and where
/// nothing else moves nothing limits the speed.
#[test]
fn joints_that_rest_over_a_stretch() {
    let grid = grid(60);
    // q = max(0, |s - 0.5| - 0.2)^4: at rest from 0.3 to 0.7, three times differentiable.
    let power = |s: f64, n: i32| (s - 0.5).signum().powi(4 - n) * ((s - 0.5).abs() - 0.2).max(0.0).powi(n);
    let derivative = |n: i32, factor: f64| -> Vec<f64> { grid.iter().map(|&s| factor * power(s, n)).collect() };
    let (first, second, third) = (derivative(3, 400.0), derivative(2, 1200.0), derivative(1, 2400.0));
    let path = PathDerivatives::new(1, &first, &second).and_then(|path| path.with_third(&third)).unwrap();
    let (velocity, acceleration) =
        (JointVelocity::new(path, &[1.0]).unwrap(), JointAcceleration::new(path, &[4.0]).unwrap());
    let (jerk, feed) = (JointJerk::new(path, &[60.0]).unwrap(), Feed::new(&[0.5; 60]).unwrap());
    let joint: [&dyn PathConstraint; 3] = [&velocity, &acceleration, &jerk];
    let alone = FeedProblem::between_points(&grid, &joint).unwrap();
    let fed = FeedProblem::between_points(&grid, &[joint[0], joint[1], joint[2], &feed]).unwrap();
    for planner in planners() {
        let error = planner.plan(&alone).unwrap_err();
        assert!(matches!(error, FeedError::Unbounded { s, .. } if (0.3..=0.72).contains(&s)), "{error:?}");
        let plan = planner.plan(&fed).unwrap();
        assert_sound(&plan, &grid);
        // 0.4 at the feed of 0.5.
        assert!(plan.duration() > 0.8 && plan.at_position(0.5).v > 0.49, "{}", plan.duration());
    }
}

#[test]
fn a_joint_that_turns_around_passes_without_stopping() {
    // q = (s - 0.5)^2: q' = 0 in the middle, where only q'' x limits.
    let grid = grid(200);
    let first: Vec<f64> = grid.iter().map(|s| 2.0 * (s - 0.5)).collect();
    let (second, third) = (vec![2.0; 201], vec![0.0; 201]);
    let path = PathDerivatives::new(1, &first, &second).unwrap().with_third(&third).unwrap();
    let acceleration = JointAcceleration::new(path, &[1.0]).unwrap();
    let (jerk, tool) = (JointJerk::new(path, &[50.0]).unwrap(), TangentialAcceleration::new(5.0).unwrap());
    let problem = FeedProblem::between_points(&grid, &[&acceleration, &jerk, &tool]).unwrap();
    for planner in planners() {
        let plan = planner.plan(&problem).unwrap();
        assert_sound(&plan, &grid);
        assert!(plan.at_position(0.5).v > 0.4);
    }
}

#[test]
fn a_million_points() {
    let n = if cfg!(debug_assertions) { 100_000 } else { 1_000_000 };
    let grid = grid(n);
    let (acceleration, jerk) = (TangentialAcceleration::new(1.0).unwrap(), TangentialJerk::new(20.0).unwrap());
    let problem = FeedProblem::between_points(&grid, &[&acceleration, &jerk]).unwrap();
    for planner in [&ForwardBackwardScan as &dyn FeedPlanner, &Reachability, &InterpolatedReachability] {
        assert!((planner.plan(&problem).unwrap().duration() - 2.0).abs() < 1e-8);
    }
    // Seven phases without cruise: 2 sqrt(1 + (a / 2j)^2) + a / j. Where an interval is short beside the way on which the
    // acceleration builds up, the spline uses the jerk next to rest in part, which costs up to 0.11 % here.
    let exact = 2.0 * (1.0 + 0.025_f64 * 0.025).sqrt() + 0.05;
    if n > 200_000 {
        let error = JerkLimited::default().plan(&problem).unwrap_err();
        assert!(matches!(error, FeedError::TooMany { .. }), "{error}");
    }
    let grid = self::grid(n / 10);
    let problem = FeedProblem::between_points(&grid, &[&acceleration, &jerk]).unwrap();
    let duration = JerkLimited::default().plan(&problem).unwrap().duration();
    assert!((1.0 - 1e-9..1.0015).contains(&(duration / exact)), "{duration} instead of {exact}");
}

/// What would not fit into memory is refused, not tried.
#[test]
fn too_many_rows_are_refused() {
    let grid = grid(100_000);
    let (acceleration, jerk) = (TangentialAcceleration::new(1.0).unwrap(), TangentialJerk::new(20.0).unwrap());
    let mut many: Vec<&dyn PathConstraint> = vec![&acceleration; 17];
    many.push(&jerk);
    let problem = FeedProblem::between_points(&grid, &many).unwrap();
    let error = JerkLimited::default().plan(&problem).unwrap_err();
    let FeedError::TooMany { got, most, .. } = error else { panic!("{error}") };
    assert!(got > most);
}

/// Terms of a jerk row that overflow only together.
struct LargeJerk;

impl PathConstraint for LargeJerk {
    fn points(&self) -> Option<usize> {
        None
    }

    fn rows(&self, _: Place, _: &mut RowSink<'_>) {}

    fn jerk_rows(&self, k: usize, _: f64, _: Within, out: &mut Vec<JerkRow>) {
        let gamma = if k == 3 { 1e308 } else { 0.0 };
        let source = LimitId::path(Quantity::Other);
        out.push(JerkRow { alpha: 0.0, beta: 1e308, gamma, step: 0.0, limit: 1.0, source });
    }
}

#[test]
fn a_jerk_row_whose_terms_overflow_together_is_named() {
    let error = FeedProblem::at_points(&grid(10), &[&LargeJerk]).unwrap_err();
    assert!(matches!(error, FeedError::BadRow { index: 3, .. }), "{error:?}");
}
