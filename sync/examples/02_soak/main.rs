//! Random motions by seed, judged sample by sample and phase by phase: `02_soak [FAMILY] [COUNT] [SEED] [THREADS]`.
//!
//! | family | one case | counted |
//! |---|---|---|
//! | `states` | one axis from state to state, in a longer duration, mirrored, reversed; four axes together | cases |
//! | `generator` | some thousand cycles in one mode, with targets, limits and ranges that change | cycles |
//! | `projection` | some thousand cycles towards a target that changes | cycles |
//! | `interrupts` | some thousand cycles with stops, jogs, holds and scales of time | cycles |
//! | `routes` | the same, and routes through way-points, from any state of motion | cycles |
//! | `changes` | the same, and other limits and ranges, while time is scaled, too | cycles |
//! | `way_points` | four axes through 1 to 64 points, from any state to any other | cases |
//! | `lines` | four axes along straight lines with blends, some sections free, from any state of motion | cases |
//! | `ranges` | one axis from state to state inside a range of positions, in a longer duration; three axes together | cases |
//!
//! Every case has a seed of its own. What fails is printed with the command that plays it alone, and with its input as code.
mod soak;

use soak::{FAMILIES, Tally, play};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "states".to_owned());
    let Some(family) = FAMILIES.iter().find(|f| f.name == name) else {
        let names: Vec<&str> = FAMILIES.iter().map(|f| f.name).collect();
        return Err(format!("there is no family {name}: choose one of {}", names.join(", ")).into());
    };
    let numbers: Vec<u64> = arguments.map(|x| x.parse()).collect::<Result<_, _>>()?;
    let count = numbers.first().copied().unwrap_or(20_000);
    let seed = numbers.get(1).copied().unwrap_or(1);
    let threads = numbers.get(2).copied().unwrap_or(2).max(1);
    let clock = std::time::Instant::now();
    let tally = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|k| scope.spawn(move || play(family, count.div_ceil(threads), seed.wrapping_add(k), threads)))
            .collect();
        let mut all = Tally::default();
        for worker in workers {
            match worker.join() {
                Ok(tally) => all.add(tally),
                Err(_) => all.panicked += 1,
            }
        }
        all
    });
    println!("{name}: {} of seed {seed} on {threads} threads in {:.1} s", tally.counted, clock.elapsed().as_secs_f64());
    for (what, count) in &tally.facts {
        println!("  {count:>10} x {what}");
    }
    if tally.failures.is_empty() && tally.panicked == 0 {
        println!("no failure");
        return Ok(());
    }
    for (kind, (count, failure)) in &tally.failures {
        println!("{count} x {kind}, worst {:e}\n  play it again: 02_soak {name} 1 {} 1", failure.size, failure.seed);
        println!("{}", failure.input);
    }
    Err(format!("{} kinds of failure, {} panics", tally.failures.len(), tally.panicked).into())
}
