//! What is fed, and with what.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use arcfeed_testing::{Random, most_bytes_in};

#[cfg(feature = "html")]
use super::meshes;
use super::verdict::Verdict;
use super::watchdog::MOST_BYTES;
use super::{corpus, mutation, planners, readers};

/// Where inputs come from.
#[derive(Debug, Clone, Copy)]
pub enum Inputs {
    /// Mutations of these texts.
    Mutated(fn() -> Vec<Vec<u8>>),
    /// At most so many random bytes, for [`Numbers`](super::Numbers).
    Bytes(usize),
}

/// A reader or a planner under test.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// Where its inputs come from.
    pub inputs: Inputs,
    /// Processor time that an input may take, s.
    pub seconds: f64,
    run: fn(&[u8]) -> Verdict,
}

/// The result of one input.
#[derive(Debug, Clone)]
pub struct Judged {
    /// What became of it.
    pub verdict: Verdict,
    /// Time, s.
    pub time: Duration,
    /// The most memory held, bytes, in programs whose allocator counts.
    pub bytes: usize,
}

/// A target with its texts read.
#[derive(Debug)]
pub struct Found {
    target: Target,
    seeds: Vec<Vec<u8>>,
}

const fn reader(name: &'static str, seeds: fn() -> Vec<Vec<u8>>, run: fn(&[u8]) -> Verdict) -> Target {
    Target { name, inputs: Inputs::Mutated(seeds), seconds: 1.0, run }
}

const fn planner(name: &'static str, bytes: usize, seconds: f64, run: fn(&[u8]) -> Verdict) -> Target {
    Target { name, inputs: Inputs::Bytes(bytes), seconds, run }
}

/// Everything that is fed.
pub const TARGETS: &[Target] = &[
    reader("json-path", || corpus::samples("robot-cr7/data", "json"), readers::json_path),
    reader("csv-points", corpus::csv_points, readers::csv_points),
    reader("gcode", || corpus::samples("robot-cr7/data/gcode", "ngc"), readers::gcode),
    reader("dxf", || corpus::samples("robot-cr7/data/drawings", "dxf"), readers::dxf),
    reader("svg", || corpus::samples("robot-cr7/data/drawings", "svg"), readers::svg),
    reader("job", corpus::jobs, readers::job),
    reader("scenario", corpus::scenarios, readers::scenario),
    reader("schedule", || corpus::samples("robot-cr7/schedules", "toml"), readers::schedule),
    reader("urdf", corpus::urdf, readers::urdf),
    reader("arm-json", corpus::arm_json, readers::arm_json),
    reader("trajectory-csv", corpus::trajectories, readers::trajectory_csv),
    reader("compiled-json", corpus::compiled, readers::compiled_json),
    reader("batch-line", corpus::batch_lines, readers::batch_line),
    #[cfg(feature = "controller")]
    reader("controller", readers::streams, readers::controller),
    #[cfg(feature = "html")]
    reader("stl", meshes::stl_files, meshes::stl),
    #[cfg(feature = "html")]
    reader("urdf-meshes", meshes::urdf_files, meshes::urdf),
    planner("state-to-state", 200, 1.0, planners::state_to_state),
    planner("online", 400, 1.0, planners::online),
    planner("way-points", 400, 1.0, planners::way_points),
    planner("joint-spline", 200, PLANNING, planners::joint_spline),
    planner("pose-move", 200, PLANNING, planners::pose_move),
    planner("tool-path", 300, PLANNING, planners::tool_path),
    Target { name: "job-plan", inputs: Inputs::Mutated(corpus::batch_lines), seconds: JOB, run: planners::job_plan },
];

/// Plans of paths may take so long, s.
const PLANNING: f64 = 20.0;
/// Whole jobs, s.
const JOB: f64 = 60.0;

/// The target of this name.
pub fn target(name: &str) -> Option<Target> {
    TARGETS.iter().find(|target| target.name == name).copied()
}

impl Target {
    /// Reads the texts that inputs are made from.
    pub fn find(self) -> Found {
        let seeds = match self.inputs {
            Inputs::Mutated(seeds) => {
                let mut all = seeds();
                all.extend(corpus::kept(self.name).into_iter().map(|(_, bytes)| bytes));
                all
            }
            Inputs::Bytes(_) => Vec::new(),
        };
        Found { target: self, seeds }
    }

    /// The inputs that are kept for it, with their names.
    pub fn kept(self) -> Vec<(String, Vec<u8>)> {
        corpus::kept(self.name)
    }

    /// Feeds it one input. A panic is a defect, and so is more than [`MOST_BYTES`]; a [`Watchdog`](super::Watchdog) judges the time.
    pub fn feed(self, input: &[u8]) -> Judged {
        let begin = Instant::now();
        let mut verdict = Verdict::Refused;
        let bytes = most_bytes_in(|| {
            verdict = catch_unwind(AssertUnwindSafe(|| (self.run)(input))).unwrap_or_else(|panic| {
                let words = panic.downcast_ref::<String>().map(String::as_str);
                let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without words");
                Verdict::Broken(format!("panics: {words}"))
            });
        });
        if bytes as u64 > MOST_BYTES {
            verdict = Verdict::Broken(format!("holds {bytes} bytes at once"));
        }
        Judged { verdict, time: begin.elapsed(), bytes }
    }
}

/// Seeds that follow each other give numbers that have nothing in common.
fn random(seed: u64) -> Random {
    Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15))
}

impl Found {
    /// The input that belongs to a seed.
    pub fn input(&self, seed: u64) -> Vec<u8> {
        let random = &mut random(seed);
        match self.target.inputs {
            Inputs::Mutated(_) => mutation::mutated(&self.seeds, random),
            Inputs::Bytes(most) => (0..1 + random.below(most)).map(|_| random.bits() as u8).collect(),
        }
    }

    /// A change of an input with regard to the structure of texts; none where inputs are bytes without one.
    pub fn changed(&self, input: &[u8], seed: u64) -> Option<Vec<u8>> {
        let texts = matches!(self.target.inputs, Inputs::Mutated(_)) && !self.seeds.is_empty();
        texts.then(|| mutation::changed(input.to_vec(), &self.seeds, &mut random(seed)))
    }

    /// Feeds the input that belongs to a seed.
    pub fn feed(&self, seed: u64) -> Judged {
        self.target.feed(&self.input(seed))
    }

    /// True if there is something to make inputs from.
    pub fn has_seeds(&self) -> bool {
        !self.seeds.is_empty() || matches!(self.target.inputs, Inputs::Bytes(_))
    }
}
