//! Planners on rows: nothing exceeded, at the grid points and between them, by families of random problems.
//!
//! Long runs: `cargo run --release -p arcfeed-feedrate --example 08_soak_rows -- SEED COUNT`.
#![allow(clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_feedrate::{
    ContinuousAccelerationScan, FeedError, FeedPlanner, FeedProblem, ForwardBackwardScan, InterpolatedReachability,
    JerkLimited, PathEnd, Quantity, Reachability, SpeedLaw,
};

use crate::row_families_cases as row_families;
use row_families::{Case, FAMILIES, Path, judge};

/// A planner, whether it keeps the limits between the points, and those on jerk.
type Entry = (&'static dyn FeedPlanner, bool, bool);

const LIMITED: JerkLimitedByDefault = JerkLimitedByDefault;

struct JerkLimitedByDefault;

impl FeedPlanner for JerkLimitedByDefault {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        JerkLimited::default().plan(problem)
    }
}

const PLANNERS: [Entry; 5] = [
    (&ForwardBackwardScan, false, false),
    (&Reachability, false, false),
    (&InterpolatedReachability, true, false),
    (&LIMITED, true, true),
    (&ContinuousAccelerationScan, true, true),
];

/// The plan, held against its limits: 1e-9 at the grid points, 1e-6 between.
fn kept(case: &Case, (planner, between, jerk): Entry) -> Result<SpeedLaw, FeedError> {
    let path = Path::new(case);
    let plan = path.problem(between, jerk).and_then(|problem| planner.plan(&problem))?;
    let excess = judge(&path, &plan, jerk);
    assert!(excess.at_grid <= 1e-9, "{:?}: {}", excess, case.literal());
    assert!(!between || excess.between <= 1e-6, "{:?}: {}", excess, case.literal());
    Ok(plan)
}

#[test]
fn no_family_exceeds_its_limits() {
    for index in 0..160 {
        let family = index as usize % FAMILIES.len();
        let case = Case::numbered(11, family, index);
        let refused: Vec<bool> = PLANNERS.iter().map(|planner| kept(&case, *planner).is_err()).collect();
        // From rest to rest there is a motion with jerk wherever there is one without that may stand anywhere.
        if case.ends == [0.0; 2] && !refused[0] {
            assert!(!refused[2] && !refused[3], "{refused:?}: {}", case.literal());
        }
    }
}

/// From a law of a hundredth of the speed the iterations led to motions that took up to 4e13 times as long, or to none.
#[test]
fn a_law_that_leads_nowhere_costs_nothing() {
    for index in [150, 494, 614, 718, 1054, 1102, 1374, 1422] {
        let case = Case::numbered(12, index as usize % FAMILIES.len(), index);
        let problem = Path::new(&case).problem(true, true).unwrap();
        let own = JerkLimited::default().plan(&problem).unwrap();
        let near = JerkLimited::default().plan_near(&problem, &own.scaled(0.01).unwrap()).unwrap();
        let ratio = near.law.duration() / own.duration();
        assert!(ratio < 1.001, "case {index}: {ratio}");
    }
}

/// A joint that stands still in places made its row decide the accelerations of all others: 4.3 % over at a grid point.
#[test]
fn certified_broke_an_acceleration_at_a_grid_point() {
    let case = Case {
        h: 0.125,
        per: 12,
        y: vec![
            vec![
                -0.21059391465348284,
                0.0,
                1.4692654483823786,
                0.35142775936623233,
                0.24924852680593446,
                1.3406705365387568,
                -0.36445461558009273,
                0.0,
                0.0,
            ],
            vec![
                1.687047721607437,
                0.0,
                0.0,
                -0.12271420227011617,
                0.0,
                -0.4874087499173422,
                -2.06927226112534,
                0.21693555216058966,
                -1.1219956959281359,
            ],
            vec![
                -0.0040317118789843865,
                -0.4370253489603498,
                0.0,
                -0.3937997996881315,
                0.0,
                -1.042169834814877,
                -0.6254955889065663,
                0.0,
                -2.3190729519891637,
            ],
            vec![
                0.0,
                -1.070080407542131,
                0.0,
                0.7564729675748233,
                0.0,
                0.00613419284121286,
                -0.6916929566750095,
                0.0,
                0.2498362043545937,
            ],
        ],
        v: vec![0.6342220106950307, 2.449547397585329, 7.055117644925135, 0.3707440322687049],
        a: vec![0.43208233474931157, 3.0400262713968753, 18.56122739287484, 1.6158364910457843],
        j: vec![10.206320501919977, 699.7781869466901, 3.444969185195735, 4.415691203550386],
        feed: 0.21063676260044037,
        ends: vec![0.0; 2],
        rows: vec![],
        thirds: vec![],
    };
    for planner in PLANNERS {
        kept(&case, planner).unwrap();
    }
}

/// The same by plain reachability, where every joint turns around between two points at once: 9.9 %, 6.1 %, 3.6 %, 2.7 %.
#[test]
fn reachability_broke_an_acceleration_at_a_grid_point() {
    for index in [47666, 35802, 46522, 7474] {
        kept(&Case::numbered(20261128, 2, index), PLANNERS[1]).unwrap();
    }
}

/// Seen between two grid points: jerk of 1.00026 and 1.0002, friction of 1.002 and 1.0010.
#[test]
fn limits_were_exceeded_between_the_points() {
    for (index, planner) in [(2116, 3), (1979, 3), (607, 3), (1903, 2), (2575, 2)] {
        kept(&Case::numbered(7, index as usize % FAMILIES.len(), index), PLANNERS[planner]).unwrap();
    }
}

/// The greatest speed before the last point was one from which only rest could be reached, an interval too early.
#[test]
fn certified_refused_with_a_standstill() {
    for index in [1120, 347, 340, 855] {
        kept(&Case::numbered(7, index as usize % FAMILIES.len(), index), PLANNERS[2]).unwrap();
    }
}

/// A joint that never moves, and may not: its rows bind nothing, but have no inside.
#[test]
fn jerk_limited_did_not_converge_beside_a_joint_at_rest() {
    for index in [5, 13, 21] {
        kept(&Case::numbered(7, 5, index), PLANNERS[3]).unwrap();
    }
}

/// What did not converge with friction is a motion now: every iterate inside the bounds is one.
#[test]
fn jerk_limited_did_not_converge_with_friction() {
    kept(&Case::numbered(7, 7, 39), PLANNERS[3]).unwrap();
}

/// "did not converge: 142114657 is left" for a start speed that cannot be had.
#[test]
fn end_speeds_that_did_not_converge_are_named() {
    let mut named = 0;
    for index in 0..30 {
        let case = Case::numbered(13, 6, index);
        let FeedError::SpeedOutOfReach { end: at, speed, highest, row, s, .. } = (match kept(&case, PLANNERS[3]) {
            Ok(plan) => {
                assert!(plan.duration() > 0.0);
                continue;
            }
            Err(error) => error,
        }) else {
            continue;
        };
        named += 1;
        let end = usize::from(at == PathEnd::End);
        assert!(speed == case.ends[end] && highest < speed, "{at} {speed} {highest}");
        assert!(row.quantity != Quantity::Other && (0.0..=1.0 + 1e-9).contains(&s), "{row} at {s}");
        // What is said to be possible is.
        let mut slower = case.clone();
        slower.ends[end] = highest;
        if at == PathEnd::Start {
            slower.ends[1] = 0.0;
        }
        kept(&slower, PLANNERS[3]).unwrap();
    }
    assert!(named > 5, "{named}");
}

/// The scan refused a joint that stands still with a limit of 0, and an interval on which nothing limited moves.
#[test]
fn the_scan_passes_a_joint_at_rest_with_a_limit_of_zero() {
    let zero_rows = FAMILIES.iter().position(|name| *name == "zero-rows").unwrap();
    let (mut solved, count) = (0, 40);
    for index in 0..count {
        let case = Case::numbered(20261205, zero_rows, index);
        solved += u64::from(kept(&case, PLANNERS[4]).is_ok());
    }
    assert!(solved > count * 9 / 10, "{solved} of {count}");
}
