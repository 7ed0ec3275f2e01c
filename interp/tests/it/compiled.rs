//! Compiled trajectories against the plans they were made from.

use arcfeed_interp::{Interpolation, JointRates, JointSpline, Limits, Planner, Trajectory};
use arcfeed_kinematics::{JointLimits, Joints};

use crate::common::{analytic, arm, knotted, limits, line_and_arc, plan};

fn show(name: &str, trajectory: &Trajectory<'_>) {
    println!(
        "{name}: {} s, law knots {}, {}",
        trajectory.duration(),
        trajectory.law().knots().len(),
        trajectory.verification().worst().ratio
    );
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let begin = std::time::Instant::now();
        for kind in [Interpolation::Quintic, Interpolation::Cubic] {
            match trajectory.compile_with(tolerance, kind) {
                Ok(c) => {
                    let l = trajectory.limits().joints();
                    let cert = c.certify(l.range(), &l.into());
                    println!(
                        "  {tolerance:e} {kind:?}: {} pieces, {:?}, {} {:?}",
                        c.len(),
                        c.deviation(),
                        cert,
                        begin.elapsed()
                    );
                }
                Err(e) => println!("  {tolerance:e} {kind:?}: {e} {:?}", begin.elapsed()),
            }
        }
    }
}

#[test]
fn experiment() {
    let arm = arm();
    for (name, curve) in [("analytic", analytic()), ("knotted", knotted()), ("line", line_and_arc(0.1, 0.05))] {
        show(name, &plan(&arm, curve).expect("a plan"));
    }
    let path =
        JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.5), Joints::repeat(-0.2)]).expect("way-points");
    show("spline", &Planner::new(&arm, Limits::new(limits(&arm))).plan(&path).expect("a plan"));
}
