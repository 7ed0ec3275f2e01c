//! The motions of a set of jobs stay what they are: duration, worst use of a limit, and the joints on the way.
//!
//! A change inside the planners may not lengthen one of these motions, nor move it by more than rounding. One that gets
//! shorter is pinned anew, with the reason in the changelog. `PIN=1 cargo test -p robot-cr7 --test it pinned -- --nocapture`
//! prints the table as it is now.

use crate::common;

use common::Desk;
use serde_json::Value;

/// Relative change of a duration that counts as rounding.
const SAME_TIME: f64 = 1e-6;
/// Change of the mean joint values (rad) that counts as rounding.
const SAME_JOINTS: f64 = 1e-6;
/// Change of the worst ratio that counts as rounding: a maximum over samples, and flat.
const SAME_RATIO: f64 = 1e-4;

/// What a job is expected to give.
struct Pin {
    name: &'static str,
    args: &'static [&'static str],
    /// Lines of a job or schedule file, named `job.toml`.
    file: &'static str,
    duration: f64,
    worst: f64,
    /// Mean over the samples of `sum (k + 1) q_k`, rad.
    joints: f64,
}

const JOINED: &str = "[plan]\nplanner = \"continuous-acceleration\"\n";
const SEGMENTS: &str = "[plan]\nplanner = \"per-segment\"\n";
const WINDOW: &str = "[plan]\nplanner = \"per-segment\"\nlookahead = 40\n";
const SECTIONS: &str = "[feed]\nstart_mm_s = 20.0\nend_mm_s = 10.0\n[[sections]]\nfeed_mm_s = 40.0\nfrom_mm = 100.0\nto_mm = 150.0\n\
    [[sections]]\nfeed_mm_s = 60.0\nfrom_mm = 200.0\nto_mm = 230.0\n";
const TORQUE: &str = "[torque]\nlimited = true\npayload_kg = 2.0\n[feed]\nangular_speed_deg_s = 30.0\n\
    [orientation]\nmode = \"slerp\"\nfrom_rpy_deg = [180.0, 0.0, 0.0]\nto_rpy_deg = [180.0, 0.0, 60.0]\n";
const TANGENT: &str = "[orientation]\nmode = \"tangent\"\naxis = [0.0, 0.0, -1.0]\n";
const PICK: &str = include_str!("../../schedules/pick.toml");
const WAYPOINTS: &str = include_str!("../../schedules/waypoints.toml");
const TURN: &str = "[start]\nq_deg = [0.0, -60.0, 100.0, 10.0, 60.0, 0.0]\n\
    [goal]\nq_deg = [0.0, -60.0, 100.0, 10.0, 60.0, 90.0]\n[limits]\nangular_deg_s = 60.0\n";

include!("pinned/table.rs");

fn worst(report: &Value) -> f64 {
    let limits = report["limits"].as_array().expect("the report lists limits");
    limits.iter().filter_map(|limit| limit["ratio"].as_f64()).fold(0.0, f64::max)
}

/// Mean over the rows of `sum (k + 1) q_k`.
fn joints(csv: &str) -> f64 {
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    // Behind a colon stands the name of the joint.
    let quantity = |i: &usize| header[*i].split(':').next().unwrap_or_default();
    let columns: Vec<usize> =
        (0..header.len()).filter(|i| quantity(i).starts_with('q') && quantity(i).ends_with("_rad")).collect();
    let row = |line: &str| -> f64 {
        let values: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        columns.iter().enumerate().map(|(k, &i)| (k + 1) as f64 * values[i]).sum()
    };
    let rows: Vec<f64> = lines.map(row).collect();
    rows.iter().sum::<f64>() / rows.len() as f64
}

fn measure(pin: &Pin) -> [f64; 3] {
    let desk = Desk::new(&format!("pinned_{}", pin.name.replace([' ', ','], "_")));
    desk.write("job.toml", pin.file);
    let run = desk.run(&[pin.args, &["--out", "out", "--json"]].concat());
    assert_eq!(run.code, 0, "{}: {run:?}", pin.name);
    let report = run.json();
    let csv = std::fs::read_to_string(desk.folder.join("out/trajectory.csv")).expect("a trajectory");
    [report["duration_s"].as_f64().expect("a duration"), worst(&report), joints(&csv)]
}

#[test]
fn motions_stay_what_they_are() {
    let print = std::env::var_os("PIN").is_some();
    let mut moved = Vec::new();
    for pin in PINS {
        let [duration, worst, joints] = measure(pin);
        if print {
            println!("{}: {duration:?} {worst:?} {joints:?}", pin.name);
        }
        let same = (duration / pin.duration - 1.0).abs() <= SAME_TIME
            && (worst - pin.worst).abs() <= SAME_RATIO
            && (joints - pin.joints).abs() <= SAME_JOINTS;
        if !same {
            moved.push(format!(
                "{}: duration {duration:?} (pinned {:?}), worst {worst:?} ({:?}), joints {joints:?} ({:?})",
                pin.name, pin.duration, pin.worst, pin.joints
            ));
        }
    }
    assert!(print || moved.is_empty(), "{} of {} motions moved:\n{}", moved.len(), PINS.len(), moved.join("\n"));
}
