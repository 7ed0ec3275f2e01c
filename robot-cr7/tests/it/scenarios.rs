//! Scenario files: those that come with the program run, and bad ones are refused by line and rule.

use crate::common::Desk;
use std::path::Path;

use robot_cr7::{Clock, Cr7, Cr7Error, Played, RunReport, Scenario};

fn played(text: &str) -> Result<(Played, RunReport), Cr7Error> {
    let scenario = Scenario::parse(text, Path::new("s.toml"))?;
    let cr7 = Cr7::of(scenario.job())?;
    let stage = scenario.stage(cr7.arm(), cr7.limits())?;
    let played = stage.play(Clock::Simulated)?;
    let report = RunReport::new(&stage, &played);
    Ok((played, report))
}

/// Differences of the setpoints themselves: no limit of velocity, acceleration or jerk is broken between two of them.
fn keeps(played: &Played, report: &RunReport, limits: [[f64; 6]; 3]) {
    let dt = report.period_s;
    let mut before = *played.start();
    for cycle in played.cycles() {
        let now = cycle.setpoint;
        let orders = [(now.q, before.q), (now.qd, before.qd), (now.qdd, before.qdd)];
        for ((now_values, before_values), limits) in orders.iter().zip(&limits) {
            for (k, limit) in limits.iter().enumerate() {
                let rate = (now_values[k] - before_values[k]).abs() / dt;
                assert!(rate <= limit * (1.0 + 1e-6) + 1e-9, "J{} at {}: {rate} of {limit}", k + 1, now.t);
            }
        }
        before = now;
    }
}

const TABLE_7: [[f64; 6]; 3] =
    [[6.0, 3.0, 4.0, 5.0, 6.0, 7.0], [10.0, 12.0, 14.0, 16.0, 18.0, 20.0], [100.0, 120.0, 140.0, 160.0, 180.0, 200.0]];

/// Point 4 of table 8, as printed.
#[allow(clippy::approx_constant, reason = "printed with four digits")]
const POINT_4: [f64; 6] = [0.0281, -1.1292, 0.8622, -2.6878, -1.5708, 0.0281];

#[test]
fn the_events_of_the_paper_end_where_they_should() {
    for (file, text) in &Scenario::ALL[..2] {
        let (played, report) = played(text).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(report.holds && report.path_finished, "{file}: {report}");
        assert!(report.events.iter().all(|e| e.refused.is_none()), "{file}: {report}");
        keeps(&played, &report, TABLE_7);
        let [way] = report.excursions.as_slice() else { panic!("{file}: {report}") };
        assert_eq!(way.resumed_at_m, Some(way.left_at_m), "{file}");
        assert!(way.time_to_goal_s.is_some() && way.time_to_return_s.is_some(), "{file}");
        // It stood at point 4 of the paper, for the second it was told to.
        let goal: Vec<f64> =
            POINT_4.iter().zip([0.0, 90.0, 0.0, 90.0, 0.0, 0.0]).map(|(q, z)| q + f64::to_radians(z)).collect();
        let there = played.cycles().iter().filter(|c| (0..6).all(|k| (c.setpoint.q[k] - goal[k]).abs() < 1e-12));
        let stood = there.count() as f64 * report.period_s;
        assert!((1.0..1.01).contains(&stood), "{file}: {stood}");
        let (before, after) = (report.accuracy_before.expect("ran"), report.accuracy_after.expect("ran"));
        assert!(before.setpoints_m < 1e-9 && after.setpoints_m < 1e-9, "{file}");
        // The lag leaves a straight path only through the joints' own geometry.
        assert!(before.simulated_arm_m > 0.0 && before.simulated_arm_m < 1e-5, "{file}: {before:?}");
        let states: Vec<&str> = report.states.iter().map(|s| s.state.as_str()).collect();
        let last = ["waiting", "returning", "task path", "done"];
        assert!(states.starts_with(&["task path", "leaving"]) && states.ends_with(&last), "{file}: {states:?}");
    }
}

/// "Control point 3 for a smooth transition": without a stop there, and by the paper's own way of moving joints.
#[test]
fn the_event_of_the_paper_passes_point_3_without_a_stop_and_by_projection() {
    let key = "pass_within_deg = 10.0\n";
    let with = |keys: &str| {
        assert!(Scenario::EXAMPLE.contains(key));
        let text = Scenario::EXAMPLE.replace(key, keys);
        let (played, report) = self::played(&text).unwrap_or_else(|e| panic!("{keys}: {e}"));
        assert!(report.holds && report.path_finished, "{keys}: {report}");
        keeps(&played, &report, TABLE_7);
        (played, report.excursions[0].time_to_goal_s.expect("it gets there"))
    };
    let stood = |played: &Played| {
        let away = |c: &&robot_cr7::Cycle| c.state.name() == "joint move";
        let still = played.cycles().iter().filter(away).filter(|c| c.setpoint.qd.amax() < 1e-9);
        still.count()
    };
    let (stopping, slow) = with("");
    let (passing, fast) = with("pass_within_deg = 5.0\n");
    assert!(stood(&stopping) > stood(&passing) && fast < slow - 0.05, "{fast} s to the goal instead of {slow}");
    let (by_projection, _) = with("pass_within_deg = 5.0\njoint_moves = \"projection\"\n");
    assert_eq!(stood(&by_projection), stood(&passing));
}

/// Nobody orders anything: what the readiness for orders costs against a plan that knows the whole motion.
#[test]
fn the_live_butterfly_is_within_three_percent_of_the_planned_one() {
    let desk = Desk::new("live_and_planned");
    let whole = include_str!("../../scenarios/butterfly_live.toml");
    let (head, _) = whole.split_once("[[event]]").expect("events");
    let (limits, run) = head.split_once("[run]").expect("how it runs");
    let without_path = limits.replace("[path]\nbuilt_in = \"butterfly\"\n", "");
    for feed in [10.0, 15.0] {
        let with_feed = |text: &str| {
            let lines = text.lines().map(|line| match line.starts_with("feed_mm_s") {
                true => format!("feed_mm_s = {feed:.1}\n"),
                false => format!("{line}\n"),
            });
            lines.collect::<String>()
        };
        desk.write("live.toml", &format!("{limits}[run]{}", with_feed(run)));
        desk.write("job.toml", &with_feed(&without_path));
        let live = desk.run(&["run", "live.toml", "--json"]).done().json();
        let planned = desk.run(&["plan", "--job", "job.toml", "--json"]).done().json();
        let [live, planned] = [live, planned].map(|report| report["duration_s"].as_f64().expect("a number"));
        assert!(live > planned && live < 1.03 * planned, "{live} s live, {planned} s planned");
    }
}

#[test]
fn the_butterfly_follows_the_feeds_that_are_ordered() {
    let (played, report) = played(Scenario::ALL[2].1).expect("runs");
    assert!(report.holds && report.path_finished, "{report}");
    assert!(report.events.iter().all(|e| e.refused.is_none()), "{report}");
    // No override or section leads above what was asked for, but while the tool brakes from a faster one.
    for pair in played.cycles().windows(2) {
        let (a, b) = (pair[0].setpoint, pair[1].setpoint);
        let asked = pair[0].asked.max(pair[1].asked);
        assert!(
            b.feed <= asked * (1.0 + 1e-9) || b.feed <= a.feed + 1e-5,
            "{} at {}: {} of {asked}",
            b.feed,
            b.t,
            a.feed
        );
    }
    assert!(report.excursions.is_empty() && report.accuracy_after.is_none());
    let states: Vec<&str> = report.states.iter().map(|s| s.state.as_str()).collect();
    assert_eq!(states, ["task path", "holding", "stepping back", "holding", "task path", "done"], "{report}");
}

#[test]
fn drives_without_lag_stay_on_the_path_and_slower_ones_are_behind() {
    let with = |ms: &str| {
        let text = Scenario::EXAMPLE.replace("drive_time_constant_ms = 8.0", &format!("drive_time_constant_ms = {ms}"));
        played(&text).expect("runs").1
    };
    let exact = with("0.0");
    assert!(exact.following_error_rad.iter().all(|&e| e == 0.0));
    assert!(exact.accuracy_before.expect("ran").simulated_arm_m < 1e-9);
    let (fast, slow) = (with("4.0"), with("[16, 16, 16, 16, 16, 16]"));
    for (k, velocity) in TABLE_7[0].into_iter().enumerate() {
        assert!(slow.following_error_rad[k] >= fast.following_error_rad[k]);
        // Behind by velocity times time constant at most.
        assert!(slow.following_error_rad[k] <= velocity * 0.016);
    }
}

const BASE: &str = "[path]\nbuilt_in = \"six_point\"\n[feed]\nfeed_mm_s = 20.0\n[run]\nfeed_mm_s = 10.0\n";

fn refused(text: &str, parts: &[&str]) {
    let error = match played(text) {
        Ok(_) => panic!("not refused: {text}"),
        Err(e) => e.to_string(),
    };
    for part in parts {
        assert!(error.contains(part), "\"{part}\" is missing in: {error}\n{text}");
    }
}

#[test]
fn orders_that_cannot_come_are_refused_by_line_and_rule() {
    let home = "points = [{ deg = [0, -30, 90, 30, -90, 0] }]";
    let event = |time: &str, what: &str| format!("[[event]]\n{time}\ndo = {what}\n");
    let leave = format!("\"leave\"\n{home}");
    let cases: [(Vec<String>, &[&str]); 23] = [
        (vec![event("at_s = -0.5", "\"hold\"")], &["s.toml:8", "event[0].at_s", "-0.5", "before the start"]),
        (vec![event("at_cycle = -1", "\"hold\"")], &["s.toml:8", "event[0].at_cycle", "-1", "before the start"]),
        (vec![event("at_mm = -1", "\"hold\"")], &["s.toml:8", "event[0].at_mm", "before the start"]),
        (vec![event("at_s = nan", "\"hold\"")], &["s.toml:8", "event[0].at_s", "NaN"]),
        (vec![event("at_s = 0.1", "\"resume\"")], &["s.toml:9", "event[0].do", "resume", "no hold or step back"]),
        (vec![event("at_s = 0.1", "\"return\"")], &["s.toml:9", "event[0].do", "return", "no event has left"]),
        (vec![event("at_s = 0.1", "\"hold\"")], &["s.toml:9", "stands for good", "add a resume"]),
        (vec![event("at_s = 0.1", &leave)], &["s.toml:9", "left for good", "add a return"]),
        (vec![event("at_s = 0.1", "\"override\"\npercent = 0")], &["s.toml:9", "override of 0 holds"]),
        (vec![event("at_s = 0.1", "\"stop\""), event("at_s = 0.2", "\"hold\"")], &["s.toml:12", "after a stop"]),
        (
            vec![event("at_s = 0.2", "\"feed\"\nfeed_mm_s = 5"), event("at_s = 0.1", "\"hold\"")],
            &["s.toml:12", "0.1 after 0.2", "order"],
        ),
        (vec![event("at_s = 0.1", &leave), event("at_mm = 10", "\"return\"")], &["event[1].at_mm", "off the path"]),
        (
            vec![event("at_s = 0.1", &leave), event("wait_s = 0.1", "\"step_back\"\nto_mm = 1")],
            &["event[1].do", "off its path", "return before"],
        ),
        (vec![event("wait_s = 1", "\"hold\"")], &["event[0].wait_s", "lets the arm stand"]),
        (vec![event("at_s = 0.1\nat_mm = 3", "\"hold\"")], &["event[0]", "several", "one time"]),
        (vec!["[[event]]\ndo = \"hold\"\n".to_owned()], &["event[0]", "needs a time", "at_s"]),
        (vec![event("at_s = 0.1", "\"hold\"\npercent = 10")], &["event[0].percent", "does not know the key"]),
        (vec![event("at_s = 0.1", "\"override\"\npercent = 151")], &["event[0].percent", "151", "0 and 150"]),
        (vec![event("at_s = 0.1", "\"fly\"")], &["s.toml:9", "unknown variant", "fly"]),
        (
            vec![event("at_s = 0.1", &format!("{leave}\npass_within_deg = -1"))],
            &["s.toml:11", "event[0].pass_within_deg", "-1", "0 to 90 deg", "0 stops at each"],
        ),
        (vec![event("at_s = 0.1", &format!("{leave}\npass_within_deg = nan"))], &["event[0].pass_within_deg", "NaN"]),
        (vec![event("at_s = 0.1", &format!("{leave}\njoint_moves = \"by_hand\""))], &["s.toml:11", "by_hand"]),
        (
            vec![event("at_s = 0.1", "\"hold\"\njoint_moves = \"projection\"")],
            &["event[0].joint_moves", "does not know the key"],
        ),
    ];
    for (events, parts) in cases {
        refused(&format!("{BASE}{}", events.concat()), parts);
    }
}

#[test]
fn places_and_times_that_the_motion_does_not_have_are_refused() {
    let event = |time: &str, what: &str| format!("{BASE}[[event]]\n{time}\ndo = {what}\n");
    let leave = |point: &str| {
        let leave = event(
            "at_s = 0.1",
            &format!("\"leave\"\npoints = [\n  {{ deg = [0, -30, 90, 30, -90, 0] }},\n  {point},\n]"),
        );
        format!("{leave}[[event]]\nwait_s = 0.1\ndo = \"return\"\n")
    };
    refused(
        &leave("{ deg = [0, -30, 200, 30, -90, 0] }"),
        &["s.toml:12", "event[0].points[1]", "joint 3 at 200.000 deg", "every joint stays in its range"],
    );
    refused(
        &leave("{ position_mm = [4000, 0, 300], rpy_deg = [180, 0, 0] }"),
        &["s.toml:12", "event[0].points[1]", "4000.000", "reach"],
    );
    refused(&leave("{ deg = [0, 1, 2] }"), &["event[0].points[1]", "a list of 3", "6 joints"]);
    refused(&leave("{ deg = 0, rad = 0 }"), &["s.toml:12", "event[0].points[1]", "neither of them, or several"]);
    refused(&leave("{ position_mm = [400, 0, 300] }"), &["event[0].points[1]", "rpy_deg"]);
    refused(&event("at_mm = 21", "\"stop\""), &["s.toml:8", "event[0].at_mm", "21", "20.849 mm", "before the end"]);
    refused(
        &event("at_s = 50", "\"stop\""),
        &["s.toml:8", "event[0].at_s", "50", "the motion ended at", "after the end"],
    );
    refused(&event("at_cycle = 50000", "\"stop\""), &["s.toml:8", "event[0].at_cycle", "the motion ended at"]);
    refused(
        &event("at_s = 0.1", "\"section\"\nfrom_mm = 30\nto_mm = 31\nfeed_mm_s = 5"),
        &["event[0].from_mm", "30", "20.849 mm"],
    );
    refused(
        &event("at_s = 0.1", "\"section\"\nfrom_mm = 3\nto_mm = 2\nfeed_mm_s = 5"),
        &["event[0].to_mm", "2 after 3"],
    );
    refused(&event("at_s = 0.1", "\"feed\"\nfeed_mm_s = 21"), &["event[0].feed_mm_s", "21", "highest"]);
    refused(&event("at_s = 0.1", "\"feed\"\nfeed_mm_s = 0"), &["event[0].feed_mm_s", "above 0"]);
    refused(&event("at_s = 0.1", "\"feed\""), &["event[0].do", "without feed_mm_s"]);
    refused(
        &format!("{BASE}longest_s = 0.5\n"),
        &["s.toml:7", "run.longest_s", "still in the state \"task path\"", "raise it"],
    );
}

#[test]
fn files_that_make_no_scenario_are_refused() {
    refused("", &["s.toml"]);
    refused(&BASE.replace("built_in", "builtin"), &["s.toml:2", "unknown field"]);
    refused(&BASE.replace("six_point", "sixpoint"), &["s.toml:2", "path.built_in", "sixpoint", "butterfly"]);
    refused(&BASE.replace("[path]", "[path]\nfile = \"x.json\""), &["path", "given twice"]);
    refused(&format!("{BASE}drive_time_constant_ms = -1\n"), &["run.drive_time_constant_ms", "-1", "0 and 10000"]);
    refused(&BASE.replace("[run]\nfeed_mm_s = 10.0", "[run]\nfeed_mm_s = 30.0"), &["run.feed_mm_s", "30", "highest"]);
    refused(&BASE.replace("built_in = \"six_point\"", "file = \"gone.json\""), &["gone.json", "check the name"]);
    let line =
        |to: &str| format!("[path]\nline = [{{ deg = [0, -30, 90, 30, -90, 0] }}{to}]\n[run]\nfeed_mm_s = 10.0\n");
    refused(&line(""), &["s.toml:2", "path.line", "a list of 1"]);
    // The same place twice is no line, and the other end is out of reach.
    refused(&line(", { deg = [0, -30, 90, 30, -90, 0] }"), &["s.toml"]);
    refused(&line(", { position_mm = [0, 3000, 0], rpy_deg = [0, 0, 0] }"), &["path.line[1]", "reach"]);
    let both = format!("{BASE}[joints]\nvelocity_deg_s = 10\nvelocity_rad_s = 1\n");
    refused(&both, &["s.toml:9", "joints.velocity_rad_s", "given once"]);
    let unknown = BASE.replace("[feed]", "[feed]\nangular_speed_deg_s = 30");
    refused(&unknown, &["feed.angular_speed_deg_s", "30", "remove the key"]);
    // A path that the arm cannot follow is named with its place.
    refused(&format!("{BASE}[workpiece]\nposition_mm = [900, 0, 0]\n"), &["s = ", "reach"]);
}
