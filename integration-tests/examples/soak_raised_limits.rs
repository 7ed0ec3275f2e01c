//! Random motions before and after one limit is raised, as many as you like: `soak_raised_limits [COUNT, else 4] [FIRST SEED]`.
//!
//! A motion that gets longer by more than 0.1 % is printed with its seed; `soak_raised_limits 1 SEED` plans it again.

use std::time::Instant;

use integration_tests::raised_limits::RaisedLimit;

/// A duration may grow by so much of itself.
const LONGER: f64 = 1e-3;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(4);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let begin = Instant::now();
    let (mut refused, mut failed, mut longer, mut worst) = (0, 0, 0, f64::NEG_INFINITY);
    for seed in first..first + count {
        let case = RaisedLimit::random(seed);
        let [before, after] = match case.durations() {
            Some(Ok(durations)) => durations,
            Some(Err(error)) => {
                failed += 1;
                println!("seed {seed}: {error}\n{case:?}");
                continue;
            }
            None => {
                refused += 1;
                continue;
            }
        };
        let growth = after / before - 1.0;
        worst = worst.max(growth);
        if growth > LONGER {
            longer += 1;
            println!("seed {seed}: {before:.6} s, then {after:.6} s, {:.3} % longer\n{case:?}", 100.0 * growth);
        }
    }
    println!(
        "{} planned twice, {refused} refused, {failed} failed, {longer} longer by more than {:.1} %, worst {:.4} %; {:.0} s",
        count - refused - failed,
        100.0 * LONGER,
        100.0 * worst,
        begin.elapsed().as_secs_f64()
    );
    if longer + failed > 0 {
        std::process::exit(1);
    }
}
