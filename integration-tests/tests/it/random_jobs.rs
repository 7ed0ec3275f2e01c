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

/// A piece ended beside the plan one sample before a step of the acceleration, and none was tried from there: "no piece keeps the limit:
/// jerk of joint 1 would be 2.0e7".
#[test]
fn a_piece_beside_the_plan_may_end_where_a_step_begins() {
    let outcome = random_job(451, false);
    assert!(matches!(outcome, Outcome::Done(_)), "{outcome:?}");
}
