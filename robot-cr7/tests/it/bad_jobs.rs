//! Job files: what they mean, and that every kind of bad one gets a message with file, line, key, value and way out.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

use approx::assert_relative_eq;
use arcfeed_interp::{Extent, Method};
use nalgebra::{UnitQuaternion, Vector3, point};
use proptest::prelude::*;
use robot_cr7::{Job, LengthUnit, ToolOrientation};

fn read(text: &str) -> Result<Job, robot_cr7::InputError> {
    Job::from_bytes(text.as_bytes(), Path::new("jobs/a.toml"))
}

fn says(text: &str, parts: &[&str]) {
    let m = match read(text) {
        Ok(job) => panic!("{text} was read as {job:?}"),
        Err(e) => e.to_string(),
    };
    assert!(m.contains("jobs/a.toml"), "the file is missing in: {m}");
    for part in parts {
        assert!(m.contains(part), "\"{part}\" is missing in: {m}");
    }
}

#[test]
fn the_example_shows_the_defaults() {
    let example = Job::from_bytes(Job::EXAMPLE.as_bytes(), Path::new("jobs/butterfly.toml")).expect("valid");
    assert_eq!(example.path_file.as_deref(), Some(Path::new("jobs/../data/butterfly.json")));
    assert_eq!(Job { path_file: None, ..example }, Job::default());
    assert_eq!(read("[plan]").expect("valid"), Job::default());
}

#[test]
fn the_example_shows_every_key() {
    // With its commented keys switched on, the example is still a valid job; the keys of the other orientation modes
    // go with their mode, and of the two ways to name a start one is taken.
    let all: String = Job::EXAMPLE
        .lines()
        .filter(|l| !["# from_rpy", "# to_rpy", "# axis", "# near_deg"].iter().any(|key| l.starts_with(key)))
        .map(|l| match l.strip_prefix("# ") {
            _ if l.starts_with("planner") => "planner = \"per-segment\"\n".to_owned(),
            Some(key) if key.split(' ').nth(1) == Some("=") => format!("{key}\n"),
            _ => format!("{l}\n"),
        })
        .collect();
    let job = read(&all).expect("valid");
    assert_eq!(job.csv_unit, Some(LengthUnit::Millimetre));
    assert_relative_eq!(job.feed.normal_jerk.expect("given"), 50.0);
    assert_relative_eq!(job.joints.velocity.expect("given").of::<6>().expect("six")[5], PI);
    assert_relative_eq!(job.joints.acceleration.expect("given").of::<6>().expect("any number")[3], 5.0 * PI);
    assert_relative_eq!(
        job.joints.jerk.expect("given").of::<7>().expect("any number")[0],
        10_000.0 * PI / 180.0,
        max_relative = 1e-15
    );
    assert_eq!(job.method, Method::PerSegment { window: Some(100) });
    assert_relative_eq!(job.feed.angular_speed.expect("given"), FRAC_PI_2);
    assert_relative_eq!(job.feed.tool_acceleration.expect("given"), 1.2);
    assert_relative_eq!(job.feed.tool_jerk.expect("given"), 40.0);
    let torque = job.torque.expect("limited");
    assert_relative_eq!(torque.limit.expect("given").of::<6>().expect("six")[3], 28.0);
    assert_relative_eq!(torque.rated.expect("given").of::<6>().expect("six")[0], 60.0);
    let payload = torque.payload.expect("given");
    assert!(payload.mass == 2.0 && payload.centre == Vector3::new(0.0, 0.0, 0.06));
    assert_eq!(job.start_posture.map(|posture| posture.to_string()).as_deref(), Some("front up no-flip"));
    for key in ["from_rpy_deg", "to_rpy_deg", "axis", "near_deg"] {
        assert!(Job::EXAMPLE.contains(&format!("# {key} = [")), "{key}");
    }
}

#[test]
fn values_are_converted_to_si() {
    let job = read(
        r#"
        path = { file = "sub/p.csv", csv_unit = "in", fit_tolerance_mm = 0.02, layers = ["cut"], lift_mm = 12.5 }
        sampling.period_ms = 4
        [workpiece]
        position_mm = [500, -20, 30.5]
        rotation_rpy_deg = [0, 0, 90]
        [tool]
        position_mm = [0, 0, 120]
        [feed]
        feed_mm_s = 250
        tangential_acceleration_mm_s2 = 2500
        tangential_jerk_mm_s3 = 3e4
        normal_acceleration_mm_s2 = 1500.0
        [tolerance]
        chord_mm = 0.005
        [plan]
        planner = "per-segment"
        lookahead = 7
        "#,
    )
    .expect("valid");
    assert_eq!(job.path_file, Some(PathBuf::from("jobs/sub/p.csv")));
    assert_eq!(job.csv_unit, Some(LengthUnit::Inch));
    assert_eq!((job.layers, job.lift), (vec!["cut".to_owned()], 0.0125));
    assert_relative_eq!(job.fit_tolerance, 2e-5);
    assert_relative_eq!(job.period, 4e-3);
    // The workpiece is turned by a quarter about z: its x axis is the base's y axis.
    assert_relative_eq!(job.workpiece * point![0.1, 0.0, 0.0], point![0.5, 0.08, 0.0305], epsilon = 1e-15);
    assert_relative_eq!(job.tool.translation.vector, Vector3::new(0.0, 0.0, 0.12));
    let feed = job.feed;
    assert_relative_eq!(feed.feed, 0.25);
    assert_relative_eq!(feed.tangential_acceleration, 2.5);
    assert_relative_eq!(feed.tangential_jerk, 30.0);
    assert_relative_eq!(feed.normal_acceleration, 1.5);
    assert_relative_eq!(job.chord_tolerance, 5e-6);
    assert_eq!(job.method, Method::PerSegment { window: Some(7) });
    assert!(job.warnings.is_empty(), "{:?}", job.warnings);
}

#[test]
fn roll_pitch_yaw_turn_about_fixed_axes() {
    // R = Rz(90) Ry(0) Rx(180): tool x along base y, tool z down.
    let job = read("orientation.rpy_deg = [180, 0, 90]").expect("valid");
    let ToolOrientation::Constant(r) = job.orientation else { panic!("constant") };
    assert_relative_eq!(r * Vector3::x(), Vector3::y(), epsilon = 1e-15);
    assert_relative_eq!(r * Vector3::z(), -Vector3::z(), epsilon = 1e-15);
    let by_axes = |r: f64, p: f64, y: f64| {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), y)
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), p)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), r)
    };
    let text = "[orientation]\nmode = \"slerp\"\nfrom_rpy_deg = [10, 20, 30]\nto_rpy_deg = [90, -45, 200]";
    let ToolOrientation::Slerp { from, to } = read(text).expect("valid").orientation else { panic!("slerp") };
    let [a, b, c] = [10f64, 20.0, 30.0].map(f64::to_radians);
    assert!(from.angle_to(&by_axes(a, b, c)) < 1e-7);
    assert!(to.angle_to(&by_axes(FRAC_PI_2, -PI / 4.0, 200f64.to_radians())) < 1e-7);
    let text = "[orientation]\nmode = \"tangent\"\naxis = [0, 3e200, -3e200]";
    let ToolOrientation::Tangent { axis } = read(text).expect("valid").orientation else { panic!("tangent") };
    assert_relative_eq!(axis.into_inner(), Vector3::new(0.0, 0.5f64.sqrt(), -(0.5f64.sqrt())), epsilon = 1e-15);
}

#[test]
fn limits_of_zero_or_below() {
    for key in [
        "feed.feed_mm_s",
        "feed.tangential_acceleration_mm_s2",
        "feed.tangential_jerk_mm_s3",
        "feed.normal_acceleration_mm_s2",
        "feed.normal_jerk_mm_s3",
        "feed.angular_speed_deg_s",
        "torque.limit_nm",
        "joints.velocity_deg_s",
        "joints.acceleration_deg_s2",
        "joints.jerk_deg_s3",
        "tolerance.chord_mm",
        "path.fit_tolerance_mm",
        "sampling.period_ms",
    ] {
        for value in ["0", "-3.5", "nan", "inf", "-0.0", "5e-324"] {
            let shown = match value {
                "nan" => "NaN",
                "-0.0" => "-0",
                "5e-324" => "0.00000",
                other => other,
            };
            let text = format!("# first line\n{key} = {value}");
            says(&text, &["a.toml:2", key, &format!("is {shown}"), "above 0", "raise it", "default"]);
        }
    }
    says("[joints]\nvelocity_deg_s = [90, 90, 0, 90, 90, 90]", &[":2", "velocity_deg_s[2]", "is 0", "above 0"]);
}

#[test]
fn periods_that_cannot_be_meant() {
    says(
        "[sampling]\n\nperiod_ms = 0.001",
        &["a.toml:3", "sampling.period_ms", "0.001", "between 0.01 and 1000", "1.0"],
    );
    says("[sampling]\nperiod_ms = 5000", &["a.toml:2", "5000", "did you mean"]);
}

#[test]
fn positions_that_cannot_be_meant() {
    says("[workpiece]\nposition_mm = [1e6, 0, 0]", &["a.toml:2", "workpiece.position_mm[0]", "1000000", "millimetres"]);
    says("[tool]\nposition_mm = [0, nan, 0]", &["a.toml:2", "tool.position_mm[1]", "NaN", "finite"]);
    says("[tool]\nrotation_rpy_deg = [0, 0, inf]", &["a.toml:2", "tool.rotation_rpy_deg[2]", "inf", "finite"]);
    says("[tool]\nrotation_rpy_deg = [0, 1e9, 0]", &["tool.rotation_rpy_deg[1]", "1000000000", "180 degrees"]);
}

#[test]
fn likely_slips_of_the_unit_are_warned_of() {
    for (text, parts) in [
        ("[workpiece]\nposition_mm = [0.4, -0.05, 0.2]", ["a.toml:2", "workpiece.position_mm", "did you mean metres?"]),
        ("[workpiece]\nposition_mm = [40000, 0, 0]", ["a.toml:2", "40000", "check the unit"]),
        ("[feed]\nfeed_mm_s = 0.1", ["a.toml:2", "feed.feed_mm_s = 0.1", "did you mean m/s?"]),
        ("[tolerance]\nchord_mm = 50", ["a.toml:2", "tolerance.chord_mm = 50", "um"]),
    ] {
        let warnings = read(text).expect("valid").warnings;
        assert_eq!(warnings.len(), 1, "{text}: {warnings:?}");
        assert!(parts.iter().all(|p| warnings[0].contains(p)), "{parts:?} in {}", warnings[0]);
    }
}

#[test]
fn unknown_keys_and_sections() {
    says("[feed]\nfeed = 100", &["a.toml:2:1", "unknown field `feed`", "`feed_mm_s`", "remove the key"]);
    says("[fed]\n", &["a.toml:1:", "unknown field `fed`", "`feed`"]);
    says("[feed]\nfeed_mm_s = 1\nfeed_mm_s = 2", &["a.toml:3:1", "duplicate key"]);
    for section in ["path", "workpiece", "tool", "orientation", "joints", "tolerance", "sampling", "plan"] {
        says(&format!("[{section}]\n\nsurprise = 1"), &["a.toml:3:1", "unknown field `surprise`", "remove the key"]);
    }
}

#[test]
fn values_of_the_wrong_kind() {
    says("[feed]\nfeed_mm_s = \"fast\"", &["a.toml:2:13", "\"fast\"", "butterfly.toml"]);
    says("[tool]\nposition_mm = [1, 2]", &["a.toml:2:15", "length 2", "length 3"]);
    says("[joints]\njerk_deg_s3 = \"much\"", &["a.toml:2:15", "\"much\"", "one number for all joints"]);
    says("[plan]\nplanner = \"best\"", &["a.toml:2", "plan.planner", "best", "continuous-acceleration", "choose one"]);
    says("[plan]\nlookahead = 7", &["a.toml:2", "plan.lookahead", "per-segment"]);
    says("[orientation]\nmode = \"free\"", &["a.toml:2:8", "`free`", "`constant`", "`slerp`", "`tangent`"]);
    says("[path]\ncsv_unit = \"mile\"", &["path.csv_unit", "line 2", "\"mile\"", "\"mm\""]);
    says("[plan]\nlookahead = 0", &["a.toml:2", "plan.lookahead", "is 0", "from 1 on", "raise it"]);
    says("[plan]\nlookahead = -4", &["a.toml:2", "plan.lookahead", "is -4"]);
}

#[test]
fn orientations() {
    says(
        "[orientation]\nmode = \"slerp\"\nfrom_rpy_deg = [0, 0, 0]",
        &["orientation.to_rpy_deg", "missing", "add the key"],
    );
    says(
        "[orientation]\nmode = \"slerp\"\nrpy_deg = [0, 0, 0]",
        &["a.toml:3", "orientation.rpy_deg", "change the mode"],
    );
    says("[orientation]\naxis = [0, 0, 1]", &["a.toml:2", "orientation.axis", "\"constant\" knows rpy_deg only"]);
    says(
        "[orientation]\nmode = \"tangent\"\naxis = [0, 0, 0]",
        &["a.toml:3", "orientation.axis", "direction", "[0, 0, -1]"],
    );
    says("[orientation]\nrpy_deg = [0, nan, 0]", &["a.toml:2", "orientation.rpy_deg[1]", "NaN"]);
}

#[test]
fn files_that_are_no_jobs() {
    says("", &["empty", "butterfly.toml"]);
    says("[feed\nfeed_mm_s = 1", &["a.toml:1:", "butterfly.toml"]);
    says("{\"feed\": 1}", &["a.toml:1:1", "butterfly.toml"]);
    let m = Job::from_bytes(b"[feed]\n\xff", Path::new("a.toml")).expect_err("not UTF-8").to_string();
    assert!(m.contains("a.toml:2") && m.contains("UTF-8"), "{m}");
    let m = Job::read(Path::new("no/such.toml")).expect_err("no such file").to_string();
    assert!(m.contains("no/such.toml") && m.contains("check the name"), "{m}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        if let Err(e) = Job::from_bytes(&bytes, Path::new("a.toml")) {
            prop_assert!(e.to_string().contains("a.toml"));
        }
    }

    #[test]
    fn mutated_jobs_never_panic_and_never_pass_a_bad_value(
        edits in prop::collection::vec((0usize..4000, prop::sample::select(b"0-9.e[]\"=#\n ni\xff".to_vec())), 1..10)
    ) {
        let mut bytes = Job::EXAMPLE.as_bytes().to_vec();
        for (at, byte) in edits {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        match Job::from_bytes(&bytes, Path::new("a.toml")) {
            Ok(job) => {
                let f = job.feed;
                let positive = [f.feed, f.tangential_acceleration, f.tangential_jerk, f.normal_acceleration, job.period,
                    job.chord_tolerance, job.fit_tolerance];
                prop_assert!(positive.iter().all(|v| v.is_finite() && *v > 0.0), "{:?}", job);
                prop_assert!(job.workpiece.to_homogeneous().iter().all(|v| v.is_finite()), "{:?}", job);
            }
            Err(e) => prop_assert!(e.to_string().contains("a.toml")),
        }
    }

    #[test]
    fn any_number_as_a_value_is_kept_or_refused(v in any::<f64>(), key in prop::sample::select(vec![
        "feed.feed_mm_s", "joints.jerk_deg_s3", "tolerance.chord_mm", "sampling.period_ms",
    ])) {
        let text = format!("{key} = {v:e}").replace("NaN", "nan");
        if let Ok(job) = read(&text) {
            prop_assert!(v.is_finite() && v > 0.0);
            prop_assert!(job.period > 0.0 && job.feed.feed > 0.0 && job.chord_tolerance > 0.0);
        }
    }
}

#[test]
fn sections_are_read_by_length_parameter_and_segment() {
    let job = read(
        "[[sections]]\nfeed_mm_s = 12\nfrom_segment = 20\nto_segment = 45\n\
         [[sections]]\nfeed_mm_s = 8\nfrom_mm = 100\nto_mm = 150.5\n\
         [[sections]]\nfeed_mm_s = 15\nfrom_u = 0.5\nto_u = 0.75\n",
    )
    .expect("valid");
    let extents: Vec<_> = job.sections.iter().map(|s| s.extent).collect();
    assert_eq!(
        extents,
        [
            Extent::Segments { first: 20, last: 45 },
            Extent::Length { from: 0.1, to: 0.1505 },
            Extent::Parameter { from: 0.5, to: 0.75 }
        ]
    );
    assert_relative_eq!(job.sections[0].feed, 0.012);
    let job = read("[feed]\nstart_mm_s = 20\nend_mm_s = 5").expect("valid");
    assert_eq!(job.feed.end_speeds, [0.02, 0.005]);
}

#[test]
fn sections_that_say_too_little_or_too_much() {
    let section =
        |keys: &str| format!("# first line\n[[sections]]\nfeed_mm_s = 1\nfrom_mm = 0\nto_mm = 1\n[[sections]]\n{keys}");
    let pair = "exactly one of the three pairs";
    for (keys, parts) in [
        ("from_mm = 1\nto_mm = 2", vec!["sections[1].feed_mm_s", "missing", "feed of its own"]),
        ("feed_mm_s = 0\nfrom_mm = 1\nto_mm = 2", vec!["a.toml:7", "sections[1].feed_mm_s", "is 0", "above 0"]),
        ("feed_mm_s = 5", vec!["sections[1]", pair]),
        ("feed_mm_s = 5\nfrom_mm = 1", vec!["sections[1]", pair]),
        ("feed_mm_s = 5\nfrom_mm = 1\nto_u = 2", vec!["sections[1]", pair]),
        ("feed_mm_s = 5\nfrom_mm = 1\nto_mm = 2\nfrom_u = 0\nto_u = 1", vec!["sections[1]", pair]),
        (
            "feed_mm_s = 5\nfrom_mm = 3\nto_mm = 2",
            vec!["a.toml:8", "sections[1].from_mm", "is 3", "begin before it ends"],
        ),
        ("feed_mm_s = 5\nfrom_u = 0.5\nto_u = nan", vec!["sections[1].to_u", "NaN", "finite"]),
        ("feed_mm_s = 5\nfrom_segment = 0\nto_segment = 4", vec!["sections[1].from_segment", "is 0", "count from 1"]),
        ("feed_mm_s = 5\nfrom_segment = 7\nto_segment = 4", vec!["sections[1].from_segment", "begin before it ends"]),
    ] {
        says(&section(keys), &parts);
    }
    for value in ["-1", "nan", "inf"] {
        says(&format!("feed.start_mm_s = {value}"), &["a.toml:1", "feed.start_mm_s", "0 or more", "rest"]);
        says(&format!("feed.end_mm_s = {value}"), &["feed.end_mm_s", "0 or more"]);
    }
}

#[test]
fn torque_and_payload_that_contradict_each_other() {
    says("[torque]\npayload_kg = 2", &["torque.payload_kg", "torque.limited = true"]);
    says("[torque]\nlimited = true\npayload_centre_mm = [0, 0, 1]", &["torque.payload_centre_mm", "needs a mass"]);
    says("[torque]\nlimited = false\nlimit_nm = 5", &["torque.limit_nm", "remove one"]);
    says("[torque]\nlimit_nm = [1, 2, 0]", &["torque.limit_nm[2]", "is 0", "above 0"]);
    says(
        "[torque]\nlimited = true\npayload_kg = 1\npayload_centre_mm = [0, nan, 1]",
        &["payload_centre_mm[1]", "finite"],
    );
    assert_eq!(read("[torque]\nlimited = false").expect("valid").torque, None);
}
