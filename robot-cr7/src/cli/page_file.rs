//! The file of `cr7 plan --format html`.

#[cfg(feature = "html")]
use std::path::Path;

#[cfg(feature = "html")]
use crate::{LinkMesh, MotionPage, PageFacts, SpeedCeiling, read_meshes};
use crate::{Report, Robot, Staging, TrajectoryRow};
use arcfeed_interp::{LimitPoint, TorqueLimits};
use arcfeed_kinematics::JointLimits;

use crate::cli::Failure;
use crate::cli::formats::Format;
use crate::cli::plan_args::Args;
use crate::cli::plan_files::Drawn;
#[cfg(feature = "html")]
use crate::cli::plan_files::PAGE;

/// The meshes of the robot's links, where they are asked for.
pub struct Meshes {
    #[cfg(feature = "html")]
    links: Vec<LinkMesh>,
}

impl Meshes {
    /// Reads them before anything is planned.
    pub fn read(args: &Args) -> Result<Self, Failure> {
        if args.meshes.is_some() && !args.format.contains(&Format::Html) {
            return Err(Failure::BadInput("--meshes: meshes are drawn on a page alone: add --format html".to_owned()));
        }
        #[cfg(feature = "html")]
        {
            let Some(folder) = &args.meshes else { return Ok(Self { links: Vec::new() }) };
            let (robot, base) = (args.robot.load()?, args.robot.base_link.as_deref());
            let links = read_meshes(Path::new(&args.robot.robot), folder, base, robot.description());
            Ok(Self { links: links.map_err(crate::Cr7Error::from)? })
        }
        #[cfg(not(feature = "html"))]
        Ok(Self {})
    }
}

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
        meshes: Meshes,
    ) -> Self {
        #[cfg(feature = "html")]
        {
            let facts = || PageFacts {
                robot: robot.description().name.clone(),
                joint_names: robot.any().joint_names().to_vec(),
                joints,
                torque,
                meshes: meshes.links,
            };
            let page = args.format.contains(&Format::Html).then(|| MotionPage::new(facts(), samples));
            Self { page, limited_by: Vec::new() }
        }
        #[cfg(not(feature = "html"))]
        {
            let _ = (args, robot, torque, samples, meshes);
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
