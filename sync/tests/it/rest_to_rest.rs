//! Straight-line moves: limits, straightness, exact ends, time-optimality against a closed form, bad input.
use arcfeed_sync::{SyncError, Trajectory, symmetric_limits};
use nalgebra::{SVector, Vector3};
use proptest::prelude::*;

fn vector(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(range).prop_map(Vector3::from)
}

proptest! {
    #[test]
    fn keeps_every_axis_inside_its_bounds_on_a_straight_line(
        start in vector(-3.0..3.0), goal in vector(-3.0..3.0),
        v in vector(0.1..5.0), a in vector(0.5..50.0), j in vector(1.0..5000.0), least in 0.0..6.0_f64,
    ) {
        let limits = symmetric_limits(v, a, j).unwrap();
        let motion = Trajectory::rest_to_rest(start, goal, &limits, least).unwrap();
        let t_end = motion.duration();
        prop_assert!(t_end >= least * (1.0 - 1e-12));
        let mut tightest = 0.0_f64;
        for i in 0..=400 {
            let s = motion.at(t_end * f64::from(i) / 400.0);
            for k in 0..3 {
                let ratio = (s.qd[k].abs() / v[k]).max(s.qdd[k].abs() / a[k]).max(s.qddd[k].abs() / j[k]);
                prop_assert!(ratio <= 1.0 + 1e-9, "axis {k}: {ratio}");
                tightest = tightest.max(ratio);
            }
            let off = (s.q - start).cross(&(goal - start)).norm();
            prop_assert!(off <= 1e-12 * (1.0 + (goal - start).norm_squared()));
        }
        // Some bound is reached unless the duration was asked for.
        prop_assert!(t_end <= least * (1.0 + 1e-12) || tightest > 1.0 - 1e-9);
        let (first, last) = (motion.at(0.0), motion.at(t_end));
        prop_assert!(first.q == start && last.q == goal && first.qd.norm() == 0.0 && last.qd.norm() == 0.0);
    }
}

#[test]
fn duration_is_the_textbook_one() {
    // All three bounds reached: d / v + v / a + a / j.
    let limits = symmetric_limits(SVector::from([1.0]), SVector::from([4.0]), SVector::from([40.0])).unwrap();
    let motion = Trajectory::rest_to_rest(SVector::from([0.0]), SVector::from([3.0]), &limits, 0.0).unwrap();
    assert!((motion.duration() - (3.0 + 0.25 + 0.1)).abs() < 1e-12);
    // Only the jerk bound: 4 (d / (2 j))^(1/3).
    let motion = Trajectory::rest_to_rest(SVector::from([0.0]), SVector::from([1e-3]), &limits, 0.0).unwrap();
    assert!((motion.duration() - 4.0 * (1e-3_f64 / 80.0).cbrt()).abs() < 1e-12);
}

#[test]
fn no_way_to_go_takes_no_time() {
    let limits = symmetric_limits(Vector3::repeat(1.0), Vector3::repeat(1.0), Vector3::repeat(1.0)).unwrap();
    let motion = Trajectory::rest_to_rest(Vector3::x(), Vector3::x(), &limits, 3.0).unwrap();
    assert_eq!(motion.duration(), 0.0);
    assert_eq!(motion.at(1.0).q, Vector3::x());
}

#[test]
fn bad_input_is_named() {
    let one = Vector3::repeat(1.0);
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let message = symmetric_limits(one, Vector3::new(1.0, bad, 1.0), one).unwrap_err().to_string();
        assert!(message.starts_with("axis 2: acceleration limit is"), "{message}");
    }
    let limits = symmetric_limits(one, one, one).unwrap();
    let nan = Vector3::new(0.0, 0.0, f64::NAN);
    assert!(matches!(
        Trajectory::rest_to_rest(nan, one, &limits, 0.0),
        Err(SyncError::Axis { axis: 2, what: "start", .. })
    ));
    assert!(matches!(Trajectory::rest_to_rest(one, one, &limits, -1.0), Err(SyncError::Duration { .. })));
    assert!(matches!(
        Trajectory::rest_to_rest(one * -1e308, one * 1e308, &limits, 0.0),
        Err(SyncError::Axis { what: "distance", .. })
    ));
}
