mod common;
use arcfeed_feedrate::*;
#[test]
fn probe2() {
    let segs = common::curve_like(3000, 0);
    let p = plan_per_segment(&segs, 0.0, 0.0).unwrap();
    let sp = boundary_speeds(&segs, 0.0, 0.0).unwrap();
    let b = boundaries(&segs);
    for k in 2139..2144 {
        {
            let l = MotionLimits::new(segs[k].v_max(), segs[k].a_max(), segs[k].j_max()).unwrap();
            println!(
                "{k} s {} v {} {} len {} need {} {:?}",
                b[k],
                sp[k],
                sp[k + 1],
                segs[k].length(),
                distance_for_change(sp[k], sp[k + 1], &l).unwrap(),
                segs[k]
            );
        }
    }
    for w in p.phases().windows(2) {
        if w[1].s < w[0].s - 1e-9 {
            let k = b.partition_point(|&x| x <= w[0].s) - 1;
            println!("{k} s {} {} v {} {} {:?}", b[k], b[k + 1], sp[k], sp[k + 1], segs[k]);
            for f in p.phases().iter().filter(|f| f.t > w[0].t - 1e-2 && f.t < w[1].t + 1e-2) {
                println!("   {f:?}");
            }
            break;
        }
    }
}
