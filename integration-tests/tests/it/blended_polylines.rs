//! Random polylines with blends: within the tolerance, smooth, verified, and no slower than with stops.

use arcfeed_testing::cases;
use integration_tests::blended_polylines::{BlendedPolyline, Outcome};

#[test]
fn random_polylines_are_within_tolerance_smooth_and_no_slower_than_with_stops() {
    let (mut faster, seeds) = (0, cases(10));
    for seed in seeds.clone() {
        let polyline = BlendedPolyline::random(seed);
        match polyline.play() {
            Ok(Outcome::Planned([smooth, exact])) => faster += u64::from(smooth < 0.98 * exact),
            Ok(Outcome::OutOfReach) => {}
            Err(what) => panic!("seed {seed}: {what}\n{polyline:?}"),
        }
    }
    assert!(5 * faster >= 3 * seeds.end, "{faster} of {} gain by their blends", seeds.end);
}

/// The jerk between two grid points exceeded its limit by half a percent, and a lower limit at the grid points did not mend it.
#[test]
fn a_peak_between_grid_points_is_found_by_a_finer_grid() {
    assert!(matches!(BlendedPolyline::random(9956).play(), Ok(Outcome::Planned(_))));
}
