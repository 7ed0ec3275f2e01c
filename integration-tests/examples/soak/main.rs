//! Random families in turn, as long as you like: jobs, compiled motions, polylines, tight bends, raised limits, motions in both spaces, the
//! inverse, and every target of `fuzz`. The soaks of single crates, of the controller and of many jobs have examples of their own, which
//! `CONTRIBUTING.md` lists.
//!
//! ```sh
//! cargo run --release -p integration-tests --example soak -- --minutes 60 --seed 1
//! cargo run --release -p integration-tests --example soak -- --family hybrid --count 1000 --seed 1
//! ```
//!
//! Each family gets the same part of the time, and one case at least. What must not be is printed with its family and its seed;
//! `--family NAME --seed S --count 1` plays it again. One report stands at the end, and the exit code is 1 if something failed or a family
//! played nothing. `--threads N` plays N seeds at a time.

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
    /// Largest part of a limit that was used, where the family tells it.
    used: f64,
    played: u64,
    done: u64,
    refused: u64,
    failed: u64,
    time: Duration,
}

const HELP: &str = "soak: plays families of random cases in turn and reports every failure

  --minutes N     minutes in all, the same part for each family (default 0.2)
  --count N       number of cases of each family, in place of a time
  --seed S        the first seed (default 1)
  --family NAME   only this family
  --threads N     number of cases at a time (default 1)

Progress goes to standard error, the report to standard output. The exit code is 1 if a case
failed or a family played none, and 2 for a wrong option.";

fn main() -> ExitCode {
    let options = match options() {
        Ok(Some(options)) => options,
        Ok(None) => {
            println!("{HELP}\n\nfamilies: {}", names().join(", "));
            return ExitCode::SUCCESS;
        }
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
            scope.spawn(move || play(options, thread, totals));
        }
    });
    let totals = totals.into_inner().unwrap_or_default();
    if totals.is_empty() {
        eprintln!("soak: no such family; choose one of {}", names().join(", "));
        return ExitCode::from(2);
    }
    println!(
        "{:<16}{:>12}{:>12}{:>12}{:>8}{:>8}{:>14}",
        "family", "cases", "done", "refused", "failed", "s", "worst ratio"
    );
    for (name, t) in &totals {
        let (seconds, used) = (t.time.as_secs(), if t.used > 0.0 { format!("{:.9}", t.used) } else { String::new() });
        println!("{name:<16}{:>12}{:>12}{:>12}{:>8}{seconds:>8}{used:>14}", t.played, t.done, t.refused, t.failed);
        if t.played == 0 {
            println!("{name} played nothing");
        }
    }
    let (played, failed) = totals.iter().fold((0, 0), |sum, (_, t)| (sum.0 + t.played, sum.1 + t.failed));
    println!("{played} cases, {failed} failed, {:.0} s, {} threads", begin.elapsed().as_secs_f64(), options.threads);
    let idle = totals.iter().any(|(_, t)| t.played == 0);
    ExitCode::from(u8::from(failed > 0 || idle))
}

/// The names of all families.
fn names() -> Vec<&'static str> {
    families::all(&arms(), &models::ur5e()).iter().map(|family| family.name).collect()
}

/// Every family in turn, with every so many seeds from the first one of this thread on.
fn play(options: &Options, thread: u64, totals: &Mutex<Vec<(&'static str, Tally)>>) {
    let (arms, six) = (arms(), models::ur5e());
    let mut families = families::all(&arms, &six);
    families.retain(|family| options.family.as_ref().is_none_or(|name| name == family.name));
    let share = 60.0 * options.minutes / families.len().max(1) as f64;
    let mut tallies = vec![Tally::default(); families.len()];
    for (family, tally) in families.iter_mut().zip(&mut tallies) {
        let begin = Instant::now();
        loop {
            let number = tally.played * options.threads + thread;
            let over = match options.count {
                Some(count) => number >= count,
                None => tally.played > 0 && begin.elapsed().as_secs_f64() > share,
            };
            if over {
                break;
            }
            let seed = options.seed + number;
            match family.play(seed) {
                Outcome::Done => tally.done += 1,
                Outcome::Used(part) => (tally.done, tally.used) = (tally.done + 1, tally.used.max(part)),
                Outcome::Refused => tally.refused += 1,
                Outcome::Failed(what) => {
                    tally.failed += 1;
                    println!("{}, seed {seed}: {what}", family.name);
                }
            }
            tally.played += 1;
        }
        tally.time = begin.elapsed();
        eprintln!("{}, thread {thread}: {} cases, {} failed", family.name, tally.played, tally.failed);
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
            used: sum.used.max(t.used),
        };
    }
}

/// The options; none where help is asked for.
fn options() -> Result<Option<Options>, String> {
    let mut options = Options { seed: 1, count: None, minutes: 0.2, family: None, threads: 1 };
    let mut arguments = std::env::args().skip(1);
    while let Some(flag) = arguments.next() {
        if flag == "--help" || flag == "-h" {
            return Ok(None);
        }
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
    Ok(Some(options))
}
