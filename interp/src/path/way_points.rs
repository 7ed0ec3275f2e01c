//! What every path through joint way-points asks of them.

use arcfeed_kinematics::Joints;

use crate::error::PathError;

/// Way-points closer than this are the same, rad.
const SAME: f64 = 1e-9;

/// The straight distances from the first of `points` to each, from one to the next, rad.
///
/// # Errors
/// [`PathError::TooFewWaypoints`] for fewer than two; [`PathError::Waypoint`] for one that is not finite or repeats the one before.
pub(super) fn distances<const N: usize>(points: &[Joints<N>]) -> Result<Vec<f64>, PathError> {
    if points.len() < 2 {
        return Err(PathError::TooFewWaypoints { count: points.len() });
    }
    let mut distances = Vec::with_capacity(points.len());
    distances.push(0.0);
    for (index, point) in points.iter().enumerate() {
        if let Some(joint) = (0..N).find(|&j| point[j].is_nan() || point[j].abs() >= 1e100) {
            return Err(PathError::Waypoint {
                index,
                problem: format!("has {} for joint {}, which is no ordinary number", point[joint], joint + 1),
            });
        }
        if index > 0 {
            let distance = (point - points[index - 1]).norm();
            if distance <= SAME {
                let problem = "repeats the one before: remove one of the two".to_owned();
                return Err(PathError::Waypoint { index, problem });
            }
            distances.push(distances[index - 1] + distance);
        }
    }
    Ok(distances)
}
