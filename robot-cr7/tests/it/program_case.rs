//! Programs that a test writes itself, and what their trajectory has to be: by the numbers of the files alone, with the lines of the
//! program, a chain of frames from the description of the arm, and differences.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use robot_cr7::{ACCELERATION, JERK, Robot, TrajectoryRow, VELOCITY};
use serde_json::Value;

use crate::common::Desk;
use crate::keeps::{Limits, broken};

/// Where the workpiece stands, mm.
const ORIGIN: [f64; 3] = [380.0, -80.0, 200.0];
/// The tool is as near to its path as this, mm: the tolerance of the verification.
const ON_PATH: f64 = 1.1e-3;

/// One move of a program, mm and mm/s.
#[derive(Debug, Clone)]
pub struct Step {
    pub line: usize,
    pub from: Vector3<f64>,
    pub to: Vector3<f64>,
    /// None for a rapid move.
    pub feed: Option<f64>,
}

/// A dwell of a program.
#[derive(Debug, Clone)]
pub struct Rest {
    pub line: usize,
    pub seconds: f64,
    /// Where the tool is, and how many steps are done.
    pub at: Vector3<f64>,
    pub after: usize,
}

/// A program with what it says.
#[derive(Debug, Clone, Default)]
pub struct Script {
    pub text: String,
    line: usize,
    at: Vector3<f64>,
    pub steps: Vec<Step>,
    pub rests: Vec<Rest>,
    /// Tolerance of blends, mm.
    pub blend: f64,
    /// Distance within which joint moves pass the ends of their lines, mm.
    pub ends: f64,
}

impl Script {
    /// A program that begins with a rapid move to a point (mm), blends within `blend` (mm) or goes exactly through its points.
    pub fn new(start: [f64; 3], blend: f64) -> Self {
        let mut script = Self { blend, ends: 1.0, ..Self::default() };
        let mode = if blend > 0.0 { format!("G64 P{blend}") } else { "G61".to_owned() };
        script.say(&format!("G21 G90 {mode}"));
        script.at = start.into();
        script.say(&format!("G0 X{} Y{} Z{}", start[0], start[1], start[2]));
        script
    }

    pub fn say(&mut self, text: &str) {
        self.text += &format!("{text}\n");
        self.line += 1;
    }

    /// A rapid move, or a line at a feed (mm/s).
    pub fn to(&mut self, point: [f64; 3], feed: Option<f64>) {
        let [x, y, z] = point;
        self.say(&match feed {
            None => format!("G0 X{x} Y{y} Z{z}"),
            Some(feed) => format!("G1 X{x} Y{y} Z{z} F{}", feed * 60.0),
        });
        let (from, to) = (self.at, Vector3::from(point));
        self.steps.push(Step { line: self.line, from, to, feed });
        self.at = to;
    }

    pub fn rest(&mut self, seconds: f64) {
        self.say(&format!("G4 P{seconds}"));
        self.rests.push(Rest { line: self.line, seconds, at: self.at, after: self.steps.len() });
    }

    fn step(&self, line: usize) -> &Step {
        self.steps.iter().find(|step| step.line == line).unwrap_or_else(|| panic!("line {line} is no move"))
    }
}

/// A planned program.
pub struct Planned {
    pub report: Value,
    pub rows: Vec<TrajectoryRow>,
    /// Tool points in the frame of the workpiece, mm, by the frames of the arm.
    pub points: Vec<Vector3<f64>>,
    pub lines: Vec<Line>,
}

/// A row of lines.csv.
#[derive(Debug, Clone)]
pub struct Line {
    /// First and last line of the program.
    pub lines: [usize; 2],
    pub t: [f64; 2],
}

/// Plans a script with `job` added to the place of the workpiece.
pub fn planned(desk: &Desk, script: &Script, job: &str) -> Planned {
    desk.write("p.ngc", &script.text);
    let [x, y, z] = ORIGIN;
    desk.write("job.toml", &format!("[workpiece]\nposition_mm = [{x}, {y}, {z}]\n{job}"));
    let report = desk.run(&["plan", "p.ngc", "--job", "job.toml", "--json"]).done().json();
    read(desk, report)
}

/// What a run has written.
pub fn read(desk: &Desk, report: Value) -> Planned {
    let rows = desk.trajectory::<6>("out");
    let robot = Robot::load("cr7", None, None).expect("built in");
    let points = rows.iter().map(|row| tool(&robot, &row.q).translation.vector * 1e3 - Vector3::from(ORIGIN)).collect();
    let table = std::fs::read_to_string(desk.folder.join("out/lines.csv")).expect("written");
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let line = |row: &str| {
        let cells: Vec<&str> = row.split(',').collect();
        let (first, last) = cells[0].split_once('-').unwrap_or((cells[0], cells[0]));
        let lines = [first, last].map(|line| line.parse().expect("a line"));
        Line { lines, t: [number(cells[4]), number(cells[5])] }
    };
    Planned { report, rows, points, lines: table.lines().skip(1).map(line).collect() }
}

/// The tool by the frames of the arm, one after the other.
fn tool(robot: &Robot, q: &[f64; 6]) -> Isometry3<f64> {
    let arm = robot.description();
    let mut pose = arm.base;
    for (joint, &q) in arm.joints.iter().zip(q) {
        let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(joint.axis), q);
        pose = pose * joint.origin * Isometry3::from_parts(Translation3::identity(), turn);
    }
    pose * arm.flange
}

/// Distance from a straight line, mm.
fn off(point: &Vector3<f64>, step: &Step) -> f64 {
    let along = step.to - step.from;
    let part = ((point - step.from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (point - step.from - along * part).norm()
}

impl Planned {
    pub fn duration(&self) -> f64 {
        self.report["duration_s"].as_f64().expect("a number")
    }

    pub fn parts(&self, kind: &str) -> Vec<&Value> {
        let parts = self.report["parts"].as_array().map_or(&[] as &[Value], Vec::as_slice);
        parts.iter().filter(|part| part["kind"] == kind).collect()
    }

    /// The tool at a time, mm, on the straight line between two samples.
    pub fn at(&self, t: f64) -> Vector3<f64> {
        let i = self.rows.partition_point(|row| row.t < t).clamp(1, self.rows.len() - 1);
        let (a, b) = (self.rows[i - 1].t, self.rows[i].t);
        self.points[i - 1] + (self.points[i] - self.points[i - 1]) * ((t - a) / (b - a)).clamp(0.0, 1.0)
    }

    /// Holds everything that is asked of any program. `rapid` is the highest speed of rapid moves, mm/s, or none for joint moves.
    pub fn keeps(&self, script: &Script, rapid: Option<f64>, period: f64) {
        self.keeps_limits(period);
        self.keeps_lines(script, rapid);
        self.rests(script, period);
        self.keeps_times(script);
        if rapid.is_none() {
            self.passes_ends(script);
        }
        let (last, end) = (self.points[self.points.len() - 1], script.steps[script.steps.len() - 1].to);
        assert!((last - end).norm() < ON_PATH, "the motion ends {} mm beside the end", (last - end).norm());
    }

    /// One grid of control periods, and the limits of the joints by differences.
    fn keeps_limits(&self, period: f64) {
        let (range, _) = Robot::load("cr7", None, None).and_then(|r| r.limits::<6>(&Default::default())).expect("cr7");
        let limits = Limits {
            velocity: [VELOCITY; 6],
            acceleration: [ACCELERATION; 6],
            jerk: [JERK; 6],
            range: std::array::from_fn(|k| [range.lower()[k] - 1e-9, range.upper()[k] + 1e-9]),
            linear: f64::INFINITY,
            angular: f64::INFINITY,
        };
        assert_eq!(broken(&self.rows, &limits), None);
        let last = self.rows.len() - 1;
        for (i, row) in self.rows[..last].iter().enumerate() {
            assert!((row.t - i as f64 * period).abs() < 1e-9 * (1.0 + row.t), "row {i} at {} s", row.t);
        }
        assert!((self.rows[last].t - self.duration()).abs() < 1e-12);
        for row in [&self.rows[0], &self.rows[last]] {
            assert!(row.qd.iter().chain(&row.qdd).all(|v| v.abs() < 1e-9), "not at rest at {} s", row.t);
        }
        for (row, point) in self.rows.iter().zip(&self.points) {
            let stated = Vector3::from(row.position) * 1e3 - Vector3::from(ORIGIN);
            assert!((stated - point).norm() < 1e-6, "the tool point of the file is off at {} s", row.t);
        }
    }

    /// The tool is on its lines, and no faster than they say.
    fn keeps_lines(&self, script: &Script, rapid: Option<f64>) {
        for line in &self.lines {
            let steps: Vec<&Step> = (line.lines[0]..=line.lines[1]).map(|line| script.step(line)).collect();
            let slowest = |least: f64, step: &&Step| Some(least.min(step.feed.or(rapid)?));
            let Some(feed) = steps.iter().try_fold(f64::INFINITY, slowest) else { continue };
            let inside = |t: f64| t >= line.t[0] && t <= line.t[1];
            let places: Vec<usize> = (0..self.rows.len()).filter(|&i| inside(self.rows[i].t)).collect();
            for &i in &places {
                let off = steps.iter().map(|step| off(&self.points[i], step)).fold(f64::INFINITY, f64::min);
                assert!(off <= script.blend + ON_PATH, "{off} mm off line {:?} at {} s", line.lines, self.rows[i].t);
            }
            for pair in places.windows(2) {
                let way = (self.points[pair[1]] - self.points[pair[0]]).norm();
                let speed = way / (self.rows[pair[1]].t - self.rows[pair[0]].t);
                // A short last step has few digits.
                let digits = 1e-9 / (self.rows[pair[1]].t - self.rows[pair[0]].t);
                assert!(speed <= feed * (1.0 + 1e-6) + digits, "{speed} mm/s of {feed} in line {:?}", line.lines);
            }
        }
    }

    /// The arm stands still where the program says so, and as long.
    fn rests(&self, script: &Script, period: f64) {
        let parts = self.parts("dwell");
        assert_eq!(parts.len(), script.rests.len());
        for (rest, part) in script.rests.iter().zip(parts) {
            let [begin, seconds] = ["begin_s", "duration_s"].map(|key| part[key].as_f64().expect("a number"));
            assert_eq!((part["lines"][0].as_u64(), seconds), (Some(rest.line as u64), rest.seconds));
            let during = self.rows.iter().zip(&self.points).filter(|(row, _)| row.t > begin && row.t < begin + seconds);
            let during: Vec<_> = during.collect();
            assert!(during.len() as f64 >= seconds / period - 2.0, "{} samples of {seconds} s", during.len());
            for (row, point) in &during {
                assert!(row.q == during[0].0.q && row.qd == [0.0; 6] && row.qdd == [0.0; 6], "moves at {} s", row.t);
                assert!((*point - rest.at).norm() < ON_PATH, "waits {} mm beside its place", (*point - rest.at).norm());
            }
            let mark = self.report["program"]["markers"].as_array().expect("a list").iter();
            let mark = mark.clone().find(|mark| mark["line"] == rest.line as u64).expect("a mark");
            assert!((mark["t_s"].as_f64().expect("a time") - begin).abs() < 1e-9, "{mark}");
        }
    }

    /// The times of the lines follow one another, with the dwells between them, and the tool is where they end.
    fn keeps_times(&self, script: &Script) {
        let waits = |after: usize, before: usize| -> f64 {
            let done = |line: usize| script.steps.iter().position(|step| step.line == line).expect("a move");
            let between = |rest: &&Rest| rest.after > done(after) && rest.after <= done(before);
            script.rests.iter().filter(between).map(|rest| rest.seconds).sum()
        };
        for pair in self.lines.windows(2) {
            let wait = pair[1].t[0] - pair[0].t[1];
            // A blend has no dwell in it.
            let planned =
                if pair[0].lines[1] == pair[1].lines[0] { 0.0 } else { waits(pair[0].lines[1], pair[1].lines[0]) };
            assert!((wait - planned).abs() < 1e-9, "{wait} s between {pair:?}, {planned} s planned");
        }
        let mut seen = vec![false; script.steps.len()];
        for line in &self.lines {
            let (i, step) = script.steps.iter().enumerate().find(|(_, s)| s.line == line.lines[1]).expect("a move");
            seen[i] = true;
            let exact = script.blend == 0.0 && step.feed.is_some();
            if exact && line.lines[0] == line.lines[1] {
                let off = (self.at(line.t[1]) - step.to).norm();
                assert!(off < 3e-3, "{off} mm from the end of line {} at {} s", step.line, line.t[1]);
            }
        }
        // Short lines between two blends may have no row of their own.
        assert!(script.blend > 0.0 || seen.iter().all(|seen| *seen), "a line has no time");
    }

    /// Joint moves pass the ends of their lines as near as is said, and leave the lines as far as is said.
    fn passes_ends(&self, script: &Script) {
        for part in self.parts("joints") {
            let number = |key: &str| part[key].as_f64().expect("a number");
            let range = [0, 1].map(|i| part["lines"][i].as_u64().expect("a line") as usize);
            let stated = number("passes_ends_m") * 1e3;
            assert!(stated <= script.ends * (1.0 + 1e-9), "{stated} mm from an end of {range:?}");
            let steps: Vec<&Step> = script
                .steps
                .iter()
                .filter(|step| (range[0]..=range[1]).contains(&step.line) && step.feed.is_none())
                .collect();
            let (mut farthest, mut passed) = (0.0f64, 0.0f64);
            for (k, step) in steps.iter().enumerate() {
                let line = self.lines.iter().find(|line| line.lines == [step.line; 2]).expect("a row");
                let missed = (self.at(line.t[1]) - step.to).norm();
                assert!(missed <= script.ends + 5e-3, "{missed} mm from the end of line {}", step.line);
                passed = passed.max(self.nearest(&step.to, line, steps.get(k + 1)));
                let beside = &steps[k.saturating_sub(1)..(k + 2).min(steps.len())];
                for (row, point) in self.rows.iter().zip(&self.points) {
                    if row.t >= line.t[0] && row.t <= line.t[1] {
                        let off = beside.iter().map(|step| off(point, step)).fold(f64::INFINITY, f64::min);
                        farthest = farthest.max(off);
                    }
                }
            }
            assert!(
                (passed - stated).abs() < 0.05 * stated + 0.03,
                "{passed} mm from an end of {range:?}, stated {stated}"
            );
            let leaves = number("leaves_lines_m") * 1e3;
            assert!(farthest <= leaves + 2e-3, "{farthest} mm beside the lines {range:?}, stated {leaves}");
            assert!(farthest >= 0.9 * leaves - 0.05, "{farthest} mm beside the lines {range:?}, stated {leaves}");
        }
    }

    /// How near the tool comes to a point on a line or on the one after it, mm.
    fn nearest(&self, point: &Vector3<f64>, line: &Line, next: Option<&&Step>) -> f64 {
        let next = next.and_then(|step| self.lines.iter().find(|line| line.lines == [step.line; 2]));
        let until = next.map_or(line.t[1], |line| line.t[1]);
        let inside = |i: usize| self.rows[i + 1].t >= line.t[0] && self.rows[i].t <= until;
        let piece = |i: usize| Step { line: 0, from: self.points[i], to: self.points[i + 1], feed: None };
        let pieces = (0..self.rows.len() - 1).filter(|&i| inside(i)).map(piece);
        pieces.filter(|piece| piece.from != piece.to).map(|piece| off(point, &piece)).fold(f64::INFINITY, f64::min)
    }
}
