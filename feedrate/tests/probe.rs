mod common;
use arcfeed_feedrate::*;
#[test]
fn probe() {
    for seed in 0..30 {
        for n in [300usize, 3000] {
            let segs = common::curve_like(n, seed);
            let t0 = std::time::Instant::now();
            let j = scan::joined::try_joined(&segs, 0.0, 0.0);
            let dt = t0.elapsed();
            let p = plan_per_segment(&segs, 0.0, 0.0).unwrap();
            let lb = common::lower_bound(&segs, 0.0, 0.0);
            let vp = common::judge(&p, &segs, 0.0, 0.0);
            assert!(vp.v < 1.0 + 1e-9 && vp.a < 1.0 + 1e-9 && vp.j < 1.0 + 1e-9 && vp.gap < 1e-9, "{vp:?}");
            match j {
                None => println!("{n} {seed}: NONE per-seg {:.4} lb {lb:.4}", p.duration()),
                Some((j, which)) => println!(
                    "[{which}] {n} {seed}: joined {:.4} ({:.4}x) per-seg {:.3}x phases {} {:?} {:?}",
                    j.duration(),
                    j.duration() / lb,
                    p.duration() / lb,
                    j.phases().len(),
                    dt,
                    common::judge(&j, &segs, 0.0, 0.0)
                ),
            }
        }
    }
}
