//! Places of a path where the arm is close to singular, or changes the branch of its inverse: found ahead of time, and what to do there.
//!
//! Liu et al. 2024, section 5.3, name this as future research and a way: look ahead along the path, find stable joint values beyond the
//! singular region, and go there through joint space.

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::{AnalyticInverse, JointRange, Joints, largest_step, nearest_solution};
use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, Synchronisation, Trajectory};

use crate::arm::PathArm;
use crate::error::PlanError;
use crate::joint_path::{JointJet, joint_jet};
use crate::live_path::LivePath;
use crate::planner::Planner;

/// Places at which the path is looked at.
const LOOKS: usize = 2000;
/// A step between two of them that misses the prediction by more than this is a change of branch, rad.
const JUMP: f64 = 0.05;
/// A stretch that is followed again for less than this many looks belongs to the trouble.
const LEAST: usize = 20;
/// Samples of a way round on which its deviation is measured.
const SAMPLES: usize = 400;

/// What to do where a path asks for more than the joints can do at a fair speed.
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

/// Why a stretch of a path is left out or refused.
#[derive(Debug, Clone, PartialEq)]
pub enum Trouble {
    /// The velocity limit of a joint allows only this speed of the tool.
    Stall {
        /// The joint, from 0.
        joint: usize,
        /// Lowest speed that is allowed on the stretch, m/s.
        speed: f64,
    },
    /// The inverse changes its branch, or there is none.
    NotFollowed(Box<PlanError>),
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stall { joint, speed } => {
                write!(f, "the velocity limit of joint {} allows the tool only {speed:.4} m/s", joint + 1)
            }
            Self::NotFollowed(error) => error.fmt(f),
        }
    }
}

/// A stretch of a path between two places where it can be followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch<const N: usize = 6> {
    /// The last place before it, m.
    pub from: f64,
    /// The first place behind it, m; the end of the path if there is none.
    pub to: f64,
    /// Joint values at both, rad; the second is `None` where the path is not followed to its end.
    pub joints: (Joints<N>, Option<Joints<N>>),
    /// What is wrong there; the worst of it.
    pub trouble: Trouble,
}

/// A way round a stretch, through joint space.
#[derive(Debug, Clone, PartialEq)]
pub struct Detour<const N: usize = 6> {
    /// The stretch that is left out.
    pub stretch: Stretch<N>,
    /// How far the tool point gets from the stretch, m.
    pub deviation: f64,
    /// How long it takes, s.
    pub duration: f64,
}

/// A path in parts that can be followed, with ways round what cannot.
#[derive(Debug, Clone)]
pub struct LiveRoute<const N: usize = 6> {
    parts: Vec<LivePath<N>>,
    detours: Vec<Detour<N>>,
}

impl<const N: usize> LiveRoute<N> {
    /// The parts, in order; without detours the one is the whole path.
    pub fn parts(&self) -> &[LivePath<N>] {
        &self.parts
    }

    /// The first part.
    pub fn first(&self) -> &LivePath<N> {
        // There is one: no route is made without.
        &self.parts[0]
    }

    /// The part on which the arc length `s` (m) lies, or that before it.
    pub fn part_at(&self, s: f64) -> &LivePath<N> {
        &self.parts[self.parts.partition_point(|part| part.range().0 <= s).saturating_sub(1)]
    }

    /// The ways round, one between each two parts.
    pub fn detours(&self) -> &[Detour<N>] {
        &self.detours
    }
}

impl<A, const N: usize> Planner<'_, A, N>
where
    A: PathArm<N> + AnalyticInverse<N> + ?Sized,
{
    /// The stretches of `path` where the joints allow less than the part `stall` of the feed, or cannot follow at all.
    ///
    /// The path is looked at in 2000 places; a stretch begins and ends at one of them.
    ///
    /// # Errors
    /// [`PlanError::Arm`] when the start of the path is out of reach, [`PlanError::Limit`] for a `stall` that is not above 0 and below 1.
    pub fn troubles(&self, path: &PosePath, start: &Joints<N>, stall: f64) -> Result<Vec<Stretch<N>>, PlanError> {
        if !(stall > 0.0 && stall < 1.0) {
            return Err(PlanError::Limit { what: "part of the feed that counts as a stall (below 1)", value: stall });
        }
        let slowest = stall * self.tool.feed;
        let mut found: Vec<Stretch<N>> = Vec::new();
        let mut last = joint_jet(self.arm, 0.0, &path.jet(0.0), start)?;
        let mut open: Option<Trouble> = self.stall(&last, slowest);
        // Looks since the path was taken up again.
        let mut since = LEAST;
        let at = |i: usize| path.length() * i as f64 / LOOKS as f64;
        for s in (1..=LOOKS).map(at) {
            let ahead = last.ahead(s - last.s);
            let next = match &open {
                None => self.follow(path, s, &ahead, &last),
                Some(_) => self.take_up(path, s, &last.q),
            };
            match (next, open.take()) {
                (Ok(jet), was_open) => match (self.stall(&jet, slowest), was_open) {
                    (None, None) => {
                        last = jet;
                        since += 1;
                    }
                    (None, Some(trouble)) => {
                        found.push(Stretch { from: last.s, to: s, joints: (last.q, Some(jet.q)), trouble });
                        (last, since) = (jet, 0);
                    }
                    (Some(stall), was_open) => {
                        open = Some(was_open.map_or(stall.clone(), |known| worse(known, stall)));
                    }
                },
                (Err(error), was_open) => {
                    let wrong = Trouble::NotFollowed(Box::new(error));
                    open = Some(was_open.map_or(wrong.clone(), |known| worse(known, wrong)));
                }
            }
            // Followed for a moment only: one stretch with the one before.
            if open.is_some()
                && since < LEAST
                && let Some(before) = found.pop()
            {
                open = open.map(|now| worse(before.trouble, now));
                last = joint_jet(self.arm, before.from, &path.jet(before.from), &before.joints.0)?;
                since = LEAST;
            }
        }
        if let Some(trouble) = open {
            found.push(Stretch { from: last.s, to: path.length(), joints: (last.q, None), trouble });
        }
        Ok(found)
    }

    /// Makes a path ready for [`HybridMotion::along`](crate::HybridMotion::along), and deals with singular places as `policy` says.
    ///
    /// # Errors
    /// [`PlanError::Singular`] naming the stretch: where it is refused, or where the path starts or ends in it, so that there is no way
    /// round. Otherwise as [`Planner::live`].
    pub fn route(
        &self,
        path: PosePath,
        start: &Joints<N>,
        policy: SingularityPolicy,
    ) -> Result<LiveRoute<N>, PlanError> {
        let stall = match policy {
            SingularityPolicy::SlowDown => {
                return Ok(LiveRoute { parts: vec![self.live(path, start)?], detours: Vec::new() });
            }
            SingularityPolicy::GoRound { stall } | SingularityPolicy::Refuse { stall } => stall,
        };
        let troubles = self.troubles(&path, start, stall)?;
        if let (SingularityPolicy::Refuse { .. }, Some(first)) = (policy, troubles.first()) {
            return Err(refusal(first, "it is to be refused: slow down there, go round, or move the path"));
        }
        let (mut parts, mut detours) = (Vec::new(), Vec::new());
        let (mut from, mut q) = (0.0, *start);
        for stretch in troubles {
            let Some(beyond) = stretch.joints.1 else {
                return Err(refusal(&stretch, "the path ends there, so that there is no way round: move it"));
            };
            if stretch.from <= from {
                return Err(refusal(&stretch, "the path begins there, so that there is no way round: move it"));
            }
            parts.push(self.live_between(path.clone(), &q, from, stretch.from)?);
            detours.push(self.detour(&path, &stretch, &beyond)?);
            (from, q) = (stretch.to, beyond);
        }
        let to = path.length();
        parts.push(self.live_between(path, &q, from, to)?);
        Ok(LiveRoute { parts, detours })
    }

    /// The next place, if it can be reached on the same branch.
    fn follow(&self, path: &PosePath, s: f64, ahead: &Joints<N>, last: &JointJet<N>) -> Result<JointJet<N>, PlanError> {
        let jet = joint_jet(self.arm, s, &path.jet(s), ahead)?;
        let (joint, jump) = largest_step(&jet.q, ahead);
        if jump > JUMP + (ahead - last.q).amax() {
            return Err(PlanError::BranchChange { s, joint, jump, predicted: ahead.iter().copied().collect() });
        }
        Ok(jet)
    }

    /// Where the path might be taken up again at `s`: the solution that is reached soonest from `q`.
    fn take_up(&self, path: &PosePath, s: f64, q: &Joints<N>) -> Result<JointJet<N>, PlanError> {
        let tool = path.jet(s);
        let fail = |source| PlanError::Arm { s, position: tool.pose.translation.vector.into(), source };
        let all: Vec<Joints<N>> = self.arm.inverse_all(&tool.pose).map_err(fail)?.iter().copied().collect();
        let range = JointRange::new(*self.joints.lower(), *self.joints.upper()).map_err(fail)?;
        let nearest = nearest_solution(&all, q, &range).map_err(fail)?;
        joint_jet(self.arm, s, &tool, &nearest)
    }

    /// Whether a joint's velocity limit allows less than `slowest` there.
    fn stall(&self, jet: &JointJet<N>, slowest: f64) -> Option<Trouble> {
        let (joint, speed) = (0..N)
            .map(|k| (k, self.joints.velocity()[k] / jet.d1[k].abs()))
            .fold((0, f64::INFINITY), |least, one| if one.1 < least.1 { one } else { least });
        (speed < slowest).then_some(Trouble::Stall { joint, speed })
    }

    /// The joint move across a stretch, and how far from it the tool gets.
    fn detour(&self, path: &PosePath, stretch: &Stretch<N>, beyond: &Joints<N>) -> Result<Detour<N>, PlanError> {
        let limits = crate::hybrid::axis_limits(&self.joints)?;
        let rest = |q: &Joints<N>| -> [AxisState; N] { std::array::from_fn(|k| AxisState::rest(q[k])) };
        let options =
            MotionOptions::new(Synchronisation::Time).with_cycle(self.period).map_err(crate::HybridError::from)?;
        let (start, end) = (rest(&stretch.joints.0), rest(beyond));
        let motion: Trajectory<N> =
            Trajectory::new(&start, &end, &limits as &[AxisLimits; N], &options).map_err(crate::HybridError::from)?;
        let places: Vec<_> = (0..=SAMPLES)
            .map(|i| path.curve().point(stretch.from + (stretch.to - stretch.from) * i as f64 / SAMPLES as f64))
            .collect();
        let deviation = (0..=SAMPLES).fold(0.0, |most: f64, i| {
            let q = motion.at(motion.duration() * i as f64 / SAMPLES as f64).q;
            let tool = self.arm.forward(&q).translation.vector;
            let off = places.iter().map(|place| (place - tool).norm()).fold(f64::INFINITY, f64::min);
            most.max(off)
        });
        Ok(Detour { stretch: stretch.clone(), deviation, duration: motion.duration() })
    }
}

/// Of two troubles on one stretch the worse.
fn worse(a: Trouble, b: Trouble) -> Trouble {
    match (&a, &b) {
        (Trouble::NotFollowed(_), _) => a,
        (_, Trouble::NotFollowed(_)) => b,
        (Trouble::Stall { speed: x, .. }, Trouble::Stall { speed: y, .. }) => {
            if x <= y {
                a
            } else {
                b
            }
        }
    }
}

fn refusal<const N: usize>(stretch: &Stretch<N>, rule: &'static str) -> PlanError {
    let trouble = stretch.trouble.to_string();
    PlanError::Singular { from: stretch.from, to: stretch.to, trouble, rule }
}
