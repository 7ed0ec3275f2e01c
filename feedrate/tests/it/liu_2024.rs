//! Liu et al. 2024, table 4: the durations of six joints are time-optimal.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

#[test]
fn table_4_durations() {
    // Start and end position (rad), velocity, acceleration; printed duration; the same to six decimals by ruckig 0.19.4.
    let joints = [
        ((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), 0.6000, 0.600000),
        ((-2.0, -4.0, 1.0), (-6.0, 6.0, 2.0), 0.6519, 0.651923),
        ((3.0, 3.0, -2.0), (10.0, 7.0, -3.0), 0.7756, 0.775559),
        ((-4.0, -2.0, 3.0), (2.0, -5.0, -1.0), 0.9145, 0.914486),
        ((5.0, 0.0, 5.0), (0.0, -6.0, 4.0), 0.6290, 0.628964),
        ((1.0, 3.0, -2.0), (-5.0, -8.0, 0.0), 0.7559, 0.755880),
    ];
    let limits = AxisLimits::symmetric(10.0, 100.0, 1000.0).unwrap();
    let state = |s: (f64, f64, f64)| AxisState::new(s.0, s.1, s.2);
    for (k, (start, end, printed, exact)) in joints.into_iter().enumerate() {
        let duration = StateToState::new(&state(start), &state(end), &limits).unwrap().duration();
        assert!((duration - printed).abs() <= 0.5e-4, "joint {}: {duration}, printed {printed}", k + 1);
        assert!((duration - exact).abs() <= 0.5e-6, "joint {}: {duration}, {exact}", k + 1);
    }
}
