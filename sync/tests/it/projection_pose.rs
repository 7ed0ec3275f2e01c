//! The pose synchroniser: norms inside their limits in every cycle, an exact end, a straight line and one axis of rotation.
#![allow(clippy::unwrap_used)]
use arcfeed_sync::nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3, Vector6};
use arcfeed_sync::{PoseLimits, PoseProjectionSync, PoseState, PoseStep, ProjectionStatus, SyncError};
use arcfeed_testing::{Random, cases};

const T: f64 = 1e-3;

fn ball(rng: &mut Random) -> Vector3<f64> {
    loop {
        let x = Vector3::new(rng.signed(), rng.signed(), rng.signed());
        if x.norm() <= 1.0 {
            return x;
        }
    }
}

fn pose(rng: &mut Random) -> Isometry3<f64> {
    let turn = UnitQuaternion::new(ball(rng) * 3.0);
    Isometry3::from_parts(ball(rng).into(), turn)
}

/// Independent of the crate: nalgebra's own logarithm.
fn turn_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> Vector3<f64> {
    (b * a.inverse()).scaled_axis()
}

/// Excess over velocity, acceleration and jerk limits in one cycle, relative, the larger of linear and angular. Jerk inside its ball
/// confines the changes of acceleration, velocity and pose; so they also have to fit together.
fn excess(a: &PoseState, b: &PoseState, l: &PoseLimits, h: f64) -> [f64; 3] {
    let mut worst = [-1.0f64; 3];
    let moved = b.pose.translation.vector - a.pose.translation.vector;
    let turned = turn_between(&a.pose.rotation, &b.pose.rotation);
    for (i, limits, change) in [(0, l.linear(), moved), (3, l.angular(), turned)] {
        let part = |x: &Vector6<f64>| x.fixed_rows::<3>(i).into_owned();
        let (va, vb, aa, ab) = (part(&a.velocity), part(&b.velocity), part(&a.acceleration), part(&b.acceleration));
        let [v, acc, j] = *limits;
        worst[0] = worst[0].max(vb.norm() / v - 1.0);
        worst[1] = worst[1].max(ab.norm() / acc - 1.0);
        worst[2] = worst[2].max(((ab - aa).norm() - 1e-13) / (j * h) - 1.0);
        worst[2] = worst[2].max(((vb - va - aa * h).norm() - 1e-14) / (j * h * h / 2.0) - 1.0);
        // A rotation differs from the integral of its rate by a commutator of the order of h³.
        let commutator = if i == 3 { (va.norm() + acc * h) * (aa.norm() + j * h) * h.powi(3) / 10.0 } else { 0.0 };
        let off = (change - va * h - aa * (h * h / 2.0)).norm() - 1e-14 - commutator;
        worst[2] = worst[2].max(off / (j * h.powi(3) / 6.0) - 1.0);
    }
    worst
}

fn limits() -> PoseLimits {
    PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]).unwrap()
}

fn stack(a: Vector3<f64>, b: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// A state of motion inside the limits, also after taking the acceleration off.
fn moving(rng: &mut Random, l: &PoseLimits) -> PoseState {
    loop {
        let mut part = |l: &[f64; 3]| {
            let (v, a) = (ball(rng) * l[0], ball(rng) * l[1]);
            let released = v + a * (0.5 * a.norm() / l[2]);
            (released.norm() <= l[0]).then_some((v, a))
        };
        if let (Some(p), Some(r)) = (part(l.linear()), part(l.angular())) {
            return PoseState { pose: pose(rng), velocity: stack(p.0, r.0), acceleration: stack(p.1, r.1) };
        }
    }
}

struct Run {
    worst: [f64; 3],
    duration: f64,
    recovered: bool,
}

fn run(sync: &mut PoseProjectionSync) -> Run {
    let mut out = Run { worst: [-1.0; 3], duration: 0.0, recovered: false };
    let mut before = sync.state();
    let l = *sync.limits();
    for _ in 0..100_000 {
        let PoseStep { state, status } = sync.step(T).unwrap();
        let unused = if let ProjectionStatus::Reached { unused } = status { unused } else { 0.0 };
        out.recovered |= status == ProjectionStatus::Recovering;
        let e = excess(&before, &state, &l, T - unused);
        for (i, (worst, e)) in out.worst.iter_mut().zip(e).enumerate() {
            // What is left of a cycle may be too short to tell a jerk from round-off.
            if i < 2 || T - unused > 1e-4 {
                *worst = worst.max(e);
            }
        }
        out.duration += T - unused;
        before = state;
        if let ProjectionStatus::Reached { .. } = status {
            assert_eq!(state, PoseState::rest(*sync.target()));
            return out;
        }
    }
    panic!("never arrives");
}

#[test]
fn limits_hold_from_random_starts() {
    let mut rng = Random::new(2);
    let mut recovered = 0;
    for i in 0..120 {
        // Also where a turn at full speed takes more acceleration than there is.
        let l = if i % 3 == 2 { PoseLimits::new([0.5, 3.0, 40.0], [4.0, 8.0, 60.0]).unwrap() } else { limits() };
        let start = if i % 5 == 0 { PoseState::rest(pose(&mut rng)) } else { moving(&mut rng, &l) };
        let target = pose(&mut rng);
        let mut sync = PoseProjectionSync::new(&start, target, &l).unwrap();
        let out = run(&mut sync);
        assert!(out.worst.iter().all(|&x| x <= 1e-9), "case {i}: {:?} {start:?} {target:?}", out.worst);
        assert!(out.duration < 12.0, "case {i}: {}", out.duration);
        recovered += usize::from(out.recovered);
    }
    println!("{recovered} of 120 took their acceleration off first");
}

#[test]
fn limits_hold_while_the_target_moves() {
    let mut rng = Random::new(9);
    let l = limits();
    for i in cases(3) {
        let start = moving(&mut rng, &l);
        let mut target = pose(&mut rng);
        let (shift, turn) = (ball(&mut rng) * (0.2 * T), ball(&mut rng) * (0.4 * T));
        let mut sync = PoseProjectionSync::new(&start, target, &l).unwrap();
        let mut before = sync.state();
        for cycle in 0..1200 {
            target = Isometry3::from_parts(
                (target.translation.vector + shift).into(),
                UnitQuaternion::new_normalize((UnitQuaternion::new(turn) * target.rotation).into_inner()),
            );
            if rng.unit() < 0.004 {
                target = pose(&mut rng);
            }
            sync.set_target(target).unwrap();
            let state = sync.step(T).unwrap().state;
            let e = excess(&before, &state, &l, T);
            assert!(e.iter().all(|&x| x <= 1e-9), "run {i} cycle {cycle}: {e:?} {before:?} {state:?}");
            before = state;
        }
        let out = run(&mut sync);
        assert!(out.worst.iter().all(|&x| x <= 1e-9), "run {i}: {:?}", out.worst);
    }
}

/// Liu et al. 2024, table 5: a straight line of the tool point and one axis of rotation, on the shorter arc.
#[test]
fn table_5_is_straight() {
    let start = Isometry3::from_parts(Vector3::new(0.1463, -0.4679, -0.0066).into(), quaternion([1.0, 0.0, 0.0, 0.0]));
    let target = Isometry3::from_parts(
        Vector3::new(-0.35, -0.35, 0.1).into(),
        // Printed to four digits: normalised.
        quaternion([0.4711, 0.7322, 0.4668, -0.1551]),
    );
    let mut sync = PoseProjectionSync::new(&PoseState::rest(start), target, &limits()).unwrap();
    let along = (target.translation.vector - start.translation.vector).normalize();
    let axis = turn_between(&start.rotation, &target.rotation).normalize();
    let mut turned = 0.0f64;
    loop {
        let step = sync.step(T).unwrap();
        let off = step.state.pose.translation.vector - start.translation.vector;
        assert!((off - along * off.dot(&along)).norm() < 1e-15);
        let turn = turn_between(&start.rotation, &step.state.pose.rotation);
        assert!((turn - axis * turn.dot(&axis)).norm() < 1e-14);
        turned = turned.max(turn.norm());
        if let ProjectionStatus::Reached { .. } = step.status {
            break;
        }
        assert_eq!(step.status, ProjectionStatus::Straight);
    }
    assert!(turned <= std::f64::consts::PI && turned > 2.0, "{turned}");
}

/// x y z w, as the paper writes them.
fn quaternion([x, y, z, w]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

#[test]
fn straight_at_last_from_any_motion() {
    let mut rng = Random::new(4);
    for i in 0..40 {
        let start = moving(&mut rng, &limits());
        let mut sync = PoseProjectionSync::new(&start, pose(&mut rng), &limits()).unwrap();
        while sync.step(T).unwrap().status != ProjectionStatus::Straight {
            if sync.remaining() == Some(0.0) {
                break;
            }
        }
        let from = sync.state().pose;
        let way = sync.target().translation.vector - from.translation.vector;
        let turn = turn_between(&from.rotation, &sync.target().rotation);
        while sync.remaining() != Some(0.0) {
            let now = sync.step(T).unwrap().state.pose;
            let off = now.translation.vector - from.translation.vector;
            let rotated = turn_between(&from.rotation, &now.rotation);
            assert!(off.cross(&way).norm() <= 1e-10 * way.norm(), "case {i}: {off:?} {way:?}");
            assert!(rotated.cross(&turn).norm() <= 1e-9 * turn.norm(), "case {i}: {rotated:?} {turn:?}");
        }
    }
}

#[test]
fn starts_outside_are_brought_inside() {
    let mut rng = Random::new(14);
    let l = limits();
    for i in 0..50 {
        let mut start = moving(&mut rng, &l);
        start.velocity *= 2.0;
        start.acceleration *= 2.0;
        let mut sync = PoseProjectionSync::new(&start, pose(&mut rng), &l).unwrap();
        let mut before = sync.state();
        let (mut t, mut last_above) = (0.0, 0.0);
        loop {
            let step = sync.step(T).unwrap();
            let unused = if let ProjectionStatus::Reached { unused } = step.status { unused } else { 0.0 };
            t += T;
            let e = excess(&before, &step.state, &l, T - unused);
            assert!(e[2] <= 1e-9 || T - unused < 1e-4, "case {i}: {e:?} {before:?} {:?}", step.state);
            if e[0] > 1e-9 || e[1] > 1e-9 {
                last_above = t;
            }
            before = step.state;
            if let ProjectionStatus::Reached { .. } = step.status {
                break;
            }
        }
        // Acceleration off in 0.16 s at most, speed by 1.75 rad/s at 8 rad/s² or 0.6 m/s at 3 m/s².
        assert!(last_above < 0.65, "case {i}: {last_above}");
    }
}

#[test]
fn half_turns_and_tiny_turns() {
    let l = limits();
    let from = Isometry3::identity();
    for angle in [0.0, 1e-300, 1e-12, 1e-6, 3.0, std::f64::consts::PI - 1e-12, std::f64::consts::PI, 3.5, 6.0] {
        for shift in [0.0, 1e-9, 0.3] {
            let target = Isometry3::new(Vector3::new(shift, 0.0, 0.0), Vector3::new(0.0, angle, 0.0));
            let mut sync = PoseProjectionSync::new(&PoseState::rest(from), target, &l).unwrap();
            let out = run(&mut sync);
            assert!(out.worst.iter().all(|&x| x <= 1e-9), "{angle} {shift}: {:?}", out.worst);
        }
    }
}

#[test]
fn refusals_name_the_field() {
    let at = PoseState::rest(Isometry3::identity());
    let l = limits();
    for bad in [f64::NAN, f64::INFINITY] {
        let mut start = at;
        start.velocity[4] = bad;
        let e = PoseProjectionSync::new(&start, at.pose, &l).unwrap_err();
        assert!(matches!(e, SyncError::Tool { what: "start velocity", .. }), "{e}");
        let mut start = at;
        start.acceleration[0] = bad;
        let e = PoseProjectionSync::new(&start, at.pose, &l).unwrap_err();
        assert!(matches!(e, SyncError::Tool { what: "start acceleration", .. }), "{e}");
        let far = Isometry3::translation(0.0, bad, 0.0);
        assert!(matches!(PoseProjectionSync::new(&at, far, &l), Err(SyncError::Tool { what: "target", .. })));
        let start = PoseState::rest(far);
        assert!(matches!(
            PoseProjectionSync::new(&start, at.pose, &l),
            Err(SyncError::Tool { what: "start pose", .. })
        ));
        let mut sync = PoseProjectionSync::new(&at, at.pose, &l).unwrap();
        assert!(sync.set_target(far).is_err() && sync.step(bad).is_err() && sync.state() == at);
        let e = PoseLimits::new([1.0; 3], [1.0, bad, 1.0]).unwrap_err();
        assert!(e.to_string().contains("angular acceleration limit"), "{e}");
    }
    let scaled = Isometry3::from_parts(
        Vector3::zeros().into(),
        UnitQuaternion::new_unchecked(Quaternion::new(1.1, 0.0, 0.0, 0.0)),
    );
    let e = PoseProjectionSync::new(&at, scaled, &l).unwrap_err().to_string();
    assert!(e.contains("norm 1"), "{e}");
}
