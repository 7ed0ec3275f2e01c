//! Random scenarios of motion in both spaces, as many as you like: `soak_hybrid [SCENARIOS, else 40] [FIRST SEED]`.
//!
//! Five scenarios share a stage (arm, path, limits). A failing one is printed with its seeds; `cargo run --release -p integration-tests
//! --example soak_hybrid -- 1 SEED` plays it again.

use std::time::Instant;

use arcfeed_testing::Counting;
use integration_tests::hybrid_scenario::{Stage, arms};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(40);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let begin = Instant::now();
    let (mut played, mut refused, mut failed, mut cycles, mut left, mut worst) =
        (0_u64, 0_u64, 0_u64, 0, 0_u64, 0.0_f64);
    let arms = arms();
    let mut stage: Option<(u64, Option<Stage<'_>>)> = None;
    for seed in first..first + count {
        if stage.as_ref().is_none_or(|(of, _)| *of != seed / 5) {
            stage = Some((seed / 5, Stage::random(&arms, seed / 5)));
        }
        let Some((_, Some(ready))) = &stage else {
            refused += 1;
            continue;
        };
        match ready.play(seed, Counting::count) {
            Ok(result) => {
                played += 1;
                cycles += result.cycles;
                left += u64::from(result.left_path);
                worst = worst.max(result.worst);
            }
            Err(what) => {
                failed += 1;
                println!("seed {seed} (stage {}): {what}", seed / 5);
            }
        }
        if (seed - first) % 500 == 499 {
            println!("{} scenarios, {failed} failed, {:.0} s", seed - first + 1, begin.elapsed().as_secs_f64());
        }
    }
    println!(
        "{played} played ({left} left the path), {refused} on paths the arm cannot follow, {failed} failed; {cycles} cycles, worst ratio {worst:.9}, {:.0} s",
        begin.elapsed().as_secs_f64()
    );
    if failed > 0 {
        std::process::exit(1);
    }
}
