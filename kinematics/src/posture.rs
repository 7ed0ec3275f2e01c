//! The names of the eight solutions of a six-joint arm.

use crate::jacobian::Configuration;
use nalgebra::Vector3;

/// Which of up to eight solutions of its inverse an arm of six joints stands in, by the terms that controllers use.
///
/// It changes only at a singular pose of the shoulder, the elbow or the wrist, and depends on neither base nor tool. "Front" is
/// the side of axis 1 to which joint 2 leans the upright arm with growing values; so an arm whose joint 2 counts the other
/// way has front and back exchanged.
///
/// ```
/// use arcfeed_kinematics::{AnalyticInverse, ForwardKinematics, Joints, Posture, models};
/// let arm = models::ur5e();
/// let q = Joints::<6>::from([0.4, -1.2, 1.1, -0.9, -1.4, 0.2]);
/// let posture = arm.posture(&q).expect("an arm with three parallel axes");
/// assert_eq!(posture.to_string(), "front up flip");
/// assert_eq!("front up flip".parse::<Posture>(), Ok(posture));
/// // Only one of the solutions stands like this.
/// let all = arm.inverse_all(&arm.forward(&q))?;
/// assert_eq!(all.iter().filter(|q| arm.posture(q) == Some(posture)).count(), 1);
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Posture {
    /// The wrist is on the front side of axis 1.
    pub front: bool,
    /// The elbow is above the line from the shoulder to the end of the forearm.
    pub up: bool,
    /// The wrist is bent against the sense of axis 5.
    pub flip: bool,
}

impl Posture {
    /// The posture of an arm with axes 2 and 3 parallel. `wrist` is the wrist point, `lined_up` the two axes that line up
    /// where the wrist is singular, `elbow_end` the end of the forearm.
    pub(crate) fn of(
        at: &Configuration<6>,
        wrist: &Vector3<f64>,
        lined_up: [&Vector3<f64>; 2],
        elbow_end: &Vector3<f64>,
    ) -> Self {
        let (z, o) = (&at.axes, &at.points);
        let forward = z[1].cross(&z[0]);
        let front = forward.dot(&(wrist - o[0])) >= 0.0;
        // The side of the elbow, seen along axis 2 with the front to the left.
        let above = z[1].dot(&(o[2] - o[1]).cross(&(elbow_end - o[1]))) >= 0.0;
        let flip = lined_up[0].cross(lined_up[1]).dot(&z[4]) < 0.0;
        Self { front, up: above == front, flip }
    }
}

impl std::fmt::Display for Posture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let side = if self.front { "front" } else { "back" };
        let elbow = if self.up { "up" } else { "down" };
        let wrist = if self.flip { "flip" } else { "no-flip" };
        write!(f, "{side} {elbow} {wrist}")
    }
}

/// A text that names no [`Posture`].
#[cfg(feature = "std")]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no posture: name the side (front or back), the elbow (up or down) and the wrist (flip or no-flip)")]
pub struct NoPosture(String);

#[cfg(feature = "std")]
impl std::str::FromStr for Posture {
    type Err = NoPosture;

    fn from_str(text: &str) -> Result<Self, NoPosture> {
        let unknown = || NoPosture(text.chars().take(60).collect());
        let of = |word: Option<&str>, [yes, no]: [&str; 2]| match word {
            Some(word) if word == yes => Ok(true),
            Some(word) if word == no => Ok(false),
            _ => Err(unknown()),
        };
        let mut words = text.split_whitespace();
        let posture = Self {
            front: of(words.next(), ["front", "back"])?,
            up: of(words.next(), ["up", "down"])?,
            flip: of(words.next(), ["flip", "no-flip"])?,
        };
        if words.next().is_some() { Err(unknown()) } else { Ok(posture) }
    }
}
