//! Files from Windows: a byte order mark and other line ends change nothing that is read.

use std::fmt::Debug;
use std::path::Path;

use arcfeed_kinematics::{ArmDescription, models};
use robot_cr7::{
    GcodeOptions, GcodeProgram, Job, OnlineScenario, PathFile, RecordedRows, SamplePath, Scenario, ScheduleFile,
    ToolScenario, read_trajectory, trajectory_columns,
};

/// Reads a text as it is and as Windows programs save it, by the file system where `read` takes a path.
fn same<T: Debug>(name: &str, text: &str, read: impl Fn(&Path) -> T) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("windows_files");
    let unix = text.replace("\r\n", "\n");
    let windows = format!("\u{feff}{}", unix.replace('\n', "\r\n"));
    let [plain, foreign] = [("unix", unix), ("windows", windows)].map(|(kind, text)| {
        let folder = folder.join(kind);
        std::fs::create_dir_all(&folder).expect("a writable target folder");
        let file = folder.join(name);
        std::fs::write(&file, text).expect("a writable target folder");
        // The names of the files are part of what is read.
        let read = format!("{:?}", read(&file));
        // Scenarios keep their text for messages.
        read.replace(&*folder.to_string_lossy(), "").replace("\\r\\n", "\\n")
    });
    assert!(!plain.contains("Err("), "{name}: {plain}");
    assert_eq!(foreign, plain, "{name}");
}

fn repository(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn paths() {
    same("six.json", SamplePath::SixPoint.json(), |file| PathFile::read(file, None));
    same("points.csv", "# points\nx_mm,y_mm\n0,0\n10,2\n\n20,1\n30,5\n", |file| PathFile::read(file, None));
    let options = GcodeOptions::default();
    same("plate.ngc", &repository("data/gcode/plate.ngc"), |file| GcodeProgram::read(file, &options));
    same("variables.ngc", &repository("data/gcode/variables.ngc"), |file| GcodeProgram::read(file, &options));
    same("plate.dxf", &repository("data/drawings/plate.dxf"), |file| PathFile::read(file, None));
    same("badge.svg", &repository("data/drawings/badge.svg"), |file| PathFile::read(file, None));
}

#[test]
fn jobs_and_scenarios() {
    same("job.toml", Job::EXAMPLE, Job::read);
    same("tool.toml", ToolScenario::EXAMPLE, robot_cr7::OnlineFile::read);
    same("online.toml", &repository("scenarios/online.toml"), robot_cr7::OnlineFile::read);
    same("run.toml", &repository("scenarios/butterfly_live.toml"), Scenario::read);
    same("pick.toml", &repository("schedules/pick.toml"), ScheduleFile::read);
    assert!(OnlineScenario::parse("\u{feff}", Path::new("a.toml")).is_err(), "texts are read without a mark");
}

#[test]
fn robots() {
    let arm = models::description("ur5e").expect("built in");
    let read =
        |file: &Path| robot_cr7::Robot::load(&file.to_string_lossy(), None, None).map(|r| r.description().clone());
    same("arm.urdf", &arm.to_urdf(), read);
    same("arm.json", &arm.to_json(), read);
    // The readers of texts, too.
    let windows = |text: String| format!("\u{feff}{}", text.replace('\n', "\r\n"));
    let urdf = ArmDescription::from_urdf(&windows(arm.to_urdf()), None, None).expect("read");
    assert_eq!(urdf.joints.len(), 6);
    assert_eq!(
        ArmDescription::from_json(&windows(arm.to_json())).expect("read"),
        ArmDescription::from_json(&arm.to_json()).expect("read")
    );
}

#[test]
fn trajectories() {
    let names: Vec<String> = (1..=6).map(|k| format!("joint{k}")).collect();
    let row = |i: usize| {
        (0..trajectory_columns(&names).len()).map(|k| (i * (k + 1)).to_string()).collect::<Vec<_>>().join(",")
    };
    let text = format!("{}\n{}\n{}\n", trajectory_columns(&names).join(","), row(0), row(1));
    let open = |file: &Path| std::fs::File::open(file).expect("there");
    same("trajectory.csv", &text, |file| read_trajectory::<_, 6>(open(file), file));
    same("recorded.csv", &text, |file| {
        RecordedRows::<_, 6>::new(open(file), file).and_then(|rows| rows.collect::<Result<Vec<_>, _>>())
    });
}

#[cfg(feature = "cli")]
#[test]
fn jobs_of_a_batch_and_compiled_motions() {
    let desk = crate::common::Desk::new("windows_commands");
    let windows = |text: &str| format!("\u{feff}{}", text.replace("\r\n", "\n").replace('\n', "\r\n"));
    desk.write("jobs.jsonl", &windows("{\"id\": \"a\", \"robot\": \"nobody\"}\n\n{\"id\": \"b\", \"feet\": {}}\n"));
    let run = desk.run(&["batch", "jobs.jsonl"]);
    assert!(run.code == 1 && run.stdout.contains("! a: ") && run.stdout.contains("! b: "), "{run:?}");
    assert!(run.stdout.contains("nobody") && run.stdout.contains("feet") && !run.stdout.contains("no JSON"), "{run:?}");
    if cfg!(feature = "controller") {
        desk.write("six.json", SamplePath::SixPoint.json());
        desk.run(&["plan", "six.json", "--compile-rad", "1e-6", "--out", "plan"]).done();
        let read = |name: &str| std::fs::read_to_string(desk.folder.join(name)).expect(name);
        desk.write("foreign.json", &windows(&read("plan/joint_trajectory.json")));
        for (motion, out) in [("plan/joint_trajectory.json", "unix"), ("foreign.json", "windows")] {
            desk.run(&["send", motion, "--out", out]).done();
        }
        assert_eq!(read("unix/setpoints.csv"), read("windows/setpoints.csv"));
    }
}
