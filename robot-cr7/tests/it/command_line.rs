//! The `cr7` command as a person runs it: exit codes, what goes to stdout and what to stderr, the files it writes, and
//! what it says about bad input.
#![cfg(feature = "cli")]

use crate::common;

use common::{Desk, Run};
use robot_cr7::{SamplePath, trajectory_columns};
use serde_json::Value;

/// A straight line (mm) as a path file.
fn line(from: [f64; 3], to: [f64; 3]) -> String {
    format!(r#"{{"units": "mm", "degree": 1, "control_points": [{from:?}, {to:?}], "knots": [0, 0, 1, 1]}}"#)
}

/// Base and workpiece frame are the same, so that path files hold coordinates of the base.
const IN_BASE: &str = "[workpiece]\nposition_mm = [0.0, 0.0, 0.0]\n";

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn the_default_plan_writes_report_trajectory_and_pictures() {
    let desk = Desk::new("default_plan");
    let run = desk.run(&["plan"]).done();
    assert_eq!(run.stderr, "");
    assert!(run.stdout.lines().count() <= 40, "one screen: {run:?}");
    for part in ["butterfly", "382.86", "trajectory.csv", "path.svg", "joint jerk", "feed"] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    for picture in
        ["path.svg", "feed.svg", "feed_time.svg", "joint_velocity.svg", "joint_acceleration.svg", "joint_jerk.svg"]
    {
        let text = std::fs::read_to_string(desk.folder.join("out").join(picture)).expect("written");
        assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>"), "{picture}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{picture}");
    }
    assert!(desk.trajectory::<6>("out").len() > 1000);
}

#[test]
fn a_compiled_plan_is_written_and_reported() {
    let desk = Desk::new("compiled");
    desk.write("six.json", SamplePath::SixPoint.json());
    let file = desk.folder.join("out/joint_trajectory.json");
    let run = desk.run(&["plan", "six.json", "--compile-rad", "1e-6"]).done();
    for part in ["compiled", "rad from the plan at most", "certified: position", ", jerk ", "joint_trajectory.json"] {
        assert!(run.stdout.contains(part) || part.ends_with("json"), "{part}: {run:?}");
    }
    let text = std::fs::read_to_string(&file).expect("written");
    let (motion, names) = arcfeed_interp::JointTrajectory::<6>::from_json(&text).expect("a joint trajectory");
    assert!(names.iter().all(|name| !name.is_empty()), "{names:?}");
    for row in desk.trajectory::<6>("out") {
        let at = motion.at(row.t);
        assert!(at.q.iter().zip(row.q).all(|(a, b)| (a - b).abs() <= 1e-6), "t = {}", row.t);
    }
    let report: Value = desk.run(&["plan", "six.json", "--compile-rad", "1e-6", "--json"]).done().json();
    let compiled = &report["compiled"];
    assert_eq!(compiled["pieces"], motion.len());
    assert_eq!(compiled["deviation_bound_rad"].as_f64(), motion.deviation().map(|deviation| deviation.bound));
    let certified = compiled["certified"].as_array().expect("a list");
    assert_eq!(certified.len(), 4);
    assert!(certified.iter().all(|line| line["ratio"].as_f64().is_some_and(|ratio| ratio <= 1.0 + 1e-6)));

    // A file of an earlier run does not stay beside a plan that was not compiled, nor after a refusal.
    desk.run(&["plan", "six.json"]).done();
    assert!(!file.exists());
    desk.run(&["plan", "six.json", "--compile-rad", "1e-6"]).done();
    desk.run(&["plan", "six.json", "--compile-rad", "1e-300"]).refused(1, &["--compile-rad", "joint", "rad at t ="]);
    assert!(!file.exists());
    for bad in ["0", "-1", "NaN", "inf"] {
        desk.run(&["plan", "six.json", &format!("--compile-rad={bad}")]).refused(2, &["--compile-rad", "above 0"]);
    }
}

#[test]
fn a_plan_states_how_much_shorter_any_motion_can_be() {
    let desk = Desk::new("bound");
    desk.write("six.json", SamplePath::SixPoint.json());
    let run = desk.run(&["plan", "six.json", "--bound"]).done();
    assert!(run.stdout.contains("at least") && run.stdout.contains("gap 0."), "{run:?}");
    let report = desk.run(&["plan", "six.json", "--bound", "--json"]).done().json();
    let number = |v: &Value| v.as_f64().expect("a number");
    let (duration, bound) = (number(&report["duration_s"]), number(&report["bound"]["lower_bound_s"]));
    assert!((1.0..1.01).contains(&(duration / bound)), "{report}");
    assert!((number(&report["bound"]["gap"]) - (duration / bound - 1.0)).abs() < 1e-12);
    assert!(desk.run(&["plan", "six.json", "--json"]).done().json().get("bound").is_none());
    desk.run(&["plan", "six.json", "--bound", "--stream", "20"]).refused(2, &["--bound", "--stream"]);
}

#[test]
fn compare_runs_every_planner_on_a_job() {
    let desk = Desk::new("compare");
    desk.write("six.json", SamplePath::SixPoint.json());
    desk.write("job.toml", "[path]\nfile = \"six.json\"\n[tolerance]\nchord_mm = 0.05\n");
    let run = desk.run(&["compare", "job.toml", "--out", "table"]).done();
    assert_eq!(run.stderr, "");
    for part in [
        "published",
        "forward-backward",
        "interpolated-reachability",
        "jerk-limited",
        "continuous-acceleration",
        "compare.svg",
        "bound with jerk at least",
    ] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    let svg = std::fs::read_to_string(desk.folder.join("table/compare.svg")).expect("written");
    assert!(svg.contains("<svg") && !svg.contains("NaN"));
    let json = desk.run(&["compare", "job.toml", "--json", "--robot", "ur5e"]).done().json();
    assert!(
        json["entries"].as_array().expect("a list").len() >= 8 && json["intervals"].as_u64().expect("a count") > 100
    );
    desk.run(&["compare", "nowhere.toml"]).refused(2, &["nowhere.toml", "cannot be read"]);
}

#[test]
fn a_streamed_plan_tells_what_the_look_ahead_costs() {
    let desk = Desk::new("stream");
    desk.write("six.json", SamplePath::SixPoint.json());
    desk.write("job.toml", "[path]\nfile = \"six.json\"\n[tolerance]\nchord_mm = 0.01\n");
    let run = |out: &str, more: &[&str]| {
        let args = [&["plan", "--job", "job.toml", "--json", "--out", out][..], more].concat();
        let report = desk.run(&args).done().json();
        let last = desk.trajectory::<6>(out).last().expect("a sample").t;
        assert!((report["duration_s"].as_f64().expect("a number") - last).abs() < 1e-9, "{report}");
        assert!(desk.folder.join(out).join("stream.svg").exists());
        report
    };
    let number = |v: &Value| v.as_f64().expect("a number");
    let sums = |report: &Value, key: &str, of: fn(f64, f64) -> f64| {
        let pairs = report["stream"][key].as_array().expect("a list");
        pairs.iter().map(|pair| of(number(&pair[0]), number(&pair[1]))).sum::<f64>()
    };
    let all = run("all", &["--stream", "1000"]);
    let ratio = number(&all["duration_s"]) / number(&all["stream"]["whole_duration_s"]);
    assert!((ratio - 1.0).abs() < 1e-9 && sums(&all, "held_back_m", |a, b| b - a) == 0.0, "{all}");
    let few = run("few", &["--stream", "2"]);
    let held = sums(&few, "held_back_m", |a, b| b - a);
    assert!(held > 0.0 && held < number(&few["length_m"]) && sums(&few, "waits_m_s", |_, t| t) == 0.0, "{few}");
    assert!(number(&few["duration_s"]) > 1.05 * number(&all["duration_s"]), "{few}");
    let late = run("late", &["--stream", "2", "--stream-gap-ms", "150"]);
    assert!(sums(&late, "waits_m_s", |_, t| t) > 0.5, "{late}");
    assert!(number(&late["duration_s"]) > number(&few["duration_s"]), "{late}");
    // Nothing of an earlier stream stays.
    desk.run(&["plan", "--job", "job.toml", "--out", "late"]).done();
    assert!(!desk.folder.join("late/stream.svg").exists());
    for wrong in [&["--stream", "0"][..], &["--stream-gap-ms", "5"], &["--stream", "5", "--stream-gap-ms", "nan"]] {
        desk.run(&[&["plan"], wrong].concat()).refused(2, &["--stream"]);
    }
}

#[test]
fn json_is_one_object_and_nothing_else() {
    let desk = Desk::new("json");
    desk.write("six.json", SamplePath::SixPoint.json());
    let run = desk.run(&["plan", "six.json", "--json", "--out", "deep/er"]).done();
    assert_eq!(run.stderr, "");
    let report = run.json();
    assert!((report["length_m"].as_f64().expect("a number") - 0.020_848_799_779).abs() < 1e-12);
    let limits = report["limits"].as_array().expect("a list");
    for name in [
        "joint position",
        "joint velocity",
        "joint acceleration",
        "joint jerk",
        "feed",
        "tangential acceleration",
        "tangential jerk",
        "normal acceleration",
        "chord error",
        "deviation from the path",
    ] {
        let lines: Vec<_> = limits.iter().filter(|l| l["name"] == name).collect();
        assert_eq!(lines.len(), if name.starts_with("joint") { 6 } else { 1 }, "{name}");
    }
    let (length, duration) = (report["length_m"].as_f64(), report["duration_s"].as_f64());
    for l in limits {
        let ratio = l["ratio"].as_f64().expect("a finite ratio");
        assert!((0.0..=1.0 + 1e-6).contains(&ratio), "{l}");
        assert!(l["at_s_m"].as_f64() <= length && l["at_t_s"].as_f64() <= duration, "{l}");
        assert!(
            (l["value"].as_f64().expect("a number").abs() / l["limit"].as_f64().expect("a number") - ratio).abs()
                < 1e-9
        );
    }
    let rows = desk.trajectory::<6>("deep/er");
    assert_eq!(report["samples"].as_u64(), Some(rows.len() as u64));
    for file in report["files"].as_array().expect("a list") {
        assert!(desk.folder.join(file.as_str().expect("a name")).is_file(), "{file}");
    }
}

#[test]
fn the_trajectory_runs_from_rest_to_rest_without_a_jump() {
    let desk = Desk::new("trajectory");
    desk.write("line.json", &line([400.0, -30.0, 200.0], [430.0, 30.0, 240.0]));
    desk.write("job.toml", &format!("{IN_BASE}[sampling]\nperiod_ms = 2.0\n"));
    let report = desk.run(&["plan", "line.json", "--job", "job.toml", "--json"]).done().json();
    let text = std::fs::read_to_string(desk.folder.join("out/trajectory.csv")).expect("written");
    let names: Vec<String> = (1..=6).map(|k| format!("joint{k}")).collect();
    assert_eq!(text.lines().next(), Some(trajectory_columns(&names).join(",").as_str()));
    let rows = desk.trajectory::<6>("out");
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    assert_eq!(first.t, 0.0);
    // The JSON parser may be off by the last digit.
    let duration = report["duration_s"].as_f64().expect("a number");
    assert!((last.t - duration).abs() <= 2.0 * f64::EPSILON * duration, "{} and {duration}", last.t);
    for (row, place) in [(first, [0.400, -0.030, 0.200]), (last, [0.430, 0.030, 0.240])] {
        assert_eq!((row.qd, row.qdd), ([0.0; 6], [0.0; 6]));
        for (at, wanted) in row.position.iter().zip(place) {
            assert!((at - wanted).abs() < 1e-12, "{:?}", row.position);
        }
    }
    for (i, pair) in rows.windows(2).enumerate() {
        let dt = pair[1].t - pair[0].t;
        if i + 2 < rows.len() {
            assert!((pair[1].t - (i + 1) as f64 * 2e-3).abs() < 1e-12, "{} at row {}", pair[1].t, i + 1);
        } else {
            assert!(dt > 0.0 && dt <= 2e-3 * (1.0 + 1e-9));
        }
        for k in 0..6 {
            // Position against velocity, velocity against acceleration, with what the assumed jerk of 100 rad/s^3 allows.
            let q = pair[1].q[k] - pair[0].q[k] - 0.5 * dt * (pair[0].qd[k] + pair[1].qd[k]);
            let v = pair[1].qd[k] - pair[0].qd[k] - 0.5 * dt * (pair[0].qdd[k] + pair[1].qdd[k]);
            assert!(q.abs() <= 100.0 * dt.powi(3) / 12.0 + 1e-12, "joint {} jumps by {q} at row {i}", k + 1);
            assert!(v.abs() <= 100.0 * dt.powi(2) / 4.0 + 1e-11, "joint {} velocity jumps by {v} at row {i}", k + 1);
        }
        // The tool points down all the way: half a turn about x.
        assert!((pair[0].quaternion[0].abs() - 1.0).abs() < 1e-12, "{:?}", pair[0].quaternion);
    }
}

#[test]
fn points_of_a_csv_file_are_passed_within_the_tolerance() {
    let desk = Desk::new("csv");
    let points: Vec<[f64; 2]> =
        (0..40).map(|i| f64::from(i) / 39.0).map(|f| [80.0 * f, 15.0 * (6.0 * f).sin()]).collect();
    let text: String = points.iter().map(|p| format!("{},{}\n", p[0], p[1])).collect();
    desk.write("points.csv", &format!("x_mm,y_mm\n{text}"));
    for (tolerance, feed) in [(0.01, 50.0), (0.2, 200.0)] {
        desk.write(
            "job.toml",
            &format!("[path]\nfile = \"points.csv\"\nfit_tolerance_mm = {tolerance}\n[feed]\nfeed_mm_s = {feed}\n[tolerance]\nchord_mm = 0.005\n"),
        );
        desk.run(&["plan", "--job", "job.toml", "--json"]).done();
        let rows = desk.trajectory::<6>("out");
        let mut worst = 0.0f64;
        for p in &points {
            // The default workpiece frame lies at (400, -50, 200) mm.
            let p = [(p[0] + 400.0) * 1e-3, (p[1] - 50.0) * 1e-3, 0.2];
            let off = rows.windows(2).map(|r| distance(p, r[0].position, r[1].position)).fold(f64::INFINITY, f64::min);
            worst = worst.max(off);
        }
        // The fit's tolerance, and the chord between two rows.
        assert!(worst <= (tolerance + 0.005) * 1e-3, "{worst} m off with a tolerance of {tolerance} mm");
    }
    // The same points without a unit, and with one on the command line.
    desk.write("bare.csv", &text);
    desk.run(&["plan", "bare.csv"]).refused(2, &["bare.csv", "unit", "mm"]);
    desk.run(&["plan", "bare.csv", "--unit", "furlong"]).refused(2, &["furlong", "mm, cm, m or in"]);
    desk.run(&["inspect", "bare.csv", "--unit", "mm", "--fit-mm", "0.05"]).done();
}

fn distance(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
    let r: [f64; 3] = std::array::from_fn(|i| p[i] - a[i]);
    let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    let f = if dot(d, d) > 0.0 { (dot(r, d) / dot(d, d)).clamp(0.0, 1.0) } else { 0.0 };
    let off = std::array::from_fn(|i| r[i] - f * d[i]);
    dot(off, off).sqrt()
}

#[test]
fn inspect_tells_length_curvature_and_segments() {
    let desk = Desk::new("inspect");
    desk.write("seven.json", SamplePath::SevenPoint.json());
    let run = desk.run(&["inspect", "seven.json", "--tolerance-mm", "0.1"]).done();
    for part in ["length", "curvature", "convex hull", "inspect.svg"] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    assert!(desk.folder.join("out/inspect.svg").is_file());
    for bad in ["0", "-1", "NaN"] {
        let run = desk.run(&["inspect", "seven.json", &format!("--tolerance-mm={bad}")]);
        assert_eq!(run.code, 2, "{run:?}");
        assert!(run.stderr.contains("tolerance"), "{run:?}");
        let run = desk.run(&["inspect", "seven.json", &format!("--fit-mm={bad}")]);
        assert!(run.code == 0 || run.code == 2, "{run:?}");
    }
}

#[test]
fn forward_of_inverse_gives_the_pose_back() {
    let desk = Desk::new("pose");
    let run = desk.run(&["ik", "--xyz-mm", "420", "-130", "310", "--rpy-deg", "170", "10", "-35", "--json"]).done();
    let solutions = run.json()["solutions_rad"].as_array().expect("a list").clone();
    assert!(solutions.len() >= 2, "{run:?}");
    let mut quaternions: Vec<Vec<f64>> = Vec::new();
    for solution in &solutions {
        let q: Vec<String> = numbers(solution).iter().map(f64::to_string).collect();
        let mut args = vec!["fk", "--rad"];
        args.extend(q.iter().map(String::as_str));
        args.push("--json");
        let pose = desk.run(&args).done().json();
        for (at, wanted) in numbers(&pose["position_m"]).iter().zip([0.42, -0.13, 0.31]) {
            assert!((at - wanted).abs() < 1e-12, "{pose}");
        }
        quaternions.push(numbers(&pose["quaternion_xyzw"]));
    }
    for q in &quaternions {
        let dot: f64 = q.iter().zip(&quaternions[0]).map(|(a, b)| a * b).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-12, "{quaternions:?}");
    }
    // The quaternion leads to the same solutions, and the nearest one to a solution is that solution.
    let text: Vec<String> = quaternions[0].iter().map(f64::to_string).collect();
    let near: Vec<String> = numbers(&solutions[1]).iter().map(|q| q.to_degrees().to_string()).collect();
    let mut args = vec!["ik", "--xyz-mm", "420", "-130", "310", "--quat-xyzw"];
    args.extend(text.iter().map(String::as_str));
    args.push("--near-deg");
    args.extend(near.iter().map(String::as_str));
    args.push("--json");
    let again = desk.run(&args).done().json();
    for (a, b) in numbers(&again["nearest_rad"]).iter().zip(numbers(&solutions[1])) {
        assert!((a - b).abs() < 1e-9, "{again}");
    }
    // For people: degrees.
    let run = desk.run(&["fk", "--deg", "0", "-30", "90", "30", "-90", "0"]).done();
    assert!(run.stdout.contains("position") && run.stdout.contains("mm"), "{run:?}");
    desk.run(&["fk", "--deg", "400", "0", "0", "0", "0", "0"]).done();

    desk.run(&["ik", "--xyz-mm", "4200", "0", "300", "--rpy-deg", "180", "0", "0"])
        .refused(1, &["out of reach", "too far by"]);
    desk.run(&["ik", "--xyz-mm", "NaN", "0", "300", "--rpy-deg", "180", "0", "0"]).refused(2, &["NaN", "--xyz-mm"]);
    desk.run(&["ik", "--xyz-mm", "400", "0", "300", "--quat-xyzw", "0", "0", "0", "0"]).refused(2, &["--quat-xyzw"]);
    desk.run(&["ik", "--rpy-deg", "180", "0", "0"]).refused(2, &["--xyz-mm"]);
    desk.run(&["fk", "--rad", "inf", "0", "0", "0", "0", "0"]).refused(2, &["inf"]);
    desk.run(&["fk", "--deg", "1", "2", "3"]).refused(2, &["3 values", "6 joints"]);
    desk.run(&["fk"]).refused(2, &["--deg"]);
}

#[test]
fn bad_usage_ends_with_two_and_shows_the_way() {
    let desk = Desk::new("usage");
    for args in [&["plan", "--frobnicate"][..], &["fly"], &["plan", "a.json", "b.json"], &["plan", "--job"]] {
        desk.run(args).refused(2, &["--help"]);
    }
    let run = desk.run(&[]);
    assert!(run.code == 2 && run.stderr.contains("cr7 plan"), "{run:?}");
    for args in [&["--help"][..], &["plan", "--help"], &["inspect", "--help"], &["ik", "--help"], &["fk", "--help"]] {
        let run = desk.run(args).done();
        assert!(run.stdout.contains("Examples:") && run.stdout.contains("cr7"), "{run:?}");
    }
    assert!(desk.run(&["--version"]).done().stdout.starts_with("cr7 "));
}

#[test]
fn bad_path_files_are_refused_by_name_place_value_and_rule() {
    let desk = Desk::new("bad_paths");
    let curve = |points: &str, weights: &str, knots: &str| {
        format!(
            "{{\"units\": \"mm\", \"degree\": 2,\n\"control_points\": {points},\n\"weights\": {weights},\n\"knots\": {knots}}}"
        )
    };
    let good = "[[0, 0], [40, 60], [80, 0]]";
    let cases: [(&str, String, &[&str]); 13] = [
        ("empty.json", String::new(), &["empty"]),
        ("blank.csv", " \n\n".to_owned(), &["empty"]),
        ("word.json", "butterfly".to_owned(), &["word.json:1"]),
        ("nan.json", curve("[[0, 0], [40, NaN], [80, 0]]", "[1, 1, 1]", "[0, 0, 0, 1, 1, 1]"), &["nan.json:2"]),
        ("weight.json", curve(good, "[1, -2, 1]", "[0, 0, 0, 1, 1, 1]"), &["weights[1]", "-2"]),
        ("zero.json", curve(good, "[1, 0, 1]", "[0, 0, 0, 1, 1, 1]"), &["weights[1]", "0"]),
        ("knots.json", curve(good, "[1, 1, 1]", "[0, 0, 0.5, 0.2, 1, 1]"), &["knots[3]", "0.2", "0.5"]),
        (
            "few.json",
            curve("[[0, 0], [40, 60]]", "[1, 1]", "[0, 0, 0, 1, 1, 1]"),
            &["control_points", "2 points for degree 2", "add"],
        ),
        ("count.json", curve(good, "[1, 1]", "[0, 0, 0, 1, 1, 1]"), &["weights", "2", "3"]),
        ("key.json", "{\"units\": \"mm\", \"grade\": 2}".to_owned(), &["grade", "key.json:1"]),
        ("nan.csv", "x_mm,y_mm\n0,0\n1,nan\n2,0\n".to_owned(), &["nan.csv:3", "column 2", "nan"]),
        ("twice.csv", "x_mm,y_mm\n0,0\n1,1\n1,1\n2,0\n".to_owned(), &["twice.csv:4", "line 3", "remove"]),
        ("one.csv", "x_mm,y_mm\n0,0\n".to_owned(), &["1 points", "at least 2"]),
    ];
    for (name, text, parts) in cases {
        desk.write(name, &text);
        for command in ["plan", "inspect"] {
            let run = desk.run(&[command, name]).refused(2, &[name]);
            for part in parts {
                assert!(run.stderr.contains(part), "\"{part}\" is missing: {run:?}");
            }
        }
    }
    desk.run(&["plan", "nowhere.json"]).refused(2, &["nowhere.json", "check the name"]);
    desk.run(&["plan", "."]).refused(2, &["extension"]);
    desk.write("part.step", "x");
    desk.run(&["plan", "part.step"]).refused(2, &["part.step", "step", ".json", ".csv"]);
}

#[test]
fn bad_jobs_are_refused_by_line_key_value_and_rule() {
    let desk = Desk::new("bad_jobs");
    let cases: [(&str, &[&str]); 10] = [
        ("[feed]\nfeed_mm_s = 0\n", &["job.toml:2", "feed.feed_mm_s", "above 0"]),
        ("[feed]\ntangential_jerk_mm_s3 = -5\n", &["job.toml:2", "feed.tangential_jerk_mm_s3", "-5", "above 0"]),
        ("[feed]\nnormal_acceleration_mm_s2 = nan\n", &["job.toml:2", "normal_acceleration_mm_s2", "NaN"]),
        ("[sampling]\n\nperiod_ms = 0\n", &["job.toml:3", "sampling.period_ms", "above 0"]),
        ("[sampling]\nperiod_ms = 0.000001\n", &["job.toml:2", "sampling.period_ms", "0.01 and 1000 ms"]),
        ("[joints]\nvelocity_deg_s = [1, 2, 0, 4, 5, 6]\n", &["job.toml:2", "joints.velocity_deg_s[2]", "above 0"]),
        ("[tolerance]\nchord_mm = -0.1\n", &["job.toml:2", "tolerance.chord_mm", "-0.1"]),
        ("[feed]\nfeed = 100\n", &["job.toml:2", "feed", "unknown field"]),
        ("feed_mm_s = \"fast\"\n", &["job.toml:1"]),
        ("", &["empty"]),
    ];
    for (text, parts) in cases {
        desk.write("job.toml", text);
        desk.run(&["plan", "--job", "job.toml"]).refused(2, parts).refused(2, &["job.toml"]);
    }
    desk.write("job.toml", "[joints]\njerk_deg_s3 = [1, 2, 3]\n");
    desk.run(&["plan", "--job", "job.toml"]).refused(2, &["joints.jerk_deg_s3", "lists 3 numbers", "6 joints"]);
    desk.run(&["plan", "--job", "none.toml"]).refused(2, &["none.toml", "check the name"]);
    desk.write("job.toml", "[path]\nfile = \"gone.json\"\n");
    desk.run(&["plan", "--job", "job.toml"]).refused(2, &["gone.json"]);
}

#[test]
fn metres_in_place_of_millimetres_are_noticed() {
    let desk = Desk::new("units");
    desk.write("big.json", &SamplePath::Butterfly.json().replace("\"mm\"", "\"m\""));
    // By how much it is out of reach, where, and the likely reason.
    desk.run(&["plan", "big.json", "--out", "o"])
        .refused(1, &["big.json", "s = 0", "x 54.89", "too far by 74.8", "units"]);
    assert!(!desk.folder.join("o/trajectory.csv").exists());
}

#[test]
fn places_where_the_arm_cannot_follow_are_named() {
    let desk = Desk::new("places");
    desk.write("base.toml", IN_BASE);
    desk.write("side.toml", &format!("{IN_BASE}[orientation]\nrpy_deg = [90.0, 0.0, 0.0]\n"));
    let plan = |file: &str, job: &str| desk.run(&["plan", file, "--job", job]);
    let place = |run: &Run| -> f64 {
        let after = run.stderr.split("s = ").nth(1).unwrap_or_else(|| panic!("no place: {run:?}"));
        after.split(' ').next().and_then(|s| s.parse().ok()).unwrap_or_else(|| panic!("no place: {run:?}"))
    };

    // The tool lies level along y; its last two axes line up where the wrist is beside the first axis by the arm's
    // offset of 141 mm, so at y = -141 - 105 mm.
    desk.write("wrist.json", &line([400.0, -300.0, 300.0], [400.0, 100.0, 300.0]));
    // The joints pass that smoothly.
    plan("wrist.json", "side.toml").done();

    // The wrist passes the first axis at just the arm's offset.
    desk.write("shoulder.json", &line([300.0, 141.0, 200.0], [-300.0, 141.0, 200.0]));
    plan("shoulder.json", "base.toml").done();

    // Nearer than that nothing reaches: the reach ends at x = sqrt(141^2 - 100^2) mm. The walk steps by 1/64 of the path.
    desk.write("inside.json", &line([300.0, 100.0, 200.0], [-300.0, 100.0, 200.0]));
    let run = plan("inside.json", "base.toml").refused(1, &["out of reach, too near by", "y 0.1000", "away from"]);
    assert!((place(&run) - (0.3 - (0.141f64.powi(2) - 0.1f64.powi(2)).sqrt())).abs() < 0.6 / 64.0, "{run:?}");

    // Out of the far end of the reach.
    desk.write("far.json", &line([400.0, 0.0, 200.0], [1200.0, 0.0, 200.0]));
    plan("far.json", "base.toml").refused(1, &["out of reach, too far by", "towards"]);
}

/// A circle of radius 400 mm about the base, twice.
fn two_turns() -> String {
    let corners = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
    let (mut points, mut weights, mut knots) = (Vec::new(), Vec::new(), vec![0, 0, 0]);
    for i in 0..17usize {
        let [x, y] = corners[i % 8];
        points.push([400 * x, 400 * y, 200]);
        weights.push(if i % 2 == 0 { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 });
        if i % 2 == 0 && i > 0 && i < 16 {
            knots.extend([i / 2, i / 2]);
        }
    }
    knots.extend([8, 8, 8]);
    format!(
        r#"{{"units": "mm", "degree": 2, "control_points": {points:?}, "weights": {weights:?}, "knots": {knots:?}}}"#
    )
}

#[test]
fn a_path_that_uses_up_a_joint_range_names_the_joint_and_its_limit() {
    let desk = Desk::new("range");
    desk.write("base.toml", IN_BASE);
    desk.write("turns.json", &two_turns());
    // Joints 1 and 6 would have to turn by 4 pi; their range is +-6.27 rad.
    desk.run(&["plan", "turns.json", "--job", "base.toml"])
        .refused(1, &["turns.json", "s = ", "joint ", "outside its range", "6.27"]);
}

#[test]
fn an_unwritable_place_is_named() {
    let desk = Desk::new("unwritable");
    desk.write("file", "in the way");
    desk.write("line.json", &line([0.0, 0.0, 0.0], [5.0, 0.0, 0.0]));
    desk.run(&["plan", "line.json", "--out", "file/sub"]).refused(2, &["file/sub", "cannot be written"]);
    desk.run(&["plan", "line.json", "--out", "file"]).refused(2, &["file", "cannot be written"]);
    // A folder where a file should be.
    std::fs::create_dir_all(desk.folder.join("taken/trajectory.csv")).expect("a writable target folder");
    desk.run(&["plan", "line.json", "--out", "taken"]).refused(2, &["trajectory.csv", "cannot be written"]);
    let run = desk.run(&["inspect", "line.json", "--out", "file"]);
    assert!(run.code == 2 && run.stderr.contains("cannot be written"), "{run:?}");
}

#[test]
fn the_configuration_at_the_start_can_be_asked_for() {
    let desk = Desk::new("start_near");
    let first = |job: &str| {
        desk.write("job.toml", job);
        desk.run(&["plan", "--job", "job.toml"]).done();
        desk.trajectory::<6>("out")[0].q
    };
    let best = first("[path]\n");
    // Another one: the wrist turned over.
    let near = [best[0], best[1], best[2], best[3] + std::f64::consts::PI, -best[4], best[5] - std::f64::consts::PI];
    let list: Vec<String> = near.iter().map(|q| format!("{:.3}", q.to_degrees())).collect();
    let other = first(&format!("[start]\nnear_deg = [{}]\n", list.join(", ")));
    assert!((other[4] + best[4]).abs() < 1.0 && other[4] * best[4] < 0.0, "{other:?}, not {best:?}");
    for (text, parts) in
        [("near_deg = [1, 2]", ["start.near_deg", "6"]), ("near_deg = 1e9", ["start.near_deg", "hundred turns"])]
    {
        desk.write("job.toml", &format!("[start]\n{text}\n"));
        desk.run(&["plan", "--job", "job.toml"]).refused(2, &parts);
    }
    desk.write("job.toml", "[start]\nnear_deg = 0\n");
    desk.run(&["plan", "--job", "job.toml", "--robot", "panda"]).refused(2, &["start.near_deg", "six joints"]);
}

#[test]
fn shells_and_manuals_know_every_command() {
    let desk = Desk::new("shell");
    let help = desk.run(&["--help"]).done().stdout;
    let (_, list) = help.split_once("Commands:").expect("a list");
    let names = list.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    let names: Vec<&str> = names.take_while(|name| !name.starts_with('-')).filter(|name| *name != "help").collect();
    assert!(names.len() > 15 && names.contains(&"verify"), "{names:?}");
    let man = desk.run(&["man"]).done().stdout;
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = desk.run(&["completions", shell]).done().stdout;
        for name in &names {
            assert!(script.contains(name), "{shell}: {name}");
        }
    }
    for name in &names {
        assert!(man.contains(&format!(".SH \"cr7 {name}\"")), "{name}");
    }
    desk.run(&["completions", "nosuch"]).refused(2, &["nosuch", "bash"]);
}
