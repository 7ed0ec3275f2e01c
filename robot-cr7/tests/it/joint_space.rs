//! `cr7 move` and `cr7 online` as a person runs them.
#![cfg(feature = "cli")]

use crate::common;

use common::Desk;
use robot_cr7::{OnlineScenario, TrajectoryRow};

const HOME: [&str; 6] = ["0", "-30", "90", "30", "-90", "0"];
const THERE: [&str; 6] = ["60", "0", "60", "30", "-90", "45"];

fn with<'a>(parts: &[&[&'a str]]) -> Vec<&'a str> {
    parts.concat()
}

/// Finite differences of the file itself: every joint's velocity, acceleration and jerk stay under the limits, to within
/// what the difference of the samples can tell.
fn keeps(rows: &[TrajectoryRow<6>], limits: impl Fn(f64) -> [f64; 3]) {
    for pair in rows.windows(2) {
        let dt = pair[1].t - pair[0].t;
        let [velocity, acceleration, jerk] = limits(pair[0].t);
        for k in 0..6 {
            let rate = |a: f64, b: f64| ((b - a) / dt).abs();
            let slack = 1e-12 / dt;
            assert!(rate(pair[0].q[k], pair[1].q[k]) <= velocity * (1.0 + 1e-9) + slack, "J{} at {}", k + 1, pair[0].t);
            assert!(rate(pair[0].qd[k], pair[1].qd[k]) <= acceleration * (1.0 + 1e-9) + slack);
            assert!(rate(pair[0].qdd[k], pair[1].qdd[k]) <= jerk * (1.0 + 1e-9) + slack);
        }
    }
}

#[test]
fn a_move_ends_where_it_should_within_the_limits() {
    let desk = Desk::new("move");
    let run = desk.run(&with(&[&["move", "--from-deg"], &HOME, &["--to-deg"], &THERE])).done();
    for part in ["joint move", "not straight", "joint_jerk.svg", "joint jerk"] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    let rows = desk.trajectory::<6>("out");
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    for k in 0..6 {
        assert_eq!(first.q[k], HOME[k].parse::<f64>().expect("a number").to_radians());
        assert!((last.q[k] - THERE[k].parse::<f64>().expect("a number").to_radians()).abs() < 1e-14);
        assert_eq!((last.qd[k], last.qdd[k]), (0.0, 0.0));
    }
    keeps(&rows, |_| [std::f64::consts::PI, 10.0, 100.0]);
    // The joint with the longest way takes its time-optimal S-profile: 60 degrees at 10 rad/s^2 and 100 rad/s^3 reach no
    // constant speed, so that 2 a (t / 2)^2 ... = way: closed form for a profile with constant acceleration, no cruise.
    let (way, a, j) = (60f64.to_radians(), 10.0, 100.0);
    let ramp = a / j;
    let hold = 0.5 * (-3.0 * ramp + (ramp * ramp + 4.0 * way / a).sqrt());
    assert!((last.t - (4.0 * ramp + 2.0 * hold)).abs() < 1e-12, "{} {}", last.t, 4.0 * ramp + 2.0 * hold);
}

#[test]
fn a_line_is_straight_and_a_whole_number_of_cycles_when_asked() {
    let desk = Desk::new("line");
    let args =
        with(&[&["move", "--from-deg"], &HOME, &["--to-deg"], &THERE, &["--mode", "line", "--whole-cycles", "--json"]]);
    let report = desk.run(&args).done().json();
    let duration = report["duration_s"].as_f64().expect("a number");
    assert!((duration * 1e3 - (duration * 1e3).round()).abs() < 1e-9, "{duration}");
    for row in desk.trajectory::<6>("out") {
        let share = (row.q[0] - 0.0) / 60f64.to_radians();
        for k in 0..6 {
            let (from, to): (f64, f64) = (HOME[k].parse().expect("a number"), THERE[k].parse().expect("a number"));
            assert!((row.q[k] - (from + share * (to - from)).to_radians()).abs() < 1e-13, "J{} at {}", k + 1, row.t);
        }
    }
}

#[test]
fn bad_moves_are_refused() {
    let desk = Desk::new("bad_moves");
    let to = |q: [&'static str; 6]| with(&[&["move", "--from-deg"], &HOME, &["--to-deg"], &q]);
    desk.run(&to(["0", "0", "200", "0", "0", "0"])).refused(2, &["--to-deg", "joint 3", "outside its range"]);
    desk.run(&to(["0", "0", "nan", "0", "0", "0"])).refused(2, &["--to-deg", "value 3 is NaN"]);
    let fast = with(&[&to(THERE), &["--to-deg-s", "0", "500", "0", "0", "0", "0"]]);
    desk.run(&fast).refused(1, &["axis 2", "v of the target", "outside the limit"]);
    let crooked = with(&[&to(THERE), &["--from-deg-s", "0", "5", "0", "0", "0", "0", "--mode", "forced-line"]]);
    desk.run(&crooked).refused(1, &["axis 2", "straight line"]);
    desk.run(&with(&[&to(THERE), &["--least-s", "-1"]])).refused(2, &["-1"]);
}

#[test]
fn the_embedded_scenario_keeps_the_limits_in_force() {
    let desk = Desk::new("online");
    let run = desk.run(&["online"]).done();
    assert_eq!(run.stderr, "");
    for part in ["new q_deg of joint 2", "new velocity_deg_s of all joints", "target reached", "joint_jerk.svg"] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    let rows = desk.trajectory::<6>("out");
    let last = rows[rows.len() - 1];
    for (q, want) in last.q.iter().zip([-20f64, -20.0, 80.0, 20.0, -70.0, 10.0]) {
        assert!((q - want.to_radians()).abs() < 1e-14, "{q} {want}");
    }
    assert_eq!((last.qd, last.qdd), ([0.0; 6], [0.0; 6]));
    // The widest limits of the file; the report holds those in force.
    keeps(&rows, |_| [120f64.to_radians(), 500f64.to_radians(), 4000f64.to_radians()]);
    // From 0.6 s on 60 deg/s are allowed; the report tells when all joints are below them.
    let report = desk.run(&["online", "--json"]).done().json();
    let events = report["events"].as_array().expect("a list");
    let inside = events.iter().find(|e| e["what"] == "all joints are inside their limits").expect("it happens");
    let inside = inside["t_s"].as_f64().expect("a number");
    assert!((0.6..0.7).contains(&inside), "{inside}");
    for row in rows.iter().filter(|row| row.t >= inside) {
        assert!(row.qd.iter().all(|v| v.abs() <= 60f64.to_radians() * (1.0 + 1e-9)), "at {}", row.t);
    }
    for line in report["limits"].as_array().expect("a list") {
        // The speed limit is halved on the way, so that a joint may be at twice of it for a moment: see above.
        let most = if line["name"] == "joint velocity" { 2.0 } else { 1.0 + 1e-9 };
        assert!(line["ratio"].as_f64().expect("a number") <= most, "{line}");
    }
}

#[test]
fn the_printed_example_runs() {
    let desk = Desk::new("online_example");
    let run = desk.run(&["online", "--print-example"]).done();
    assert_eq!(run.stdout, OnlineScenario::EXAMPLE);
    desk.write("mine.toml", &run.stdout);
    desk.run(&["online", "mine.toml"]).done();
}

#[test]
fn bad_scenarios_name_the_line_and_the_rule() {
    const STATES: &str = "[start]\nq_deg = 0\n[target]\nq_deg = 10\n";
    let desk = Desk::new("bad_scenarios");
    let cases: [(&str, i32, &[&str]); 12] = [
        ("", 2, &["empty"]),
        ("[start]\nq_deg = 0\n", 2, &["missing field `target`"]),
        ("[start]\nq_deg = [1, 2]\n[target]\nq_deg = 0\n", 2, &["s.toml:2", "start.q_deg", "list of 2 for 6 joints"]),
        ("[start]\nq_deg = nan\n[target]\nq_deg = 0\n", 2, &["s.toml:2", "start.q_deg", "finite"]),
        ("[[change]]\nat_s = -1\nq_deg = 3\n", 2, &["s.toml:6", "change[0].at_s", "-1"]),
        ("[[change]]\nat_s = 0.1\n", 2, &["s.toml:5", "change[0]", "has to change something"]),
        ("[[change]]\nat_s = 0.1\njoint = 0\nq_deg = 3\n", 2, &["s.toml:7", "change[0].joint", "count from 1"]),
        ("[[change]]\nat_s = 0.1\njoint = 7\nq_deg = 3\n", 2, &["s.toml:7", "change[0].joint", "no such joint"]),
        ("[[change]]\nat_s = 0.1\njoint = 2\nq_deg = [3]\n", 2, &["s.toml:8", "change[0].q_deg", "one number"]),
        (
            "[[change]]\nat_s = 0.2\nq_deg = 3\n[[change]]\nat_s = 0.1\nq_deg = 4\n",
            2,
            &["s.toml:9", "change[1].at_s", "order of their times"],
        ),
        ("[[change]]\nat_s = 0.1\nvelocity_deg_s = 0\n", 2, &["s.toml:7", "change[0].velocity_deg_s", "above 0"]),
        ("[[change]]\nat_s = 0.1\nqd_deg_s = 300\n", 1, &["s.toml:6", "axis 1", "outside the limit"]),
    ];
    for (text, code, parts) in cases {
        let whole = if text.starts_with("[[") { format!("{STATES}{text}") } else { text.to_owned() };
        desk.write("s.toml", &whole);
        desk.run(&["online", "s.toml"]).refused(code, parts).refused(code, &["s.toml"]);
    }
    desk.write("s.toml", &format!("{STATES}[run]\nlongest_s = 0.05\n"));
    desk.run(&["online", "s.toml"]).refused(1, &["longest_s", "not reached"]);
}
