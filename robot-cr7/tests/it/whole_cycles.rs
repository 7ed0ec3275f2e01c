//! Motions that last a whole number of control periods, by every command that plans one.

use crate::common::Desk;
use robot_cr7::{TrajectoryRow, read_trajectory};

/// Duration over period of a report, and the largest part of a limit that is used.
fn cycles(report: &serde_json::Value) -> (f64, f64) {
    let limits = report["limits"].as_array().expect("limits").iter();
    let most = limits.filter_map(|line| line["ratio"].as_f64()).fold(0.0, f64::max);
    (report["duration_s"].as_f64().expect("a number") / report["period_s"].as_f64().expect("a number"), most)
}

/// Runs a command with and without whole cycles: the second motion is longer by less than a period, and as many rows as periods follow the
/// first.
fn is_rounded(desk: &Desk, command: &[&str], plain: &str, whole: &str) {
    let run = |job: &str| {
        desk.write("job.toml", job);
        cycles(&desk.run(&[command, &["--json"]].concat()).done().json())
    };
    let (shortest, _) = run(plain);
    let (rounded, most) = run(whole);
    assert!((shortest - shortest.round()).abs() > 1e-3, "{command:?}: {shortest} is whole by chance");
    assert!((rounded - rounded.round()).abs() < 1e-6, "{command:?}: {rounded}");
    assert!(rounded > shortest && rounded < shortest + 1.001, "{command:?}: {shortest} {rounded}");
    assert!(most <= 1.0 + 1e-6, "{command:?}: {most}");
    let file = std::fs::File::open(desk.folder.join("out/trajectory.csv")).expect("a trajectory");
    let rows: Vec<TrajectoryRow> = read_trajectory(file, "trajectory.csv".as_ref()).expect("rows");
    assert_eq!(rows.len() as f64, rounded.round() + 1.0, "{command:?}");
}

#[test]
fn motions_last_whole_cycles_where_that_is_asked_for() {
    let desk = Desk::new("whole_cycles");
    let plain = "[feed]\nfeed_mm_s = 37.0\n[sampling]\nperiod_ms = 8.0\n";
    let whole = format!("{plain}whole_cycles = true\n");
    desk.write("six.json", robot_cr7::SamplePath::SixPoint.json());
    is_rounded(&desk, &["plan", "six.json", "--job", "job.toml"], plain, &whole);
    is_rounded(&desk, &["plan", "six.json", "--job", "job.toml", "--compile-rad", "1e-6"], plain, &whole);
    let scan = "[plan]\nplanner = \"continuous-acceleration\"\n";
    is_rounded(&desk, &["plan", "six.json", "--job", "job.toml"], &(plain.to_owned() + scan), &(whole.clone() + scan));
    let to = ["move", "--from-deg", "0", "-30", "90", "30", "-90", "0", "--to-deg", "60", "0", "60", "30", "-90", "45"];
    is_rounded(&desk, &[&to[..], &["--job", "job.toml"]].concat(), plain, &whole);
    // A program with a dwell, and rapid moves of the joints.
    desk.write("part.ngc", "G21 G90\nG0 X0 Y0 Z10\nG1 Z0 F1000\nG1 X20\nG4 P0.0123\nG1 Y30\nG0 Z10\nG0 X0 Y0\nM2\n");
    for rapid in ["line", "joints"] {
        let command = ["plan", "part.ngc", "--job", "job.toml"];
        // Each of its parts is longer by less than a period.
        let run = |job: &str| {
            desk.write("job.toml", &job.replace("[feed]\n", &format!("[feed]\nrapid = \"{rapid}\"\n")));
            let report = desk.run(&[&command[..], &["--json"]].concat()).done().json();
            (cycles(&report), report["parts"].as_array().map_or(1, Vec::len))
        };
        let ((shortest, _), parts) = run(plain);
        let ((rounded, most), _) = run(&whole);
        assert!((rounded - rounded.round()).abs() < 1e-6 && most <= 1.0 + 1e-6, "{rounded} {most}");
        assert!(
            parts > 2 && rounded > shortest && rounded < shortest + parts as f64,
            "{rapid}, {parts}: {shortest} {rounded}"
        );
    }
}

#[test]
fn schedules_last_whole_cycles_and_speeds_at_the_ends_are_refused() {
    let desk = Desk::new("whole_schedules");
    let example = desk.run(&["schedule", "--print-example"]).done().stdout;
    assert!(example.contains("whole_cycles = false"));
    is_rounded(
        &desk,
        &["schedule", "job.toml", "--robot", "kr6_r700"],
        &example.replace("period_ms = 1.0", "period_ms = 8.0"),
        &example.replace("period_ms = 1.0", "period_ms = 8.0").replace("whole_cycles = false", "whole_cycles = true"),
    );
    desk.write("moving.toml", "[feed]\nend_mm_s = 10.0\n[sampling]\nwhole_cycles = true\n");
    let run = desk.run(&["plan", "--job", "moving.toml"]);
    assert!(run.code == 2 && run.stderr.contains("moving.toml:4") && run.stderr.contains("whole_cycles"), "{run:?}");
    desk.write("whole.toml", "[sampling]\nwhole_cycles = true\n");
    let run = desk.run(&["plan", "--job", "whole.toml", "--stream", "20"]);
    assert!(run.code == 2 && run.stderr.contains("sampling.whole_cycles"), "{run:?}");
}

#[test]
fn what_is_compared_by_its_duration_is_not_rounded() {
    let desk = Desk::new("whole_compared");
    desk.write("six.json", robot_cr7::SamplePath::SixPoint.json());
    let plain = "[path]\nfile = \"six.json\"\n[feed]\nfeed_mm_s = 37.0\n[sampling]\nperiod_ms = 8.0\n";
    desk.write("plain.toml", plain);
    desk.write("whole.toml", &format!("{plain}whole_cycles = true\n"));
    for command in ["advise", "compare"] {
        let [exact, whole] = ["plain.toml", "whole.toml"].map(|job| desk.run(&[command, job, "--json"]).done().json());
        let says = |report: &serde_json::Value| report["warnings"].to_string().contains("sampling.whole_cycles");
        assert!(says(&whole) && !says(&exact), "{command}: {whole}");
        let numbers = |report: &serde_json::Value| match report["entries"].as_array() {
            Some(entries) => entries.iter().map(|entry| entry["duration_s"].clone()).collect(),
            None => vec![report["duration_s"].clone(), report["limits"].clone()],
        };
        assert_eq!(numbers(&exact), numbers(&whole), "{command}");
    }
}

#[test]
fn motions_that_are_made_cycle_by_cycle_take_no_such_key() {
    let desk = Desk::new("whole_online");
    for (command, example) in
        [("online", "--print-example"), ("online", "--print-tool-example"), ("run", "--print-example")]
    {
        let text = desk.run(&[command, example]).done().stdout;
        assert!(text.contains("\n[sampling]\n"), "{command} {example}: {text}");
        for value in ["true", "false"] {
            desk.write("s.toml", &text.replace("\n[sampling]\n", &format!("\n[sampling]\nwhole_cycles = {value}\n")));
            desk.run(&[command, "s.toml"]).refused(2, &["s.toml", "sampling.whole_cycles", "remove the key"]);
        }
    }
}
