//! No limit that is raised makes a motion longer: see `integration_tests::raised_limits`; the example `soak` plans as
//! many as you like.

use arcfeed_testing::cases;
use integration_tests::raised_limits::RaisedLimit;

/// A duration may grow by so much of itself when a limit is raised: the grid depends on the limits.
const LONGER: f64 = 1e-3;

#[test]
fn a_raised_limit_never_makes_a_random_motion_longer() {
    let mut planned = 0;
    let seeds = cases(8);
    for seed in seeds.clone() {
        let Some(durations) = RaisedLimit::random(seed).durations() else { continue };
        let [before, after] =
            durations.unwrap_or_else(|error| panic!("`soak --family raised-limits --count 1 --seed {seed}`: {error}"));
        planned += 1;
        assert!(
            after <= before * (1.0 + LONGER),
            "`soak --family raised-limits --count 1 --seed {seed}`: {before} s, then {after} s"
        );
    }
    assert!(2 * planned >= seeds.end, "{planned} of {} planned: too few to say anything", seeds.end);
}
