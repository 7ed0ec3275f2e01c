//! The blend of two lines against its neighbours in the family, by the time over a corner.

use integration_tests::blend_corner::{Corner, Failure, Shape, TOOLS};

/// A neighbour may be faster by this part of the time.
const FASTER: f64 = 0.015;

#[test]
fn no_neighbour_of_the_blend_is_much_faster_on_the_mean() -> Result<(), Failure> {
    for degrees in [30_i32, 90, 150] {
        let corners: Vec<Corner> = [1e-5, 1e-3]
            .into_iter()
            .zip(TOOLS)
            .map(|(tolerance, tool)| Corner { angle: f64::from(degrees).to_radians(), tolerance, direction: 0.5, tool })
            .collect();
        let sum = |shape: Shape| {
            corners.iter().try_fold(0.0, |sum, corner| Ok::<f64, Failure>(sum + corner.time(Some(shape))?))
        };
        let (_, made) = corners[0].shipped()?;
        let shipped = corners.iter().try_fold(0.0, |sum, corner| Ok::<f64, Failure>(sum + corner.shipped()?.0))?;
        assert!((made.scale - 1.0).abs() < 1e-6, "{made:?}");
        for (scale, b, c) in
            [(0.8, 0.0, 0.0), (1.0, 0.12, 0.0), (1.0, -0.12, 0.0), (1.0, 0.0, 0.1), (1.0, 0.0, -0.1), (1.0, 0.2, 0.2)]
        {
            let time = sum(Shape { scale, b: made.b + b, c: made.c + c })?;
            assert!(
                shipped <= time * (1.0 + FASTER),
                "{degrees} degrees: {shipped} s, {time} s with {scale}, {b}, {c}"
            );
        }
    }
    Ok(())
}
