use arcfeed_interp::Method;
use integration_tests::cnc_curves::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let curve = NAMES.into_iter().find(|n| *n == a[1]).unwrap();
    let arm = ARMS.into_iter().find(|n| n.0 == a[4]).unwrap().0;
    let job = CncJob::new(curve, a[2].parse::<f64>().unwrap() * 1e-3, a[3].parse::<f64>().unwrap() * 1e-3, arm);
    println!("{:?}", job.plan(Method::default()));
    println!("{:?}", job.plan(Method::ContinuousAcceleration));
    println!("{:?}", job.plan(Method::Reachability));
}
