//! A few random jobs; `soak_jobs` does as many as you like.

use integration_tests::random_jobs::{Outcome, random_job};

#[test]
fn random_jobs_are_planned_and_certified_or_refused_for_their_path() {
    let mut done = 0;
    for seed in 0..12 {
        match random_job(seed, false) {
            Outcome::Done(job) => {
                assert!(job.duration > 0.0 && job.ratio <= 1.0 + 1e-6, "seed {seed}: {job:?}");
                done += 1;
            }
            Outcome::NoPath(_) => {}
            Outcome::Failed(what) => panic!("seed {seed}: {what}"),
        }
    }
    assert!(done >= 6, "{done} of 12 planned");
}
