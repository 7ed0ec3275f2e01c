//! jerk
use arcfeed_feedrate::constraint::{JointAcceleration, JointJerk, JointVelocity};
use arcfeed_feedrate::{FeedPlanner, FeedProblem, JerkLimited};

#[path = "common/spline_paths.rs"]
mod spline_paths;
use spline_paths::{A_MAX, V_A, V_B, paths};

#[test]
fn try_it() {
    let jerk = A_MAX.map(|a| 10.0 * a);
    for path in paths() {
        for fine in &path.fine {
            let v = if fine.case == 'B' { &V_B } else { &V_A };
            let n = std::env::var("N").ok().and_then(|v| v.parse().ok()).unwrap_or(1000);
            let grid = path.spline.on_knots(n);
            let samples = path.spline.samples(&grid);
            let vel = JointVelocity::new(samples.path(), v).unwrap();
            let acc = JointAcceleration::new(samples.path(), &A_MAX).unwrap();
            let jer = JointJerk::new(samples.path(), &jerk).unwrap();
            let problem = FeedProblem::between_points(&grid, &[&vel, &acc, &jer]).unwrap();
            let t0 = std::time::Instant::now();
            let plan = JerkLimited::default().plan(&problem).unwrap();
            let dt = t0.elapsed();
            let worst = spline_paths::worst(&path.spline, &grid, &plan, 20, v, &jerk);
            println!("{} {} T {:.5} copp {:.5} ({:.5}) fine {:.5} {worst:.5?} {dt:?}", path.seed, fine.case, plan.duration(), fine.jerk, plan.duration() / fine.jerk, fine.fine);
        }
    }
}
