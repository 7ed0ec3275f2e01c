//! The file of `cr7 plan --format html`.

#[cfg(feature = "html")]
use crate::{MotionPage, PageFacts, SpeedCeiling};
use crate::{Report, Robot, Staging, TrajectoryRow};
use arcfeed_interp::{LimitPoint, TorqueLimits};
use arcfeed_kinematics::JointLimits;

use crate::cli::Failure;
#[cfg(feature = "html")]
use crate::cli::formats::Format;
use crate::cli::plan_args::Args;
use crate::cli::plan_files::Drawn;
#[cfg(feature = "html")]
use crate::cli::plan_files::PAGE;

/// The page while its samples are collected.
pub struct PageFile<'a, const N: usize> {
    #[cfg(feature = "html")]
    page: Option<MotionPage<'a, N>>,
    /// From which place on (m), increasing, which limit sets the highest speed, in words.
    #[cfg(feature = "html")]
    limited_by: Vec<(f64, String)>,
    #[cfg(not(feature = "html"))]
    _limits: &'a JointLimits<N>,
}

impl<'a, const N: usize> PageFile<'a, N> {
    /// Begins the page of a motion of `samples` samples, where it is asked for.
    pub fn new(
        args: &Args,
        robot: &Robot,
        joints: &'a JointLimits<N>,
        torque: Option<&'a TorqueLimits<'a, N>>,
        samples: usize,
    ) -> Self {
        #[cfg(feature = "html")]
        {
            let facts = || PageFacts {
                robot: robot.description().name.clone(),
                joint_names: robot.any().joint_names().to_vec(),
                joints,
                torque,
            };
            let page = args.format.contains(&Format::Html).then(|| MotionPage::new(facts(), samples));
            Self { page, limited_by: Vec::new() }
        }
        #[cfg(not(feature = "html"))]
        {
            let _ = (args, robot, torque, samples);
            Self { _limits: joints }
        }
    }

    /// The next sample, with its place on the path (m) and the speed there (m/s).
    pub fn push(&mut self, row: &TrajectoryRow<N>, s: f64, feed: f64) {
        #[cfg(feature = "html")]
        if let Some(page) = &mut self.page {
            page.push(row, s, feed);
        }
        #[cfg(not(feature = "html"))]
        let _ = (row, s, feed);
    }

    /// Adds the limits that set the highest speed along a path that begins at `from` (m).
    pub fn see_limits(&mut self, curve: &[LimitPoint], from: f64) {
        #[cfg(feature = "html")]
        for point in curve {
            let name = point.id.map_or_else(|| "no limit".to_owned(), |id| id.to_string());
            if self.limited_by.last().is_none_or(|(_, last)| *last != name) {
                self.limited_by.push((from + point.s, name));
            }
        }
        #[cfg(not(feature = "html"))]
        let _ = (curve, from);
    }

    /// Writes the page.
    pub fn finish(self, report: &Report, drawn: &Drawn<'_, N>, staging: &mut Staging) -> Result<(), Failure> {
        #[cfg(feature = "html")]
        if let Some(page) = self.page {
            let ceiling = SpeedCeiling { by_time: &drawn.limit_by_time, limits: &self.limited_by };
            staging.write(PAGE, &page.finish(report, &ceiling, &drawn.poses))?;
        }
        #[cfg(not(feature = "html"))]
        let _ = (report, drawn, staging);
        Ok(())
    }
}
