#[path = "common/qb.rs"]
mod qb;
use arcfeed_interp::*;
use arcfeed_kinematics::Joints;
#[test]
fn explore() {
    let arm = qb::arm();
    let dynamics = arm.dynamics().unwrap();
    for (name, motion, near) in [("PO", qb::po(), qb::PO_NEAR), ("TO", qb::to(), qb::TO_NEAR)] {
        let path = ArmMotion::new(&arm, motion, &Joints::from(near)).unwrap();
        println!("{name} {:?} end {} angle {} start {:?}", motion.kind(), motion.end(), motion.angle(), path.start());
        for (lname, limits) in [
            ("kin", qb::kinematic()),
            ("tau", qb::with_torque()),
            ("jerk", ScheduleLimits { jerk: Some(Joints::repeat(40.0)), ..qb::with_torque() }),
        ] {
            for n in [100usize, 200, 500, 1000, 2000] {
                for planner in SpeedPlanner::ALL {
                    if (planner == SpeedPlanner::JerkLimited) != (lname == "jerk") {
                        continue;
                    }
                    let sch = Scheduler::new(&arm, limits).unwrap().with_dynamics(dynamics).with_intervals(n).unwrap();
                    let t0 = std::time::Instant::now();
                    match sch.plan(&path, planner) {
                        Ok(s) => {
                            let el = t0.elapsed();
                            let c = s.check(20).unwrap();
                            let w = c.worst().unwrap();
                            println!(
                                "{name} {lname} N={n} {:<13} T={:.9} {:?} {:?} worst {:.6} ({}) at s={:.4}, at points {:.6}",
                                planner.name(),
                                s.duration(),
                                s.timings(),
                                el,
                                w.ratio,
                                w.source,
                                w.s,
                                c.uses.iter().map(|u| u.ratio_at_points).fold(0.0, f64::max)
                            );
                            if n >= 1000 {
                                for b in &c.bindings {
                                    println!("    {}: {:.3?}", b.source, b.intervals);
                                }
                            }
                        }
                        Err(e) => println!("{name} {lname} N={n} {:<13} ERR {e}", planner.name()),
                    }
                }
            }
        }
    }
}
