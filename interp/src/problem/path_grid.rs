//! From a path to its grid: chord segments, sections and where limits are evaluated.

use arcfeed_geometry::{PosePath, Segmentation, SegmentationMethod};

use super::grid::{self, Measure};
use super::settings::{MOST_INTERVALS, Settings};
use crate::error::{LimitError, PathError, PlanError};
use crate::limits::{self, Feeds, Section};
use crate::path::MotionPath;

/// Motion of the tool per motion of a joint, m/rad, where a limit of the tool itself is not set.
const REACH: f64 = 1.0;

/// The grid of a path, with what it was made from.
#[derive(Debug, Clone)]
pub(crate) struct PathGrid {
    /// Values of the parameter.
    pub grid: Vec<f64>,
    /// Chord segments of a curve of the tool.
    pub segmentation: Option<Segmentation>,
    /// Arc lengths where they begin and end, m.
    pub breaks: Vec<f64>,
    /// Parts with a feed of their own, by arc length.
    pub sections: Vec<Section>,
}

impl PathGrid {
    /// Cuts a curve of the tool into chord segments and lays a grid over it; over any other path a grid of equal steps. Chord
    /// segments begin and end on the grid where `on_breaks` says so: they matter to the scans that know one box for each interval.
    pub fn lay<const N: usize>(
        settings: &Settings<'_, N>,
        path: &dyn MotionPath<N>,
        on_breaks: bool,
    ) -> Result<Self, PlanError> {
        let Some(curve) = path.tool_curve() else {
            if !settings.sections.is_empty() {
                return Err(LimitError::Unsuited {
                    limit: "a feed section",
                    problem: "is a part of a curve of the tool, which this path has not",
                    remedy: "limit the feed of the whole motion",
                }
                .into());
            }
            // At the most so many between neighbouring knots that are hardly apart.
            let places = grid::places(path.knots(), path.corners(), path.length());
            fits(grid::BETWEEN_STOPS * (places.len() + 1))?;
            let grid = grid::equal_steps(path.length(), &places, path.corners(), settings.intervals);
            return Ok(Self { grid, segmentation: None, breaks: Vec::new(), sections: Vec::new() });
        };
        let segmentation = curve
            .curve()
            .curve()
            .segment(SegmentationMethod::Greedy { across_knots: false }, settings.chord_tolerance)
            .map_err(PathError::from)?;
        let breaks: Vec<f64> = segmentation.breaks().iter().map(|&u| curve.curve().arc_length_at(u)).collect();
        let mut sections = limits::resolve(&settings.sections, curve, &breaks)?;
        let mut places = if on_breaks { breaks.clone() } else { Vec::new() };
        places.extend(sections.iter().flat_map(|section| [section.from, section.to]));
        places.extend(path.corners());
        let measure = measure(settings, curve, &sections)?;
        let mut grid = grid::along_curve(curve, &curve.knots(), &places, &measure);
        let shortest = grid::shortest(grid.len(), settings.period);
        if shortest > 0.0 {
            grid = grid::along_curve(curve, &curve.knots(), &places, &Measure { shortest, ..measure });
        }
        fits(grid.len() - 1)?;
        limits::snap(&mut sections, &grid);
        Ok(Self { grid, segmentation: Some(segmentation), breaks, sections })
    }
}

/// Refuses a grid that would not fit into the memory of an ordinary machine.
fn fits(intervals: usize) -> Result<(), LimitError> {
    if intervals > MOST_INTERVALS { Err(LimitError::TooFine { intervals, most: MOST_INTERVALS }) } else { Ok(()) }
}

/// The measure of the density of the grid over a curve.
fn measure<const N: usize>(
    settings: &Settings<'_, N>,
    curve: &PosePath,
    sections: &[Section],
) -> Result<Measure, LimitError> {
    let (tool, joints) = (settings.limits.tool(), settings.limits.joints());
    let elsewhere = settings.feed()?;
    Ok(Measure {
        feed: Feeds { elsewhere, sections }.highest().min(settings.reachable(curve.length())),
        normal_acceleration: tool.normal_acceleration().unwrap_or(REACH * joints.acceleration().min()),
        jerk: tool.tangential_jerk().unwrap_or(REACH * joints.jerk().min()),
        shortest: 0.0,
    })
}
