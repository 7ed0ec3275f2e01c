//! Random jobs, planned, compiled and certified: `soak_jobs [COUNT, else 10] [FIRST SEED] [BOUND EVERY, else 10; 0 for never]`.
//!
//! What must not be is printed with its seed; `soak_jobs 1 SEED 1` does it again. The gap is that between the duration and a lower bound
//! of all motions under the same limits, on every so many jobs.

use std::time::Instant;

use integration_tests::random_jobs::{Outcome, random_job};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let count = arguments.next().and_then(Result::ok).unwrap_or(10);
    let first = arguments.next().and_then(Result::ok).unwrap_or(0);
    let every = arguments.next().and_then(Result::ok).unwrap_or(10);
    let begin = Instant::now();
    let (mut done, mut without, mut failed, mut back, mut worst_ratio) = (0, 0, 0, 0, 0.0f64);
    let mut gaps: Vec<(f64, u64)> = Vec::new();
    for seed in first..first + count {
        match random_job(seed, every > 0 && seed % every == 0) {
            Outcome::Done(job) => {
                done += 1;
                if let Some(why) = &job.fallback {
                    back += 1;
                    println!("seed {seed}: {:.6} s; {why}", job.duration);
                }
                worst_ratio = worst_ratio.max(job.ratio);
                gaps.extend(job.gap.map(|gap| (gap, seed)));
            }
            Outcome::NoPath(_) => without += 1,
            Outcome::Failed(what) => {
                failed += 1;
                println!("seed {seed}: {what}");
            }
        }
    }
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    println!(
        "{done} planned, compiled and certified ({back} not by the jerk-limited planner), worst certified ratio {worst_ratio:.9}; \
         {without} paths that the arm cannot follow; {failed} failed; {:.0} s",
        begin.elapsed().as_secs_f64()
    );
    if let (Some(middle), Some((worst, seed))) = (gaps.get(gaps.len() / 2), gaps.last()) {
        println!(
            "gap to the lower bound of {} jobs: median {:.3} %, worst {:.3} % (seed {seed})",
            gaps.len(),
            100.0 * middle.0,
            100.0 * worst
        );
    }
    if failed > 0 {
        std::process::exit(1);
    }
}
