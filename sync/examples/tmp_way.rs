#![allow(missing_docs, clippy::unwrap_used)]
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{Route, WayPoint, WayPointPlanner};
use arcfeed_testing::Random;
fn run<const N: usize>(m: usize, parts: usize, rounds: usize, seed: u64) -> (f64, f64, usize, f64, f64) {
    let mut rng = Random::new(Random::new(seed).bits());
    let limits: [AxisLimits; N] = std::array::from_fn(|_| AxisLimits::symmetric(rng.log(0.5, 2.0), rng.log(2.0, 10.0), rng.log(10.0, 200.0)).unwrap());
    let p: Vec<[f64; N]> = (0..m + 2).map(|_| std::array::from_fn(|_| rng.between(-1.0, 1.0))).collect();
    let points: Vec<_> = p[1..=m].iter().map(|x| WayPoint::new(*x)).collect();
    let start = p[0].map(AxisState::rest);
    let target = p[m + 1].map(AxisState::rest);
    let mut planner = Box::new(WayPointPlanner::<N>::new());
    planner.parts = parts;
    planner.rounds = rounds;
    let clock = std::time::Instant::now();
    let r = planner.plan(&start, &Route::new(&points, target, limits)).unwrap();
    (planner.debug.0, r.duration(), planner.debug.1, 0.0, clock.elapsed().as_secs_f64() * 1e6)
}
fn table<const N: usize>(m: usize, show: bool) {
    for (parts, rounds) in [(1, 8), (1, 12), (1, 20), (1, 40), (2, 12), (2, 20), (2, 40), (3, 40), (4, 40), (6, 60)] {
        if parts * (m + 1) > 65 { continue; }
        let mut sum = (0.0, 0.0, 0, 0.0);
        let n = 50;
        for seed in 0..n {
            let r = run::<N>(m, parts, rounds, seed);
            if show { println!("  {seed} {r:?}"); }
            sum.0 += r.0; sum.1 += r.1; sum.2 += r.2; sum.3 += r.4;
        }
        let n = n as f64;
        println!("N {N} m {m} parts {parts} rounds {rounds}: coarse {:.5} exact {:.5} scaled {} time {:.0} us", sum.0 / n, sum.1 / n, sum.2, sum.3 / n);
    }
}
fn main() {
    let a: Vec<usize> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    if a.len() == 4 {
        println!("{:?}", run::<6>(a[0], a[1], a[2], a[3] as u64));
        return;
    }
    table::<1>(1, false); table::<1>(10, false);
    table::<3>(3, false); table::<6>(10, false); table::<6>(30, false); table::<6>(64, false);
}
