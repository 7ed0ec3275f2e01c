//! Programs of many short blocks on the CR7, with three decimals: a raster over a curved surface and a spiral.
//! `04_dense_program [BLOCKS, else 2000] [PART, else 300]`; 150000 is a program of a CAM system, and 2000 a part of it that shows the
//! other modes in a minute.
//!
//! A part of each program is planned with a stop in each block (G61.1), with blends alone (G64 P0.02 Q0), and with smooth curves
//! (G64 P0.02 Q0.01); then the whole program with smooth curves. Each motion is verified.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use robot_cr7::{Job, PathFile, Task};

const MODES: [(&str, &str); 3] =
    [("exact stop", "G61.1"), ("blends", "G64 P0.02 Q0"), ("smooth curves", "G64 P0.02 Q0.01")];
/// Length of a block, mm, and blocks in a row of the raster.
const STEP: f64 = 0.1;
const ROW: usize = 1000;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let count = |i: usize, default: usize| std::env::args().nth(i).map_or(Ok(default), |text| text.parse::<usize>());
    let (blocks, part) = (count(1, 2000)?, count(2, 300)?);
    println!(
        "| program | mode | blocks | length, mm | motion, s | mean feed, mm/s | against stops | read, planned and verified, s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, points) in [("raster", raster as fn(usize) -> [f64; 3]), ("spiral", spiral)] {
        let mut slowest = None;
        for (mode, code) in MODES {
            let mean = measure((name, mode), &program(code, part, points))?;
            let stops = *slowest.get_or_insert(mean.feed);
            mean.print((name, mode), part, stops);
        }
        let whole = measure((name, "smooth curves"), &program(MODES[2].1, blocks, points))?;
        whole.print((name, "smooth curves"), blocks, slowest.unwrap_or(whole.feed));
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().filter(|line| line.starts_with("VmHWM"));
        peak.for_each(|line| println!("largest memory: {}", line.trim_start_matches("VmHWM:").trim()));
    }
    Ok(())
}

struct Mean {
    length: f64,
    duration: f64,
    feed: f64,
    time: f64,
}

impl Mean {
    fn print(&self, (name, mode): (&str, &str), blocks: usize, stops: f64) {
        let Self { length, duration, feed, time } = self;
        println!(
            "| {name} | {mode} | {blocks} | {:.1} | {duration:.2} | {:.2} | {:.1} | {time:.2} |",
            1e3 * length,
            1e3 * feed,
            feed / stops
        );
    }
}

/// Rows of 100 mm over a surface of hills, there and back, 0.5 mm apart.
fn raster(i: usize) -> [f64; 3] {
    let (row, at) = (i / ROW, i % ROW);
    let along = STEP * at as f64 * (ROW as f64 / (ROW - 1) as f64);
    let x = if row % 2 == 0 { along } else { STEP * ROW as f64 - along };
    let y = 0.5 * row as f64;
    [x, y, 4.0 * (x / 15.0).sin() * (y / 20.0).cos()]
}

/// From 10 mm outwards, 0.5 mm for each turn.
fn spiral(i: usize) -> [f64; 3] {
    let pitch = 0.5 / std::f64::consts::TAU;
    // The length of a spiral is half the difference of the squared radii over the pitch.
    let radius = (100.0 + 2.0 * pitch * STEP * i as f64).sqrt();
    let angle = (radius - 10.0) / pitch;
    [50.0 + radius * angle.cos(), 40.0 + radius * angle.sin(), 0.0]
}

fn program(mode: &str, blocks: usize, point: fn(usize) -> [f64; 3]) -> String {
    let mut text = String::with_capacity(32 * blocks);
    let [x, y, z] = point(0);
    let _ = writeln!(text, "G21 G90 {mode}\nG0 X{x:.3} Y{y:.3} Z{z:.3}\nF6000");
    for i in 1..=blocks {
        let [x, y, z] = point(i);
        let _ = writeln!(text, "G1 X{x:.3} Y{y:.3} Z{z:.3}");
    }
    text
}

fn measure((name, mode): (&str, &str), program: &str) -> Result<Mean, Failure> {
    let begin = Instant::now();
    let file = PathFile::from_bytes(program.as_bytes(), Path::new("program.ngc"), None)?;
    let job = Job::from_bytes(JOB.as_bytes(), Path::new("job.toml"))?;
    let task = Task::of_cr7(&job, &file)?;
    let motion = task.plan()?;
    let plan = motion.trajectory();
    let (length, duration) = (task.path().length(), plan.duration());
    eprintln!(
        "{name}, {mode}: {} intervals, {} rounds, {:?}",
        plan.info().intervals,
        plan.info().rounds,
        plan.timings()
    );
    Ok(Mean { length, duration, feed: length / duration, time: begin.elapsed().as_secs_f64() })
}

const JOB: &str = "[workpiece]\nposition_mm = [380, -50, 200]\n[orientation]\nrpy_deg = [180, 0, 0]\n";
