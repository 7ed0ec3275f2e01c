//! `cr7 verify`: trajectories of any source. What keeps the limits passes, each kind of spoilt row is named.
#![cfg(feature = "cli")]

use crate::common;

use common::Desk;
use robot_cr7::{SamplePath, TrajectoryRow, read_trajectory, write_trajectory};

/// Two joints that move as polynomials of the time, from rest to rest in 1 s, by `way` (rad) and half of it.
fn quintic(way: f64, digits: usize, rates: bool) -> String {
    let mut text = "t_s,q1_rad,q2_rad".to_owned();
    if rates {
        text += ",qd1_rad_s,qd2_rad_s,qdd1_rad_s2,qdd2_rad_s2";
    }
    text += "\n";
    for i in 0..=1000 {
        let t = f64::from(i) * 1e-3;
        let q = 10.0 * t.powi(3) - 15.0 * t.powi(4) + 6.0 * t.powi(5);
        let qd = 30.0 * t.powi(2) - 60.0 * t.powi(3) + 30.0 * t.powi(4);
        let qdd = 60.0 * t - 180.0 * t.powi(2) + 120.0 * t.powi(3);
        text += &format!("{t},{:.digits$},{:.digits$}", way * q, 0.5 * way * q);
        if rates {
            text += &[qd, 0.5 * qd, qdd, 0.5 * qdd].map(|v| format!(",{:.digits$}", way * v)).concat();
        }
        text += "\n";
    }
    text
}

/// Limits of which the quintic by 1 rad uses all of the velocity (1.875), acceleration (5.7735) and jerk (60) of its first joint.
const JOB: &str = "[joints]\nvelocity_deg_s = 107.42957\nacceleration_deg_s2 = 330.7975\njerk_deg_s3 = 3437.7468\n[feed]\nfeed_mm_s = 5000\n";

#[test]
fn a_planned_trajectory_passes_and_each_spoilt_row_is_named() {
    let desk = Desk::new("verify");
    desk.write("six.json", SamplePath::SixPoint.json());
    desk.run(&["plan", "six.json"]).done();
    let json = desk.run(&["verify", "out/trajectory.csv", "--json"]).done().json();
    assert!(json["limits"].as_array().is_some_and(|limits| limits.len() > 20));
    let file = std::fs::File::open(desk.folder.join("out/trajectory.csv")).expect("a file");
    let rows: Vec<TrajectoryRow> = read_trajectory(file, "out/trajectory.csv".as_ref()).expect("rows");
    let names = robot_cr7::Robot::load("cr7", None, None).expect("built in").any().joint_names().to_vec();
    let middle = rows.len() / 2;
    type Spoil = fn(&mut TrajectoryRow);
    let spoilt: [(&str, Spoil); 4] = [
        ("joint velocity", |row| row.q[2] += 0.01),
        ("joint velocity", |row| row.qd[1] = 4.0),
        ("joint acceleration", |row| row.qdd[0] = -11.0),
        ("joint position", |row| row.q[4] = 7.0),
    ];
    for (name, spoil) in spoilt {
        let mut rows = rows.clone();
        spoil(&mut rows[middle]);
        write_trajectory(&desk.folder.join("spoilt.csv"), &names, rows).expect("written");
        let run = desk.run(&["verify", "spoilt.csv", "--json"]);
        assert_eq!(run.code, 1, "{name}");
        let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        let limits = json["limits"].as_array().expect("limits");
        let over = limits.iter().filter(|line| line["ratio"].as_f64().is_none_or(|ratio| ratio > 1.0 + 1e-6));
        let names: Vec<&str> = over.filter_map(|line| line["name"].as_str()).collect();
        assert!(names.iter().any(|over| over.starts_with(name)), "{name}: {names:?}");
    }
}

#[test]
fn a_trajectory_of_another_robot_is_refused_by_the_names_of_its_joints() {
    let desk = Desk::new("verify_names");
    let run = |header: &str| {
        desk.write("q.csv", &format!("{header}\n0,0,0\n1,0,0\n"));
        desk.run(&["verify", "q.csv", "--robot", "planar_2r"])
    };
    run("t_s,q1_rad,q2_rad:joint2").done();
    for (header, column) in [
        ("t_s,q1_rad,q2_rad,qd1_rad_s,qd2_rad_s:elbow", "qd2_rad_s"),
        ("t_s,q1_rad,q2_rad:joint2,jerk2_rad_s3:elbow,y", "jerk2_rad_s3"),
        ("t_s,q1_rad,q2_rad,qdd1_rad_s2:joint1,qdd2_rad_s2:elbow", "qdd2_rad_s2"),
    ] {
        let more = ",0".repeat(header.matches(',').count() - 2);
        desk.write("q.csv", &format!("{header}\n0,0,0{more}\n1,0,0{more}\n"));
        let wrong = ["joint 2 is called \"elbow\" in column", column];
        desk.run(&["verify", "q.csv", "--robot", "planar_2r"]).refused(2, &wrong);
    }
    let time = run("t_s:anything,q1_rad,q2_rad");
    assert!(time.code == 2 && time.stderr.contains("t_s is missing"), "{time:?}");
    let other = run("t_s,q1_rad:joint1,q2_rad:elbow");
    assert!(other.code == 2 && other.stderr.contains("joint 2 is called \"elbow\""), "{other:?}");
}

#[test]
fn positions_alone_are_held_against_closed_forms() {
    let desk = Desk::new("verify_positions");
    desk.write("job.toml", JOB);
    let verify = |way: f64, digits: usize, rates: bool| {
        desk.write("q.csv", &quintic(way, digits, rates));
        let run = desk.run(&["verify", "q.csv", "--robot", "planar_2r", "--job", "job.toml", "--json"]);
        let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        let most = |name: &str| {
            let lines = json["limits"].as_array().expect("limits").iter();
            let of = lines.filter(|line| line["name"] == name && line["joint"] == 1);
            of.filter_map(|line| line["ratio"].as_f64()).fold(f64::NAN, f64::max)
        };
        (run.code, ["joint velocity", "joint acceleration", "joint jerk"].map(most), json["warnings"].to_string())
    };
    for rates in [false, true] {
        let (code, used, warnings) = verify(0.999, 17, rates);
        assert_eq!(code, 0, "{used:?}");
        // The mean of the jerk over three rows beside the start, where it is greatest, is a little less.
        assert!((used[0] - 0.999).abs() < 1e-5 && (used[1] - 0.999).abs() < 1e-5, "{used:?}");
        assert!((0.98..0.999 + 1e-6).contains(&used[2]), "{used:?}");
        assert_eq!(warnings.contains("differences"), !rates, "{warnings}");
        let (code, used, _) = verify(1.03, 17, rates);
        assert!(code == 1 && used.iter().all(|used| (1.01..1.031).contains(used)), "{used:?}");
    }
    // Six decimals are enough for the velocities, and what they are too few for is taken off.
    let (code, used, warnings) = verify(0.9, 6, true);
    assert!(code == 0 && (used[0] - 0.9).abs() < 2e-3, "{used:?}");
    assert!(warnings.contains("write more digits"), "{warnings}");
    // Four decimals feign a jerk of far above the limit: it is taken off and told.
    let (code, used, warnings) = verify(0.9, 4, false);
    assert!(code == 0 && used[2] < 0.9, "{used:?}");
    assert!(warnings.contains("write more digits"), "{warnings}");
}

/// Exit code and warnings for a file of two joints.
fn verified(desk: &Desk, text: &str) -> (i32, String) {
    desk.write("q.csv", text);
    let run = desk.run(&["verify", "q.csv", "--robot", "planar_2r", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    (run.code, json["warnings"].to_string())
}

#[test]
fn rounding_hides_no_excess_and_makes_none() {
    let desk = Desk::new("verify_rounding");
    // A joint that rests in short numbers beside one that is far too fast.
    let text =
        "t_s,q1_rad,q2_rad\n0,0.0001234567890123,0.0\n0.001,0.0601234567890123,0.0\n0.002,0.1201234567890123,0.0\n";
    assert_eq!(verified(&desk, text).0, 1);
    // Velocities that no position confirms, without accelerations.
    let text = "t_s,q1_rad,q2_rad,qd1_rad_s,qd2_rad_s\n0,0,0,100,100\n0.001,0,0,100,100\n";
    let (code, warnings) = verified(&desk, text);
    assert!(code == 1 && warnings.contains("no accelerations"), "{warnings}");
    // At the end of the range of pi, in four decimals.
    assert_eq!(verified(&desk, "t_s,q1_rad,q2_rad\n0,3.1416,0\n0.001,3.1416,0\n").0, 0);
    // At a constant speed just below pi, by a clock of milliseconds at 30 Hz.
    let rows = (0..60).map(|i| format!("{:.3},{:.6},0\n", f64::from(i) / 30.0, -3.1 + 3.1 * f64::from(i) / 30.0));
    let text = "t_s,q1_rad,q2_rad\n".to_owned() + &rows.collect::<String>();
    let (code, warnings) = verified(&desk, &text);
    assert!(code == 0, "{warnings}");
    assert!(verified(&desk, &text.replace("q2_rad", "q2_rads,q2_rad").replace(",0\n", ",0,0\n")).1.contains("q2_rads"));
}

#[test]
fn bad_files_are_refused() {
    let desk = Desk::new("verify_bad");
    desk.write("none.csv", "");
    desk.write("one.csv", "t_s,q1_rad,q2_rad\n0,0,0\n");
    desk.write("back.csv", "t_s,q1_rad,q2_rad\n0,0,0\n0.1,0,0\n0.05,0,0\n");
    desk.write("blank.csv", "\n\nt_s,q1_rad,q2_rad\n0,0,0\n\n0.1,0,0\n\n0.05,0,0\n");
    let args = |file| ["verify", file, "--robot", "planar_2r"];
    desk.run(&args("blank.csv")).refused(2, &["blank.csv:8", "increase"]);
    desk.run(&args("none.csv")).refused(2, &["none.csv", "header"]);
    desk.run(&args("one.csv")).refused(2, &["one.csv", "two rows"]);
    desk.run(&args("back.csv")).refused(2, &["back.csv", "4", "increase"]);
    desk.run(&args("nosuch.csv")).refused(2, &["nosuch.csv"]);
    desk.run(&["verify", "back.csv"]).refused(2, &["q3", "missing"]);
}
