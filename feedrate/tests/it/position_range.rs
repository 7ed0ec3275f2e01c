//! The lowest and the highest position of a motion, and when it is there.
#![allow(clippy::unwrap_used)]
use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

/// A position that is reached twice counts at its first time.
#[test]
fn the_range_of_a_way_there_and_back_begins_with_its_start() {
    let limits = AxisLimits::symmetric(2.0, 1.0, 4.0).unwrap();
    for v in [1.0, -1.0] {
        let (from, to) = (AxisState::new(0.0, v, 0.0), AxisState::new(0.0, -v, 0.0));
        let motion = StateToState::new(&from, &to, &limits).unwrap();
        let range = motion.position_range();
        let ends = [(range.min, range.t_min), (range.max, range.t_max)];
        let [edge, turn] = if v > 0.0 { ends } else { [ends[1], ends[0]] };
        assert_eq!(edge, (0.0, 0.0), "{range:?}");
        assert!(turn.0 * v > 0.0 && (turn.1 - 0.5 * motion.duration()).abs() < 1e-12, "{range:?}");
    }
}
