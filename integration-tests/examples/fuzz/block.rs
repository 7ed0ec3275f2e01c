//! A run of inputs in a process of their own.

use std::fmt;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};

use integration_tests::fuzz::Target;

/// What was found of one target.
pub struct Tally {
    pub target: Target,
    pub fed: u64,
    pub defects: usize,
    accepted: u64,
    refused: u64,
    slowest_us: u128,
    most_bytes: usize,
}

impl Tally {
    pub fn new(target: Target) -> Self {
        Self { target, fed: 0, defects: 0, accepted: 0, refused: 0, slowest_us: 0, most_bytes: 0 }
    }

    /// Says a defect and saves its input.
    fn defect(&mut self, seed: u64, words: &str) -> io::Result<()> {
        self.defects += 1;
        if self.defects > crate::MOST_DEFECTS {
            return Ok(());
        }
        let folder = Path::new("target/fuzz");
        std::fs::create_dir_all(folder)?;
        let file = folder.join(format!("{}-{seed}.bin", self.target.name));
        std::fs::write(&file, self.target.find().input(seed))?;
        println!("{}, seed {seed}: {words}", self.target.name);
        println!("    --target {} --replay {}", self.target.name, file.display());
        Ok(())
    }

    fn done(&mut self, line: &str) {
        let mut numbers = line.split(' ').map(|number| number.parse::<u64>().unwrap_or(0));
        let mut next = || numbers.next().unwrap_or(0);
        self.accepted += next();
        self.refused += next();
        self.slowest_us = self.slowest_us.max(next().into());
        self.most_bytes = self.most_bytes.max(next() as usize);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, slowest) = (self.target.name, self.slowest_us as f64 * 1e-3);
        let (fed, accepted, refused) = (self.fed, self.accepted, self.refused);
        write!(
            f,
            "{name:<16}{fed:>12}{accepted:>12}{refused:>12}{:>9}{slowest:>12.1}{:>10}",
            self.defects,
            self.most_bytes / 1000
        )
    }
}

/// Feeds the inputs of `count` seeds. A process that ends before is replaced by one that begins behind the input that ended it.
pub fn run_block(tally: &mut Tally, first: u64, count: u64) -> io::Result<()> {
    let end = first + count;
    let mut at = first;
    while at < end {
        let said = worker(&tally.target, at, end - at, false)?;
        let mut ended = None;
        for line in said.lines.iter() {
            let Some((word, rest)) = line.split_once(' ') else { continue };
            let (seed, words) = rest.split_once(' ').unwrap_or((rest, ""));
            match (word, seed.parse::<u64>()) {
                ("broken", Ok(seed)) => tally.defect(seed, words)?,
                ("ended", Ok(seed)) => {
                    tally.defect(seed, words)?;
                    ended = Some(seed);
                }
                ("done", _) => tally.done(rest),
                _ => {}
            }
        }
        if !said.success && ended.is_none() {
            // It was killed, by a stack that overflowed or memory that was not there: each input is said before it is fed.
            let traced = worker(&tally.target, at, end - at, true)?;
            let last = traced.lines.iter().rev().find_map(|line| line.strip_prefix("feeds ")?.parse::<u64>().ok());
            let Some(seed) = last.filter(|_| !traced.success) else {
                return Err(io::Error::other(format!("seeds {at} to {end} end the process, but not again")));
            };
            // The first process said nothing of what it had fed.
            traced.lines.iter().filter_map(|line| line.strip_prefix("done ")).for_each(|counts| tally.done(counts));
            tally.defect(seed, "ends the process")?;
            ended = Some(seed);
        }
        at = ended.map_or(end, |seed| seed + 1);
        if tally.defects >= crate::MOST_DEFECTS {
            break;
        }
    }
    tally.fed += at.min(end) - first;
    Ok(())
}

struct Said {
    lines: Vec<String>,
    success: bool,
}

fn worker(target: &Target, first: u64, count: u64, trace: bool) -> io::Result<Said> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["--worker", "--target", target.name]);
    command.args(["--seed", &first.to_string(), "--count", &count.to_string()]);
    if trace {
        command.arg("--trace");
    }
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output()?;
    let lines = String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect();
    Ok(Said { lines, success: output.status.success() })
}
