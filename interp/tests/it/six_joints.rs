//! Arms of six joints without a closed form follow paths as others do.

use crate::six_joints_cases as six_joints;

use arcfeed_interp::Quantity;
use arcfeed_kinematics::{ForwardKinematics, InverseKinematics};
use arcfeed_testing::cases;
use six_joints::{Outcome, bent_wrist, draw_case, plan, play};

/// The inverse stopped at a miss of 1e-11, and continuity reached 118 % of what the jerk limit
/// allows.
#[test]
fn a_bent_wrist_follows_a_line() {
    let case = bent_wrist();
    assert_eq!(play(&case), Ok(Outcome::Planned));
    let plan = plan(&case).expect("in reach");
    let continuity = plan.verification().worst_of(Quantity::Continuity).expect("looked at");
    assert!(continuity.ratio <= 1.0 + 1e-9, "{continuity:?}");
}

/// Nothing but the solver's own residual, which is that of rounding, is allowed on top of the jerk
/// limit.
#[test]
fn the_residual_that_is_stated_holds_along_random_paths() {
    let mut worst = 0.0_f64;
    for case in (0..40).filter_map(draw_case) {
        for step in 0..200 {
            let target = case.path.jet(case.path.length() * f64::from(step) / 199.0).pose;
            let Ok(q) = case.arm.inverse(&target, &case.start) else { continue };
            let (at, stated) = (case.arm.forward(&q), case.arm.residual(&q));
            let position = (at.translation.vector - target.translation.vector).norm() / stated.position;
            worst = worst.max(position);
        }
    }
    assert!(worst > 0.0 && worst <= 1.0, "{worst} of the residual that is stated");
}

#[test]
fn random_arms_without_a_closed_form_follow_circles_and_lines() {
    let (mut planned, mut out_of_reach) = (0, 0);
    let seeds = cases(24);
    for seed in seeds.clone() {
        let Some(case) = draw_case(seed) else { continue };
        match play(&case) {
            Ok(Outcome::Planned) => planned += 1,
            Ok(Outcome::OutOfReach) => out_of_reach += 1,
            Err(what) => panic!("seed {seed}: {what}"),
        }
    }
    assert!(planned > seeds.end / 3 && planned > out_of_reach, "{planned} planned, {out_of_reach} out of reach");
}
