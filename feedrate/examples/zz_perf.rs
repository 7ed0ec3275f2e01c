use arcfeed_feedrate::constraint::*;
use arcfeed_feedrate::*;
#[path = "../tests/common/spline_paths.rs"]
mod spline_paths;
use spline_paths::*;
fn main() {
    let which = std::env::args().nth(1).unwrap();
    let reps: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let path = &paths()[0].spline;
    let grid = Spline::uniform(1000);
    let s = path.samples(&grid);
    let jl = A_MAX.map(|a| 10.0 * a);
    let mut sum = 0.0;
    let t0 = std::time::Instant::now();
    let mut best = f64::INFINITY;
    for _ in 0..reps {
        let t = std::time::Instant::now();
        let v = JointVelocity::new(s.path(), &V_A).unwrap();
        let a = JointAcceleration::new(s.path(), &A_MAX).unwrap();
        let j = JointJerk::new(s.path(), &jl).unwrap();
        sum += match which.as_str() {
            "rows" => FeedProblem::at_points(&grid, &[&v, &a]).unwrap().cap(3).0,
            "both" => BothEndsScan.plan(&FeedProblem::at_points(&grid, &[&v, &a]).unwrap()).unwrap().duration(),
            "reach" => Reachability.plan(&FeedProblem::at_points(&grid, &[&v, &a]).unwrap()).unwrap().duration(),
            "cert" => {
                CertifiedReachability.plan(&FeedProblem::between_points(&grid, &[&v, &a]).unwrap()).unwrap().duration()
            }
            _ => JerkLimited::default()
                .plan(&FeedProblem::between_points(&grid, &[&v, &a, &j]).unwrap())
                .unwrap()
                .duration(),
        };
        best = best.min(t.elapsed().as_secs_f64());
    }
    println!("{which}: best {:.1} us mean {:.1} us {sum}", best * 1e6, t0.elapsed().as_secs_f64() * 1e6 / reps as f64);
}
