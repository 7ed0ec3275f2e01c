//! A setpoint with what the tool really does there.

use arcfeed_kinematics::Twist;
use nalgebra::Vector3;

use super::requirement::Requirement;
use crate::setpoint::Setpoint;

/// A setpoint, and the motion of the tool recomputed from its joints.
pub(crate) struct Sample<const N: usize> {
    pub at: Setpoint<N>,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// Angular speed.
    pub turning: f64,
    /// True if the tool moves; its direction is that of the path otherwise.
    pub moves: bool,
    /// Acceleration of the tool point.
    pub acceleration: Vector3<f64>,
    /// Its parts along the direction of the tool and across it.
    pub tangential: f64,
    pub normal: f64,
    /// Distance from the path and angle to its orientation, where the path prescribes the tool.
    pub off_path: f64,
    pub turned: f64,
    /// Position and angle by which the setpoint's own pose is off, in m and rad added up.
    pub misstated: f64,
}

impl<const N: usize> Sample<N> {
    pub fn new(r: &Requirement<'_, N>, at: Setpoint<N>) -> Self {
        let configuration = r.arm.configuration(&at.q);
        let jacobian = configuration.jacobian();
        let linear = |v: Twist| Vector3::new(v[0], v[1], v[2]);
        let pose = configuration.pose();
        let position = pose.translation.vector;
        let twist = jacobian * at.qd;
        let velocity = linear(twist);
        let acceleration = linear(jacobian * at.qdd + configuration.acceleration_bias(&at.qd));
        let tool = r.path.tool(at.s);
        // At a standstill the motion has no direction of its own; the path has one.
        let of_path = || match tool {
            Some(tool) => linear(tool.d1).try_normalize(0.5),
            None => r.path.jet(at.s, &at.q).ok().and_then(|jet| linear(jacobian * jet.d1).try_normalize(1e-9)),
        };
        let of_motion = velocity.try_normalize(1e-9);
        let direction = of_motion.or_else(of_path);
        let tangential = direction.map_or(0.0, |direction| acceleration.dot(&direction));
        let normal = direction.map_or(0.0, |direction| (acceleration - direction * tangential).norm());
        let stated = (at.pose.translation.vector - position).norm() + at.pose.rotation.angle_to(&pose.rotation);
        Self {
            turned: tool.map_or(0.0, |tool| pose.rotation.angle_to(&tool.pose.rotation)),
            misstated: stated,
            position,
            velocity,
            moves: of_motion.is_some(),
            turning: Vector3::new(twist[3], twist[4], twist[5]).norm(),
            acceleration,
            tangential,
            normal,
            off_path: tool.map_or(0.0, |tool| (position - tool.pose.translation.vector).norm()),
            at,
        }
    }
}
