//! `cr7 send` without a controller: a dry run, and what is refused. With one: `integration-tests/controller`.

use std::net::TcpListener;

use crate::common::Desk;

#[test]
fn a_dry_run_says_what_would_be_sent_and_its_setpoints_keep_the_limits() {
    let desk = Desk::new("send");
    let run = desk.run(&["send", "--out", "dry"]).done();
    assert!(run.stdout.contains("nothing is sent") && run.stdout.contains("ServoJ("), "{run:?}");
    desk.run(&["verify", "dry/setpoints.csv"]).done();
    desk.run(&["plan", "--compile-rad", "1e-6", "--out", "plan"]).done();
    let again = desk.run(&["send", "plan/joint_trajectory.json", "--json", "--out", "again"]).done();
    assert_eq!(again.json()["duration_s"], desk.run(&["send", "--json"]).done().json()["duration_s"]);
    let read = |name: &str| std::fs::read_to_string(desk.folder.join(name)).expect(name);
    assert_eq!(read("dry/setpoints.csv"), read("again/setpoints.csv"));
}

#[test]
fn what_is_not_certified_for_the_arm_is_not_sent() {
    let desk = Desk::new("send_slow");
    desk.run(&["plan", "--compile-rad", "1e-6", "--out", "plan"]).done();
    desk.write("slow.toml", "[joints]\nvelocity_deg_s = 30\n");
    let arguments = ["send", "plan/joint_trajectory.json", "--job", "slow.toml"];
    desk.run(&arguments).refused(1, &["not certified", "velocity of joint 3", "plan it under the limits"]);
    assert!(!desk.folder.join("out/setpoints.csv").exists());
}

#[test]
fn limits_beyond_those_of_the_arm_are_not_sent() {
    let desk = Desk::new("send_beyond");
    desk.run(&["plan", "--compile-rad", "1e-6", "--out", "plan"]).done();
    desk.write("fast.toml", "[joints]\nvelocity_deg_s = [180, 180, 344, 180, 180, 180]\n");
    let words = ["velocity of joint 3", "344.000", "joint3 of cr7", "180.000 deg/s", "lower it", "--robot"];
    desk.run(&["send", "--job", "fast.toml"]).refused(2, &words);
    desk.run(&["send", "plan/joint_trajectory.json", "--job", "fast.toml"]).refused(2, &words);
    assert!(!desk.folder.join("out/setpoints.csv").exists());
    // A job may state what the arm has, and what nobody knows of it.
    desk.write("own.toml", "[joints]\nvelocity_deg_s = 180\nacceleration_deg_s2 = 1200\njerk_deg_s3 = 12000\n");
    desk.run(&["send", "--job", "own.toml"]).done();
    desk.write("accelerating.toml", "[joints]\nacceleration_deg_s2 = 100000\n");
    let arguments = ["send", "--robot", "drv70l_stand_in", "--job", "accelerating.toml"];
    desk.run(&arguments).refused(2, &["acceleration of joint 1", "100000.000", "deg/s^2"]);
    desk.write("jerking.toml", "[joints]\njerk_deg_s3 = 100000\n");
    let arguments = ["send", "--robot", "drv70l_stand_in", "--job", "jerking.toml"];
    desk.run(&arguments).refused(2, &["jerk of joint 1", "100000.000", "deg/s^3"]);
}

#[test]
fn a_scenario_is_rehearsed_and_its_setpoints_keep_the_limits() {
    let desk = Desk::new("send_live");
    desk.write("live.toml", &desk.run(&["run", "--print-example", "butterfly_live"]).done().stdout);
    let run = desk.run(&["send", "--scenario", "live.toml", "--json"]).done();
    let report = run.json();
    let facts = report["facts"].to_string();
    assert!(facts.contains("nothing is sent") && facts.contains("planned while the arm moves"), "{facts}");
    // The joints keep the limits, whatever became of the feed on the way.
    desk.run(&["verify", "out/setpoints.csv"]).done();
    let played = desk.run(&["run", "live.toml", "--json", "--out", "played"]).done().json();
    assert_eq!(report["duration_s"], played["duration_s"]);
    assert_eq!(report["limits"], played["limits"]);

    desk.write("event.toml", &desk.run(&["run", "--print-example", "event"]).done().stdout);
    let arguments = ["send", "--scenario", "event.toml"];
    desk.run(&arguments).refused(2, &["velocity of joint 1", "343.775", "joint1 of cr7 has 180.000 deg/s", "lower it"]);
    let arguments = ["send", "--scenario", "live.toml", "--period-ms", "7", "--dialect", "v4"];
    let live = desk
        .run(&["run", "--print-example", "butterfly_live"])
        .done()
        .stdout
        .replace("period_ms = 1.0", "period_ms = 2.0");
    desk.write("live.toml", &live);
    desk.run(&arguments).refused(2, &["live.toml", "sampling.period_ms", "whole number of cycles"]);
    desk.run(&["send", "motion.json", "--scenario", "live.toml"]).refused(2, &["cannot be used with"]);
    assert!(!desk.folder.join("out/setpoints.csv").exists());
}

#[test]
fn wrong_usage_is_refused_with_the_way_out() {
    let desk = Desk::new("send_usage");
    desk.run(&["send", "--really"]).refused(2, &["--address"]);
    desk.run(&["send", "--enable", "--address", "127.0.0.1"]).refused(2, &["--really"]);
    desk.run(&["send", "--period-ms", "3"]).refused(2, &["period", "0.004"]);
    desk.run(&["send", "--period-ms", "10", "--dialect", "v3"]).refused(2, &["20 ms and more"]);
    desk.run(&["send", "--period-ms", "4.4"]).refused(2, &["whole number of milliseconds"]);
    desk.run(&["send", "--start-tolerance-deg", "6"]).refused(2, &["0 to 5", "--approach"]);
    desk.run(&["send", "--following-deg", "6"]).refused(2, &["--following-deg 6", "give 0.006 to 5 degrees"]);
    desk.run(&["send", "--following-deg", "0.005"]).refused(2, &["--following-deg 0.005", "give 0.006 to 5"]);
    desk.run(&["send", "--lag-ms", "1100"]).refused(2, &["lag", "1.000000"]);
    desk.run(&["send", "--robot", "panda"]).refused(2, &["six joints"]);
    desk.run(&["send", "--model", "10"]).refused(2, &["--model 10", "[7, 117, 207]"]);
    desk.run(&["send", "--model", "0"]).refused(2, &["1..=255"]);
    let ur = ["send", "--robot", "ur5e", "--address", "127.0.0.1", "--really"];
    desk.run(&ur).refused(2, &["--model"]);
    // A port on which nobody listens.
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("its number").port().to_string();
    drop(listener);
    let arguments = ["send", "--address", "127.0.0.1", "--ports", &port, &port, &port, "--really"];
    desk.run(&arguments).refused(1, &["dashboard connection", "check the address"]);
}

#[test]
fn a_motion_of_another_robot_is_refused() {
    let desk = Desk::new("send_names");
    desk.run(&["plan", "--compile-rad", "1e-6", "--out", "plan"]).done();
    let file = desk.folder.join("plan/joint_trajectory.json");
    let text = std::fs::read_to_string(&file).expect("a motion");
    let names: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let name = names["joint_names"][2].as_str().expect("a name").to_owned();
    desk.write("other.json", &text.replace(&format!("{name:?}"), "\"elbow\""));
    desk.run(&["send", "other.json"]).refused(2, &["joint 3", "elbow", "another robot"]);
}

#[test]
fn joints_that_slide_are_refused() {
    let desk = Desk::new("send_slides");
    let joints: String = (1..=6)
        .map(|k| {
            let kind = if k == 3 { "prismatic" } else { "revolute" };
            format!(
                "<link name='l{k}'/><joint name='j{k}' type='{kind}'><parent link='l{}'/><child link='l{k}'/><origin xyz='0.1 0 0.2'/>\
                 <axis xyz='{} 0'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint>",
                k - 1,
                if k % 2 == 0 { "0 1" } else { "1 0" }
            )
        })
        .collect();
    desk.write("slide.urdf", &format!("<robot name='slide'><link name='l0'/>{joints}</robot>"));
    desk.run(&["send", "--robot", "slide.urdf"]).refused(2, &["j3 of slide slides"]);
}

#[test]
fn names_of_joints_with_commas_and_quotes_stay_one_column() {
    let desk = Desk::new("send_quoted");
    let urdf = desk.run(&["robots", "--urdf", "ur5e"]).done().stdout;
    assert!(urdf.contains("shoulder_pan_joint"));
    desk.write("quoted.urdf", &urdf.replace("shoulder_pan_joint", "pan, &quot;left&quot;"));
    desk.run(&["send", "--robot", "quoted.urdf"]).done();
    let text = std::fs::read_to_string(desk.folder.join("out/setpoints.csv")).expect("setpoints");
    assert!(
        text.starts_with("t_s,\"q1_rad:pan, \"\"left\"\"\",q2_rad:shoulder_lift_joint,"),
        "{:?}",
        text.lines().next()
    );
    desk.run(&["verify", "out/setpoints.csv", "--robot", "quoted.urdf"]).done();
}
