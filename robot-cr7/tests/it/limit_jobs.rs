//! Jobs with limits as tables, limits on the vectors of the tool, ratings and vibrations: read, planned, reported.

use std::path::Path;
use std::time::Duration;

use approx::assert_relative_eq;
use arcfeed_interp::{Quantity, TableKind};
use robot_cr7::{Advice, Job, SamplePath, Task};

fn read(text: &str) -> Result<Job, robot_cr7::InputError> {
    Job::from_bytes(text.as_bytes(), Path::new("jobs/a.toml"))
}

fn task(text: &str) -> Task {
    let job = read(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    Task::of_cr7(&job, &SamplePath::SixPoint.load().expect("embedded")).expect("in reach")
}

#[test]
fn tables_are_read_in_si_for_the_payload_of_the_job() {
    let job = read(
        "torque.payload_kg = 3.5
        [[tables]]
        joint = 2
        speed_deg_s = [0, 180]
        payload_kg = [0, 7]
        acceleration_deg_s2 = [[360, 180], [90, 45]]
        [[tables]]
        position_deg = [-90, 90]
        jerk_deg_s3 = [1800, 3600]",
    )
    .expect("valid");
    let [one, other] = &job.tables[..] else { panic!("{:?}", job.tables) };
    assert_eq!((one.joint, one.kind), (Some(1), TableKind::AccelerationBySpeed));
    // 2 / (1 / 360 + 1 / 90) = 144.
    let pi = std::f64::consts::PI;
    for (point, expected) in one.table.points().iter().zip([[0.0, 0.8 * pi], [pi, 0.4 * pi]]) {
        assert_relative_eq!(point[0], expected[0], epsilon = 1e-12);
        assert_relative_eq!(point[1], expected[1], epsilon = 1e-12);
    }
    assert_eq!((other.joint, other.kind), (None, TableKind::JerkByPosition));
    assert_relative_eq!(other.table.at(0.0), 15.0 * pi, epsilon = 1e-12);
}

#[test]
fn bad_tables_and_vibrations_name_key_line_value_rule_and_way_out() {
    let cases: [(&str, &[&str]); 22] = [
        ("[[tables]]\njerk_deg_s3 = [1]", &["tables[0]", "speed_deg_s or position_deg"]),
        (
            "[[tables]]\nspeed_deg_s = [1]\nposition_deg = [1]\njerk_deg_s3 = [1]",
            &["tables[0]", "exactly one of the two"],
        ),
        ("[[tables]]\nspeed_deg_s = [1]", &["tables[0]", "exactly one of the three"]),
        ("[[tables]]\nspeed_deg_s = [1]\njerk_deg_s3 = [1]\nacceleration_deg_s2 = [1]", &["exactly one of the three"]),
        ("[[tables]]\nposition_deg = [1]\ntorque_nm = [1]", &["tables[0].torque_nm", "by speed"]),
        ("[[tables]]\nspeed_deg_s = [1]\ntorque_nm = [1]", &["tables[0].torque_nm", "torque.limited = true"]),
        ("[[tables]]\njoint = 0\nspeed_deg_s = [1]\njerk_deg_s3 = [1]", &[":2", "tables[0].joint", "0", "from 1"]),
        ("[[tables]]\nspeed_deg_s = []\njerk_deg_s3 = []", &["tables[0].speed_deg_s", "one row at the least"]),
        ("[[tables]]\nspeed_deg_s = [5, 2]\njerk_deg_s3 = [1, 1]", &[":2", "speed_deg_s[1]", "2", "increase", "sort"]),
        ("[[tables]]\nspeed_deg_s = [-5, 2]\njerk_deg_s3 = [1, 1]", &["speed_deg_s[0]", "-5", "0 or more"]),
        ("[[tables]]\nspeed_deg_s = [5, 7]\njerk_deg_s3 = [1, 0]", &[":3", "jerk_deg_s3[1]", "0", "above 0"]),
        (
            "[[tables]]\nspeed_deg_s = [5, 7]\njerk_deg_s3 = [1]",
            &["jerk_deg_s3", "1 limits for 2 arguments", "same length"],
        ),
        ("[[tables]]\nspeed_deg_s = [5]\njerk_deg_s3 = [[1], [1]]", &["tables[0].payload_kg", "several payloads"]),
        (
            "torque.payload_kg = 8\n[[tables]]\nspeed_deg_s = [5]\npayload_kg = [0, 7]\njerk_deg_s3 = [[1], [1]]",
            &["torque.payload_kg", "8 above 7", "take off load"],
        ),
        (
            "torque.payload_kg = 1\n[[tables]]\nspeed_deg_s = [5]\npayload_kg = [7, 0]\njerk_deg_s3 = [[1], [1]]",
            &["tables[0].payload_kg", "increase", "sort"],
        ),
        (
            "[[tables]]\nspeed_deg_s = [5]\npayload_kg = [0, 7]\njerk_deg_s3 = [[1], [1]]",
            &["tables[0].payload_kg", "payload of the job", "0 for none"],
        ),
        (
            "[[tables]]\nspeed_deg_s = [5]\njerk_deg_s3 = [9]\n[[tables]]\njoint = 2\nspeed_deg_s = [7]\njerk_deg_s3 = [8]",
            &["tables[1]", "tables[0] has too", "one table of a kind", "least limits"],
        ),
        ("[[vibration]]\njoint = 1", &["vibration[0].frequency_hz", "missing"]),
        ("[[vibration]]\nfrequency_hz = 1e-310", &["vibration[0].frequency_hz", "from 0.001 to 10000"]),
        ("[[vibration]]\nfrequency_hz = 5\ndamping = 1", &[":3", "damping", "1", "0.02 for 2 %"]),
        ("[[vibration]]\nfrequency_hz = 5\nresidual_limit_deg = 1", &["residual_limit_deg", "residual_limit_mm"]),
        ("torque.rated_nm = 5", &["torque.rated_nm", "torque.limited = true"]),
    ];
    for (text, parts) in cases {
        let message = read(text).map(|job| panic!("{text} was read as {job:?}")).expect_err("refused").to_string();
        for part in parts.iter().chain(&["jobs/a.toml"]) {
            assert!(message.contains(part), "\"{part}\" is missing in: {message}");
        }
    }
}

#[test]
fn joints_that_the_arm_has_not_are_refused() {
    for text in
        ["[[tables]]\njoint = 7\nspeed_deg_s = [1]\njerk_deg_s3 = [1]", "[[vibration]]\njoint = 7\nfrequency_hz = 5"]
    {
        let job = read(text).expect("valid");
        let error =
            Task::of_cr7(&job, &SamplePath::SixPoint.load().expect("embedded")).map(drop).expect_err("six joints");
        let message = error.to_string();
        assert!(message.contains("joint 7") && message.contains("6 joints"), "{message}");
    }
}

const FAST: &str = "feed = { feed_mm_s = 400, tangential_acceleration_mm_s2 = 20000, tangential_jerk_mm_s3 = 500000,
    normal_acceleration_mm_s2 = 20000 }\n";

/// Each new limit binds, holds, and costs time; the report names it.
#[test]
fn new_limits_bind_in_a_plan_and_in_its_report() {
    let free = task(FAST).plan().expect("it can be followed").trajectory().duration();
    let tool = FAST.replace(" }", ", tool_acceleration_mm_s2 = 1500, tool_jerk_mm_s3 = 30000 }");
    let by_speed = |limits: &str| format!("{FAST}\n[[tables]]\nspeed_deg_s = [5, 60]\n{limits}");
    let cases = [
        (tool, vec![Quantity::ToolAcceleration, Quantity::ToolJerk]),
        (by_speed("acceleration_deg_s2 = [200, 60]"), vec![Quantity::JointAcceleration]),
        (by_speed("jerk_deg_s3 = [4000, 1500]"), vec![Quantity::JointJerk]),
        (
            format!("{FAST}\n[[tables]]\nposition_deg = [-90, 0, 90]\nacceleration_deg_s2 = [100, 200, 100]"),
            vec![Quantity::JointAcceleration],
        ),
    ];
    for (text, quantities) in cases {
        let task = task(&text);
        let motion = task.plan().expect("it can be followed");
        let trajectory = motion.trajectory();
        assert!(trajectory.duration() > 1.02 * free, "{text}: {} and {free} s", trajectory.duration());
        for quantity in quantities {
            let worst = trajectory.verification().worst_of(quantity).expect("looked at");
            // What the lines below a table leave that is not concave in the squared speed.
            assert!((0.85..=1.0 + 1e-6).contains(&worst.ratio), "{text}: {worst:?}");
            let report = motion.report(1, Duration::from_millis(1)).to_string();
            assert!(report.contains(quantity.name()), "{report}");
        }
    }
}

/// Less jerk until the limit holds; the structure shakes more without it.
#[test]
fn jerk_is_lowered_until_a_residual_vibration_is_within_its_limit() {
    let text = |limit: &str| format!("{FAST}\n[[vibration]]\njoint = 1\nfrequency_hz = 6\ndamping = 0.01\n{limit}");
    let free_task = task(&text(""));
    let free = free_task.plan().expect("it can be followed");
    let [before] = free.vibration() else { panic!("{:?}", free.vibration()) };
    assert!(before.holds() && before.residual > 0.0 && before.deflection >= before.residual * 0.5, "{before:?}");
    let limit = 0.5 * before.residual;
    let calm_task = task(&text(&format!("residual_limit_deg = {}", limit.to_degrees())));
    let calm = calm_task.plan().expect("it can be followed");
    let [after] = calm.vibration() else { panic!("{:?}", calm.vibration()) };
    assert!(after.residual <= limit && after.holds(), "{after:?}");
    assert!(calm.trajectory().duration() > free.trajectory().duration());
    assert!(
        calm.warnings().iter().any(|warning| warning.contains("jerk of the joints is 0.")),
        "{:?}",
        calm.warnings()
    );
    let report = calm.report(1, Duration::from_millis(1));
    assert!(report.to_string().contains("vibration  J1 at 6 Hz"), "{report}");
    let json = serde_json::to_string(&report).expect("JSON");
    assert!(json.contains("\"residual_limit\""), "{json}");
    // A limit that no motion keeps.
    let error = task(&text("residual_limit_deg = 1e-300")).plan().map(drop).expect_err("it shakes").to_string();
    assert!(error.contains("J1 at 6 Hz") && error.contains("raise vibration.residual_limit_deg"), "{error}");
}

#[test]
fn the_thermal_load_is_held_against_the_rated_torque() {
    let text = format!("{FAST}\n[torque]\nlimit_nm = 1000\nrated_nm = [80, 80, 80, 1, 20, 20]");
    let job = read(&text).expect("valid");
    let robot = robot_cr7::Robot::load("ur5e", None, None).expect("built in");
    let (limits, _) = robot.limits::<6>(&job.joints).expect("six joints");
    let arm = robot.arm::<6>(job.tool).expect("six joints");
    let drives = robot.drives::<6>(&job).expect("known");
    let file = SamplePath::SixPoint.load().expect("embedded");
    let task = Task::of_six_joints(&job, &file, arm, &limits, drives).expect("in reach");
    let motion = task.plan().expect("it can be followed");
    let report = motion.report(1, Duration::from_millis(1));
    assert_eq!(report.thermal.len(), 6);
    let rms = motion.trajectory().rms_torque().expect("on the path").expect("known");
    for (j, line) in report.thermal.iter().enumerate() {
        assert_eq!((line.joint, line.rms_torque_nm), (j + 1, rms[j]));
        assert_relative_eq!(line.used.expect("rated"), rms[j] / [80.0, 80.0, 80.0, 1.0, 20.0, 20.0][j]);
    }
    let text = report.to_string();
    let line = text.lines().find(|line| line.contains("rms torque")).expect("a line for it");
    // Joint 4 is beyond what it is rated for.
    assert!(line.starts_with('!') && line.ends_with("% of rated"), "{line}");
    assert!(serde_json::to_string(&report).expect("JSON").contains("\"rms_torque_nm\""));
}

#[test]
fn advice_names_the_keys_of_the_new_limits() {
    let text = FAST.replace(" }", ", tool_jerk_mm_s3 = 30000 }")
        + "[[tables]]\nspeed_deg_s = [5, 60]\nacceleration_deg_s2 = [100, 40]";
    let advice = Advice::new(&task(&text), |_| {}).expect("it can be planned");
    let found = |name: &str| advice.costs.iter().find(|limit| limit.name == name).map(|limit| limit.key);
    assert_eq!(found("tool jerk"), Some("feed.tool_jerk_mm_s3"), "{advice}");
    assert_eq!(found("joint acceleration"), Some("joints.acceleration_deg_s2, and [[tables]]"), "{advice}");
    let saved = advice.costs.iter().map(|limit| limit.raised_saves_s.unwrap_or(0.0)).fold(0.0, f64::max);
    assert!(saved > 0.0, "{advice}");
}

/// Where nothing makes a motion calmer, a limit on its vibration is refused and not ignored.
#[test]
#[cfg(feature = "cli")]
fn a_residual_limit_that_nobody_keeps_is_refused() {
    let desk = crate::common::Desk::new("residual");
    let job = |more: &str| format!("{more}\n[[vibration]]\nfrequency_hz = 8\nresidual_limit_mm = 1e-4\n");
    desk.write("job.toml", &job(""));
    desk.write("no_jerk.toml", &job("[plan]\nplanner = \"interpolated-reachability\""));
    desk.write("dwell.ngc", "G21 G90 F3000\nG1 X20\nG4 P0.1\nG1 Y20\n");
    let parts = |why| ["residual_limit_mm", why];
    desk.run(&["plan", "--job", "job.toml", "--stream", "20"]).refused(2, &parts("leave out --stream"));
    desk.run(&["plan", "dwell.ngc", "--job", "job.toml"]).refused(2, &parts("dwells or joint moves"));
    desk.run(&["plan", "--job", "no_jerk.toml"]).refused(2, &parts("jerk-limited"));
}

/// A line of 100 mm on which only the tangential jerk limits: four phases of it take (32 d / j)^(1/3).
#[cfg(feature = "cli")]
#[test]
fn a_line_limited_by_jerk_alone_takes_the_time_of_four_phases() {
    let desk = crate::common::Desk::new("jerk_line");
    desk.write("line.csv", "0,0,0\n100,0,0\n");
    for jerk in [1000.0_f64, 100.0] {
        let job = format!(
            "[path]\nfile = \"line.csv\"\ncsv_unit = \"mm\"\nthrough = \"polyline\"\n[feed]\nfeed_mm_s = 500\ntangential_jerk_mm_s3 = {jerk}\n"
        );
        desk.write("job.toml", &job);
        let report = desk.run(&["plan", "--job", "job.toml", "--json"]).done().json();
        let (duration, ideal) = (report["duration_s"].as_f64().expect("a number"), (32.0 * 100.0 / jerk).cbrt());
        assert!(duration >= ideal * (1.0 - 1e-9) && duration <= ideal * (1.0 + 1e-6), "{duration} against {ideal}");
    }
}
