//! Long paths in windows: verified, as fast as the whole within 0.5 %, in less memory.

use std::f64::consts::FRAC_PI_2;

use arcfeed_feedrate::{FeedPlanner, JerkLimited};
use arcfeed_interp::{
    Extent, FeedSection, JointJet, JointSpline, LimitError, Limits, Method, MotionPath, PathError, PathParameter,
    Planner, RowsNeeded, ToolPath,
};
use arcfeed_kinematics::{ArmDynamics, Inertial, Joints, models};
use arcfeed_testing::{Random, most_bytes_in};
use nalgebra::{Matrix3, Vector3};

use crate::common::{analytic, arm, bent, knotted, tool, tool_down};
use crate::limit_tables::Kind;
use crate::qb;

/// Way-points all over a part of the range.
pub(crate) fn route(seed: u64, points: usize) -> JointSpline<6> {
    let mut rng = Random::new(seed);
    let points: Vec<Joints<6>> = (0..points).map(|_| Joints::from_fn(|_, _| rng.between(-1.2, 1.2))).collect();
    JointSpline::through(&points).expect("way-points that differ")
}

pub(crate) fn limits() -> Limits<'static, 6> {
    let rates = [2.5, 8.0, 80.0].map(Joints::repeat);
    Limits::new(models::ur5e().range().with_rates(rates[0], rates[1], rates[2]).expect("above 0"))
}

/// The knots of a spline of 40 points take some 45 s: a window takes 9 s, which is many times the way to brake.
#[test]
fn windows_are_as_fast_as_the_whole_in_less_memory() {
    let arm = models::ur5e();
    for seed in 1..=2 {
        let path = route(seed, 40);
        let planner = Planner::new(&arm, limits()).with_intervals(6000).expect("allowed");
        let (mut whole, mut windows) = (None, None);
        let at_once = most_bytes_in(|| whole = Some(planner.plan(&path).expect("is planned")));
        let planner = planner.with_window(1200).expect("allowed");
        let in_windows = most_bytes_in(|| windows = Some(planner.plan(&path).expect("is planned")));
        let (whole, windows) = (whole.expect("planned"), windows.expect("planned"));
        let info = windows.info().windows.as_ref().expect("a long path");
        let what = format!("seed {seed}: {} and {}: {info:?}", windows.duration(), whole.duration());
        // What rounding of so long a parameter adds to a difference of positions is no excess.
        assert!(whole.info().rounds == 1 && windows.info().rounds == 1, "{what}");
        assert!(whole.info().windows.is_none() && info.count >= 8 && info.stops.is_empty(), "{what}");
        assert!(windows.duration() < 1.005 * whole.duration(), "{what}");
        assert!(windows.duration() > 0.99 * whole.duration(), "{what}");
        assert!(windows.verification().holds(1e-6) && windows.info().method == Some(Method::JerkLimited), "{what}");
        assert!(2 * in_windows < at_once, "{what}: {in_windows} bytes in windows, {at_once} at once");
    }
}

/// Along a curve of the tool.
#[test]
fn curves_of_the_tool_are_planned_in_windows() {
    let arm = arm();
    for curve in [knotted(), analytic()] {
        let path = ToolPath::new(&arm, tool_down(curve), arm.range()).expect("in reach");
        let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(120.0));
        let planner = Planner::new(&arm, Limits::new(joints.expect("above 0")).with_tool(tool()));
        let whole = planner.plan(&path).expect("is planned");
        let windows = planner.with_window(250).expect("allowed").plan(&path).expect("is planned");
        let info = windows.info().windows.as_ref().expect("a long path");
        let what = format!("{} and {}: {info:?}", windows.duration(), whole.duration());
        assert!(info.count > 1 && info.stops.is_empty(), "{what}");
        // Some are hardly longer than the way to brake.
        assert!(windows.duration() < 1.02 * whole.duration(), "{what}");
    }
}

#[test]
fn windows_of_other_sizes_are_refused() {
    let arm = models::ur5e();
    for intervals in [0, 63, 100_001] {
        let error = Planner::new(&arm, limits()).with_window(intervals).expect_err("too short or too long");
        assert!(matches!(error, LimitError::Window { .. }) && error.to_string().contains("64"), "{error}");
    }
}

/// All joints run along a sine, with stops that the path asks for at other places than its knots.
#[derive(Debug)]
struct Stopping {
    stops: Vec<f64>,
}

impl MotionPath<6> for Stopping {
    fn parameter(&self) -> PathParameter {
        PathParameter::JointDistance
    }

    fn length(&self) -> f64 {
        10.0
    }

    fn start(&self) -> Joints<6> {
        Joints::zeros()
    }

    fn jet(&self, s: f64, _near: &Joints<6>) -> Result<JointJet<6>, PathError> {
        let (sin, cos) = s.sin_cos();
        let [q, d1, d2, d3] = [sin, cos, -sin, -cos].map(Joints::repeat);
        Ok(JointJet { s, q, d1, d2, d3 })
    }

    fn corners(&self) -> &[f64] {
        &self.stops
    }
}

/// Windows end at the stops of the path, and the motion rests there and nowhere else.
#[test]
fn windows_rest_where_the_path_asks_for_it() {
    let arm = models::ur5e();
    // Not in order: whoever makes a path may have found them in any.
    let path = Stopping { stops: vec![7.5, 2.5, 2.9, 5.0] };
    let planner = Planner::new(&arm, limits()).with_intervals(1000).expect("allowed");
    let whole = planner.plan(&path).expect("is planned");
    let windows = planner.with_window(250).expect("allowed").plan(&path).expect("is planned");
    let info = windows.info().windows.as_ref().expect("a long path");
    assert!(info.count >= 4 && info.stops.is_empty(), "{info:?}");
    assert!((windows.duration() / whole.duration() - 1.0).abs() < 0.005, "{windows:?} {}", whole.duration());
    for stop in &path.stops {
        let (at, beside) = (windows.law().at_position(*stop), windows.law().at_position(stop - 0.2));
        assert!(at.v < 1e-6 && beside.v > 0.1, "{at:?} {beside:?}");
    }
}

/// Speeds at the ends are those of the first and the last window.
#[test]
fn windows_keep_the_speeds_at_the_ends() {
    let arm = models::ur5e();
    let path = Stopping { stops: vec![5.0] };
    let planner = Planner::new(&arm, limits()).with_intervals(1000).expect("allowed").with_end_speeds(0.5, 0.25);
    let planner = planner.expect("allowed").with_window(250).expect("allowed");
    let plan = planner.plan(&path).expect("is planned");
    assert!(plan.info().windows.as_ref().is_some_and(|windows| windows.count > 2));
    let ends = [plan.law().at_position(0.0).v, plan.law().end().v];
    assert!((ends[0] - 0.5).abs() < 1e-9 && (ends[1] - 0.25).abs() < 1e-9, "{ends:?}");
}

/// Stops where no grid of equal steps has a point, at the ends, and as near to each other as 30 nm: the motion rests in each that is
/// inside, at once and in windows.
#[test]
fn stops_are_planned_wherever_they_are() {
    let arm = models::ur5e();
    let inside = [3.00317, 5.0, 5.001, 6.0, 6.0 + 3e-8];
    let path = Stopping { stops: [&inside[..], &[0.0, 9.999_999_999_999_998, 10.0]].concat() };
    let planner = Planner::new(&arm, limits()).with_intervals(1000).expect("allowed");
    let whole = planner.plan(&path).expect("is planned");
    let windows = planner.with_window(250).expect("allowed").plan(&path).expect("is planned");
    for plan in [&whole, &windows] {
        let info = plan.info();
        assert!(info.fallback.is_none() && info.method == Some(Method::JerkLimited), "{info:?}");
        assert!(plan.verification().holds(1e-6), "{:?}", plan.verification().worst());
        let rests = plan.law().knots().filter(|(_, state)| state.v == 0.0).count();
        assert_eq!(rests, inside.len() + 1, "one in each stop, and at the begin");
        for stop in inside {
            let v = plan.law().at_position(stop).v;
            assert!(v < 1e-6, "{v} at {stop}");
        }
    }
    assert!(windows.duration() < 1.005 * whole.duration(), "{} and {}", windows.duration(), whole.duration());
}

/// A stop of a curve of the tool is where it was asked for, though no knot and no break is there.
#[test]
fn stops_of_curves_are_where_they_were_asked_for() {
    let arm = arm();
    let curve = tool_down(analytic());
    for part in [0.123_456_7, 0.5, 0.876_543_21] {
        let stop = part * curve.length();
        let path = ToolPath::new(&arm, curve.clone(), arm.range()).expect("in reach").with_stops(&[stop]);
        let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(120.0));
        let plan = Planner::new(&arm, Limits::new(joints.expect("above 0")).with_tool(tool())).plan(&path);
        let plan = plan.expect("is planned");
        let v = plan.law().at_position(stop).v;
        assert!(v < 1e-6, "{v} at {stop}");
    }
}

/// With torques limited there is a grid point where a joint turns around. A stop beside it stays.
#[test]
fn a_stop_beside_a_turning_point_is_kept_under_limits_on_torque() {
    let arm = models::ur5e();
    let point = Inertial::new(4.0, Vector3::zeros(), Matrix3::zeros()).expect("a point mass");
    let bare = ArmDynamics::new(arm.chain(), [Inertial::none(); 6]).expect("finite");
    let dynamics = bare.with_payload(point).expect("finite");
    let limits = limits().with_torque(&dynamics, Joints::repeat(500.0)).expect("above 0");
    for stop in [1e-3, -1e-3, 1e-6].map(|beside| FRAC_PI_2 + beside) {
        let path = Stopping { stops: vec![stop] };
        let plan = Planner::new(&arm, limits).with_intervals(1000).expect("allowed").plan(&path);
        let plan = plan.expect("is planned");
        assert!(plan.verification().holds(1e-6), "{:?}", plan.verification().worst());
        let rests: Vec<f64> = plan.law().knots().filter(|(_, at)| at.v == 0.0).map(|(_, at)| at.p).collect();
        assert!(rests.len() == 2 && (rests[1] - stop).abs() < 1e-12, "{rests:?}, asked for {stop}");
    }
}

/// From the middle of one of these windows no motion was found that goes on: it rested at 4.75 rad, 3.7 % longer in all.
#[test]
fn windows_go_on_where_the_grid_is_very_fine() {
    let arm = models::ur5e();
    let path = Stopping { stops: Vec::new() };
    let rates = [3.0, 8.0, 80.0].map(Joints::repeat);
    let joints = arm.range().with_rates(rates[0], rates[1], rates[2]).expect("above 0");
    let planner = Planner::new(&arm, Limits::new(joints)).with_intervals(12_000).expect("allowed");
    let plan = planner.with_window(2400).expect("allowed").plan(&path).expect("is planned");
    let info = plan.info().windows.as_ref().expect("a long path");
    assert!(info.count > 5 && info.stops.is_empty() && plan.verification().holds(1e-6), "{info:?}");
}

/// The motion passes half a window of 10 000 intervals in less than twice the time in which it brakes: windows grow by themselves.
#[test]
#[ignore = "a minute: a grid of more than 50 000 intervals, twice"]
fn windows_grow_where_the_motion_brakes_for_longer() {
    let arm = models::ur5e();
    let path = Stopping { stops: Vec::new() };
    let rates = [3.0, 8.0, 80.0].map(Joints::repeat);
    let slow = models::ur5e().range().with_rates(rates[0], rates[1], rates[2]).expect("above 0");
    let planner = Planner::new(&arm, Limits::new(slow));
    let plan = planner.clone().with_intervals(51_000).expect("allowed").plan(&path).expect("is planned");
    let info = plan.info().windows.as_ref().expect("a long path");
    let coarse = planner.clone().with_intervals(5000).expect("allowed").plan(&path).expect("is planned");
    let short = planner.with_intervals(51_000).expect("allowed").with_window(10_000).expect("allowed");
    let short = short.plan(&path).expect("is planned");
    let durations = [coarse.duration(), plan.duration(), short.duration()];
    assert!(info.intervals > 10_000 && info.stops.is_empty() && plan.verification().holds(1e-6), "{info:?}");
    assert!(durations[1] < 1.005 * durations[0] && durations[1] < durations[2], "{durations:?}");
}

/// Feeds of sections hold in windows as they do on the whole path.
#[test]
fn sections_are_kept_in_windows() {
    let arm = arm();
    let path = ToolPath::new(&arm, tool_down(analytic()), arm.range()).expect("in reach");
    let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(12.0), Joints::repeat(120.0));
    let length = path.length();
    let section = |[from, to, feed]: [f64; 3]| FeedSection {
        extent: Extent::Length { from: from * length, to: to * length },
        feed,
    };
    let feeds = [[0.2, 0.35, 0.03], [0.35, 0.6, 0.06], [0.8, 0.9, 0.04]];
    let planner = Planner::new(&arm, Limits::new(joints.expect("above 0")).with_tool(tool()))
        .with_sections(feeds.map(section).to_vec());
    let whole = planner.plan(&path).expect("is planned");
    let windows = planner.with_window(250).expect("allowed").plan(&path).expect("is planned");
    assert!(windows.info().windows.as_ref().is_some_and(|windows| windows.count > 1), "{:?}", windows.info());
    assert!(windows.duration() < 1.02 * whole.duration(), "{} and {}", windows.duration(), whole.duration());
    assert!(windows.verification().holds(1e-6), "{:?}", windows.verification().worst());
    for [from, to, feed] in feeds {
        let fastest = (0..=1000)
            .map(|i| windows.law().at_position(length * (from + (to - from) * f64::from(i) / 1000.0)).v)
            .fold(0.0, f64::max);
        assert!(fastest <= feed * (1.0 + 1e-6) && fastest > 0.99 * feed, "{fastest} of {feed}");
    }
}

/// Tables of limits, torques and limits on the tool's vectors hold in windows as they do on the whole path.
#[test]
fn tables_are_kept_in_windows() {
    let arm = qb::arm();
    let path = bent::rounds();
    for kind in [Kind::AccelerationBySpeed, Kind::JerkByPosition, Kind::TorqueBySpeed, Kind::ToolAcceleration] {
        let told = kind.told(1.0);
        let planner = told.planner(&arm).with_intervals(1200).expect("allowed");
        let whole = planner.plan(&path).expect("is planned");
        let windows = planner.with_window(400).expect("allowed").plan(&path).expect("is planned");
        let info = windows.info();
        let what = format!("{kind:?}: {} and {}, {info:?}", windows.duration(), whole.duration());
        assert!(info.windows.as_ref().is_some_and(|windows| windows.count > 2 && windows.stops.is_empty()), "{what}");
        assert!(windows.verification().holds(1e-6) && windows.duration() < 1.005 * whole.duration(), "{what}");
        let worst = windows.verification().worst_of(kind.quantity()).expect("looked at");
        assert!(worst.ratio > 0.95, "{what}: {worst:?} does not bind");
    }
}

/// A grid that is no longer than a window and a half is planned at once, and its information says so.
#[test]
fn one_window_is_the_whole() {
    let arm = models::ur5e();
    let path = Stopping { stops: Vec::new() };
    let planner = Planner::new(&arm, limits()).with_intervals(360).expect("allowed");
    let plan = planner.with_window(250).expect("allowed").plan(&path).expect("is planned");
    assert!(plan.info().windows.is_none() && !plan.info().to_string().contains("window"), "{}", plan.info());
}

/// On few intervals the plan on the grid that was asked for may be shorter than that on a finer one: the shorter one is taken.
#[test]
fn a_plan_on_few_intervals_is_no_longer_than_that_of_its_grid() {
    let arm = models::ur5e();
    let mut compared = 0;
    for (seed, way_points) in [(1, 3), (2, 3), (3, 4)] {
        let path = route(seed, way_points);
        for intervals in [4, 6, 8, 12, 16, 24, 32, 40, 48] {
            let planner = Planner::new(&arm, limits()).with_intervals(intervals).expect("allowed");
            let plan = planner.plan(&path).expect("is planned");
            let rows = planner.prepare(&path, RowsNeeded::Jerk).and_then(|problem| Ok(problem.rows(RowsNeeded::Jerk)?));
            let Ok(coarse) = JerkLimited::default().plan(&rows.expect("rows")) else { continue };
            if plan.info().rounds > 1 {
                continue;
            }
            compared += 1;
            let durations = [plan.duration(), coarse.duration()];
            assert!(durations[0] <= durations[1] * (1.0 + 1e-9), "seed {seed}, {intervals}: {durations:?}");
        }
    }
    assert!(compared > 10, "{compared}");
}
