//! Rapid moves of a program: lines with a speed of their own, and motions of the joints.
//!
//! `ARCFEED_CASES=100 cargo test --release -p robot-cr7 --test it rapid_moves -- --nocapture` searches longer.

use arcfeed_interp::Quantity;
use arcfeed_testing::{Random, cases};
use robot_cr7::{Job, PartMotion, PathFile, ProgramTask};

use crate::common::Desk;
use crate::program_case::{Planned, Script, planned, read};

const JOINTS: &str = "[feed]\nrapid = \"joints\"\n";
const PLATE: &str = include_str!("../../data/gcode/plate.ngc");
const PLATE_JOB: &str = "[workpiece]\nposition_mm = [380, -80, 200]\n";

/// Squares of 20 mm side by side, with lifts of 8 mm between them; the tool goes back to the start above the last one.
fn squares(count: usize, blend: f64) -> Script {
    let mut script = Script::new([0.0, 0.0, 8.0], blend);
    for i in 0..count {
        let x = 35.0 * i as f64;
        if i > 0 {
            script.to([x, 0.0, 8.0], None);
        }
        script.to([x, 0.0, -1.0], Some(20.0));
        for (dx, y) in [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)] {
            script.to([x + dx, y, -1.0], Some(50.0));
        }
        script.to([x, 0.0, 8.0], None);
    }
    script.to([0.0, 0.0, 30.0], None);
    script
}

fn fastest(planned: &Planned) -> f64 {
    let pairs = planned.points.windows(2).zip(planned.rows.windows(2));
    pairs
        .filter(|(_, t)| t[1].t - t[0].t > 1e-4)
        .map(|(p, t)| (p[1] - p[0]).norm() / (t[1].t - t[0].t))
        .fold(0.0, f64::max)
}

#[test]
fn rapid_lines_have_a_speed_of_their_own_and_working_lines_keep_their_feed() {
    let desk = Desk::new("rapid_lines");
    for blend in [0.0, 0.05] {
        let script = squares(3, blend);
        let as_ever = planned(&desk, &script, "");
        as_ever.keeps(&script, Some(100.0), 1e-3);
        let same = planned(&desk, &script, "[feed]\nrapid_mm_s = 100\n");
        assert_eq!(as_ever.rows, same.rows, "the feed of the job is the default");
        let fast = planned(&desk, &script, "[feed]\nrapid_mm_s = 300\n");
        fast.keeps(&script, Some(300.0), 1e-3);
        assert!(fastest(&fast) > 160.0, "{} mm/s", fastest(&fast));
        assert!(fast.duration() < as_ever.duration() - 0.3, "{} s, {} s", fast.duration(), as_ever.duration());
        // Slower than the feed, too.
        let slow = planned(&desk, &script, "[feed]\nrapid_mm_s = 30\n");
        slow.keeps(&script, Some(30.0), 1e-3);
        assert!(slow.duration() > as_ever.duration() + 0.3, "{} s, {} s", slow.duration(), as_ever.duration());
    }
}

#[test]
fn rapid_moves_of_the_joints_pass_the_ends_and_are_faster() {
    let desk = Desk::new("rapid_joints");
    let script = squares(4, 0.05);
    let lines = planned(&desk, &script, "");
    let joints = planned(&desk, &script, JOINTS);
    joints.keeps(&script, None, 1e-3);
    assert_eq!((joints.parts("path").len(), joints.parts("joints").len()), (4, 4));
    assert!(joints.duration() < 0.95 * lines.duration(), "{} s, {} s", joints.duration(), lines.duration());
    for part in joints.parts("joints") {
        assert_eq!(part["reconfigured"], false, "{part}");
        assert!(part["passes_ends_m"].as_f64().is_some_and(|m| m <= 1e-3), "{part}");
    }
    // The lift between two squares is 8 mm above the start of the next path, which is the height of the lines: none.
    assert!(joints.parts("joints")[0]["lift_m"].as_f64().is_some_and(|m| m.abs() < 1e-12));
    assert!(joints.report["warnings"].to_string().contains("where the lift is 0 mm"), "{}", joints.report["warnings"]);
    // Nearer ends take longer; G61 stops there.
    let mut close = script.clone();
    close.ends = 0.02;
    let near = planned(&desk, &close, &format!("{JOINTS}rapid_blend_mm = 0.02\n"));
    near.keeps(&close, None, 1e-3);
    assert!(near.duration() > joints.duration() + 0.01, "{} s, {} s", near.duration(), joints.duration());
    let exact = squares(4, 0.0);
    let stops = planned(&desk, &exact, JOINTS);
    stops.keeps(&exact, None, 1e-3);
    assert!(stops.parts("joints").iter().all(|part| part["passes_ends_m"].as_f64().is_some_and(|m| m < 1e-9)));
}

#[test]
fn twenty_contours_are_faster_with_every_freedom() {
    let desk = Desk::new("rapid_plate");
    desk.write("plate.ngc", PLATE);
    let mut times = Vec::new();
    for job in ["", "[feed]\nrapid_mm_s = 500\n", JOINTS] {
        desk.write("job.toml", &format!("{PLATE_JOB}{job}"));
        let report = desk.run(&["plan", "plate.ngc", "--job", "job.toml", "--json"]).done().json();
        times.push(report["duration_s"].as_f64().expect("a number"));
        assert_eq!(report["warnings"].as_array().map(Vec::len), Some(1), "{}", report["warnings"]);
        assert!(report["warnings"][0].as_str().is_some_and(|text| text.starts_with("the motion begins")));
    }
    println!(
        "20 contours: lines at the feed {:.3} s, at 500 mm/s {:.3} s, joints {:.3} s",
        times[0], times[1], times[2]
    );
    assert!(times[1] < 0.95 * times[0] && times[2] < 0.95 * times[1], "{times:?}");
}

#[test]
fn a_configuration_that_does_not_reach_on_is_left_between_two_paths() {
    let desk = Desk::new("rapid_configuration");
    let script = {
        let mut script = Script::new([0.0, 0.0, 20.0], 0.0);
        for x in [0.0, 200.0] {
            script.to([x, 0.0, 20.0], None);
            script.to([x, 0.0, 0.0], Some(50.0));
            script.to([x + 10.0, 0.0, 0.0], Some(50.0));
            script.to([x + 10.0, 0.0, 20.0], None);
        }
        script.steps.remove(0);
        script
    };
    // The hand is turned back: it cannot reach as far as with the hand forward.
    let job = format!("{JOINTS}[start]\nnear_deg = [9.4, -108.9, 85.7, 113.2, -90.0, 99.4]\n");
    let planned = planned(&desk, &script, &job);
    planned.keeps(&script, None, 1e-3);
    let moves = planned.parts("joints");
    assert_eq!((moves[0]["reconfigured"].as_bool(), moves[1]["reconfigured"].as_bool()), (Some(true), Some(false)));
    assert!(moves[0]["leaves_lines_m"].as_f64().is_some_and(|m| m > 0.1), "{}", moves[0]);
    let warnings = planned.report["warnings"].to_string();
    for part in ["changes its configuration in 1 joint moves", "leaves the lines by up to"] {
        assert!(warnings.contains(part), "{warnings}");
    }
}

#[test]
fn rapid_moves_that_cannot_be_made_are_refused_by_line() {
    let desk = Desk::new("rapid_refused");
    let job = format!("{PLATE_JOB}{JOINTS}");
    let program = "G21 G0 X0 Y0 Z5\nG1 X20 F600\nG0 Z20\nN7 X1900\nX20\nG1 X40\nG0 Z20\n";
    desk.write("p.ngc", program);
    desk.write("job.toml", &job);
    let run = desk.run(&["plan", "p.ngc", "--job", "job.toml"]);
    run.refused(1, &["p.ngc:4", "the end of the rapid move (G0)", "out of reach"]);
    desk.write("p.ngc", "G21 G0 X0 Y0 Z5\nG1 X20 F600\nG0 Z20\n");
    desk.write("job.toml", &format!("{job}end_mm_s = 5\n"));
    desk.run(&["plan", "p.ngc", "--job", "job.toml"]).refused(2, &["feed.end_mm_s", "at rest", "feed.rapid"]);
    desk.write("job.toml", &job);
    desk.run(&["plan", "p.ngc", "--job", "job.toml", "--stream", "20"]).refused(2, &["--stream", "one path"]);
    for (keys, parts) in [
        ("rapid = \"fast\"", &["job.toml:4", "`fast`", "`line`", "`joints`"][..]),
        ("rapid_mm_s = 0", &["job.toml:4", "feed.rapid_mm_s", "above 0"]),
        ("rapid_mm_s = 2e6", &["job.toml:4", "feed.rapid_mm_s", "1000000 mm/s"]),
        ("rapid_blend_mm = -1", &["job.toml:4", "feed.rapid_blend_mm", "above 0"]),
    ] {
        desk.write("job.toml", &format!("{PLATE_JOB}[feed]\n{keys}\n"));
        desk.run(&["plan", "p.ngc", "--job", "job.toml"]).refused(2, parts);
    }
    // No rapid move between working moves: one path, as ever.
    desk.write("p.ngc", "G21 G0 X0 Y0 Z5\nG0 X1\nG1 X20 F600\nX40\n");
    desk.write("job.toml", &format!("{job}rapid_mm_s = 300\n"));
    let report = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json"]).done().json();
    assert!(report["parts"].is_null() && report["warnings"].to_string().contains("rapid_mm_s = 300 has no effect"));
}

#[test]
fn a_rapid_move_that_moves_nothing_has_a_row_without_time() {
    let desk = Desk::new("still_rapids");
    // A full turn of the tool is the same pose.
    desk.write("p.ngc", "G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F600\nG1 X40\nN7 G0 A360\nG0 A0\nG1 Y30\n");
    desk.write("job.toml", &format!("{PLATE_JOB}{JOINTS}"));
    let report = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json"]).done().json();
    let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), ["3", "4", "5", "6", "7"], "{table}");
    assert_eq!((rows[2][1], rows[3][1]), ("7", ""), "N words");
    for still in &rows[2..4] {
        assert_eq!([still[2], still[4]], [rows[1][3], rows[1][5]], "{table}");
        assert_eq!([still[3], still[5]], [rows[1][3], rows[1][5]], "{table}");
    }
    let sum: f64 = rows.iter().map(|row| row[5].parse::<f64>().unwrap() - row[4].parse::<f64>().unwrap()).sum();
    assert!((sum - report["duration_s"].as_f64().expect("a number")).abs() < 1e-12, "{sum} s");
}

#[test]
fn a_compiled_program_is_one_joint_trajectory() {
    let desk = Desk::new("rapid_compiled");
    let mut script = squares(2, 0.05);
    script.rest(0.125);
    desk.write("p.ngc", &script.text);
    desk.write("job.toml", &format!("{PLATE_JOB}{JOINTS}"));
    let run = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json", "--compile-rad", "1e-6", "--bound"]);
    let planned = read(&desk, run.done().json());
    planned.keeps(&script, None, 1e-3);
    let text = std::fs::read_to_string(desk.folder.join("out/joint_trajectory.json")).expect("written");
    let file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
    };
    let times = numbers(&file["times_s"]);
    let duration = planned.duration();
    assert!((times[times.len() - 1] - duration).abs() < 1e-9 * duration);
    let pieces = file["coefficients_rad_per_s_k"].as_array().expect("a list");
    for row in &planned.rows {
        let i = times.partition_point(|t| *t <= row.t).clamp(1, times.len() - 1) - 1;
        for (k, q) in row.q.iter().enumerate() {
            let powers = numbers(&pieces[i][k]);
            let value = powers.iter().rev().fold(0.0, |sum, c| sum * (row.t - times[i]) + c);
            assert!((value - q).abs() <= 1.5e-6, "joint {k} at {} s: {value}, {q}", row.t);
        }
    }
    let compiled = &planned.report["compiled"];
    assert_eq!(compiled["pieces"].as_u64(), Some(pieces.len() as u64));
    let bound = compiled["deviation_bound_rad"].as_f64().expect("a number, dwells included");
    assert!(bound > 0.0 && bound <= 1e-6, "{bound}");
    for list in ["certified", "certified_tool"] {
        for line in compiled[list].as_array().expect("a list") {
            assert!(line["ratio"].as_f64().is_some_and(|ratio| ratio <= 1.0 + 1e-6), "{line}");
        }
    }
    let bound = planned.report["bound"]["lower_bound_s"].as_f64().expect("a number");
    assert!(bound > 0.9 * duration && bound <= duration, "{bound} s of {duration} s");
}

/// Joint moves belong to what is certain of a program: here they use more torque than the slow paths.
#[test]
fn the_certified_torque_of_a_program_is_that_of_its_joint_moves_too() {
    let desk = Desk::new("rapid_torque");
    desk.write("p.ngc", &squares(2, 0.05).text);
    desk.write("job.toml", &format!("{PLATE_JOB}{JOINTS}[torque]\nlimit_nm = 300\n"));
    let report = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json", "--compile-rad", "1e-6"]).done().json();
    // One line for each joint, or for the one that uses most.
    let of = |lines: &serde_json::Value| -> [f64; 2] {
        let lines = lines.as_array().expect("a list").iter().filter(|line| line["name"] == "joint torque");
        let number = |line: &serde_json::Value, key: &str| line[key].as_f64().unwrap_or_else(|| panic!("{line}"));
        let of_line = |line| [number(line, "ratio"), number(line, "at_t_s")];
        lines.map(of_line).fold([0.0; 2], |most, line| if line[0] > most[0] { line } else { most })
    };
    let ([seen, t], [certain, _]) = (of(&report["limits"]), of(&report["compiled"]["certified"]));
    assert!(certain >= 0.9999 * seen && certain < 1.02 * seen, "{certain} certain, {seen} seen at {t} s");
}

/// A program of several contours with lifts and dwells, and the job it is planned with: the highest speed of rapid lines, or none.
fn random_program(random: &mut Random) -> (Script, String, Option<f64>, f64) {
    let round = |v: f64| (v * 100.0).round() / 100.0;
    let blend = random.one_of(&[0.0, 0.02, 0.2]);
    let lift = round(random.log(3.0, 40.0));
    let place = |random: &mut Random| [round(random.between(0.0, 180.0)), round(random.between(-60.0, 180.0))];
    let [x, y] = place(random);
    let mut script = Script::new([x, y, lift], blend);
    let mut at = [x, y];
    for contour in 0..2 + random.below(4) {
        if contour > 0 {
            at = place(random);
            script.to([at[0], at[1], lift], None);
            if random.chance(0.3) {
                script.to([at[0], at[1], round(0.3 * lift)], None);
            }
            if random.chance(0.2) {
                script.rest(round(random.log(0.01, 0.5)));
            }
        }
        script.to([at[0], at[1], -1.0], Some(round(random.log(5.0, 80.0))));
        let feed = round(random.log(10.0, 100.0));
        for _ in 0..1 + random.below(5) {
            at = [0, 1].map(|k| round(at[k] + random.sign() * random.between(2.0, 25.0)));
            script.to([at[0], at[1], -1.0], Some(feed));
            if random.chance(0.15) {
                script.rest(round(random.log(0.01, 0.5)));
            }
        }
        script.to([at[0], at[1], lift], None);
    }
    if random.chance(0.5) {
        script.rest(0.05);
    }
    let period = random.one_of(&[1e-3, 4e-3]);
    let sampling = format!("[sampling]\nperiod_ms = {}\n", period * 1e3);
    if random.chance(0.7) {
        script.ends = round(random.log(0.05, 10.0));
        let job = format!("{JOINTS}rapid_blend_mm = {}\n{sampling}", script.ends);
        (script, job, None, period)
    } else {
        let rapid = round(random.log(30.0, 800.0));
        (script, format!("[feed]\nrapid_mm_s = {rapid}\n{sampling}"), Some(rapid), period)
    }
}

#[test]
fn random_programs_keep_limits_lines_and_times() {
    let desk = Desk::new("rapid_random");
    for seed in cases(5).map(|i| 20_261_129 + i) {
        let (script, job, rapid, period) = random_program(&mut Random::new(seed));
        // What a failure is about.
        println!("seed {seed}\n{job}{}", script.text);
        planned(&desk, &script, &job).keeps(&script, rapid, period);
    }
}

/// The polynomials of joint moves keep the limit of the angular speed of the tool, too, however coarse they are.
#[test]
fn compiled_joint_moves_keep_the_angular_speed_of_the_tool() {
    let text = b"G21 G90 G61\nG0 X0 Y0 Z20\nG1 Z0 F1200\nG1 X40\nG0 Z40\nG0 X120 Y100 C60\nG0 Z0\nG1 X80\nM2\n";
    let limit = 20.0_f64;
    let job = format!("[feed]\nrapid = \"joints\"\nangular_speed_deg_s = {limit}\n");
    let job = Job::from_bytes(job.as_bytes(), "job.toml".as_ref()).expect("a job");
    let file = PathFile::from_bytes(text, "part.ngc".as_ref(), None).expect("a program");
    let task = ProgramTask::of_cr7(&job, &file).expect("in reach");
    for tolerance in [1e-6, 1e-3, 1e-2] {
        let (motion, compiled) = task.plan_compiled(tolerance).expect("a motion");
        let moves = motion.parts().iter().filter(|part| matches!(part.motion(), PartMotion::Joints(_))).count();
        assert_eq!(moves, 1);
        let arm = task.arm().expect("a path");
        let tool = compiled.joints.certify_tool(arm);
        let bound = tool.of(Quantity::AngularSpeed).expect("bounded").bound.to_degrees();
        assert!(bound <= limit * (1.0 + 1e-6), "{tolerance}: {bound}");
        assert!(bound > 0.5 * limit, "{tolerance}: the limit does not matter");
    }
}
