//! Places of a path where the arm is close to singular, or changes the branch of its inverse: found ahead of time, and what to do there.
//!
//! Liu et al. 2024, section 5.3, name this as future research and a way: look ahead along the path, find stable joint values beyond the
//! singular region, and go there through joint space.

use std::sync::Arc;

use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints, largest_step, nearest_solution};
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};

use super::error::{HybridError, LiveError};
use super::joints::axis_limits;
use super::live_path::LivePath;
use crate::arm::PathArm;
use crate::error::{LimitError, PathError};
use crate::path::{JointJet, MotionPath, ToolPath};
use crate::planner::Planner;

/// Places at which the path is looked at.
const LOOKS: usize = 2000;
/// A step between two of them that misses the prediction by more than this is a change of branch, rad.
const JUMP: f64 = 0.05;
/// An interval of fewer looks between two that are singular belongs to them.
const LEAST: usize = 20;
/// Samples of a way round on which its deviation is measured.
const SAMPLES: usize = 400;

/// The policy where a path asks for more than the joints can do at a fair speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SingularityPolicy {
    /// Follow it, as slowly as the joints need. Where it cannot be followed at any speed that is an error.
    SlowDown,
    /// Stop before, go through joint space to where the path can be followed again, and go on from there.
    GoRound {
        /// Part of the feed: where joint velocities allow less than this, it counts as a stall.
        stall: f64,
    },
    /// An error that names the place.
    Refuse {
        /// As in [`SingularityPolicy::GoRound`].
        stall: f64,
    },
}

/// Why an interval of a path is left out or refused.
#[derive(Debug, Clone, PartialEq)]
pub enum SingularityKind {
    /// The velocity limit of a joint allows only this speed of the tool.
    Stall {
        /// The joint, from 0.
        joint: usize,
        /// Lowest speed that is allowed on the interval, m/s.
        speed: f64,
    },
    /// The inverse changes its branch, or there is none.
    NotFollowed(Box<PathError>),
}

impl std::fmt::Display for SingularityKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stall { joint, speed } => {
                write!(f, "the velocity limit of joint {} allows the tool only {speed:.4} m/s", joint + 1)
            }
            Self::NotFollowed(error) => error.fmt(f),
        }
    }
}

/// An interval of a path, near singular poses, between two places where it can be followed.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularInterval<const N: usize = 6> {
    /// The last place before it, m.
    pub from: f64,
    /// The first place behind it, m; the end of the path if there is none.
    pub to: f64,
    /// Joint values at both, rad; the second is `None` where the path is not followed to its end.
    pub joints: (Joints<N>, Option<Joints<N>>),
    /// The fault there, the worst of several.
    pub kind: SingularityKind,
}

/// A way round a singular interval, through joint space.
#[derive(Debug, Clone, PartialEq)]
pub struct Detour<const N: usize = 6> {
    /// The interval that is left out.
    pub interval: SingularInterval<N>,
    /// The largest distance of the tool point from it, m.
    pub deviation: f64,
    /// The duration, s.
    pub duration: f64,
}

/// A path in parts that can be followed, with ways round what cannot.
#[derive(Debug, Clone)]
pub struct LiveRoute<'p, const N: usize = 6> {
    parts: Vec<LivePath<'p, N>>,
    detours: Vec<Detour<N>>,
}

impl<'p, const N: usize> LiveRoute<'p, N> {
    /// The parts, in order; without detours the one is the whole path.
    pub fn parts(&self) -> &[LivePath<'p, N>] {
        &self.parts
    }

    /// The first part.
    pub fn first(&self) -> &LivePath<'p, N> {
        // There is one: no route is made without.
        &self.parts[0]
    }

    /// The part on which the arc length `s` (m) lies, or that before it.
    pub fn part_at(&self, s: f64) -> &LivePath<'p, N> {
        &self.parts[self.parts.partition_point(|part| part.range().0 <= s).saturating_sub(1)]
    }

    /// The ways round, one between each two parts.
    pub fn detours(&self) -> &[Detour<N>] {
        &self.detours
    }
}

impl<'a, const N: usize> Planner<'a, N> {
    /// The intervals of `path` where the joints allow less than the part `stall` of the feed, or cannot follow at all.
    ///
    /// The path is looked at in 2000 places; an interval begins and ends at one of them.
    ///
    /// # Errors
    /// [`PathError::Arm`] when the start of the path is out of reach, [`LimitError::NotPositive`] for a `stall` that is not above 0 and
    /// below 1, [`LimitError::Unsuited`] without a feed.
    pub fn find_singular_intervals<A>(
        &self,
        arm: &A,
        path: &ToolPath<'_, N>,
        stall: f64,
    ) -> Result<Vec<SingularInterval<N>>, LiveError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
    {
        if !(stall > 0.0 && stall < 1.0) {
            let what = "part of the feed that counts as a stall (below 1)";
            return Err(LimitError::NotPositive { what, value: stall }.into());
        }
        let limits = self.settings().limits;
        let feed = self.settings().feed()?;
        let velocity = limits.joints().velocity();
        let slowest = stall * feed;
        let stall_at = |jet: &JointJet<N>| stalled(velocity, jet, slowest);
        let mut found: Vec<SingularInterval<N>> = Vec::new();
        let mut last = path.jet(0.0, &path.start())?;
        let mut open: Option<SingularityKind> = stall_at(&last);
        // Looks since the path was taken up again.
        let mut since = LEAST;
        let at = |i: usize| path.length() * i as f64 / LOOKS as f64;
        for s in (1..=LOOKS).map(at) {
            let next = match &open {
                None => follow(path, s, &last),
                Some(_) => take_up(arm, path, s, &last.q, limits.joints().range()),
            };
            match (next, open.take()) {
                (Ok(jet), was_open) => match (stall_at(&jet), was_open) {
                    (None, None) => {
                        last = jet;
                        since += 1;
                    }
                    (None, Some(kind)) => {
                        found.push(SingularInterval { from: last.s, to: s, joints: (last.q, Some(jet.q)), kind });
                        (last, since) = (jet, 0);
                    }
                    (Some(stall), was_open) => {
                        open = Some(was_open.map_or(stall.clone(), |known| worse(known, stall)));
                    }
                },
                (Err(error), was_open) => {
                    let wrong = SingularityKind::NotFollowed(Box::new(error));
                    open = Some(was_open.map_or(wrong.clone(), |known| worse(known, wrong)));
                }
            }
            // Followed for a moment only: one interval with the one before.
            if open.is_some()
                && since < LEAST
                && let Some(before) = found.pop()
            {
                open = open.map(|now| worse(before.kind, now));
                last = path.jet(before.from, &before.joints.0)?;
                since = LEAST;
            }
        }
        if let Some(kind) = open {
            found.push(SingularInterval { from: last.s, to: path.length(), joints: (last.q, None), kind });
        }
        Ok(found)
    }

    /// Makes a path of `arm` ready for [`HybridMotion::along`](crate::HybridMotion::along), and deals with singular places as `policy`
    /// says.
    ///
    /// # Errors
    /// [`PathError::Singular`] naming the interval: where it is refused, or where the path starts or ends in it, so that there is no way
    /// round. Otherwise as [`Planner::live`].
    pub fn route<'p, A>(
        &self,
        arm: &A,
        path: ToolPath<'p, N>,
        policy: SingularityPolicy,
    ) -> Result<LiveRoute<'p, N>, LiveError>
    where
        A: PathArm<N> + AnalyticInverse<N>,
        'a: 'p,
    {
        let stall = match policy {
            SingularityPolicy::SlowDown => {
                return Ok(LiveRoute { parts: vec![self.live(path)?], detours: Vec::new() });
            }
            SingularityPolicy::GoRound { stall } | SingularityPolicy::Refuse { stall } => stall,
        };
        let singular = self.find_singular_intervals(arm, &path, stall)?;
        if let (SingularityPolicy::Refuse { .. }, Some(first)) = (policy, singular.first()) {
            return Err(refusal(first, "it is to be refused: slow down there, go round, or move the path").into());
        }
        let (mut parts, mut detours) = (Vec::new(), Vec::new());
        let (mut from, mut q) = (0.0, path.start());
        let path = Arc::new(path);
        for interval in singular {
            let Some(beyond) = interval.joints.1 else {
                return Err(refusal(&interval, "the path ends there, so that there is no way round: move it").into());
            };
            if interval.from <= from {
                return Err(refusal(&interval, "the path begins there, so that there is no way round: move it").into());
            }
            parts.push(self.live_between(Arc::clone(&path), &q, from, interval.from)?);
            detours.push(self.detour(&path, &interval, &beyond)?);
            (from, q) = (interval.to, beyond);
        }
        let to = path.length();
        parts.push(self.live_between(path, &q, from, to)?);
        Ok(LiveRoute { parts, detours })
    }

    /// The joint move across an interval, and how far from it the tool gets.
    fn detour(
        &self,
        path: &ToolPath<'_, N>,
        interval: &SingularInterval<N>,
        beyond: &Joints<N>,
    ) -> Result<Detour<N>, HybridError> {
        let settings = self.settings();
        let limits = axis_limits(settings.limits.joints())?;
        let rest = |q: &Joints<N>| -> [AxisState; N] { std::array::from_fn(|k| AxisState::rest(q[k])) };
        let options = MotionOptions::new(Synchronisation::Time).with_cycle(settings.period)?;
        let (start, end) = (rest(&interval.joints.0), rest(beyond));
        let motion: Trajectory<N> = Trajectory::new(&start, &end, &limits as &[AxisLimits; N], &options)?;
        let place = |i: usize| interval.from + (interval.to - interval.from) * i as f64 / SAMPLES as f64;
        let places: Vec<_> = (0..=SAMPLES).map(|i| path.pose_path().curve().point(place(i))).collect();
        let deviation = (0..=SAMPLES).fold(0.0, |most: f64, i| {
            let q = motion.at(motion.duration() * i as f64 / SAMPLES as f64).q;
            let tool = settings.arm.forward(&q).translation.vector;
            let off = places.iter().map(|place| (place - tool).norm()).fold(f64::INFINITY, f64::min);
            most.max(off)
        });
        Ok(Detour { interval: interval.clone(), deviation, duration: motion.duration() })
    }
}

/// The next place, if it can be reached on the same branch.
fn follow<const N: usize>(path: &ToolPath<'_, N>, s: f64, last: &JointJet<N>) -> Result<JointJet<N>, PathError> {
    let ahead = last.ahead(s - last.s);
    let jet = path.jet(s, &ahead)?;
    let (joint, jump) = largest_step(&jet.q, &ahead);
    if jump > JUMP + (ahead - last.q).amax() {
        let predicted = ahead.iter().copied().collect();
        return Err(PathError::BranchChange { place: path.place(s), joint, jump, predicted });
    }
    Ok(jet)
}

/// The joint values at which the path might be resumed at `s`: the solution that is reached soonest from `q`.
fn take_up<A, const N: usize>(
    arm: &A,
    path: &ToolPath<'_, N>,
    s: f64,
    q: &Joints<N>,
    range: &JointRange<N>,
) -> Result<JointJet<N>, PathError>
where
    A: PathArm<N> + AnalyticInverse<N>,
{
    let fail = |source| PathError::Arm { place: path.place(s), source };
    let solutions = arm.inverse_all(&path.pose_path().jet(s).pose).map_err(fail)?;
    let all: Vec<Joints<N>> = solutions.iter().copied().collect();
    path.jet(s, &nearest_solution(&all, q, range).map_err(fail)?)
}

/// True if a joint's velocity limit allows less than `slowest` there.
fn stalled<const N: usize>(velocity: &Joints<N>, jet: &JointJet<N>, slowest: f64) -> Option<SingularityKind> {
    let (joint, speed) = (0..N)
        .map(|k| (k, velocity[k] / jet.d1[k].abs()))
        .fold((0, f64::INFINITY), |least, one| if one.1 < least.1 { one } else { least });
    (speed < slowest).then_some(SingularityKind::Stall { joint, speed })
}

/// The worse of two kinds in one interval.
fn worse(a: SingularityKind, b: SingularityKind) -> SingularityKind {
    match (&a, &b) {
        (SingularityKind::NotFollowed(_), _) => a,
        (_, SingularityKind::NotFollowed(_)) => b,
        (SingularityKind::Stall { speed: x, .. }, SingularityKind::Stall { speed: y, .. }) => {
            if x <= y {
                a
            } else {
                b
            }
        }
    }
}

fn refusal<const N: usize>(interval: &SingularInterval<N>, rule: &'static str) -> PathError {
    PathError::Singular { from: interval.from, to: interval.to, trouble: interval.kind.to_string(), rule }
}
