//! Places along a motion, for the pictures of its path.

use arcfeed_interp::{PlanError, Setpoint, Trajectory};
use nalgebra::Isometry3;

use crate::plot::PathPlace;
use crate::{JointMove, PartMotion, ProgramMotion};

/// Places along the longest side of a path: about one a pixel.
const ACROSS: f64 = 1000.0;
/// The most places along all of a path; a path that needs more is so long that its laps are drawn over each other.
const MOST: f64 = 400_000.0;
/// Places along a motion of the joints.
const OF_JOINTS: f64 = 400.0;

/// The distance of places (m) that can be told apart in a picture of these points (m), on a path of this length (m).
pub fn distance_of_places(segments: &[Vec<[f64; 3]>], length: f64) -> f64 {
    let side = |k: usize| {
        let values = segments.iter().flatten().map(|p| p[k]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        (high - low).max(0.0)
    };
    ((0..3).map(side).fold(0.0, f64::max) / ACROSS).max(length / MOST)
}

/// Places of the tool along its path, `apart` (m) and nearer, in the frame of the workpiece; both ends are among them. The way counts
/// from `from` (m) on.
pub fn places_of_path<const N: usize>(
    plan: &Trajectory<'_, N>,
    workpiece: &Isometry3<f64>,
    from: f64,
    apart: f64,
) -> Vec<PathPlace> {
    let Some(path) = plan.path().tool_curve() else { return Vec::new() };
    let inverse = workpiece.inverse();
    let place = |s: f64| PathPlace {
        at: inverse.transform_point(&path.curve().point(s).into()).into(),
        s: from + s,
        speed: plan.law().v_at_s(s),
    };
    let breaks = plan.breaks();
    let (mut places, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for piece in breaks.windows(2) {
        let steps = ((piece[1] - piece[0]) / apart).ceil().clamp(1.0, MOST);
        for step in 0..steps as usize {
            let s = piece[0] + (piece[1] - piece[0]) * step as f64 / steps;
            // Many pieces may be shorter than a pixel.
            if s - last >= 0.5 * apart {
                places.push(place(s));
                last = s;
            }
        }
    }
    places.extend(breaks.last().map(|end| place(*end)));
    places
}

/// Places of the tool in all parts of a program, in the same way.
///
/// # Errors
/// Never for a motion that was planned; the signature is that of [`Trajectory::setpoints`].
pub fn places_of_program<const N: usize>(
    motion: &ProgramMotion<'_, N>,
    workpiece: &Isometry3<f64>,
    apart: f64,
) -> Result<Vec<PathPlace>, PlanError> {
    let mut places = Vec::new();
    for part in motion.parts() {
        match part.motion() {
            PartMotion::Path(path) => {
                places.extend(places_of_path(path.trajectory(), workpiece, part.from(), apart));
            }
            PartMotion::Joints(joints) => places.extend(places_of_joints(motion, joints, workpiece, part.from())?),
            PartMotion::Dwell(_) => {}
        }
    }
    Ok(places)
}

/// Places of the tool during rapid moves of the joints.
fn places_of_joints<const N: usize>(
    motion: &ProgramMotion<'_, N>,
    joints: &JointMove<'_, N>,
    workpiece: &Isometry3<f64>,
    from: f64,
) -> Result<Vec<PathPlace>, PlanError> {
    let (plan, inverse) = (joints.trajectory(), workpiece.inverse());
    let setpoints = plan.setpoints(plan.duration() / OF_JOINTS).map_err(PlanError::from)?;
    let place = |at: Result<Setpoint<N>, PlanError>| {
        at.map(|at| PathPlace {
            at: inverse.transform_point(&at.pose.translation.vector.into()).into(),
            s: from + joints.way_at(at.s),
            speed: (motion.arm().jacobian(&at.q) * at.qd).fixed_rows::<3>(0).norm(),
        })
    };
    setpoints.map(place).collect()
}
