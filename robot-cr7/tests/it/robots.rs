//! Other robots on the command line: by name, from URDF, from JSON.
#![cfg(feature = "cli")]

use crate::common;

use arcfeed_kinematics::{ForwardKinematics, Joints, models};
use common::Desk;
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn the_butterfly_with_other_robots() {
    let desk = Desk::new("other_robots");
    for robot in ["ur5e", "kr6_r700"] {
        let report = desk.run(&["plan", "--robot", robot, "--out", robot, "--json"]).done().json();
        assert!(report["duration_s"].as_f64().expect("a number") > 1.0);
        for limit in report["limits"].as_array().expect("a list") {
            assert!(limit["ratio"].as_f64().expect("a number") <= 1.0 + 1e-6, "{robot}: {limit}");
        }
        // The tool of the file is where the joints of the file put it.
        for row in desk.trajectory::<6>(robot).iter().step_by(100) {
            let q = Joints::from(row.q);
            let tool = if robot == "ur5e" { models::ur5e().forward(&q) } else { models::kr6_r700().forward(&q) };
            for k in 0..3 {
                assert!((tool.translation.vector[k] - row.position[k]).abs() < 1e-9, "{robot} at {}", row.t);
            }
        }
    }
}

#[test]
fn seven_joints_from_a_urdf_file_and_by_name_are_the_same_robot() {
    let desk = Desk::new("urdf");
    let urdf = desk.run(&["robots", "--urdf", "panda"]).done().stdout;
    desk.write("arm.urdf", &urdf);
    // The scan gives the same motion to rounding; the jerk-limited planner stops within a tolerance.
    desk.write("job.toml", "[plan]\nplanner = \"continuous-acceleration\"\n");
    let plan =
        |robot, out| desk.run(&["plan", "--job", "job.toml", "--robot", robot, "--out", out, "--json"]).done().json();
    let (by_name, by_file) = (plan("panda", "a"), plan("arm.urdf", "b"));
    let duration = |report: &Value| report["duration_s"].as_f64().expect("a number");
    assert!((duration(&by_name) - duration(&by_file)).abs() < 1e-6);
    let (a, b) = (desk.trajectory::<7>("a"), desk.trajectory::<7>("b"));
    assert_eq!(a.len(), b.len());
    let panda = models::panda();
    for (a, b) in a.iter().zip(&b).step_by(200) {
        for k in 0..7 {
            assert!((a.q[k] - b.q[k]).abs() < 1e-6, "joint {} at {}", k + 1, a.t);
        }
        let tool = panda.forward(&Joints::from(a.q));
        assert!((0..3).all(|k| (tool.translation.vector[k] - a.position[k]).abs() < 1e-9), "at {}", a.t);
    }
}

#[test]
fn what_is_left_out_of_a_file_is_said_by_every_command() {
    let desk = Desk::new("urdf_hand");
    let urdf = desk.run(&["robots", "--urdf", "panda"]).done().stdout;
    let last = urdf.rsplit("<child link=\"").next().and_then(|rest| rest.split('"').next()).expect("a last link");
    let finger = |k: usize| {
        format!(
            "<link name=\"f{k}\"/><joint name=\"jaw{k}\" type=\"prismatic\"><parent link=\"{last}\"/><child link=\"f{k}\"/>\
             <axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"0.04\" effort=\"10\" velocity=\"0.1\"/></joint>"
        )
    };
    desk.write("hand.urdf", &urdf.replace("</robot>", &format!("{}{}</robot>", finger(1), finger(2))));
    let report = desk.run(&["plan", "--robot", "hand.urdf", "--json"]).done().json();
    assert_eq!(report["joint_names"].as_array().map(Vec::len), Some(7));
    let warnings = report["warnings"].as_array().expect("a list");
    assert!(warnings.iter().any(|w| w.as_str().is_some_and(|w| w.contains("jaw1, jaw2"))), "{warnings:?}");
}

#[test]
fn one_configuration_of_any_robot() {
    let desk = Desk::new("one_configuration");
    let q = ["0.1", "-0.4", "0.2", "-2", "0.3", "1.6", "0.7"];
    let mut fk = vec!["fk", "--robot", "panda", "--json", "--rad"];
    fk.extend(q);
    let pose = desk.run(&fk).done().json();
    let position: Vec<String> = numbers(&pose["position_m"]).iter().map(|x| (x * 1e3).to_string()).collect();
    let rotation: Vec<String> = numbers(&pose["quaternion_xyzw"]).iter().map(f64::to_string).collect();
    let near: Vec<String> = q.iter().map(|q| q.parse::<f64>().expect("a number").to_degrees().to_string()).collect();
    let mut ik = vec!["ik", "--robot", "panda", "--json", "--xyz-mm"];
    ik.extend(position.iter().map(String::as_str));
    ik.push("--quat-xyzw");
    ik.extend(rotation.iter().map(String::as_str));
    ik.push("--near-deg");
    ik.extend(near.iter().map(String::as_str));
    let found = desk.run(&ik).done().json();
    assert_eq!(found["complete"], Value::Bool(false));
    for (found, q) in numbers(&found["nearest_rad"]).iter().zip(q) {
        assert!((found - q.parse::<f64>().expect("a number")).abs() < 1e-6);
    }
    let mut jacobian = vec!["jacobian", "--robot", "panda", "--json", "--rad"];
    jacobian.extend(q);
    assert_eq!(desk.run(&jacobian).done().json()["columns"].as_array().expect("a list").len(), 7);
    // Held still against gravity: what hangs on the first, vertical axis pulls on it with nothing.
    let mut torque = vec!["torque", "--robot", "ur5e", "--json", "--deg"];
    torque.extend(["10", "-80", "70", "-60", "-90", "20"]);
    let torque = numbers(&desk.run(&torque).done().json()["torque"]);
    assert!(torque[0].abs() < 1e-9 && torque[1].abs() > 1.0, "{torque:?}");
    let text = desk.run(&["inspect", "--robot", "kr6_r700"]).done().stdout;
    for part in ["spherical wrist", "335.000", "joint_6", "not known: jerk"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let list = desk.run(&["robots", "--json"]).done().json();
    assert_eq!(list["robots"].as_array().expect("a list").len(), 7);
}

#[test]
fn robots_that_cannot_be_used_say_why() {
    let desk = Desk::new("bad_robots");
    desk.run(&["plan", "--robot", "r2d2"]).refused(2, &["r2d2", "kr6_r700", ".urdf"]);
    desk.run(&["plan", "--robot", "planar_2r"]).refused(1, &["planar_2r", "2 joints", "six"]);
    desk.run(&["fk", "--robot", "panda", "--deg", "1", "2"]).refused(2, &["2 values", "panda has 7 joints"]);
    desk.run(&["fk", "--robot", "gone.urdf", "--deg", "1"]).refused(2, &["gone.urdf", "check the name"]);
    desk.write("not.urdf", "so long");
    desk.run(&["fk", "--robot", "not.urdf", "--deg", "1"]).refused(2, &["not.urdf", "URDF"]);
    desk.write("empty.json", "{}");
    desk.run(&["fk", "--robot", "empty.json", "--deg", "1"]).refused(2, &["empty.json", "JSON"]);
    desk.run(&["torque", "--robot", "planar_2r", "--deg", "1", "2"]).refused(1, &["inertia", "behind the joints"]);
    let to = ["move", "--robot", "planar_2r", "--from-deg", "0", "0", "--to-deg", "30"];
    desk.run(&to).refused(2, &["--to-deg", "1 values", "2 joints"]);
    desk.run(&["move", "--robot", "planar_2r", "--from-deg", "0", "0", "--to-deg", "30", "-20"]).done();
}
