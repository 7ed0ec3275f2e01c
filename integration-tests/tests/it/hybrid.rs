//! Motion in both spaces under random operators: see `integration_tests::hybrid_scenario`. The example `soak` plays as many as you like.

use arcfeed_testing::Counting;
use integration_tests::hybrid_scenario::{Stage, arms};

#[test]
fn random_scenarios_keep_every_limit_and_end_where_they_should() {
    let (mut played, mut left) = (0, 0);
    let arms = arms();
    for stage_seed in 0..12 {
        let Some(stage) = Stage::random(&arms, stage_seed) else { continue };
        for seed in 5 * stage_seed..5 * stage_seed + 5 {
            match stage.play(seed, Counting::count) {
                Ok(result) => {
                    played += 1;
                    left += usize::from(result.left_path);
                }
                Err(what) => panic!("`soak --family hybrid --count 1 --seed {seed}`: {what}"),
            }
        }
    }
    // The counter works.
    let before = Counting::count();
    std::hint::black_box(Vec::<f64>::with_capacity(10));
    assert!(Counting::count() > before);
    assert!(played >= 50 && left >= 20, "{played} scenarios, {left} of them off the path: too few to say anything");
}
