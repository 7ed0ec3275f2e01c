//! Arbitrary inputs for every reader and planner, as many as you like:
//!
//! ```sh
//! cargo run --release -p integration-tests --example fuzz -- --target NAME|all --count N --seed S
//! cargo run --release -p integration-tests --example fuzz -- --target all --minutes M --seed S
//! cargo run --release -p integration-tests --example fuzz -- --target NAME --replay FILE
//! ```
//!
//! Inputs are fed in a process of their own, which a watchdog ends when one takes more than the time of its target (1 s of the processor for
//! readers) or 500 MB. An input that is a defect is saved to `target/fuzz/`, ready for `--replay`, and the exit code is 1. The feature
//! `controller` adds the packets of a controller, `html` the meshes of an arm.

mod block;
mod options;
mod worker;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use arcfeed_testing::Counting;
use block::{Tally, run_block};
use integration_tests::fuzz::{Target, Verdict, Watchdog};
use options::Options;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Defects of one target after which it is left alone.
const MOST_DEFECTS: usize = 10;

fn main() -> ExitCode {
    let options = match Options::read(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(what) => {
            eprintln!("fuzz: {what}");
            return ExitCode::from(2);
        }
    };
    if options.worker {
        return worker::run(&options);
    }
    match &options.replay {
        Some(file) => replay(&options.targets, file),
        None => search(&options),
    }
}

/// Feeds the targets one file, watched as in a search.
fn replay(targets: &[Target], file: &PathBuf) -> ExitCode {
    let input = match std::fs::read(file) {
        Ok(input) => input,
        Err(error) => {
            eprintln!("fuzz: {}: {error}", file.display());
            return ExitCode::from(2);
        }
    };
    let mut broken = false;
    for target in targets {
        let name = target.name;
        let watchdog = Watchdog::new(target.seconds, move |_, why| {
            println!("{name}: {why}");
            std::process::exit(1);
        });
        watchdog.begins(0);
        let judged = target.feed(&input);
        watchdog.rests();
        broken |= matches!(judged.verdict, Verdict::Broken(_));
        println!("{name}: {:?} in {:.3} s, {} kB", judged.verdict, judged.time.as_secs_f64(), judged.bytes / 1000);
    }
    ExitCode::from(u8::from(broken))
}

/// Feeds every target until the count or the time is reached.
fn search(options: &Options) -> ExitCode {
    let begin = Instant::now();
    let mut tallies: Vec<Tally> = options.targets.iter().map(|target| Tally::new(*target)).collect();
    loop {
        let mut working = false;
        for tally in &mut tallies {
            let left = match options.minutes {
                Some(minutes) if begin.elapsed().as_secs_f64() > 60.0 * minutes => 0,
                Some(_) => u64::MAX,
                None => options.count.saturating_sub(tally.fed),
            };
            let block = left.min(block_size(tally));
            if block == 0 || tally.defects >= MOST_DEFECTS {
                continue;
            }
            working = true;
            if let Err(error) = run_block(tally, options.seed + tally.fed, block) {
                eprintln!("fuzz: {}: {error}", tally.target.name);
                return ExitCode::from(2);
            }
        }
        if !working {
            break;
        }
    }
    println!(
        "{:<16}{:>12}{:>12}{:>12}{:>9}{:>12}{:>10}",
        "target", "inputs", "accepted", "refused", "defects", "slowest ms", "most kB"
    );
    for tally in &tallies {
        println!("{tally}");
    }
    let (fed, defects) = tallies.iter().fold((0, 0), |sum, tally| (sum.0 + tally.fed, sum.1 + tally.defects));
    println!("{fed} inputs, {defects} defects, {:.0} s", begin.elapsed().as_secs_f64());
    ExitCode::from(u8::from(defects > 0))
}

/// Inputs of one process: some seconds' worth.
fn block_size(tally: &Tally) -> u64 {
    if tally.target.seconds > 1.0 { 20 } else { 10_000 }
}
