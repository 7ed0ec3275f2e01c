//! The known cases of ruckig's own test suite: each agrees, or the difference is explained.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, StateToState};
use arcfeed_sync::{MotionOptions, SyncError, Synchronisation, Trajectory};
use serde::Deserialize;

const CASES: &str = include_str!("../data/ruckig_cases.json");

/// Cases with another result, and why. `docs/conformance.md` says it at length.
const EXPLAINED: [(&str, &str); 5] = [
    ("phase-synchronization: velocities on a line", STRAIGHT),
    ("phase-synchronization: velocities on a line, less jerk", STRAIGHT),
    ("zero-limits", ZERO),
    ("zero-limits: velocities", ZERO),
    ("zero-limits: velocities, other axis", ZERO),
];
const STRAIGHT: &str = "axes that are led by velocities do not keep to a line";
const ZERO: &str = "limits are above 0";

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

/// Numbers that may be NaN.
type Numbers = Vec<Option<f64>>;

#[derive(Deserialize)]
struct Case {
    case: String,
    start: [Numbers; 3],
    target: [Numbers; 3],
    v: Numbers,
    a: Numbers,
    j: Numbers,
    synchronisation: Option<String>,
    interface: Option<String>,
    least_duration: Option<f64>,
    expect: Expected,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum Expected {
    Duration(f64),
    Positions(f64, Vec<f64>),
    Straight(bool),
    Refused(String),
    Accepted(bool),
    #[serde(untagged)]
    StraightIn {
        duration: f64,
        straight: bool,
    },
}

/// A motion of `N` axes, or why there is none.
struct Ours {
    duration: f64,
    straight: bool,
    positions: Box<dyn Fn(f64) -> Vec<f64>>,
}

fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn states<const N: usize>(numbers: &[Numbers; 3]) -> [AxisState; N] {
    std::array::from_fn(|k| AxisState::new(number(numbers[0][k]), number(numbers[1][k]), number(numbers[2][k])))
}

fn run<const N: usize>(case: &Case) -> Result<Ours, String> {
    let mut limits = [AxisLimits::symmetric(1.0, 1.0, 1.0).expect("limits"); N];
    for (k, limits) in limits.iter_mut().enumerate() {
        let (v, a, j) = (number(case.v[k]), number(case.a[k]), number(case.j[k]));
        *limits = AxisLimits::symmetric(v, a, j).map_err(|error| error.to_string())?;
    }
    let (start, target) = (states::<N>(&case.start), states::<N>(&case.target));
    if case.interface.as_deref() == Some("velocity") {
        return to_velocities(&start, &target, &limits).map_err(|error| error.to_string());
    }
    let mode = match case.synchronisation.as_deref() {
        Some("phase") => Synchronisation::StraightLine,
        _ => Synchronisation::Time,
    };
    let motion = motion(&start, &target, &limits, mode, case.least_duration).map_err(|error| error.to_string())?;
    Ok(Ours {
        duration: motion.duration(),
        straight: motion.is_straight(),
        positions: Box::new(move |t| motion.at(t).q.iter().copied().collect()),
    })
}

fn motion<const N: usize>(
    start: &[AxisState; N],
    target: &[AxisState; N],
    limits: &[AxisLimits; N],
    mode: Synchronisation,
    least_duration: Option<f64>,
) -> Result<Trajectory<N>, SyncError> {
    let options = MotionOptions::new(mode).with_least_duration(least_duration.unwrap_or(0.0))?;
    Trajectory::new(start, target, limits, &options)
}

fn to_velocities<const N: usize>(
    start: &[AxisState; N],
    target: &[AxisState; N],
    limits: &[AxisLimits; N],
) -> Result<Ours, FeedError> {
    use arcfeed_feedrate::MotionLaw;
    let mut duration = 0.0_f64;
    for ((start, target), limits) in start.iter().zip(target).zip(limits) {
        let motion = StateToState::to_velocity(start, target.v, target.a, limits)?;
        duration = duration.max(motion.duration());
    }
    Ok(Ours { duration, straight: false, positions: Box::new(|_| Vec::new()) })
}

/// The comparison of the suite.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1.2e-5 * (1.0 + a.abs().max(b.abs()))
}

/// Nothing if the case agrees, otherwise what came instead.
fn difference(case: &Case) -> Option<String> {
    let ours = match case.v.len() {
        1 => run::<1>(case),
        2 => run::<2>(case),
        _ => run::<3>(case),
    };
    let ours = match (&case.expect, ours) {
        (Expected::Refused(what), Err(text)) if text.contains(what) => return None,
        (_, Err(text)) => return Some(format!("refused: {text}")),
        (Expected::Refused(_), Ok(ours)) => return Some(format!("a motion of {} s", ours.duration)),
        (_, Ok(ours)) => ours,
    };
    let agrees = match &case.expect {
        Expected::Duration(t) => close(ours.duration, *t),
        Expected::Straight(straight) => ours.straight == *straight,
        Expected::StraightIn { duration, straight } => close(ours.duration, *duration) && ours.straight == *straight,
        Expected::Positions(t, positions) => (ours.positions)(*t).iter().zip(positions).all(|(a, b)| close(*a, *b)),
        Expected::Accepted(accepted) => *accepted,
        Expected::Refused(_) => false,
    };
    let at = match &case.expect {
        Expected::Positions(t, _) => format!(", {:?}", (ours.positions)(*t)),
        _ => String::new(),
    };
    (!agrees).then(|| format!("{} s, straight: {}{at}", ours.duration, ours.straight))
}

#[test]
fn every_known_case_agrees_or_is_explained() {
    let file: File = serde_json::from_str(CASES).expect("cases");
    // Suite, cases, agreed, explained.
    let mut table: BTreeMap<String, [usize; 3]> = BTreeMap::new();
    let mut failed = Vec::new();
    for case in &file.cases {
        let suite = case.case.split(':').next().unwrap_or_default().to_owned();
        let row = table.entry(suite).or_default();
        row[0] += 1;
        let explained = EXPLAINED.iter().any(|(name, _)| *name == case.case);
        match difference(case) {
            None if explained => failed.push(format!("{}: agrees, and is explained all the same", case.case)),
            None => row[1] += 1,
            Some(_) if explained => row[2] += 1,
            Some(difference) => failed.push(format!("{}: {difference}", case.case)),
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/conformance.md");
    let page = fs::read_to_string(page).expect("the page");
    for (suite, [cases, agreed, explained]) in table {
        let row = format!("| {suite} | {cases} | {agreed} | {explained} | 0 |");
        assert!(page.contains(&row), "docs/conformance.md has no line\n{row}");
    }
}
