//! Goals of the Panda from the problems of MotionBenchMaker: its forward solution is theirs, the inverse reaches their poses, and
//! motions lead from their start to all of their joint values. Obstacles are no part of it.
//!
//! Origin: fishbotics/robometrics (MIT), named in the data. Only numbers are taken.

use std::f64::consts::FRAC_PI_4;

use arcfeed_kinematics::{ForwardKinematics, InverseKinematics, Joints, NumericArm, models};
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};
use arcfeed_testing::{Phase, Wanted};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;

const CASES: &str = include_str!("../data/motion_bench_maker.json");
/// Rounding of single precision in all joint values of an arm of a metre: m, rad.
const ROUNDING: (f64, f64) = (1e-6, 2e-6);
/// How far other joint values than the first of a problem are from its pose there: m, rad.
const NEAR: (f64, f64) = (0.012, 0.1);

#[derive(Deserialize)]
struct File {
    start: [f64; 7],
    v: [f64; 7],
    a: [f64; 7],
    goals: Vec<Goal>,
}

#[derive(Deserialize)]
struct Goal {
    position: [f64; 3],
    quaternion_wxyz: [f64; 4],
    q: Vec<[f64; 7]>,
}

impl Goal {
    fn pose(&self) -> Isometry3<f64> {
        let [w, x, y, z] = self.quaternion_wxyz;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Isometry3::from_parts(Vector3::from(self.position).into(), turn)
    }
}

fn cases() -> File {
    let file: File = serde_json::from_str(CASES).expect("valid cases");
    let solutions: Vec<usize> = file.goals.iter().map(|goal| goal.q.len()).collect();
    assert_eq!(solutions, [16, 11, 12, 14, 14]);
    file
}

/// The Panda to `panda_hand`, which is turned by 45 degrees against the flange.
fn arm() -> NumericArm<7> {
    let hand = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -FRAC_PI_4);
    models::panda().with_tool(Isometry3::from_parts(Vector3::zeros().into(), hand)).expect("a tool")
}

/// Distance in m, angle in rad.
fn off(a: &Isometry3<f64>, b: &Isometry3<f64>) -> (f64, f64) {
    ((a.translation.vector - b.translation.vector).norm(), a.rotation.angle_to(&b.rotation))
}

/// The shortest time for a way from rest to rest: as long at the greatest jerk, acceleration and velocity as there is way for.
fn shortest(way: f64, v: f64, a: f64, j: f64) -> f64 {
    if way >= v * (v / a + a / j) && v * j >= a * a {
        return way / v + v / a + a / j;
    }
    if v * j < a * a && way >= 2.0 * v * (v / j).sqrt() {
        return way / v + 2.0 * (v / j).sqrt();
    }
    if way >= 2.0 * a.powi(3) / (j * j) {
        let ramp = a / j;
        return ramp + (ramp * ramp + 4.0 * way / a).sqrt();
    }
    4.0 * (way / (2.0 * j)).cbrt()
}

#[test]
fn poses_of_motion_bench_maker_are_where_its_joint_values_lead() {
    let arm = arm();
    for (i, goal) in cases().goals.iter().enumerate() {
        for (k, q) in goal.q.iter().enumerate() {
            let (distance, angle) = off(&arm.forward(&Joints::from(*q)), &goal.pose());
            let most = if k == 0 { ROUNDING } else { NEAR };
            assert!(distance < most.0 && angle < most.1, "goal {i}, {k}: {distance:e} m, {angle:e} rad away");
        }
    }
}

#[test]
fn the_inverse_reaches_the_goals_of_motion_bench_maker() {
    let (arm, file) = (arm(), cases());
    for (i, goal) in file.goals.iter().enumerate() {
        let pose = goal.pose();
        let reached = |from: &[f64; 7], what: &str| {
            let from = Joints::from(*from);
            let q = arm.inverse(&pose, &from).unwrap_or_else(|error| panic!("goal {i} from {what}: {error}"));
            let (distance, angle) = off(&arm.forward(&q), &pose);
            assert!(distance < 1e-9 && angle < 1e-9, "goal {i} from {what}: {distance:e} m, {angle:e} rad away");
            assert!(arm.range().contains(&q), "goal {i} from {what}: {q} is out of range");
            (q - from).amax()
        };
        reached(&file.start, "the start");
        for (k, q) in goal.q.iter().enumerate() {
            let moved = reached(q, &format!("joint values {k}"));
            // It stays where the pose is reached already. Of the others some stand at a joint's limit, and the way may be long.
            assert!(k > 0 || moved < 1e-5, "goal {i} from joint values {k}: moved by {moved} rad");
        }
    }
}

#[test]
fn motions_lead_to_all_joint_values_of_motion_bench_maker() {
    let (arm, file) = (arm(), cases());
    let jerk = |k: usize| 10.0 * file.a[k];
    let limits = std::array::from_fn(|k| AxisLimits::symmetric(file.v[k], file.a[k], jerk(k)).expect("above 0"));
    let start = file.start.map(AxisState::rest);
    for (i, q) in file.goals.iter().flat_map(|goal| &goal.q).enumerate() {
        assert!(arm.range().contains(&Joints::from(*q)), "{i}: out of range");
        let ways = |k: usize| (q[k] - file.start[k]).abs();
        let least = (0..7).map(|k| shortest(ways(k), file.v[k], file.a[k], jerk(k))).fold(0.0, f64::max);
        for mode in [Synchronisation::Time, Synchronisation::StraightLine] {
            let motion = Trajectory::new(&start, &q.map(AxisState::rest), &limits, &MotionOptions::new(mode))
                .unwrap_or_else(|error| panic!("{i}: {error}"));
            for (k, axis) in motion.axes().iter().enumerate() {
                let limits = [file.v[k], file.a[k], jerk(k)].map(|limit| (-limit, limit));
                let wanted = Wanted { start: [file.start[k], 0.0, 0.0], target: [q[k], 0.0, 0.0], limits };
                let phases: Vec<Phase> =
                    axis.phases().map(|(p, time)| Phase { state: [p.s, p.v, p.a], jerk: p.j, time }).collect();
                assert_eq!(wanted.fault(&phases, true), None, "{i}, joint {k}");
            }
            let ratio = motion.duration() / least;
            let most = if mode == Synchronisation::Time { 1.0 + 1e-9 } else { 1.5 };
            assert!((1.0 - 1e-9..most).contains(&ratio), "{i}, {mode:?}: {ratio} times the closed form");
            let states = (0..=50).map(|n| Joints::from(motion.at(motion.duration() * f64::from(n) / 50.0).q));
            for q in states {
                assert!(arm.range().contains(&q), "{i}, {mode:?}: {q} is out of range");
            }
        }
    }
}
