//! The scans with S-profiles as planners: from the bounds of a problem to a law.

use super::continuous_acceleration::{plan_continuous, plan_continuous_at_once};
use super::per_segment::{plan_per_segment, plan_windowed};
use super::segment::Segment;
use crate::error::FeedError;
use crate::problem::{FeedPlanner, FeedProblem, LimitPartition};
use crate::speed_law::SpeedLaw;

/// The scan with continuous acceleration ([`plan_continuous`]) over the boxes of a problem, each
/// limit shared out between speed, acceleration and jerk by fixed parts: a tenth of the computing
/// time of [`JerkLimited`](crate::JerkLimited), a longer motion.
///
/// Plans with several partitions of the limits and keeps the fastest law. Needs
/// [`FeedProblem::between_points`] with limits on acceleration and jerk along the path. It stops at
/// grid points whose cap is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ContinuousAccelerationScan;

/// One S-profile per interval with zero acceleration at each boundary (Liu et al. 2023, algorithm
/// 2); needs what [`ContinuousAccelerationScan`] needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PerSegmentScan {
    /// Look-ahead in intervals; `None` for the whole path.
    pub window: Option<usize>,
}

impl FeedPlanner for ContinuousAccelerationScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        // The partitions that go through at once are quick, and the fastest laws are among them;
        // the thorough scan is for where none does.
        let at_once = |segments: &[Segment]| {
            let mut laws = Vec::new();
            for (part, [v_start, v_end]) in parts(problem, segments) {
                let Some(law) = plan_continuous_at_once(part, v_start, v_end)? else { return Ok(None) };
                laws.push(law);
            }
            Ok(Some(SpeedLaw::chain(problem.grid()[0], laws)))
        };
        if let Some(law) = fastest(problem, SpeedLaw::duration, at_once)? {
            return Ok(law);
        }
        let segments = problem.segments(&LimitPartition::ALL[0])?;
        let laws = parts(problem, &segments).map(|(part, [v_start, v_end])| plan_continuous(part, v_start, v_end));
        Ok(SpeedLaw::chain(problem.grid()[0], laws.collect::<Result<Vec<_>, _>>()?))
    }
}

impl FeedPlanner for PerSegmentScan {
    fn plan(&self, problem: &FeedProblem) -> Result<SpeedLaw, FeedError> {
        if self.window.is_some() && problem.v_end() > 0.0 {
            return Err(FeedError::WindowEndSpeed { speed: problem.v_end() });
        }
        let scan = |segments: &[Segment]| {
            let laws = parts(problem, segments).map(|(part, [v_start, v_end])| match self.window {
                None => plan_per_segment(part, v_start, v_end),
                Some(window) => plan_windowed(part, v_start, window),
            });
            Ok(Some(SpeedLaw::chain(problem.grid()[0], laws.collect::<Result<Vec<_>, _>>()?)))
        };
        // There always is one: a scan that fails says why.
        fastest(problem, SpeedLaw::duration, scan)?.ok_or(FeedError::Empty { what: "partitions of the limits" })
    }
}

/// The result of the partition with which it is shortest; `None` where `scan` finds none for any.
pub(super) fn fastest<T>(
    problem: &FeedProblem,
    duration: impl Fn(&T) -> f64,
    scan: impl Fn(&[Segment]) -> Result<Option<T>, FeedError>,
) -> Result<Option<T>, FeedError> {
    let mut best: Option<T> = None;
    for partition in &LimitPartition::ALL {
        if let Some(found) = scan(&problem.segments(partition)?)?
            && best.as_ref().is_none_or(|best| duration(&found) < duration(best))
        {
            best = Some(found);
        }
    }
    Ok(best)
}

/// The stretches between stops, each with the speeds at its ends.
pub(super) fn parts<'s>(
    problem: &FeedProblem,
    segments: &'s [Segment],
) -> impl Iterator<Item = (&'s [Segment], [f64; 2])> {
    let n = segments.len();
    let stops: Vec<usize> = (1..n).filter(|&i| problem.x_max(i) == 0.0).collect();
    let starts: Vec<(usize, f64)> =
        std::iter::once((0, problem.v_start())).chain(stops.iter().map(|&i| (i, 0.0))).collect();
    let ends = stops.into_iter().map(|i| (i, 0.0)).chain(std::iter::once((n, problem.v_end())));
    let pairs: Vec<_> = starts.into_iter().zip(ends).collect();
    pairs.into_iter().map(|((from, v_start), (to, v_end))| (&segments[from..to], [v_start, v_end]))
}
