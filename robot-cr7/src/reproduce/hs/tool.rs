//! The tool of Liu et al. 2024, Table 5.

use arcfeed_sync::nalgebra::{Isometry3, Quaternion, SVector, UnitQuaternion, Vector3};
use arcfeed_sync::{PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, SyncError};

use super::conditions::{CYCLES, PERIOD};
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};

/// Limits of the tool, of which the paper prints none: velocity, acceleration, jerk in m and in
/// rad.
const LINEAR: [f64; 3] = [0.5, 3.0, 40.0];
const ANGULAR: [f64; 3] = [1.5, 8.0, 100.0];

pub(super) const FROM_POINT: [f64; 3] = [0.1463, -0.4679, -0.0066];
pub(super) const TO_POINT: [f64; 3] = [-0.35, -0.35, 0.1];
/// x y z w.
pub(super) const FROM_QUATERNION: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
pub(super) const TO_QUATERNION: [f64; 4] = [0.4711, 0.7322, 0.4668, -0.1551];

pub(super) type ToolRun = (SampledMotion, Vec<[f64; 3]>, Vec<[f64; 4]>);

/// The motion as way along its line and angle about its axis, tool points, and orientations.
pub(super) fn tool_run() -> Result<ToolRun, SyncError> {
    let pose = |p: [f64; 3], [x, y, z, w]: [f64; 4]| {
        Isometry3::from_parts(SVector::from(p).into(), UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
    };
    let (from, to) = (pose(FROM_POINT, FROM_QUATERNION), pose(TO_POINT, TO_QUATERNION));
    let mut sync = PoseProjectionSync::new(&PoseState::rest(from), to, &PoseLimits::new(LINEAR, ANGULAR)?)?;
    let (mut t, mut states, mut arrived) = (vec![0.0], vec![PoseState::rest(from)], false);
    for cycle in 1..=CYCLES {
        let step = sync.step(PERIOD)?;
        let unused = if let ProjectionStatus::Reached { unused } = step.status { Some(unused) } else { None };
        t.push(PERIOD * f64::from(cycle) - unused.unwrap_or(0.0));
        states.push(step.state);
        arrived = unused.is_some();
        if arrived {
            break;
        }
    }
    let length = Vector3::from(TO_POINT) - Vector3::from(FROM_POINT);
    let way = length.normalize();
    // Angle from the scalar product of quaternions, axis from the cross product of two half-way
    // pictures.
    let dot = SVector::<f64, 4>::from(TO_QUATERNION).normalize().dot(&SVector::from(FROM_QUATERNION));
    let angle = 2.0 * dot.abs().min(1.0).acos();
    let axis = {
        let q = to.rotation * from.rotation.inverse();
        q.vector().normalize() * q.w.signum()
    };
    let turned = |s: &PoseState| {
        let q = s.pose.rotation * from.rotation.inverse();
        2.0 * q.vector().norm().atan2(q.w.abs())
    };
    let of = |f: &dyn Fn(&PoseState) -> f64| states.iter().map(f).collect::<Vec<f64>>();
    let bounds = |l: [f64; 3]| vec![(0.0, AxisBounds::symmetric(l[0], l[1], l[2]))];
    let linear = SampledAxis {
        name: "way".to_owned(),
        p: of(&|s| (s.pose.translation.vector - Vector3::from(FROM_POINT)).dot(&way)),
        v: of(&|s| s.velocity.fixed_rows::<3>(0).dot(&way)),
        a: of(&|s| s.acceleration.fixed_rows::<3>(0).dot(&way)),
        start: [0.0; 3],
        end: [length.norm(), 0.0, 0.0],
        bounds: bounds(LINEAR),
    };
    let angular = SampledAxis {
        name: "angle".to_owned(),
        p: of(&turned),
        v: of(&|s| s.velocity.fixed_rows::<3>(3).dot(&axis)),
        a: of(&|s| s.acceleration.fixed_rows::<3>(3).dot(&axis)),
        start: [0.0; 3],
        end: [angle, 0.0, 0.0],
        bounds: bounds(ANGULAR),
    };
    let points = states.iter().map(|s| s.pose.translation.vector.into()).collect();
    let orientations = states.iter().map(|s| s.pose.rotation.coords.into()).collect();
    Ok((SampledMotion { t, axes: vec![linear, angular], arrived: Some(arrived), tolerance: 0.0 }, points, orientations))
}
