#[path = "/work/wt-geometry/geometry/benches/published/mod.rs"]
mod published;
use arcfeed_geometry::*;
use std::hint::black_box;
fn main() {
    let c = published::published("butterfly");
    let us: Vec<f64> = (0..1024).map(|i| (i as f64 * 0.6180339887498949).fract()).collect();
    let mut b = [f64::INFINITY; 3];
    for _ in 0..400 {
        let t = std::time::Instant::now();
        for i in 0..4096usize {
            let j = c.jet(us[i & 1023]);
            black_box((j.point, j.d1, j.d2));
        }
        b[0] = b[0].min(t.elapsed().as_secs_f64() * 1e9 / 4096.0);
        let t = std::time::Instant::now();
        for i in 0..4096usize {
            black_box(c.point(us[i & 1023]));
        }
        b[1] = b[1].min(t.elapsed().as_secs_f64() * 1e9 / 4096.0);
        let t = std::time::Instant::now();
        black_box(c.arc_length_between(0.0, 1.0, 1e-12).unwrap());
        b[2] = b[2].min(t.elapsed().as_secs_f64() * 1e9);
    }
    println!(
        "jet {:.1} point {:.1} arclength {:.0} ns  {}",
        b[0],
        b[1],
        b[2],
        c.arc_length_between(0.0, 1.0, 1e-12).unwrap()
    );
    let l = NurbsCurve::<3>::new(
        1,
        vec![nalgebra::vector![10., 20., 30.], nalgebra::vector![90., -70., 55.]],
        vec![0.2, 5.0],
        vec![0., 0., 1., 1.],
    )
    .unwrap();
    let (a, d) = (nalgebra::vector![10., 20., 30.], nalgebra::vector![80., -90., 25.0f64].normalize());
    println!("line off {:e}", us.iter().map(|&u| (l.point(u) - a).cross(&d).norm()).fold(0.0, f64::max));
}
