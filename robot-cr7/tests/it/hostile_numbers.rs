//! Numbers that cannot be meant: refused by name, with the bound.

use std::path::Path;

use robot_cr7::{OnlineScenario, PathFile, ScheduleFile};

#[test]
fn a_million_control_points_are_refused_with_the_bound() {
    let points = vec!["[0.1, 0.2]"; 25_001].join(", ");
    let text = format!("{{\"units\": \"m\", \"degree\": 3, \"control_points\": [{points}], \"knots\": []}}");
    let error = PathFile::from_bytes(text.as_bytes(), Path::new("big.json"), None).expect_err("too many");
    let text = error.to_string();
    assert!(text.contains("control_points is a list of 25001") && text.contains("at most 25000"), "{text}");
}

#[test]
fn a_million_points_are_refused_with_the_bound() {
    let rows: String = (0..=500_000).map(|i| format!("{i},0\n")).collect();
    let text = format!("x_mm,y_mm\n{rows}");
    let error = PathFile::from_bytes(text.as_bytes(), Path::new("big.csv"), None).expect_err("too many");
    let text = error.to_string();
    assert!(text.contains("big.csv:500002") && text.contains("at most 500000 points"), "{text}");
}

/// Sine and cosine of 1e9 degrees have lost half their digits, and nobody means them.
#[test]
fn joint_values_of_a_billion_degrees_are_refused_by_name() {
    let online = "[start]\nq_deg = [1e9, 0]\n[target]\nq_deg = [10, 20]\n";
    let error = OnlineScenario::parse(online, Path::new("online.toml")).expect_err("absurd").to_string();
    assert!(error.contains("start.q_deg[0] is 1000000000") && error.contains("within a hundred turns"), "{error}");
    let schedule = "[[waypoint]]\nq_deg = 0\n[[waypoint]]\nq_deg = [0, -1e9]\n";
    let error = ScheduleFile::parse(schedule, Path::new("schedule.toml")).expect_err("absurd").to_string();
    assert!(error.contains("waypoint[1].q_deg[1] is -1000000000"), "{error}");
}
