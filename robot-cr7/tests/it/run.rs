//! `cr7 run` as a person runs it.
#![cfg(feature = "cli")]

use crate::common;

use common::Desk;
use robot_cr7::Scenario;

#[test]
fn the_embedded_scenario_writes_trajectory_pictures_and_reports() {
    let desk = Desk::new("run_embedded");
    let run = desk.run(&["run"]).done();
    for part in
        ["event.toml", "leave, braking", "to return", "resumed at", "waiting", "joint jerk", "median", "report.json"]
    {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    assert_eq!(run.stderr, "");
    for picture in ["tool_path", "joints", "timeline", "feed"] {
        let text =
            std::fs::read_to_string(desk.folder.join("out").join(picture).with_extension("svg")).expect("written");
        assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>"), "{picture}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{picture}");
    }
    let text = std::fs::read_to_string(desk.folder.join("out/report.txt")).expect("written");
    assert!(text.contains("left the path"), "{text}");
    let json = std::fs::read_to_string(desk.folder.join("out/report.json")).expect("written");
    let report: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(report["holds"], true, "{report}");

    // The trajectory is what the report says: it ends where the scenario's line does, and the simulated arm follows it with its lag.
    let rows = desk.trajectory::<6>("out");
    assert_eq!(rows.len() as u64, report["samples"].as_u64().expect("a number"));
    let end = [
        -1.288716540983,
        -1.53915982343 + std::f64::consts::FRAC_PI_2,
        1.908883478059,
        -1.940343105692 + std::f64::consts::FRAC_PI_2,
        -1.570343399872,
        0.284108430358,
    ];
    let last = rows[rows.len() - 1];
    for (k, end) in end.into_iter().enumerate() {
        assert!((last.q[k] - end).abs() < 1e-9, "J{}: {} {end}", k + 1, last.q[k]);
        assert_eq!((last.qd[k], last.qdd[k]), (0.0, 0.0));
    }
    let file = desk.folder.join("out/simulated.csv");
    let bytes = std::fs::read(&file).expect("written");
    let simulated = robot_cr7::read_trajectory::<_, 6>(bytes.as_slice(), &file).expect("a trajectory");
    for (a, b) in rows[1..].iter().zip(&simulated) {
        for k in 0..6 {
            // Behind by at most the highest velocity times the time constant.
            assert!((a.t - b.t).abs() < 1e-12 && (a.q[k] - b.q[k]).abs() <= 7.0 * 0.008, "J{} at {}", k + 1, a.t);
        }
    }
}

#[test]
fn json_is_one_object_and_examples_can_be_printed_and_run() {
    let desk = Desk::new("run_json");
    for (file, text) in Scenario::ALL {
        let printed = desk.run(&["run", "--print-example", file.trim_end_matches(".toml")]).done();
        assert_eq!(printed.stdout, text, "{file}");
    }
    assert_eq!(desk.run(&["run", "--print-example"]).done().stdout, Scenario::EXAMPLE);
    desk.run(&["run", "--print-example", "nothing"]).refused(2, &["nothing", "event_middle.toml"]);
    desk.write("middle.toml", Scenario::ALL[1].1);
    let report = desk.run(&["run", "middle.toml", "--out", "deep/er", "--json"]).done().json();
    assert_eq!(report["excursions"][0]["time_to_leave_s"], 0.0, "{report}");
    assert_eq!(report["path_finished"], true);
    assert!(desk.folder.join("deep/er/trajectory.csv").exists());
}

/// A short line in front of any arm of that size.
const SHORT: &str = "[path]\nline = [\n  { position_mm = [400, 0, 300], rpy_deg = [180, 0, 0] },\n  { position_mm = [400, 30, 300], rpy_deg = [180, 0, 0] },\n]\n[run]\nfeed_mm_s = 100\nstart = { deg = [0, -30, 90, 30, -90, 0] }\n";

#[test]
fn other_robots_and_real_time() {
    let desk = Desk::new("run_others");
    desk.write("short.toml", SHORT);
    let report = desk.run(&["run", "short.toml", "--real-time", "--json"]).done().json();
    assert!(report["duration_s"].as_f64().is_some_and(|t| t > 0.3), "{report}");
    assert!(report["step_times"]["median_s"].as_f64().is_some_and(|t| t < 1e-3), "{report}");
    let other =
        SHORT.replace("start = { deg = [0, -30, 90, 30, -90, 0] }", "start = { deg = [0, -90, 90, -90, -90, 0] }");
    desk.write("other.toml", &other);
    let run = desk.run(&["run", "other.toml", "--robot", "ur5e"]).done();
    assert!(run.stdout.contains("warning: ") && run.stdout.contains("assumed"), "{run:?}");
    desk.run(&["run", "short.toml", "--robot", "panda"]).refused(1, &["panda", "7 joints"]);
}

#[test]
fn bad_scenarios_are_refused_with_their_line() {
    let desk = Desk::new("run_bad");
    desk.write("early.toml", &format!("{SHORT}[[event]]\nat_s = -1\ndo = \"stop\"\n"));
    desk.run(&["run", "early.toml"]).refused(2, &["early.toml:10", "event[0].at_s", "-1", "before the start"]);
    desk.write("resume.toml", &format!("{SHORT}[[event]]\nat_s = 0.1\ndo = \"resume\"\n"));
    desk.run(&["run", "resume.toml"]).refused(2, &["resume.toml:11", "event[0].do", "no hold or step back"]);
    desk.write("late.toml", &format!("{SHORT}[[event]]\nat_s = 9\ndo = \"stop\"\n"));
    desk.run(&["run", "late.toml"]).refused(2, &["late.toml:10", "event[0].at_s", "the motion ended at"]);
    desk.write("far.toml", &SHORT.replace("[400, 30, 300]", "[400, 3000, 300]"));
    desk.run(&["run", "far.toml"]).refused(2, &["far.toml:4", "path.line[1]", "reach"]);
    desk.run(&["run", "gone.toml"]).refused(2, &["gone.toml", "check the name"]);
    assert!(!desk.folder.join("out/trajectory.csv").exists());
}
