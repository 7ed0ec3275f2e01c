//! No motion that exceeds a limit is a success, and files are there whole or not at all: each test is named after what
//! was seen when it was not so.
#![cfg(feature = "cli")]

use crate::common;
use crate::keeps;

use std::process::{Command, Stdio};
use std::time::Duration;

use common::{Desk, Run, binary};
use keeps::{Limits, broken};

const HOME: [&str; 6] = ["0", "-30", "90", "30", "-90", "0"];
const THERE: [&str; 6] = ["60", "0", "60", "30", "-90", "45"];

fn limits<const N: usize>(velocity: f64, acceleration: f64, jerk: f64) -> Limits<N> {
    let each = |degrees: f64| [degrees.to_radians(); N];
    Limits {
        velocity: each(velocity),
        acceleration: each(acceleration),
        jerk: each(jerk),
        range: [[f64::NEG_INFINITY, f64::INFINITY]; N],
        linear: f64::INFINITY,
        angular: f64::INFINITY,
    }
}

/// Names of everything in the output folder, hidden files included.
fn left(desk: &Desk, out: &str) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(desk.folder.join(out)) else { return Vec::new() };
    entries.filter_map(|e| Some(e.ok()?.file_name().to_string_lossy().into_owned())).collect()
}

/// The run is a success and its file keeps the limits from `start` on, or it is refused and leaves nothing.
fn holds_or_is_refused<const N: usize>(desk: &Desk, run: &Run, limits: &Limits<N>, start: ([f64; N], [f64; N])) {
    if run.code != 0 {
        assert_eq!(run.code, 1, "{run:?}");
        assert!(left(desk, "out").is_empty(), "{:?} after {run:?}", left(desk, "out"));
        return;
    }
    let rows = desk.trajectory::<N>("out");
    assert_eq!(broken(&rows, limits), None, "{}", run.command);
    let (q, v) = (start.0.map(f64::to_radians), start.1.map(f64::to_radians));
    for k in 0..N {
        assert!((rows[0].q[k] - q[k]).abs() < 1e-12 && (rows[0].qd[k] - v[k]).abs() < 1e-12, "J{}: {run:?}", k + 1);
    }
}

#[test]
fn a_joint_that_jumps_17_degrees_on_arrival_is_no_success() {
    let desk = Desk::new("jump_on_arrival");
    desk.write(
        "s.toml",
        "[run]\nmode = \"none\"\n[joints]\nvelocity_deg_s = 100\nacceleration_deg_s2 = 500\njerk_deg_s3 = 5000\n\
         [start]\nq_deg = 0\n[target]\nq_deg = [10, 90]\nqd_deg_s = [20, 0]\n",
    );
    let run = desk.run(&["online", "s.toml", "--robot", "planar_2r"]);
    holds_or_is_refused(&desk, &run, &limits::<2>(100.0, 500.0, 5000.0), ([0.0; 2], [0.0; 2]));
}

#[test]
fn a_stop_in_mode_line_that_turns_the_velocity_round_is_no_success() {
    let desk = Desk::new("stop_in_line");
    desk.write(
        "s.toml",
        "[run]\nmode = \"line\"\n[start]\nq_deg = [0.1, -30, 90, 30, -90, 0]\n[target]\nq_deg = [60.1, 0, 60, 30, -90, 45]\n\
         [[change]]\nat_s = 0.5\n\
         q_deg = [47.8219919151757, -6.13900404241213, 66.1390040424121, 30, -90, 35.7914939363818]\n",
    );
    let run = desk.run(&["online", "s.toml"]);
    let start = ([0.1, -30.0, 90.0, 30.0, -90.0, 0.0], [0.0; 6]);
    holds_or_is_refused(&desk, &run, &limits::<6>(180.0, 573.0, 5730.0), start);
}

#[test]
fn a_move_in_mode_line_that_starts_at_rest_in_place_of_50_degrees_a_second_is_no_success() {
    let desk = Desk::new("start_of_line");
    let from = ["move", "--robot", "planar_2r", "--from-deg", "10", "20", "--from-deg-s", "30", "-50"];
    let run = desk.run(&[&from[..], &["--to-deg", "10.000000000000002", "20", "--mode", "line"]].concat());
    holds_or_is_refused(&desk, &run, &limits::<2>(180.0, 573.0, 5730.0), ([10.0, 20.0], [30.0, -50.0]));
}

#[test]
fn a_move_with_5163_percent_of_its_jerk_is_no_success() {
    let desk = Desk::new("target_acceleration");
    let from = ["move", "--robot", "planar_2r", "--from-deg", "0", "0", "--to-deg", "10", "90"];
    let run = desk.run(&[&from[..], &["--to-deg-s", "20", "0", "--to-deg-s2", "300", "0", "--mode", "none"]].concat());
    holds_or_is_refused(&desk, &run, &limits::<2>(180.0, 573.0, 5730.0), ([0.0; 2], [0.0; 2]));
}

/// The joint turns 0.05 deg beyond the end of its range, by three parts in ten thousand.
#[test]
fn a_small_excess_is_no_success() {
    let desk = Desk::new("small_excess");
    let from = ["move", "--robot", "planar_2r", "--from-deg", "179", "0", "--to-deg", "170", "0", "--from-deg-s"];
    desk.run(&[&from[..], &["18", "0"]].concat()).done();
    assert!(left(&desk, "out").contains(&"trajectory.csv".to_owned()));
    let run = desk.run(&[&from[..], &["19.2", "0"]].concat());
    assert!(run.code == 1 && run.stderr.contains("joint 1 reaches 100.03 % of its limit"), "{run:?}");
    assert!(left(&desk, "out").is_empty(), "{:?}", left(&desk, "out"));
}

#[test]
fn schedules_on_coarse_grids_that_exceeded_a_tool_speed_keep_it() {
    const RAISED: &str = "intervals raised";
    let desk = Desk::new("coarse_grids");
    let point = |q: &str| format!("[[waypoint]]\nq_deg = [{q}]\n");
    let ends = ["0, -30, 90, 30, -90, 0", "40, -10, 70, 35, -80, 20", "90, 0, 60, 30, -90, 45"].map(point);
    let repeated = [&ends[0], &ends[1], &point("40.001, -10, 70, 35, -80, 20"), &ends[2]].map(String::as_str).concat();
    let turned = [&ends[0], &ends[1], &point("60, -40, 100, 20, -100, 60"), &ends[2]].map(String::as_str).concat();
    // 1.00035 without a warning, and 1.038: the one takes a little less of the limit, the others a finer grid.
    for (planner, head, way, linear, angular, mended) in [
        (
            "interpolated-reachability",
            "[motion]\nintervals = 10\n[limits]\nlinear_mm_s = 50\n",
            &repeated,
            0.05,
            f64::INFINITY,
            "lowered by 0.03",
        ),
        (
            "reachability",
            "[motion]\nintervals = 50\n[limits]\nangular_deg_s = 20\n",
            &turned,
            f64::INFINITY,
            20.0,
            RAISED,
        ),
        (
            "forward-backward",
            "[motion]\nintervals = 50\n[limits]\nangular_deg_s = 20\n",
            &turned,
            f64::INFINITY,
            20.0,
            RAISED,
        ),
    ] {
        desk.write("s.toml", &format!("{head}{way}"));
        let run = desk.run(&["schedule", "s.toml", "--planner", planner]).done();
        assert!(run.stdout.contains("planned") && run.stdout.contains(mended), "{run:?}");
        let asked = limits::<6>(180.0, 573.0, f64::INFINITY);
        let asked = Limits { linear, angular: angular.to_radians(), ..asked };
        assert_eq!(broken(&desk.trajectory::<6>("out"), &asked), None, "{planner}");
    }
}

#[test]
fn motions_of_ten_million_seconds_are_refused_by_key_and_not_aborted() {
    let desk = Desk::new("too_many_samples");
    let job = "[joints]\nvelocity_deg_s = 0.001\n";
    desk.write("slow.toml", job);
    desk.write("way.toml", "[limits]\nvelocity_deg_s = 0.001\n[[waypoint]]\nq_deg = 0\n[[waypoint]]\nq_deg = 40\n");
    desk.write("feed.toml", "[feed]\nfeed_mm_s = 0.00001\n");
    let between = [&["move", "--from-deg"], &HOME[..], &["--to-deg"], &THERE].concat();
    let bound = ["sampling.period_ms = 1", "10000000 are written at most"];
    desk.run(&[&between[..], &["--least-s", "1e7"]].concat()).refused(1, &[bound[0], bound[1], "--least-s"]);
    desk.run(&[&between[..], &["--job", "slow.toml"]].concat()).refused(1, &[bound[0], bound[1], "[joints]"]);
    desk.run(&["schedule", "way.toml"]).refused(1, &["way.toml", bound[0], bound[1], "[limits]"]);
    desk.run(&["plan", "--job", "feed.toml"]).refused(1, &[bound[0], bound[1], "feed.feed_mm_s"]);
    // Planned for minutes in gigabytes once.
    desk.write("fast.toml", "[feed]\nfeed_mm_s = 1e13\n");
    desk.run(&["plan", "--job", "fast.toml"])
        .refused(2, &["fast.toml:2", "feed.feed_mm_s", "1000000 mm/s at the most"]);
    assert!(left(&desk, "out").is_empty(), "{:?}", left(&desk, "out"));
}

#[test]
fn a_refused_job_leaves_no_trajectory_of_an_earlier_one() {
    let desk = Desk::new("stale");
    let between = [&["move", "--from-deg"], &HOME[..], &["--to-deg"], &THERE].concat();
    let short = "[path]\nline = [{ deg = [0, -30, 90, 30, -90, 0] }, { deg = [4, -30, 90, 30, -90, 0] }]\n[run]\nfeed_mm_s = 100\n";
    desk.write("run.toml", short);
    desk.write(
        "far.toml",
        &short.replace("deg = [4, -30, 90, 30, -90, 0]", "position_mm = [4000, 0, 300], rpy_deg = [180, 0, 0]"),
    );
    desk.write("way.toml", "[[waypoint]]\nq_deg = 0\n[[waypoint]]\nq_deg = 40\n");
    desk.write("same.toml", "[[waypoint]]\nq_deg = 40\n[[waypoint]]\nq_deg = 40\n");
    desk.write("six.json", robot_cr7::SamplePath::SixPoint.json());
    let fast = [&between[..], &["--to-deg-s", "0", "500", "0", "0", "0", "0"]].concat();
    let cases: [(&[&str], &[&str], i32); 6] = [
        (&between, &fast, 1),
        (&["online"], &["online", "none.toml"], 2),
        (&["schedule", "way.toml"], &["schedule", "same.toml"], 1),
        (&["schedule", "way.toml"], &["schedule", "way.toml", "--robot", "none"], 2),
        (&["run", "run.toml"], &["run", "far.toml"], 2),
        (&["plan", "six.json"], &["plan", "none.json"], 2),
    ];
    for (good, bad, code) in cases {
        desk.run(good).done();
        let names = left(&desk, "out");
        assert!(names.contains(&"trajectory.csv".to_owned()) && names.iter().all(|n| !n.starts_with('.')), "{names:?}");
        let run = desk.run(bad);
        assert_eq!((run.code, left(&desk, "out")), (code, Vec::new()), "{run:?}");
    }
}

#[test]
fn a_file_that_is_read_is_not_overwritten() {
    let desk = Desk::new("overwritten");
    let points = "x_mm,y_mm\n0,0\n10,2\n20,1\n30,5\n";
    desk.write("trajectory.csv", points);
    let refused = ["trajectory.csv", "would be overwritten", "--out"];
    desk.run(&["plan", "trajectory.csv", "--out", "."]).refused(2, &refused);
    desk.write("job.toml", "[path]\nfile = \"trajectory.csv\"\n");
    desk.run(&["plan", "--job", "job.toml", "--out", "."]).refused(2, &refused);
    assert_eq!(std::fs::read_to_string(desk.folder.join("trajectory.csv")).expect("there"), points);
}

/// Runs the command under a limit on the size of a file, which ends a write as a full disk does.
#[cfg(unix)]
fn on_a_small_disk(desk: &Desk, args: &[&str]) -> Run {
    let script = format!("trap '' XFSZ; ulimit -f 20; exec \"$0\" {}", args.join(" "));
    let output = Command::new("sh").args(["-c", &script, &binary()]).current_dir(&desk.folder).output();
    Run::new(args, output.expect("a shell"))
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_half_written_trajectory() {
    let desk = Desk::new("full_disk");
    desk.write("way.toml", "[[waypoint]]\nq_deg = 0\n[[waypoint]]\nq_deg = 40\n");
    desk.write("six.json", robot_cr7::SamplePath::SixPoint.json());
    let between = [&["move", "--from-deg"], &HOME[..], &["--to-deg"], &THERE].concat();
    let commands: [&[&str]; 5] = [&between, &["online"], &["schedule", "way.toml"], &["run"], &["plan", "six.json"]];
    for command in commands {
        let run = on_a_small_disk(&desk, command);
        run.refused(2, &["cannot be written", "the disk is not full"]);
        assert!(left(&desk, "out").is_empty(), "{command:?}: {:?}", left(&desk, "out"));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_half_written_trajectory() {
    let desk = Desk::new("interrupt");
    // Nine million rows: it is still writing when it is stopped, and had it come to the end, it would say so.
    let args = [&["move", "--from-deg"], &HOME[..], &["--to-deg"], &THERE, &["--least-s", "9000"]].concat();
    for signal in ["-INT", "-TERM"] {
        let mut child = Command::new(binary())
            .args(&args)
            .current_dir(&desk.folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the binary runs");
        while left(&desk, "out").is_empty() {
            assert!(child.try_wait().expect("a child").is_none(), "ended before it wrote");
            std::thread::sleep(Duration::from_millis(5));
        }
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("a kill command");
        assert!(sent.success());
        assert_eq!(child.wait().expect("a child").code(), Some(130), "{signal}");
        assert!(left(&desk, "out").is_empty(), "{:?}", left(&desk, "out"));
    }
}
