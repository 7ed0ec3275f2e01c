//! All random families in turn, as long as you like:
//!
//! ```sh
//! cargo run --release -p integration-tests --example soak -- --minutes 60 --seed 1
//! cargo run --release -p integration-tests --example soak -- --family hybrid --count 1000 --seed 1
//! ```
//!
//! Each family gets the same time, in slices. What must not be is printed with its family and its seed; `--family NAME --seed S --count 1`
//! plays it again. One report stands at the end, and the exit code is 1 if something failed. `--threads N` plays N seeds at a time.

mod compiled;
mod families;
mod family;

use std::process::ExitCode;
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use arcfeed_kinematics::models;
use arcfeed_testing::Counting;
use family::Outcome;
use integration_tests::hybrid_scenario::arms;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Time of one family before the next one has its turn.
const SLICE: Duration = Duration::from_secs(5);

struct Options {
    seed: u64,
    count: Option<u64>,
    minutes: f64,
    family: Option<String>,
    threads: u64,
}

/// The count of each end of a family, and the time it took.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    played: u64,
    done: u64,
    refused: u64,
    failed: u64,
    time: Duration,
}

fn main() -> ExitCode {
    let options = match options() {
        Ok(options) => options,
        Err(what) => {
            eprintln!("soak: {what}");
            return ExitCode::from(2);
        }
    };
    let begin = Instant::now();
    let totals: Mutex<Vec<(&'static str, Tally)>> = Mutex::default();
    thread::scope(|scope| {
        for thread in 0..options.threads {
            let (options, totals) = (&options, &totals);
            scope.spawn(move || play(options, thread, begin, totals));
        }
    });
    let totals = totals.into_inner().unwrap_or_default();
    if totals.is_empty() {
        eprintln!("soak: no such family");
        return ExitCode::from(2);
    }
    println!("{:<16}{:>12}{:>12}{:>12}{:>8}{:>8}", "family", "cases", "done", "refused", "failed", "s");
    for (name, t) in &totals {
        let seconds = t.time.as_secs();
        println!("{name:<16}{:>12}{:>12}{:>12}{:>8}{seconds:>8}", t.played, t.done, t.refused, t.failed);
    }
    let (played, failed) = totals.iter().fold((0, 0), |sum, (_, t)| (sum.0 + t.played, sum.1 + t.failed));
    println!("{played} cases, {failed} failed, {:.0} s, {} threads", begin.elapsed().as_secs_f64(), options.threads);
    ExitCode::from(u8::from(failed > 0))
}

/// Every family in turn, with every so many seeds from the first one of this thread on.
fn play(options: &Options, thread: u64, begin: Instant, totals: &Mutex<Vec<(&'static str, Tally)>>) {
    let (arms, six) = (arms(), models::ur5e());
    let mut families = families::all(&arms, &six);
    families.retain(|family| options.family.as_ref().is_none_or(|name| name == family.name));
    let mut tallies = vec![Tally::default(); families.len()];
    loop {
        let mut working = false;
        for (family, tally) in families.iter_mut().zip(&mut tallies) {
            let slice = Instant::now();
            loop {
                let number = tally.played * options.threads + thread;
                let over = match options.count {
                    Some(count) => number >= count,
                    None => begin.elapsed().as_secs_f64() > 60.0 * options.minutes,
                };
                if over {
                    break;
                }
                working = true;
                let seed = options.seed + number;
                match (family.play)(seed) {
                    Outcome::Done => tally.done += 1,
                    Outcome::Refused => tally.refused += 1,
                    Outcome::Failed(what) => {
                        tally.failed += 1;
                        println!("{}, seed {seed}: {what}", family.name);
                    }
                }
                tally.played += 1;
                if slice.elapsed() > SLICE {
                    break;
                }
            }
            tally.time += slice.elapsed();
        }
        if !working {
            break;
        }
    }
    let Ok(mut totals) = totals.lock() else { return };
    if totals.is_empty() {
        totals.extend(families.iter().map(|family| (family.name, Tally::default())));
    }
    for ((_, sum), t) in totals.iter_mut().zip(&tallies) {
        *sum = Tally {
            played: sum.played + t.played,
            done: sum.done + t.done,
            refused: sum.refused + t.refused,
            failed: sum.failed + t.failed,
            time: sum.time + t.time,
        };
    }
}

fn options() -> Result<Options, String> {
    let mut options = Options { seed: 1, count: None, minutes: 0.2, family: None, threads: 1 };
    let mut arguments = std::env::args().skip(1);
    while let Some(flag) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{flag} needs a value"))?;
        let wrong = || format!("{flag} {value}: give a number");
        match flag.as_str() {
            "--seed" => options.seed = value.parse().map_err(|_| wrong())?,
            "--count" => options.count = Some(value.parse().map_err(|_| wrong())?),
            "--minutes" => options.minutes = value.parse().map_err(|_| wrong())?,
            "--threads" => options.threads = value.parse::<u64>().map_err(|_| wrong())?.clamp(1, 64),
            "--family" => options.family = Some(value),
            _ => return Err(format!("no option {flag}: --minutes, --count, --seed, --family, --threads")),
        }
    }
    Ok(options)
}
