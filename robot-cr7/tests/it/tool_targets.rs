//! `cr7 online` with poses of the tool as targets.

use crate::common::Desk;

use nalgebra::{UnitQuaternion, Vector3};
use robot_cr7::{LimitLine, Robot, ToolRun, ToolScenario, tool_lines};

const STATES: &str =
    "[run]\nmode = \"tool\"\n[start]\nq_deg = [0, -30, 90, 30, -90, 0]\n[target]\nposition_mm = [-430, -250, 450]\n";

#[test]
fn the_example_goes_to_its_last_target_inside_every_limit() {
    let desk = Desk::new("tool_targets");
    let run = desk.run(&["online", "--print-tool-example"]).done();
    assert_eq!(run.stdout, ToolScenario::EXAMPLE);
    desk.write("tool.toml", &run.stdout);
    let report = desk.run(&["online", "tool.toml", "--json"]).done().json();
    for line in report["limits"].as_array().expect("a list") {
        assert!(line["ratio"].as_f64().expect("a number") <= 1.0 + 1e-6, "{line}");
    }
    let events: Vec<&str> =
        report["events"].as_array().expect("a list").iter().filter_map(|event| event["what"].as_str()).collect();
    assert!(events[1].starts_with("new position_mm of the tool"), "{events:?}");
    assert!(events[2].starts_with("new linear_mm_s of the tool at"), "{events:?}");
    assert_eq!(events.last(), Some(&"target reached"));
    // The flange carries a tool of 100 mm.
    let rows = desk.trajectory::<6>("out");
    let last = rows[rows.len() - 1];
    let miss = (Vector3::from(last.position) - Vector3::new(-0.45, -0.1, 0.5)).norm();
    assert!(miss < 1e-11, "{miss}");
    assert_eq!((last.qd, last.qdd), ([0.0; 6], [0.0; 6]));
    // From 1.1 s on there is one target: once the tool has turned towards it, it moves on a straight line.
    let straight: Vec<_> = rows.iter().filter(|row| row.t > 2.0).map(|row| Vector3::from(row.position)).collect();
    let along = (straight[straight.len() - 1] - straight[0]).normalize();
    for p in &straight {
        let off = p - straight[0];
        assert!((off - along * off.dot(&along)).norm() < 1e-9, "{off}");
    }
}

#[test]
fn what_is_wrong_is_named_by_line() {
    let desk = Desk::new("bad_tool_targets");
    let cases: [(&str, i32, &[&str]); 9] = [
        ("[[change]]\nat_s = 0.1\n", 2, &["s.toml:7", "change[0]", "has to change something"]),
        ("[[change]]\nat_s = 0.1\nq_deg = 3\n", 2, &["s.toml:9", "unknown field `q_deg`"]),
        ("[[change]]\nat_s = -1\nlinear_mm_s = 3\n", 2, &["s.toml:8", "change[0].at_s", "-1"]),
        ("[[change]]\nat_s = 0.1\nlinear_mm_s = 0\n", 2, &["s.toml:9", "change[0].linear_mm_s", "above 0"]),
        ("[[change]]\nat_s = 0.1\nposition_mm = [nan, 0, 0]\n", 2, &["s.toml:9", "change[0].position_mm[0]", "finite"]),
        ("[[change]]\nat_s = 0.2\nposition_mm = [900, 900, 300]\n", 1, &["s.toml:8", "straight way", "out of reach"]),
        ("[limits]\nangular_deg_s3 = -1\n", 2, &["s.toml:8", "limits.angular_deg_s3", "above 0"]),
        ("[limits]\nlinear_mm_s3 = 1e-9\n", 1, &["s.toml", "target", "more than 1000000 cycles"]),
        ("[joints]\nvelocity_deg_s = 0.01\n", 1, &["s.toml", "limit of joint velocity", "% of the tool limits"]),
    ];
    for (text, code, parts) in cases {
        desk.write("s.toml", &format!("{STATES}{text}"));
        desk.run(&["online", "s.toml"]).refused(code, parts).refused(code, &["s.toml"]);
        assert!(!desk.folder.join("out/trajectory.csv").exists(), "{text}");
    }
    desk.write("s.toml", &STATES.replace("position_mm = [-430, -250, 450]\n", ""));
    desk.run(&["online", "s.toml"]).refused(2, &["s.toml:5", "a target has a position or a rotation"]);
    desk.write("s.toml", &STATES.replace("[0, -30, 90, 30, -90, 0]", "[0, -30, 90, 30, 0, 0]"));
    desk.run(&["online", "s.toml"]).refused(1, &["s.toml:4", "start", "singular"]);
    desk.write("s.toml", STATES);
    desk.run(&["online", "s.toml", "--robot", "panda"]).refused(1, &["panda has 7 joints", "six joints"]);
    desk.write(
        "s.toml",
        &format!("{STATES}[sampling]\nperiod_ms = 1\n").replace("[run]\n", "[run]\nlongest_s = 0.05\n"),
    );
    desk.run(&["online", "s.toml"]).refused(1, &["longest_s", "not reached"]);
}

/// A change of a motion that a check has to notice.
type Spoil = fn(&mut ToolRun<6>);

/// The lines of the example after `spoil`, and which of them are broken.
fn broken(spoil: impl Fn(&mut ToolRun<6>)) -> Vec<String> {
    let scenario = ToolScenario::parse(ToolScenario::EXAMPLE, "tool.toml".as_ref()).expect("a scenario");
    let robot = Robot::load("cr7", None, None).expect("built in");
    let arm = robot.arm::<6>(scenario.tool).expect("six joints");
    let (limits, _) = robot.limits::<6>(&scenario.settings.joints).expect("limits");
    let mut run = scenario.run(&arm, &limits).expect("a motion");
    spoil(&mut run);
    let lines: Vec<LimitLine> = tool_lines(&arm, &run);
    lines.into_iter().filter(|line| !line.holds()).map(|line| line.name).collect()
}

#[test]
fn a_spoilt_motion_of_the_tool_breaks_a_named_line() {
    assert_eq!(broken(|_| {}), Vec::<String>::new());
    let cases: [(&str, Spoil); 8] = [
        ("tool speed", |run| run.limits.iter_mut().for_each(|(_, l)| l[0] *= 0.9)),
        ("tool acceleration", |run| run.limits.iter_mut().for_each(|(_, l)| l[1] *= 0.5)),
        ("tool jerk", |run| run.limits.iter_mut().for_each(|(_, l)| l[2] *= 0.7)),
        ("tool angular speed", |run| run.limits.iter_mut().for_each(|(_, l)| l[3] *= 0.99)),
        ("tool angular acceleration", |run| run.limits.iter_mut().for_each(|(_, l)| l[4] *= 0.99)),
        ("tool angular jerk", |run| run.limits.iter_mut().for_each(|(_, l)| l[5] *= 0.99)),
        ("tool at the end", |run| run.target.translation.vector.x += 1e-6),
        ("orientation at the end", |run| {
            run.target.rotation = UnitQuaternion::from_euler_angles(1e-6, 0.0, 0.0) * run.target.rotation;
        }),
    ];
    for (name, spoil) in cases {
        let broken = broken(spoil);
        assert!(broken.iter().any(|line| line == name), "{name}: {broken:?}");
    }
    // A stale velocity, seen as a jump of the acceleration.
    let stale = broken(|run| run.joints.samples[500].1.qd *= 0.5);
    assert!(stale.iter().any(|line| line == "tool acceleration"), "{stale:?}");
    assert!(broken(|run| run.joints.samples.clear()).iter().any(|line| line == "tool at the end"));
}
