//! The same input gives the same bytes: in every run, and with any number of threads.
#![cfg(feature = "cli")]

use crate::common;

use std::collections::BTreeMap;
use std::path::Path;

use common::Desk;
use serde_json::Value;

/// A file without what tells how long the computer took, and where its files are.
fn told(file: &Path) -> Vec<u8> {
    let bytes = std::fs::read(file).expect("written");
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if name.ends_with(".json") {
        let mut value: Value = serde_json::from_slice(&bytes).expect("JSON");
        strip(&mut value);
        return value.to_string().into_bytes();
    }
    if name == "report.txt" {
        let text = String::from_utf8(bytes).expect("text");
        let kept = text.lines().filter(|line| !line.trim_start().starts_with("computing") && !line.contains("wrote "));
        // Of a schedule the times stand behind its planner.
        let without = |line: &str| match line.trim_start().starts_with("planner") {
            true => line.split(": ").next().unwrap_or_default().to_owned(),
            false => line.to_owned(),
        };
        return kept.map(without).collect::<Vec<_>>().join("\n").into_bytes();
    }
    bytes
}

fn strip(value: &mut Value) {
    let measured = |key: &str| key == "files" || key.ends_with("_time_s") || key.contains("computing");
    let is_fact = |value: &Value| value.get(0).and_then(Value::as_str) == Some("computing");
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !measured(key));
            map.values_mut().for_each(strip);
        }
        Value::Array(list) => {
            list.retain(|value| !is_fact(value));
            list.iter_mut().for_each(strip);
        }
        _ => {}
    }
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries
        .map(|e| e.expect("an entry").path())
        .map(|path| (path.file_name().unwrap_or_default().to_string_lossy().into_owned(), told(&path)))
        .collect()
}

#[test]
fn two_runs_write_the_same_bytes() {
    let desk = Desk::new("same_bytes");
    desk.write("six.json", robot_cr7::SamplePath::SixPoint.json());
    desk.write("square.ngc", include_str!("../../data/gcode/square.ngc"));
    desk.write("way.toml", "[[waypoint]]\nq_deg = 0\n[[waypoint]]\nq_deg = [40, -10, 70, 35, -80, 20]\n");
    let commands: [&[&str]; 4] = [
        &["plan", "six.json", "--compile-rad", "1e-6"],
        &["plan", "square.ngc"],
        &["schedule", "way.toml"],
        &["online"],
    ];
    for command in commands {
        let [first, second] = ["first", "second"].map(|out| {
            desk.run(&[command, &["--out", out]].concat()).done();
            files(&desk.folder.join(out))
        });
        assert_eq!(first.keys().collect::<Vec<_>>(), second.keys().collect::<Vec<_>>(), "{command:?}");
        for (name, bytes) in &first {
            assert!(!bytes.is_empty(), "{command:?}: {name}");
            assert!(*bytes == second[name], "{command:?}: {name} differs");
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let desk = Desk::new("same_bytes_threads");
    desk.write(
        "line.json",
        "{\"units\": \"mm\", \"degree\": 1, \"control_points\": [[0, 0, 0], [5, 2, 1]], \"knots\": [0, 0, 1, 1]}",
    );
    let line = |i: usize| {
        format!(
            "{{\"id\": \"{i}\", \"path\": {{\"file\": \"line.json\"}}, \"feed\": {{\"feed_mm_s\": {}}}, \"workpiece\": {{\"position_mm\": [400, {i}, 200]}}}}\n",
            20 + 10 * i
        )
    };
    desk.write("jobs.jsonl", &(0..6).map(line).collect::<String>());
    let results = |threads: &str| {
        let out = format!("out{threads}");
        desk.run(&["batch", "jobs.jsonl", "--trajectories", "-j", threads, "--out", &out]).done();
        let text = std::fs::read_to_string(desk.folder.join(&out).join("results.jsonl")).expect("results");
        let mut lines: Vec<String> = text
            .lines()
            .map(|line| {
                let mut value: Value = serde_json::from_str(line).expect("JSON");
                strip(&mut value);
                value.to_string()
            })
            .collect();
        // They stand in the order in which they were done.
        lines.sort();
        (lines, files(&desk.folder.join(&out).join("trajectories")))
    };
    let (one, two, four) = (results("1"), results("2"), results("4"));
    assert_eq!(one.0.len(), 6);
    assert!(one == two && one == four, "{:?}\n{:?}\n{:?}", one.0, two.0, four.0);
}
