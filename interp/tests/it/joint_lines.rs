//! Straight lines between joint way-points: derivatives, blends and stops, and motions along them.

use arcfeed_interp::{JointLines, Limits, MotionPath, PathError, Planner};
use arcfeed_kinematics::{Joints, models};
use arcfeed_testing::Random;

fn joints(values: [f64; 6]) -> Joints<6> {
    Joints::from(values)
}

/// Way-points some tenths of a radian apart.
fn way_points(random: &mut Random, count: usize) -> Vec<Joints<6>> {
    let mut at = joints([0.1, -1.2, 1.4, -0.3, 1.2, 0.4]);
    let mut points = vec![at];
    for _ in 1..count {
        let size = random.log(1e-3, 0.6);
        at += Joints::from_fn(|_, _| random.signed()) * size;
        points.push(at);
    }
    points
}

/// Blends that meet, blends with straight stretches between them, and stops.
fn blends(random: &mut Random, points: &[Joints<6>]) -> Vec<f64> {
    let line = |i: usize| (points[i + 1] - points[i]).norm();
    let share = random.one_of(&[0.1, 0.3, 0.5]);
    if points.len() == 3 && random.chance(0.5) {
        // The only blend may reach to both ends.
        return vec![line(0).min(line(1))];
    }
    (1..points.len() - 1).map(|i| if random.chance(0.2) { 0.0 } else { share * line(i - 1).min(line(i)) }).collect()
}

#[test]
fn derivatives_agree_with_differences_and_only_the_third_one_jumps() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let count = 2 + random.below(5);
        let points = way_points(&mut random, count);
        let path = JointLines::through(&points, &blends(&mut random, &points)).expect("good way-points");
        let length = path.length();
        let at = |s: f64| path.jet(s, &points[0]).expect("a place");
        assert!((at(0.0).q - points[0]).norm() < 1e-14 && (at(length).q - points[points.len() - 1]).norm() < 1e-14);
        let h = 1e-5 * length;
        for k in 1..400 {
            let s = length * (f64::from(k) + random.unit()) / 401.0;
            if path.knots().iter().any(|knot| (knot - s).abs() <= h) {
                continue;
            }
            let [a, b, c] = [s - h, s, s + h].map(at);
            let off = [
                ((c.q - a.q) / (2.0 * h) - b.d1).norm(),
                ((c.d1 - a.d1) / (2.0 * h) - b.d2).norm() * length,
                ((c.d2 - a.d2) / (2.0 * h) - b.d3).norm() * length * length,
            ];
            let size = 1.0 + b.d3.norm() * length * length;
            assert!(off.iter().all(|off| *off < 1e-6 * size), "seed {seed}, s {s}: {off:?} of {size}");
        }
        for &knot in path.knots() {
            let after = at(knot);
            let before = path.jet_before(&after).expect("a place");
            let stops = path.corners().contains(&knot);
            assert!((after.q - before.q).norm() < 1e-14, "seed {seed}");
            assert!(stops || (after.d1 - before.d1).norm() < 1e-12, "seed {seed}, at {knot}");
            assert!(stops || (after.d2 - before.d2).norm() * length < 1e-6, "seed {seed}, at {knot}");
        }
    }
}

#[test]
fn a_motion_passes_the_way_points_as_near_as_stated_and_keeps_the_limits() {
    let arm = models::ur5e();
    let limits = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0));
    let limits = limits.expect("good limits");
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let count = 3 + random.below(4);
        let points = way_points(&mut random, count);
        let d = blends(&mut random, &points);
        let path = JointLines::through(&points, &d).expect("good way-points");
        let trajectory =
            Planner::new(&arm, Limits::new(limits)).plan(&path).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let places: Vec<Joints<6>> =
            trajectory.setpoints(1e-4).expect("a period").map(|p| p.expect("a setpoint").q).collect();
        for (i, d) in d.iter().enumerate() {
            let line = |k: usize| (points[k + 1] - points[k]).normalize();
            let stated = 0.1875 * d * (line(i + 1) - line(i)).norm();
            let nearest = places.iter().map(|q| (q - points[i + 1]).norm()).fold(f64::INFINITY, f64::min);
            assert!((nearest - stated).abs() < 4e-4, "seed {seed}, point {i}: {nearest}, stated {stated}");
        }
        let stops = d.iter().filter(|d| **d == 0.0).count();
        assert_eq!(trajectory.stops().len(), stops, "seed {seed}");
    }
}

#[test]
fn a_motion_with_blends_is_faster_than_one_that_stops() {
    let arm = models::ur5e();
    let limits = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0));
    let limits = Limits::new(limits.expect("good limits"));
    // Lift, move across, lower; and a way back.
    let points =
        [[0.0; 6], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0], [0.8, 0.1, 0.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.0, 0.0, 0.0]];
    let points = [points[0], points[1], points[2], points[3], points[2]].map(joints);
    let time = |blends: &[f64]| {
        let path = JointLines::through(&points, blends).expect("good way-points");
        Planner::new(&arm, limits).plan(&path).expect("a motion").duration()
    };
    let (stopping, blended) = (time(&[0.0, 0.0, 0.0]), time(&[0.05, 0.05, 0.05]));
    assert!(blended < 0.85 * stopping, "{blended} s, {stopping} s with stops");
}

#[test]
fn blends_that_do_not_fit_are_refused() {
    let points =
        [[0.0; 6], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0, 0.0, 0.0], [2.0, 1.0, 0.0, 0.0, 0.0, 0.0]];
    let points = points.map(joints);
    for (blends, index) in [
        (&[0.6, 0.6][..], 2),
        (&[1.1, 0.0], 1),
        (&[0.0, 1.1], 2),
        (&[-0.1, 0.0], 1),
        (&[f64::NAN, 0.0], 1),
        (&[0.0, f64::INFINITY], 2),
        (&[0.1], 3),
    ] {
        match JointLines::through(&points, blends) {
            Err(PathError::Waypoint { index: found, .. }) => assert_eq!(found, index, "{blends:?}"),
            other => panic!("{blends:?}: {other:?}"),
        }
    }
    assert!(JointLines::through(&points, &[0.5, 0.5]).is_ok());
    assert!(matches!(JointLines::through(&points[..1], &[]), Err(PathError::TooFewWaypoints { count: 1 })));
}
