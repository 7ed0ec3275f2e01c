//! `JointCheck` has to say no: recorded joint motions, each spoilt in one way.

use arcfeed_feedrate::AxisState;
use arcfeed_interp::{JointCheck, JointRates, JointSample, Quantity, Verification};
use arcfeed_kinematics::{JointRange, Joints};

const PERIOD: f64 = 1e-3;

fn range() -> JointRange<1> {
    JointRange::new(Joints::from([-10.0]), Joints::from([10.0])).expect("a range")
}

fn rates(velocity: f64, jerk: f64) -> JointRates<1> {
    JointRates { velocity: [velocity].into(), acceleration: [10.0].into(), jerk: [jerk].into() }
}

/// One joint from a state on, with a jerk for each period.
fn rows(from: f64, period: f64, [mut q, mut v, mut a]: [f64; 3], jerks: &[f64]) -> Vec<JointSample<1>> {
    let begin = (from / period).round();
    let mut rows = Vec::new();
    for (i, j) in jerks.iter().enumerate() {
        let t = begin * period + i as f64 * period;
        rows.push(JointSample { t, q: [q].into(), qd: [v].into(), qdd: [a].into() });
        q += period * (v + period * (a / 2.0 + period * j / 6.0));
        v += period * (a + period * j / 2.0);
        a += period * j;
    }
    rows
}

fn judged(rows: &[JointSample<1>], period: f64, rates: &JointRates<1>) -> Verification {
    let mut check = JointCheck::new(&range());
    rows.iter().for_each(|row| check.see(row, period, rates));
    check.finish()
}

fn ratio(verification: &Verification, quantity: Quantity) -> f64 {
    verification.worst_of(quantity).expect("looked at").ratio
}

/// From rest to rest with jerks of 100 rad/s^3.
fn good() -> Vec<JointSample<1>> {
    let jerks: Vec<f64> = [(50, 100.0), (100, -100.0), (51, 100.0), (10, 0.0)]
        .into_iter()
        .flat_map(|(count, jerk)| std::iter::repeat_n(jerk, count))
        .collect();
    // One period more than the phases, so that the last row is at rest.
    let mut rows = rows(0.0, PERIOD, [0.0; 3], &jerks[..200]);
    let last = rows[rows.len() - 1];
    rows.push(JointSample { t: last.t + PERIOD, ..last });
    rows
}

#[test]
fn a_good_motion_holds_and_each_spoilt_one_is_named() {
    let limits = rates(3.0, 100.0);
    let untouched = judged(&good()[..199], PERIOD, &limits);
    assert!(untouched.holds(1e-6), "{:?}", untouched.worst());
    assert!(ratio(&untouched, Quantity::JointJerk) > 0.999_999);
    type Spoil = fn(&mut Vec<JointSample<1>>);
    let spoilt: [(&str, Quantity, Spoil); 8] = [
        ("a jump", Quantity::Continuity, |rows| rows[120..].iter_mut().for_each(|r| r.q[0] += 1e-6)),
        ("a jump in the last sample", Quantity::Continuity, |rows| rows[198].q[0] += 1e-6),
        ("positions halved", Quantity::Continuity, |rows| rows.iter_mut().for_each(|r| r.q[0] *= 0.5)),
        ("velocity of the sample before", Quantity::Continuity, |rows| {
            for i in (1..rows.len()).rev() {
                rows[i].qd = rows[i - 1].qd;
            }
        }),
        ("acceleration 20 % larger for a sample", Quantity::JointJerk, |rows| rows[30].qdd[0] *= 1.2),
        ("out of range", Quantity::JointPosition, |rows| rows.iter_mut().for_each(|r| r.q[0] += 10.0)),
        ("not a number", Quantity::JointVelocity, |rows| rows[77].qd[0] = f64::NAN),
        ("a time stamp twice", Quantity::Continuity, |rows| rows[60].t = rows[59].t),
    ];
    for (name, quantity, spoil) in spoilt {
        let mut rows = good()[..199].to_vec();
        spoil(&mut rows);
        let verification = judged(&rows, PERIOD, &limits);
        let ratio = ratio(&verification, quantity);
        assert!(ratio.is_nan() || ratio > 1.0 + 1e-6, "{name}: {:?}", verification.checks());
        assert!(!verification.holds(1e-6), "{name}");
    }
}

#[test]
fn both_ends_are_held_against_the_states_asked_for() {
    let limits = rates(3.0, 100.0);
    for (wanted, holds) in [
        (AxisState::rest(0.0), true),
        (AxisState::rest(1e-8), false),
        (AxisState::new(0.0, 1e-5, 0.0), false),
        (AxisState::new(0.0, 0.0, 1e-4), false),
    ] {
        let mut check = JointCheck::new(&range());
        let first = good()[0];
        check.see(&first, PERIOD, &limits);
        check.see_end(0.0, &[AxisState::rest(0.0)], &[wanted]);
        assert_eq!(check.finish().holds(1e-6), holds, "{wanted:?}");
    }
}

#[test]
fn a_late_motion_at_its_jerk_limit_is_no_false_alarm_and_a_late_jump_is_one() {
    // Seen: continuity 1.00001 at t = 134 s, by the rounding of t times the velocity.
    let (period, jerk) = (5e-4, 110.0);
    let limits = rates(3.0, jerk);
    let jerks: Vec<f64> = (0..400).map(|i| if i % 20 < 10 { jerk } else { -jerk }).collect();
    for from in [0.0, 134.0, 3600.0, 1e5] {
        let mut rows = rows(from, period, [0.3, 1.7, 0.0], &jerks);
        let verification = judged(&rows, period, &limits);
        let (continuity, by_jerk) =
            (ratio(&verification, Quantity::Continuity), ratio(&verification, Quantity::JointJerk));
        // What is left to rounding grows with the time, since the resolution of the time does.
        let least = if from < 1e4 { 0.98 } else { 0.8 };
        assert!(continuity <= 1.0 + 1e-6 && continuity > least, "{continuity} at {from}");
        assert!(by_jerk <= 1.0 + 1e-6 && by_jerk > 0.98, "{by_jerk} at {from}");
        // A hundredth of what a cycle of this velocity covers.
        rows[200..].iter_mut().for_each(|row| row.q[0] += 1e-2 * period);
        let jumped = ratio(&judged(&rows, period, &limits), Quantity::Continuity);
        assert!(jumped > 1.5, "{jumped} at {from}");
    }
}

#[test]
fn a_joint_outside_lowered_limits_has_the_time_of_its_brake_and_no_more() {
    let jerk = 100.0;
    // From 2 rad/s with the full acceleration, allowed 1 rad/s from the first row on: jerk down to -10, hold, and up to 0.
    let judged = |late: usize| {
        let jerks: Vec<f64> = (0..600)
            .map(|i| match i as i64 - late as i64 {
                1..=100 => -jerk,
                111..=210 => jerk,
                _ => 0.0,
            })
            .collect();
        let mut check = JointCheck::new(&range());
        for (i, row) in rows(0.0, PERIOD, [0.0, 2.0, 0.0], &jerks).iter().enumerate() {
            check.see(row, PERIOD, &rates(if i == 0 { 2.0 } else { 1.0 }, jerk));
        }
        check.finish().worst().ratio
    };
    assert!(judged(0) <= 1.0 + 1e-6, "{}", judged(0));
    assert!(judged(50) > 1.02, "{}", judged(50));
}

#[test]
fn what_nobody_has_looked_at_does_not_hold() {
    let nothing = JointCheck::new(&range()).finish();
    assert!(!nothing.holds(1e-6) && nothing.worst().ratio.is_nan(), "{:?}", nothing.checks());
    let no_joints = JointRange::<0>::new(Joints::zeros(), Joints::zeros()).expect("an empty range");
    assert!(!JointCheck::new(&no_joints).finish().holds(1e-6));
    assert!(JointCheck::new(&no_joints).finish().worst().ratio.is_nan());
}

#[test]
fn one_sample_is_held_against_every_limit() {
    let limits = rates(3.0, 100.0);
    let sample = |qd: f64, qdd: f64| JointSample { t: 0.0, q: [0.0].into(), qd: [qd].into(), qdd: [qdd].into() };
    let rest = judged(&[sample(0.0, 0.0)], PERIOD, &limits);
    assert!(rest.holds(1e-6));
    for quantity in [Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk] {
        assert_eq!(ratio(&rest, quantity), 0.0, "{quantity}");
    }
    // Not a number, whatever the limit.
    let free = JointRates { jerk: [f64::INFINITY].into(), ..limits };
    for (qd, qdd) in [(f64::NAN, 0.0), (0.0, f64::NAN)] {
        assert!(!judged(&[sample(qd, qdd)], PERIOD, &free).holds(1e-6), "{qd} {qdd}");
    }
    let unknown = JointRates { velocity: [f64::NAN].into(), ..limits };
    assert!(!judged(&[sample(0.0, 0.0)], PERIOD, &unknown).holds(1e-6));
}
