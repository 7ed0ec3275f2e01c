//! The texts that inputs are made from.

use std::path::{Path, PathBuf};

use arcfeed_interp::{Interpolation, JointTrajectory};
use arcfeed_kinematics::{Joints, models};
use robot_cr7::{Job, ToolScenario, trajectory_columns};

/// Longer files are left out: changes in them are spread too thin.
const LONGEST: u64 = 20_000;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The files of a folder with this extension, in the order of their names.
fn files(folder: &Path, extension: &str) -> Vec<Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let fits = |path: &&PathBuf| {
        path.extension().is_some_and(|e| e == extension) && path.metadata().is_ok_and(|data| data.len() <= LONGEST)
    };
    paths.iter().filter(fits).filter_map(|path| std::fs::read(path).ok()).collect()
}

/// The sample files of the repository in `folder`.
pub(super) fn samples(folder: &str, extension: &str) -> Vec<Vec<u8>> {
    files(&root().join(folder), extension)
}

/// What is kept of a target in `corpus/`, with the names of the files: inputs that were a defect once, and odd ones.
pub(super) fn kept(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut found: Vec<(String, Vec<u8>)> = entries
        .flatten()
        .filter_map(|entry| Some((entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).ok()?)))
        .collect();
    found.sort();
    found
}

/// Points with and without a tool.
pub(super) fn csv_points() -> Vec<Vec<u8>> {
    [
        "x_mm,y_mm,z_mm\n0,0,0\n10,2,1\n20,1,3\n30,5,2\n40,0,0\n",
        "x,y\n0,0\n1,0.5\n2,0\n# a remark\n\n3,1\n",
        "x_m,y_m,z_m,i,j,k\n0,0,0,0,0,1\n0.1,0,0,0,0.1,1\n0.2,0.1,0,0,0,1\n",
        "x_in,y_in,z_in,qx,qy,qz,qw\n0,0,0,1,0,0,0\n1,0,0,0.99,0.1,0,0\n2,1,0,1,0,0,0\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Built-in arms, and one with a hand.
pub(super) fn urdf() -> Vec<Vec<u8>> {
    let built_in = models::NAMES.iter().filter_map(|name| models::description(name));
    let mut all: Vec<Vec<u8>> = built_in.map(|arm| arm.to_urdf().into_bytes()).collect();
    all.extend(samples("kinematics/tests/fixtures", "urdf"));
    all
}

/// Built-in arms in the format of their own.
pub(super) fn arm_json() -> Vec<Vec<u8>> {
    samples("kinematics/tests/fixtures/arms", "json")
}

/// Jobs.
pub(super) fn jobs() -> Vec<Vec<u8>> {
    let short = "[path]\nfile = \"a.csv\"\n[feed]\nfeed_mm_s = 50\n[joints]\nvelocity_deg_s = [1, 2, 3, 4, 5, 6]\n\
                 [[sections]]\nfrom_mm = 1\nto_mm = 3\nfeed_mm_s = 10\n[torque]\nlimit_nm = 30\n";
    let mut all = samples("robot-cr7/jobs", "toml");
    all.extend([Job::EXAMPLE, short].map(|text| text.as_bytes().to_vec()));
    all
}

/// Scenarios of every kind.
pub(super) fn scenarios() -> Vec<Vec<u8>> {
    let mut all = samples("robot-cr7/scenarios", "toml");
    all.push(ToolScenario::EXAMPLE.as_bytes().to_vec());
    all
}

/// Jobs with names, one a line.
pub(super) fn batch_lines() -> Vec<Vec<u8>> {
    [
        r#"{"id": "a", "robot": "ur5e", "feed": {"feed_mm_s": 50}}"#,
        r#"{"feed": {"feed_mm_s": 100, "tangential_acceleration_mm_s2": 1000, "tangential_jerk_mm_s3": 30000, "normal_acceleration_mm_s2": 500}}"#,
        r#"{"id": 7, "joints": {"velocity_deg_s": 100, "acceleration_deg_s2": [100, 200, 300, 400, 500, 600], "jerk_deg_s3": 5000}, "tolerance": {"chord_mm": 0.01}}"#,
        r#"{"robot": "kr6_r700", "sampling": {"period_ms": 4, "whole_cycles": true}, "plan": {"planner": "continuous-acceleration"}}"#,
        r#"{"workpiece": {"position_mm": [400, 0, 200], "rotation_rpy_deg": [0, 0, 30]}, "tool": {"position_mm": [0, 0, 100]}, "plan": {"planner": "per-segment", "lookahead": 10}}"#,
        r#"{"sections": [{"from_mm": 10, "to_mm": 30, "feed_mm_s": 20}], "orientation": {"mode": "tangent"}}"#,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Trajectories as the command writes them, and as others do.
pub(super) fn trajectories() -> Vec<Vec<u8>> {
    let names: Vec<String> = (1..=6).map(|k| format!("joint{k}")).collect();
    let columns = trajectory_columns(&names);
    let row = |t: usize| {
        let cells: Vec<String> = (0..columns.len()).map(|k| format!("{}", (t * k) as f64 * 1e-3)).collect();
        cells.join(",") + "\n"
    };
    let own = columns.join(",") + "\n" + &(0..5).map(row).collect::<String>();
    let foreign = "t_ms,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n0,1,2,3,4,5,6\n4,1.1,2.1,3.1,4.1,5.1,6.1\n8,1.2,2.2,3.2,4.2,5.2,6.2\n";
    vec![own.into_bytes(), foreign.as_bytes().to_vec()]
}

/// Compiled motions.
pub(super) fn compiled() -> Vec<Vec<u8>> {
    let piece = |end: f64| [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(|c| Joints::<2>::new(c * end, -c));
    let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece(1.0)], Interpolation::Quintic);
    let names = ["a", "b"].map(str::to_owned);
    motion.iter().map(|motion| motion.to_json(&names).into_bytes()).collect()
}
