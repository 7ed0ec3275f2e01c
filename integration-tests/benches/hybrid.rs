//! One cycle of motion in both spaces: the butterfly on the CR7 at 1 ms with overrides, holds, an event and the way back.
//!
//! A cycle is the speed under the limit curve, the pose on the path, the inverse kinematics and three derivatives of six joints. Besides the
//! mean that criterion gives, the times of all cycles of one motion are sorted: median, 99th percentile, worst.
//!
//! On an idle 2-core AMD EPYC VM: median 1.8 us, 99 % 2.9 us, 99.9 % 3.2 to 6.2 us, worst 25 to 38 us of 16 690 cycles; ready in 0.19 s.

use std::hint::black_box;
use std::time::{Duration, Instant};

use arcfeed_geometry::{ArcLengthCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Command, Excursion, HybridMotion, HybridState, LeaveBy, Limits, LivePath, Planner, ToolLimits, ToolPath,
};
use arcfeed_kinematics::Joints;
use criterion::{Criterion, criterion_group, criterion_main};
use robot_cr7::{Cr7, Job, PathGeometry, ToolOrientation, butterfly};

fn live<'a>(cr7: &'a Cr7, job: &Job) -> LivePath<'a> {
    let PathGeometry::Curve(curve) = butterfly().expect("comes with the program").geometry else {
        unreachable!("the butterfly is a curve")
    };
    let ToolOrientation::Constant(rotation) = job.orientation else {
        unreachable!("the default job keeps the tool down")
    };
    let curve = ArcLengthCurve::new(curve.transformed(&job.workpiece).expect("finite numbers"), 1e-15);
    let path = PosePath::new(
        curve.expect("a curve of some length"),
        OrientationPath::Constant(job.workpiece.rotation * rotation),
    );
    let limits = *cr7.limits();
    let path = ToolPath::new(cr7.arm(), path, limits.range()).expect("in reach");
    let limits = Limits::new(limits).with_tool(tool(job, 1.5 * job.feed.feed));
    Planner::new(cr7.arm(), limits).live(path).expect("in reach")
}

fn tool(job: &Job, feed: f64) -> ToolLimits {
    ToolLimits::new()
        .with_feed(feed)
        .and_then(|t| t.with_tangential_acceleration(job.feed.tangential_acceleration))
        .and_then(|t| t.with_tangential_jerk(job.feed.tangential_jerk))
        .and_then(|t| t.with_normal_acceleration(job.feed.normal_acceleration))
        .and_then(|t| job.feed.normal_jerk.map_or(Ok(t), |limit| t.with_normal_jerk(limit)))
        .expect("valid limits")
}

/// What the operator does, by cycle.
fn command(cycle: usize, park: Excursion) -> Command {
    match cycle {
        1000 => Command::Override(1.5),
        2000 => Command::Override(0.4),
        2500 => Command::Override(1.0),
        3000 => Command::Hold,
        3500 => Command::StepBack(0.01),
        5000 => Command::Resume,
        6500 => Command::Leave(park),
        10_000 => Command::Return,
        _ => Command::None,
    }
}

fn hybrid(c: &mut Criterion) {
    let job = Job::default();
    let cr7 = Cr7::new(job.tool).expect("a finite tool");
    let begin = Instant::now();
    let live = live(&cr7, &job);
    println!("made ready in {:.0} ms", begin.elapsed().as_secs_f64() * 1e3);
    let home = live.joint_path().nodes()[0].q;
    let points = [home + Joints::repeat(0.2), home + Joints::repeat(-0.3)];
    let park = Excursion::new(&points, LeaveBy::AtOnce).expect("two points");
    let start = || HybridMotion::new(&live, job.feed.feed).expect("a valid feed");

    let mut times: Vec<Duration> = Vec::new();
    let mut motion = start();
    for cycle in 0.. {
        let command = command(cycle, park);
        let begin = Instant::now();
        let step = black_box(motion.step(black_box(&command)));
        times.push(begin.elapsed());
        if step.state == HybridState::Done {
            break;
        }
    }
    times.sort_unstable();
    let at = |part: f64| times[((times.len() - 1) as f64 * part) as usize];
    println!(
        "{} cycles, step: median {:?}, 99 % {:?}, 99.9 % {:?}, worst {:?}",
        times.len(),
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0)
    );

    let mut motion = start();
    let mut cycle = 0;
    c.bench_function("one cycle of motion in both spaces", |b| {
        b.iter(|| {
            let step = motion.step(black_box(&command(cycle, park)));
            cycle += 1;
            if step.state == HybridState::Done {
                (motion, cycle) = (start(), 0);
            }
            step.setpoint.q
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().measurement_time(Duration::from_secs(5));
    targets = hybrid
}
criterion_main!(benches);
