//! The whole way of the main job on the butterfly: 383 mm at 100 mm/s on the CR7, chord tolerance 0.001 mm, 1 ms.
//!
//! Measured on a 2-core AMD EPYC VM, medians:
//!
//! | | |
//! |---|---|
//! | arc-length map of the butterfly, to 1e-12 mm | 0.70 ms |
//! | choice of the start (all branches walked) | 2.1 ms |
//! | plan without verification, scanned: 1174 chord segments, joint path, four scans | 18.9 ms |
//! | plan without verification, jerk-limited, on some 3600 intervals | 100 ms |
//! | verification of 5.7 s of motion on eight samples per cycle | 109 ms |
//! | one cycle of sampling with inverse kinematics | 1.52 us |
//! | one S-profile | 79 ns |
//!
//! Of the compiled motion, in the same run:
//!
//! | | |
//! |---|---|
//! | compile the butterfly to 1e-6 rad: 202 pieces | 17.4 ms |
//! | certificate of the joints | 0.80 ms |
//! | certificate of the tool | 2.6 ms |
//! | certificate of the torques, with friction | 2.4 ms |
//! | one sample of six joints by a cursor, in order | 20 ns |
//! | the same at any time | 27 ns |

use std::hint::black_box;
use std::time::Duration;

use arcfeed_feedrate::{AxisLimits, SProfile};
use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{Limits, Method, Planner, ToolLimits, ToolPath, Trajectory};
use arcfeed_kinematics::{ForwardKinematics, Friction, Joints, models};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use robot_cr7::{Cr7, Job, PathGeometry, ToolOrientation, butterfly};

/// The butterfly in the base frame of the default job.
fn curve(job: &Job) -> NurbsCurve<3> {
    match butterfly().expect("comes with the program").geometry {
        PathGeometry::Curve(curve) => curve.transformed(&job.workpiece).expect("finite numbers"),
        PathGeometry::Points { .. } | PathGeometry::Program(_) => unreachable!("the butterfly is a curve"),
    }
}

/// The time of `plans` plans along a path, as each states it: without the verification that belongs to it.
fn planning(planner: &Planner<'_>, path: &ToolPath<'_>, plans: u64) -> Duration {
    (0..plans).map(|_| planner.plan(black_box(path)).expect("in reach").timings().planning()).sum()
}

fn pipeline(c: &mut Criterion) {
    let job = Job::default();
    let curve = curve(&job);
    let ToolOrientation::Constant(rotation) = job.orientation else {
        unreachable!("the default job keeps the tool down")
    };
    let by_length = ArcLengthCurve::new(curve.clone(), 1e-15).expect("a curve of some length");
    let path = PosePath::new(by_length, OrientationPath::Constant(job.workpiece.rotation * rotation));
    let cr7 = Cr7::new(job.tool).expect("a finite tool");
    let limits = *cr7.limits();
    let feed = job.feed.feed;
    let tool = ToolLimits::new()
        .with_feed(feed)
        .and_then(|t| t.with_tangential_acceleration(job.feed.tangential_acceleration))
        .and_then(|t| t.with_tangential_jerk(job.feed.tangential_jerk))
        .and_then(|t| t.with_normal_acceleration(job.feed.normal_acceleration))
        .and_then(|t| job.feed.normal_jerk.map_or(Ok(t), |limit| t.with_normal_jerk(limit)))
        .expect("valid limits");
    let limits = Limits::new(limits).with_tool(tool);
    let planner = Planner::new(cr7.arm(), limits);
    let followed = ToolPath::new(cr7.arm(), path.clone(), cr7.limits().range()).expect("in reach");
    let plan = planner.plan(&followed).expect("in reach");

    c.bench_function("arc-length map of the butterfly", |b| {
        b.iter_batched(|| curve.clone(), |curve| ArcLengthCurve::new(curve, 1e-15), BatchSize::SmallInput);
    });
    c.bench_function("choice of the start", |b| {
        b.iter_batched(
            || path.clone(),
            |path| ToolPath::new(cr7.arm(), black_box(path), cr7.limits().range()),
            BatchSize::SmallInput,
        );
    });
    let scanning = planner.clone().with_method(Method::ContinuousAcceleration);
    c.bench_function("plan of the butterfly, scanned, without verification", |b| {
        b.iter_custom(|plans| planning(&scanning, &followed, plans));
    });
    c.bench_function("plan of the butterfly, jerk-limited, without verification", |b| {
        b.iter_custom(|plans| planning(&planner, &followed, plans));
    });
    c.bench_function("verification of the plan", |b| {
        b.iter(|| planner.verify(plan.problem(), plan.law(), true));
    });

    let mut sampler = plan.setpoints(1e-3).expect("a valid period");
    c.bench_function("one cycle of sampling with inverse kinematics", |b| {
        b.iter(|| match sampler.next() {
            Some(setpoint) => Some(setpoint),
            None => {
                sampler = plan.setpoints(1e-3).expect("a valid period");
                sampler.next()
            }
        });
    });

    compiled(c, &plan, cr7.arm());

    let limits = AxisLimits::symmetric(0.1, 1.0, 20.0).expect("above 0");
    c.bench_function("one S-profile", |b| {
        b.iter(|| SProfile::new(black_box(0.05), black_box(0.01), black_box(0.03), &limits));
    });
}

/// The plan as polynomials of the time: compiling, certifying, sampling.
fn compiled(c: &mut Criterion, plan: &Trajectory<'_>, arm: &dyn ForwardKinematics<6>) {
    let compiled = plan.compile(1e-6).expect("compiles");
    let limits = plan.limits().joints();
    c.bench_function("compile the butterfly to 1e-6 rad", |b| b.iter(|| plan.compile(black_box(1e-6))));
    c.bench_function("certificate of the joints", |b| {
        b.iter(|| black_box(&compiled).certify(limits.range(), &limits.into()));
    });
    c.bench_function("certificate of the tool", |b| b.iter(|| black_box(&compiled).certify_tool(arm)));
    let robot = models::description("cr7").and_then(|arm| arm.build::<6>().ok()).expect("built in");
    let friction = Friction::new(Joints::repeat(5.0), Joints::repeat(8.0), Joints::repeat(8.0)).expect("friction");
    let dynamics = robot.dynamics().expect("known").with_friction(friction);
    c.bench_function("certificate of the torques, with friction", |b| {
        b.iter(|| black_box(&compiled).certify_torque(&dynamics));
    });

    // A thousand cycles, and a thousand times all over the motion, none near the last one.
    let in_order: Vec<f64> = (0..1024).map(|i| f64::from(i) * 1e-3).collect();
    let anywhere: Vec<f64> =
        (0..1024).map(|i| (f64::from(i) * 0.618_033_988_749_895).fract() * compiled.duration()).collect();
    let (mut cursor, mut i) = (compiled.cursor(), 0);
    c.bench_function("one sample of six joints, in order", |b| {
        b.iter(|| {
            i = (i + 1) % 1024;
            cursor.at(in_order[i])
        });
    });
    c.bench_function("one sample of six joints, anywhere", |b| {
        b.iter(|| {
            i = (i + 1) % 1024;
            compiled.at(anywhere[i])
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .sample_size(20);
    targets = pipeline
}
criterion_main!(benches);
