//! The test that takes longest. Tests begin in the order of their names, and the last one would keep one core waiting.

use arcfeed_interp::Planner;
use arcfeed_kinematics::models;

use crate::windows::{limits, route};

/// Without being asked for: what would take half a gigabyte at once.
#[test]
fn very_long_paths_are_planned_in_windows_by_themselves() {
    let arm = models::ur5e();
    let path = route(4, 60);
    let planner = Planner::new(&arm, limits());
    let plan = planner.clone().with_intervals(60_000).expect("allowed").plan(&path).expect("is planned");
    let info = plan.info().windows.as_ref().expect("a long path");
    assert!(info.count > 5 && info.stops.is_empty() && plan.info().to_string().contains("windows"), "{info:?}");
    let coarse = planner.with_intervals(6000).expect("allowed").plan(&path).expect("is planned");
    assert!(plan.duration() < 1.005 * coarse.duration(), "{} and {}", plan.duration(), coarse.duration());
}
