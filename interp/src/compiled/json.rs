//! Joint trajectories as JSON, format "joint-trajectory/1": s, rad and their quotients.

use serde::{Deserialize, Serialize};

use super::error::JointTrajectoryError;
use super::joint_trajectory::{Deviation, Interpolation, JointTrajectory};
use arcfeed_kinematics::Joints;

const FORMAT: &str = "joint-trajectory/1";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    interpolation: Name,
    joint_names: Vec<String>,
    #[serde(default)]
    deviation_bound_rad: Option<f64>,
    #[serde(default)]
    deviation_measured_rad: Option<f64>,
    times_s: Vec<f64>,
    coefficients_rad_per_s_k: Vec<Vec<[f64; 6]>>,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Name {
    Quintic,
    Cubic,
}

/// A message, of a long one its beginning and its end: it can repeat a text of the file.
fn clipped(text: &str) -> String {
    const BEGINNING: usize = 600;
    const END: usize = 400;
    let length = text.chars().count();
    if length <= BEGINNING + END {
        return text.to_owned();
    }
    let beginning = text.chars().take(BEGINNING).chain(" ... ".chars());
    beginning.chain(text.chars().skip(length - END)).collect()
}

impl<const N: usize> JointTrajectory<N> {
    /// The motion as JSON in the format "joint-trajectory/1", with the names of its joints. Reading it gives the same numbers.
    ///
    /// ```json
    /// { "format": "joint-trajectory/1",
    ///   "interpolation": "quintic",
    ///   "joint_names": ["shoulder", "elbow"],
    ///   "deviation_bound_rad": 1e-6, "deviation_measured_rad": 9e-7,
    ///   "times_s": [0.0, 0.5],
    ///   "coefficients_rad_per_s_k": [
    ///     [[0.1, 0.0, 0.0, 0.5, -0.3, 0.0], [0.2, 0.0, 0.0, 0.1, 0.0, 0.0]]
    ///   ] }
    /// ```
    ///
    /// Piece `i` runs from `times_s[i]` to `times_s[i + 1]`. It holds one list for each joint: the coefficients `c` of
    /// `q(t) = sum c[k] (t - times_s[i])^k` for `k` from 0 to 5, in rad/s^k (m/s^k for joints that slide). Both deviations are absent or
    /// null where there is no plan. Keys that are not known are an error.
    pub fn to_json(&self, joint_names: &[String; N]) -> String {
        let piece = |c: &[Joints<N>; 6]| (0..N).map(|j| std::array::from_fn(|k| c[k][j])).collect();
        let file = File {
            format: FORMAT.to_owned(),
            interpolation: match self.interpolation() {
                Interpolation::Quintic => Name::Quintic,
                Interpolation::Cubic => Name::Cubic,
            },
            joint_names: joint_names.to_vec(),
            deviation_bound_rad: self.deviation().map(|deviation| deviation.bound),
            deviation_measured_rad: self.deviation().map(|deviation| deviation.measured),
            times_s: self.times().to_vec(),
            coefficients_rad_per_s_k: self.coefficients().iter().map(piece).collect(),
        };
        // Finite numbers and strings always become JSON.
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// The motion and the names of its joints from JSON in the format "joint-trajectory/1".
    ///
    /// ```
    /// use arcfeed_interp::{Interpolation, JointTrajectory};
    /// use arcfeed_kinematics::Joints;
    ///
    /// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(|c| Joints::from([c]));
    /// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
    /// let text = motion.to_json(&["elbow".to_owned()]);
    /// let (again, names) = JointTrajectory::<1>::from_json(&text)?;
    /// assert_eq!((again, names[0].as_str()), (motion, "elbow"));
    /// # Ok::<(), arcfeed_interp::JointTrajectoryError>(())
    /// ```
    ///
    /// # Errors
    /// [`JointTrajectoryError::File`] for text that is not of this format or of another number of joints; otherwise as
    /// [`JointTrajectory::from_pieces`].
    pub fn from_json(text: &str) -> Result<(Self, [String; N]), JointTrajectoryError> {
        let wrong = |problem: String| JointTrajectoryError::File { problem: clipped(&problem) };
        let file: File = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if file.format != FORMAT {
            return Err(wrong(format!("format is {:?}, but has to be {FORMAT:?}", file.format)));
        }
        let names = file.joint_names.try_into();
        let names: [String; N] = names
            .map_err(|names: Vec<String>| wrong(format!("{} joint names, but the arm has {N} joints", names.len())))?;
        let mut pieces = Vec::with_capacity(file.coefficients_rad_per_s_k.len());
        for (i, piece) in file.coefficients_rad_per_s_k.iter().enumerate() {
            if piece.len() != N {
                let problem = format!("piece {i} has {} joints, but the arm has {N}", piece.len());
                return Err(wrong(problem));
            }
            pieces.push(std::array::from_fn(|k| Joints::from_fn(|j, _| piece[j][k])));
        }
        let deviation = match (file.deviation_bound_rad, file.deviation_measured_rad) {
            (Some(bound), Some(measured)) if measured >= 0.0 && bound >= measured => {
                Some(Deviation { bound, measured })
            }
            (None, None) => None,
            _ => {
                return Err(wrong(
                    "deviations come in pairs, the measured one at least 0 and at most the bound".into(),
                ));
            }
        };
        let interpolation = match file.interpolation {
            Name::Quintic => Interpolation::Quintic,
            Name::Cubic => Interpolation::Cubic,
        };
        let motion = Self::from_pieces(file.times_s, pieces, interpolation)?;
        Ok((motion.with_deviation(deviation), names))
    }
}
