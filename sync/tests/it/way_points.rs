//! Motions through way-points: exact in the points, inside the limits everywhere, near the shortest.

#![allow(clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisState, MotionLaw};
use arcfeed_sync::{MotionOptions, Route, SyncError, Trajectory, WayPoint, WayPointPlanner, WayPointTrajectory};
use arcfeed_testing::{Random, allocations_in};

pub fn random_limits<const N: usize>(rng: &mut Random) -> [AxisLimits; N] {
    std::array::from_fn(|_| {
        let mut pair = |lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
        AxisLimits::new(pair(0.5, 2.0), pair(2.0, 10.0), pair(10.0, 200.0)).unwrap()
    })
}

/// Independent points, samples of a smooth curve, or a walk with small steps.
pub fn random_points<const N: usize>(rng: &mut Random, count: usize) -> Vec<[f64; N]> {
    let (kind, step, size) = (rng.below(3), rng.log(0.1, 1.5), rng.log(0.01, 0.5));
    let frequency: [f64; N] = std::array::from_fn(|_| rng.between(0.2, 1.0));
    let mut place = [0.0; N];
    (0..count)
        .map(|i| {
            for (k, x) in place.iter_mut().enumerate() {
                match kind {
                    0 => *x = rng.between(-1.0, 1.0),
                    1 => *x = (frequency[k] * (step * i as f64 + k as f64)).sin(),
                    _ => *x += rng.between(-size, size),
                }
            }
            place
        })
        .collect()
}

/// Checks continuity, the points and the limits, at the extremes of every phase.
fn check<const N: usize>(
    motion: &WayPointTrajectory<N>,
    start: &[AxisState; N],
    route: &Route<'_, N>,
    from_inside: bool,
) {
    let n = route.sections();
    assert_eq!(motion.states()[0], *start);
    assert_eq!(motion.states()[n], *route.target());
    for (state, point) in motion.states()[1..n].iter().zip(route.points()) {
        for (k, s) in state.iter().enumerate() {
            assert_eq!(s.p, point.position()[k]);
            assert!(point.velocity()[k].is_none_or(|v| v == s.v));
        }
    }
    for i in 0..n {
        let section = motion.section(i).unwrap();
        let duration = motion.section_durations()[i];
        assert_eq!(section.duration(), duration);
        assert!(duration >= route.least_duration(i) * (1.0 - 1e-15), "section {i} takes {duration}");
        for (k, axis) in section.axes().iter().enumerate() {
            let l = &route.limits(i)[k];
            let (from, to) = (motion.states()[i][k], motion.states()[i + 1][k]);
            let begin = axis.at(0.0);
            assert_eq!((begin.p, begin.v, begin.a), (from.p, from.v, from.a));
            let last = axis.phases().last().map_or(begin, |(phase, dt)| phase.after(dt));
            assert!((last.p - to.p).abs() < 1e-8 && (last.v - to.v).abs() < 1e-8, "{last:?} {to:?}");
            for (phase, dt) in axis.phases() {
                let turn = phase.turn(dt).unwrap_or(0.0);
                for s in [0.0, turn, dt].map(|t| phase.after(t)) {
                    let over = |x: f64, lo: f64, hi: f64| (x / hi).max(x / lo) - 1.0;
                    let jerk = over(s.j, l.j_min(), l.j_max());
                    let worst = over(s.v, l.v_min(), l.v_max()).max(over(s.a, l.a_min(), l.a_max()));
                    assert!(jerk <= 1e-12 && (!from_inside || worst <= 1e-12), "section {i}, axis {k}: {s:?} {l:?}");
                }
            }
        }
    }
}

/// The duration of the same route with a stop in every point.
fn stopping<const N: usize>(
    start: &[AxisState; N],
    points: &[WayPoint<N>],
    target: &[AxisState; N],
    limits: &[AxisLimits; N],
) -> f64 {
    let mut states = vec![*start];
    states.extend(points.iter().map(|p| p.position().map(AxisState::rest)));
    states.push(*target);
    states
        .windows(2)
        .map(|pair| Trajectory::new(&pair[0], &pair[1], limits, &MotionOptions::default()).unwrap().duration())
        .sum()
}

fn random_case<const N: usize>(planner: &mut WayPointPlanner<N>, seed: u64) -> f64 {
    let mut rng = Random::new(Random::new(seed).bits());
    let limits = random_limits::<N>(&mut rng);
    let count = if rng.chance(0.8) { 1 + rng.below(12) } else { 1 + rng.below(64) };
    let places = random_points::<N>(&mut rng, count + 2);
    let moving = |rng: &mut Random, p: f64, l: &AxisLimits| {
        AxisState::new(p, rng.between(0.5 * l.v_min(), 0.5 * l.v_max()), 0.1 * rng.between(l.a_min(), l.a_max()))
    };
    let (mut start, mut target) = (places[0].map(AxisState::rest), places[count + 1].map(AxisState::rest));
    if rng.chance(0.5) {
        start = std::array::from_fn(|k| moving(&mut rng, start[k].p, &limits[k]));
    }
    if rng.chance(0.2) {
        target = std::array::from_fn(|k| moving(&mut rng, target[k].p, &limits[k]));
    }
    let points: Vec<_> = places[1..=count]
        .iter()
        .map(|p| {
            let mut point = WayPoint::new(*p);
            if rng.chance(0.1) {
                point = point.with_velocity(0, rng.between(0.3 * limits[0].v_min(), 0.3 * limits[0].v_max()));
            }
            if rng.chance(0.1) {
                point = point.with_least_duration(rng.log(0.01, 2.0));
            }
            point
        })
        .collect();
    let route = Route::new(&points, target, limits);
    let motion = planner.plan(&start, &route).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
    check(&motion, &start, &route, true);
    let plain =
        points.iter().all(|p| p.velocity() == [None; N]) && (0..points.len()).all(|i| route.least_duration(i) == 0.0);
    if plain { motion.duration() / stopping(&start, &points, &target, &limits) } else { 0.5 }
}

/// A walk of one axis whose search has not converged after the usual rounds: it ended 5.5 % above what it
/// finds in as many again.
#[test]
fn a_search_that_has_not_converged_goes_on() {
    let mut rng = Random::new(Random::new(551).bits());
    let limits = [AxisLimits::symmetric(rng.log(0.5, 2.0), rng.log(2.0, 10.0), rng.log(10.0, 200.0)).unwrap()];
    let (_, size) = (rng.log(0.1, 1.5), rng.log(0.02, 0.5));
    let _ = (rng.between(0.2, 1.0), rng.between(0.0, std::f64::consts::TAU));
    let mut place = 0.0;
    let places = [(); 7].map(|()| {
        place += rng.between(-size, size);
        [place]
    });
    let points: Vec<_> = places[1..6].iter().map(|p| WayPoint::new(*p)).collect();
    let route = Route::new(&points, places[6].map(AxisState::rest), limits);
    let motion = WayPointPlanner::new().plan(&places[0].map(AxisState::rest), &route).unwrap();
    // After 12 rounds alone it is 0.45395 s.
    assert!(motion.duration() < 0.43, "{}", motion.duration());
}

/// With limits that are decades apart, where all axes turn in nearly all points, a rest in every point is often the shortest motion
/// that is found: it is tried far from the origin, too.
#[test]
fn where_a_rest_in_every_point_is_shortest_it_is_taken() {
    let mut planner = Box::new(WayPointPlanner::<3>::new());
    let mut rests = 0;
    for seed in 0..400 {
        let mut rng = Random::new(Random::new(seed).bits());
        let limits = [(); 3]
            .map(|()| AxisLimits::symmetric(rng.log(0.1, 10.0), rng.log(0.1, 100.0), rng.log(1.0, 1e4)).unwrap());
        let count = 3 + rng.below(6);
        // From one side to the other.
        let mut place = |i: usize| std::array::from_fn(|_| 100.0 + [-1.0, 1.0][i % 2] * rng.between(0.2, 1.0));
        let (start, target) = (place(0).map(AxisState::rest), place(count + 1).map(AxisState::rest));
        let points: Vec<_> = (1..=count).map(|i| WayPoint::new(place(i))).collect();
        let motion = planner.plan(&start, &Route::new(&points, target, limits)).unwrap();
        let stops = stopping(&start, &points, &target, &limits);
        assert!(motion.duration() <= (1.0 + 1e-9) * stops, "seed {seed}: {} {stops}", motion.duration());
        rests += usize::from(motion.duration() >= (1.0 - 1e-9) * stops);
    }
    assert!(rests > 5, "{rests}");
}

#[test]
fn random_routes_pass_the_points_inside_the_limits() {
    let mut ratios = vec![];
    let (mut one, mut three, mut six) =
        (Box::new(WayPointPlanner::new()), Box::new(WayPointPlanner::new()), Box::new(WayPointPlanner::new()));
    for seed in 0..150 {
        ratios.push((random_case::<1>(&mut one, seed), seed));
        ratios.push((random_case::<3>(&mut three, seed), seed));
        ratios.push((random_case::<6>(&mut six, seed), seed));
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, worst) = (ratios[ratios.len() / 2].0, ratios[ratios.len() - 1]);
    // No route takes longer than with a stop in every point.
    assert!(median < 0.75 && worst.0 <= 1.0 + 1e-9, "median {median}, worst {worst:?}");
}

#[test]
fn points_on_a_line_are_passed_at_full_speed() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let (start, target) = ([AxisState::rest(0.0); 2], [4.0, 2.0].map(AxisState::rest));
    let points: Vec<_> = (1..8).map(|i| WayPoint::new([0.5 * f64::from(i), 0.25 * f64::from(i)])).collect();
    let motion = WayPointPlanner::new().plan(&start, &Route::new(&points, target, limits)).unwrap();
    let direct = Trajectory::new(&start, &target, &limits, &MotionOptions::default()).unwrap();
    // The points leave the shortest motion as it is.
    assert!(motion.duration() < 1.002 * direct.duration(), "{} {}", motion.duration(), direct.duration());
}

/// Points of one axis in order leave the shortest motion as it is: its closed form is the optimum.
#[test]
fn points_in_order_cost_little_on_one_axis() {
    let mut ratios = vec![];
    let mut planner = Box::new(WayPointPlanner::<1>::new());
    for seed in 0..300 {
        let mut rng = Random::new(Random::new(seed).bits());
        let limits = random_limits::<1>(&mut rng);
        let (mut place, count) = (0.0, 1 + rng.below(10));
        let mut next = || {
            place += rng.log(0.003, 0.3);
            place
        };
        let points: Vec<_> = (0..count).map(|_| WayPoint::new([next()])).collect();
        let (start, target) = ([AxisState::rest(0.0)], [AxisState::rest(next())]);
        let route = Route::new(&points, target, limits);
        let motion = planner.plan(&start, &route).unwrap();
        check(&motion, &start, &route, true);
        let direct = Trajectory::new(&start, &target, &limits, &MotionOptions::default()).unwrap();
        ratios.push((motion.duration() / direct.duration(), seed));
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (median, worst) = (ratios[150].0, ratios[299]);
    assert!(ratios[0].0 > 1.0 - 1e-9 && median < 1.01 && worst.0 < 1.08, "median {median}, worst {worst:?}");
}

/// Two examples of ruckig, whose solutions with way-points are pictures in its crate (ruckig 0.19.4, MIT:
/// `examples/03_waypoints.cpp`, `08_per_section_minimum_duration.cpp`, `03_trajectory.pdf` and
/// `08_trajectory.pdf`). The durations are read from the lines that its plotter draws at the ends of
/// the sections, to 1e-3 s.
#[test]
fn the_published_examples_of_ruckig_take_about_as_long() {
    const THEIRS: [f64; 2] = [7.832, 7.513];
    let symmetric = |l: [[f64; 3]; 3]| l.map(|[v, a, j]| AxisLimits::symmetric(v, a, j).unwrap());
    let places = [[1.4, -1.6, 1.0], [-0.6, -0.5, 0.4], [-0.4, -0.35, 0.0], [0.8, 1.8, -0.1]];
    let start = [AxisState::rest(0.2), AxisState::new(0.0, 0.2, 0.6), AxisState::rest(-0.3)];
    let target = [AxisState::new(0.5, 0.2, 0.0), AxisState::new(1.0, 0.0, 0.1), AxisState::new(0.0, 0.3, -0.1)];
    let limits = symmetric([[1.0, 3.0, 6.0], [2.0, 2.0, 10.0], [1.0, 2.0, 20.0]]);
    let points = places.map(WayPoint::new);
    let route = Route::new(&points, target, limits);
    let first = WayPointPlanner::new().plan(&start, &route).unwrap();
    check(&first, &start, &route, true);

    let places = [places[0], places[1], places[2], [-0.2, 0.35, -0.1], [0.2, 0.5, -0.1], places[3]];
    let least = [0.0, 2.0, 0.0, 1.0, 0.0, 2.0];
    let points: Vec<_> = places.iter().zip(least).map(|(p, t)| WayPoint::new(*p).with_least_duration(t)).collect();
    let (start, target) = ([0.8, 0.0, 0.5].map(AxisState::rest), [0.5, 1.2, 0.0].map(AxisState::rest));
    let limits = symmetric([[3.0, 6.0, 16.0], [2.0, 4.0, 10.0], [2.0, 4.0, 20.0]]);
    let route = Route::new(&points, target, limits);
    let second = WayPointPlanner::new().plan(&start, &route).unwrap();
    check(&second, &start, &route, true);
    for (ours, theirs) in [&first, &second].into_iter().zip(THEIRS) {
        assert!(ours.duration() < 1.01 * theirs, "{} s, theirs {theirs} s", ours.duration());
    }
}

#[test]
fn the_same_point_twice_and_points_close_together_are_possible() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let start = [AxisState::rest(0.0); 2];
    for distance in [0.0, 1e-12, 1e-9, 1e-6, 1e-3] {
        let points = [[0.5, 0.5], [0.5 + distance, 0.5], [0.5 + distance, 0.5 - distance]].map(WayPoint::new);
        let route = Route::new(&points, [1.0, 0.0].map(AxisState::rest), limits);
        let motion = WayPointPlanner::new().plan(&start, &route).unwrap();
        check(&motion, &start, &route, true);
        assert!(motion.duration() < 2.6, "{distance}: {}", motion.duration());
    }
    // All in one place.
    let points = [WayPoint::new([0.0, 0.0])];
    let motion = WayPointPlanner::new().plan(&start, &Route::new(&points, start, limits)).unwrap();
    assert_eq!(motion.duration(), 0.0);
}

/// A point that is given again is passed at once, unless something is asked of the way between.
#[test]
fn a_point_given_twice_costs_nothing() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let mut planner = WayPointPlanner::new();
    let target = [1.2, 0.1].map(AxisState::rest);
    let mut run = |start: [AxisState; 2], points: &[WayPoint<2>], target: [AxisState; 2]| {
        let route = Route::new(points, target, limits);
        let motion = planner.plan(&start, &route).unwrap();
        check(&motion, &start, &route, true);
        motion
    };
    let moving = [AxisState::new(0.0, 0.5, 0.3), AxisState::new(0.0, -0.2, 0.0)];
    let [a, b] = [[0.4, 0.3], [0.8, 0.2]].map(WayPoint::new);
    let start = WayPoint::new([0.0; 2]);
    for from in [[AxisState::rest(0.0); 2], moving] {
        let once = run(from, &[a, b], target);
        let twice = run(from, &[start, start, a, a, a, b, b.with_velocity(0, once.states()[2][0].v)], target);
        let pinned = run(from, &[a, b.with_velocity(0, once.states()[2][0].v)], target);
        assert_eq!(twice.duration(), pinned.duration());
        assert_eq!(twice.section_durations().iter().filter(|t| **t == 0.0).count(), 5);
        assert!(once.states()[1][0].v > 0.3 && twice.states()[3] == pinned.states()[1]);
        // The target is where the last point is.
        let end = run(from, &[a, b, WayPoint::new([1.2, 0.1])], target);
        assert_eq!(end.duration(), once.duration());
        // Sampled across.
        let t = twice.section_durations()[..3].iter().sum::<f64>();
        assert!((twice.at(t).qd[0] - twice.states()[3][0].v).abs() < 1e-9);
    }
    // Two velocities, a duration, limits: there is a way between.
    let slow = [AxisLimits::symmetric(0.2, 2.0, 20.0).unwrap(); 2];
    for other in [a.with_least_duration(0.5), a.with_limits(slow), a.with_velocity(0, 0.2)] {
        let motion = run([AxisState::rest(0.0); 2], &[a.with_velocity(0, 0.1), other, b], target);
        assert!(motion.states()[1][0].v == 0.1);
    }
}

#[test]
fn limits_and_least_durations_hold_section_by_section() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let slow = [AxisLimits::symmetric(0.2, 1.0, 20.0).unwrap(); 2];
    let start = [AxisState::rest(0.0); 2];
    let points = [
        WayPoint::new([0.5, 0.1]),
        WayPoint::new([0.8, 0.2]).with_limits(slow),
        WayPoint::new([1.2, 0.0]).with_least_duration(1.5),
    ];
    let route = Route::new(&points, [2.0, 0.0].map(AxisState::rest), limits).with_least_duration(2.5);
    let motion = WayPointPlanner::new().plan(&start, &route).unwrap();
    check(&motion, &start, &route, true);
    let durations = motion.section_durations();
    assert!(
        durations[1] > 0.3 / 0.2 && (durations[2] - 1.5).abs() < 0.1 && (durations[3] - 2.5).abs() < 0.1,
        "{durations:?}"
    );
}

#[test]
fn a_start_outside_its_limits_is_brought_back() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let start = [AxisState::new(0.0, 1.5, 2.0), AxisState::new(0.0, 0.0, -7.0)];
    let points = [[1.0, 0.3], [1.5, 0.5]].map(WayPoint::new);
    let route = Route::new(&points, [2.0, 0.6].map(AxisState::rest), limits);
    let motion = WayPointPlanner::new().plan(&start, &route).unwrap();
    check(&motion, &start, &route, false);
}

#[test]
fn what_is_no_route_is_refused_by_name() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 2];
    let rest = [AxisState::rest(0.0); 2];
    let mut planner = WayPointPlanner::new();
    let mut refuse = |start: &[AxisState; 2], points: &[WayPoint<2>], target: [AxisState; 2]| {
        planner.plan(start, &Route::new(points, target, limits)).unwrap_err()
    };
    let point = WayPoint::new([0.1, 0.2]);
    let e = refuse(&rest, &[point, WayPoint::new([0.0, f64::NAN])], rest);
    assert!(matches!(e, SyncError::WayPoint { index: 1, axis: 1, what: "position", .. }), "{e}");
    let e = refuse(&rest, &[point.with_velocity(1, 1.5)], rest);
    assert!(matches!(e, SyncError::WayPoint { index: 0, axis: 1, what: "velocity", value: 1.5, .. }), "{e}");
    let e = refuse(&rest, &[point.with_least_duration(-1.0)], rest);
    assert!(matches!(e, SyncError::Duration { value: -1.0 }), "{e}");
    let e = refuse(&rest, &[point; 65], rest);
    assert!(matches!(e, SyncError::TooManyWayPoints { count: 65, most: 64 }), "{e}");
    let e = refuse(&[AxisState::new(0.0, f64::INFINITY, 0.0), rest[1]], &[point], rest);
    assert!(matches!(e, SyncError::State { axis: 0, .. }), "{e}");
    let e = refuse(&rest, &[point], [rest[0], AxisState::new(0.0, 2.0, 0.0)]);
    assert!(matches!(e, SyncError::State { axis: 1, .. }), "{e}");
}

#[test]
fn planning_allocates_nothing() {
    let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0).unwrap(); 3];
    let points: Vec<_> = (1..20).map(|i| WayPoint::new([f64::from(i), (f64::from(i)).sin(), 0.0])).collect();
    let route = Route::new(&points, [20.0, 0.0, 0.5].map(AxisState::rest), limits);
    let mut planner = Box::new(WayPointPlanner::new());
    let mut duration = 0.0;
    let count = allocations_in(|| {
        duration = planner.plan(&[AxisState::rest(0.0); 3], &route).map_or(0.0, |motion| motion.duration());
    });
    assert!(count == 0 && duration > 5.0, "{count} allocations, {duration} s");
}

/// In another unit of time the same motion is found. The unit is a power of two, so that the problem has the same digits.
#[test]
fn the_unit_of_time_changes_no_motion() {
    let mut planner = WayPointPlanner::new();
    for seed in 0..60 {
        let mut rng = Random::new(Random::new(seed).bits());
        let limits = random_limits::<2>(&mut rng);
        let count = 2 + rng.below(8);
        let places = random_points::<2>(&mut rng, count + 2);
        let points: Vec<_> = places[1..=count].iter().map(|place| WayPoint::new(*place)).collect();
        let (start, target) = (places[0].map(AxisState::rest), places[count + 1].map(AxisState::rest));
        let mut duration = |unit: f64| {
            let in_unit = |l: AxisLimits| {
                let pair = |(lo, hi): (f64, f64), power: i32| (lo * unit.powi(power), hi * unit.powi(power));
                let (v, a, j) = ((l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max()));
                AxisLimits::new(pair(v, 1), pair(a, 2), pair(j, 3)).unwrap()
            };
            let route = Route::new(&points, target, limits.map(in_unit));
            planner.plan(&start, &route).unwrap().duration() * unit
        };
        let usual = duration(1.0);
        for unit in [64.0, 1.0 / 64.0] {
            let other = duration(unit);
            assert!((other - usual).abs() < 1e-9 * usual, "seed {seed}: {usual} s, {other} s with a unit of {unit} s");
        }
    }
}
