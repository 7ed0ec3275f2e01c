//! A planned and verified motion, with all that a report needs.

use std::time::Duration;

use arcfeed_interp::{LimitError, Setpoints, Trajectory};
use nalgebra::Vector3;

use super::outline::Outline;
use super::placed_path::PointFit;
use super::side_effects::{ThermalLine, VibrationLine};
use super::stream::StreamReport;

/// A planned and verified motion along the path of a [`Task`](super::task::Task), with all that a report needs.
#[derive(Debug, Clone)]
pub struct Motion<'t, const N: usize = 6> {
    pub(super) name: &'t str,
    pub(super) trajectory: Trajectory<'t, N>,
    pub(super) preparation: Duration,
    pub(super) stream: Option<StreamReport>,
    pub(super) outline: Option<&'t Outline>,
    pub(super) fit: Option<PointFit>,
    pub(super) vibration: Vec<VibrationLine>,
    pub(super) thermal: Vec<ThermalLine>,
    pub(super) warnings: Vec<String>,
}

impl<'t, const N: usize> Motion<'t, N> {
    /// Name of the path.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The trajectory: path, speed, limits, verification.
    pub fn trajectory(&self) -> &Trajectory<'t, N> {
        &self.trajectory
    }

    /// What the look-ahead cost, if the motion was streamed.
    pub fn stream(&self) -> Option<&StreamReport> {
        self.stream.as_ref()
    }

    /// The lines of the file along the path, where it has such.
    pub fn outline(&self) -> Option<&Outline> {
        self.outline
    }

    /// How near the path is to the points of its file, where it is a smooth curve through such.
    pub fn fit(&self) -> Option<PointFit> {
        self.fit
    }

    /// The vibrations of the structures that the job names.
    pub fn vibration(&self) -> &[VibrationLine] {
        &self.vibration
    }

    /// The thermal load of the drives, where torque is limited.
    pub fn thermal(&self) -> &[ThermalLine] {
        &self.thermal
    }

    /// Warnings about the motion.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds what else a person should know, such as an assumption about the arm.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.warnings.extend(warnings);
    }

    /// Time from the path file to the finished plan without its verification.
    pub fn planning_time(&self) -> Duration {
        self.preparation + self.trajectory.timings().planning()
    }

    /// Setpoints at the job's control period, start and end included.
    ///
    /// # Errors
    /// Never for a motion that was planned; the signature is that of [`Trajectory::setpoints`].
    pub fn setpoints(&self) -> Result<Setpoints<'_, 't, N>, LimitError> {
        self.trajectory.setpoints(self.trajectory.period())
    }
}

/// What is said of corners in which the tool stops.
pub(crate) fn corner_words(corners: usize) -> Option<String> {
    (corners > 0).then(|| format!("the path has {corners} corners, where the tool stops"))
}

/// Points of each chord segment, dense enough to be drawn as a curve, in the frame of the workpiece (x, y, z in m).
pub fn drawn_segments<const N: usize>(
    plan: &Trajectory<'_, N>,
    workpiece: &nalgebra::Isometry3<f64>,
) -> Vec<Vec<[f64; 3]>> {
    let inverse = workpiece.inverse();
    let Some(path) = plan.path().tool_curve() else { return Vec::new() };
    let curve = path.curve();
    plan.breaks()
        .windows(2)
        .map(|b| {
            (0..=8)
                .map(|i| {
                    let s = b[0] + (b[1] - b[0]) * f64::from(i) / 8.0;
                    let p: Vector3<f64> = inverse.transform_point(&curve.point(s).into()).coords;
                    p.into()
                })
                .collect()
        })
        .collect()
}
