//! Random paths with places that are nearly a corner, as many as you like: `soak_tight_bends [PATHS, else 100] [FIRST SEED]`.
//!
//! A failing one is printed with its seed and its path; `soak_tight_bends 1 SEED` plans it again.

use std::time::Instant;

use integration_tests::tight_bends::{Outcome, TightBend};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(10);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let begin = Instant::now();
    let (mut planned, mut refused, mut out_of_reach, mut failed) = (0, 0, 0, 0);
    for seed in first..first + count {
        let path = TightBend::random(seed);
        match path.play() {
            Ok(Outcome::Planned) => planned += 1,
            Ok(Outcome::Refused) => refused += 1,
            Ok(Outcome::OutOfReach) => out_of_reach += 1,
            Err(what) => {
                failed += 1;
                println!("seed {seed}: {what}\n{path:?}\n{}", path.path_file());
            }
        }
    }
    println!(
        "{planned} planned, {refused} refused with a reason, {out_of_reach} out of reach, {failed} failed; {:.0} s",
        begin.elapsed().as_secs_f64()
    );
    if failed > 0 {
        std::process::exit(1);
    }
}
