//! Jerk-limited motion on one scalar: S-curves, and speed along a path.
//!
//! # The problem
//! A tool moves along a path of length `L`; `s(t)` is the arc length covered. The planners minimise
//! the time `T` subject to
//!
//! ```text
//! s(0) = 0,  s(T) = L,  s'(0) = v_start,  s'(T) = v_end,  s''(0) = s''(T) = 0,
//! 0 <= s'(t) <= v_max(s),   |s''(t)| <= a_max(s),   |s'''(t)| <= j_max(s)     for all t,
//! ```
//!
//! where the bounds follow from the feed, the shape of the path and the joints of the machine
//! ([`caps`]). Everything here is on that one scalar: no robot and no curve is known to this crate,
//! and a single axis is as good a path as any.
//!
//! With constant bounds the answer is the seven-phase S-profile ([`SProfile`]), and from any state
//! of motion a [`SpeedChange`]. With bounds given segment by segment two planners share one input
//! and one output: [`plan_per_segment`] with one S-profile per segment (Liu et al. 2023, section
//! 4), also with a look-ahead window ([`plan_windowed`]), and [`plan_continuous`], which keeps the
//! acceleration continuous across segments and so does not pay for their number.
//!
//! If the limits are not one number per segment but belong to joints, motors and tool, each is a
//! [`Row`] in `sdot^2` and `sddot` ([`constraint`], [`FeedProblem`]), and a [`FeedPlanner`] finds
//! the law: [`ForwardBackwardScan`], [`Reachability`], [`InterpolatedReachability`] and, with jerk,
//! [`JerkLimited`]. All read the same rows and yield a [`SpeedLaw`].
//!
//! # Overview
//! | task | items |
//! |---|---|
//! | states, limits, errors | [`MotionState`], [`AxisState`], [`AxisLimits`], [`MotionLaw`], [`Phase`], [`FeedError`] |
//! | change of speed in the least time | [`SpeedChange`], [`distance_for_change`] and its inverses |
//! | motion over a displacement | [`SProfile`] |
//! | motion from any state to any other | [`StateToState`]; in a given duration [`AxisProblem`], [`Durations`]; inside a range of positions [`BoundedProblem`], [`PositionLimits`] |
//! | speed limits from the path and the joints | [`caps`] |
//! | limits as rows on a grid | [`constraint`], [`Row`], [`JerkRow`], [`IntervalBound`], [`FeedProblem`] |
//! | planners for segments | [`Segment`], [`plan_per_segment`], [`plan_windowed`], [`plan_continuous`] |
//! | planners for rows ([`FeedPlanner`]) | [`ForwardBackwardScan`], [`Reachability`], [`InterpolatedReachability`], [`JerkLimited`]; in windows [`WindowedJerkLimited`] |
//! | reference optimum (feature `clarabel`) | `ClarabelBaseline` |
//! | the result of every planner | [`SpeedLaw`], sampled by time or by position |
//! | limits that change while the motion runs | [`FeedScheduler`] |
//! | a moving target followed by one axis | [`TargetTracker`] |
//! | segments that arrive while the motion runs | [`SegmentStream`]; simulated on a problem [`StreamedScan`] |
//! | an operator's override, hold and step back | [`FeedOverride`] under a [`VelocityLimitCurve`] |
//!
//! # Units
//! Metres and seconds in the docs, but nothing depends on them: no tolerance in this crate is
//! absolute.
//!
//! # Without the standard library
//! Without the feature `std`, which is on by default, the crate needs neither standard library nor
//! heap. S-curves, motions of one axis between states, [`FeedScheduler`] and [`TargetTracker`] are
//! there; planners along a path, speed laws and everything made of them are not.
//!
//! # Sources
//! X. Liu et al., "A High-Precision Planar NURBS Interpolation System Based on Segmentation Method
//! for Industrial Robot", Appl. Sci. 2023, 13, 13210, cited as Liu et al. 2023; online trajectory
//! generation in robot task and joint spaces, Actuators 2024, 13, 108, cited as Liu et al. 2024;
//! "Quaternion-Based Velocity Scheduling for Robotic Systems", Electronics 2025, 14, 3869. A
//! formula that departs from print says so in its docs, with the reason.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
// `!(x > 0.0)` is how NaN is taken to the safe side.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

// Without the standard library `std::` is what `core` has of it.
#[cfg(not(feature = "std"))]
extern crate core as std;

#[cfg(feature = "clarabel")]
mod baseline;
pub mod caps;
#[cfg(feature = "clarabel")]
mod conic_program;
#[cfg(feature = "std")]
pub mod constraint;
mod error;
#[cfg(feature = "std")]
mod jerk_limited;
mod limits;
#[cfg(feature = "std")]
mod live;
#[cfg(feature = "std")]
mod lp2;
mod online;
#[cfg(feature = "std")]
mod problem;
mod row;
#[cfg(feature = "std")]
mod scan;
mod scurve;
#[cfg(feature = "std")]
mod speed_law;
mod state;
mod state_to_state;

#[cfg(feature = "clarabel")]
pub use baseline::{Bounded, ClarabelBaseline};
pub use error::{FeedError, PathEnd};
#[cfg(feature = "std")]
pub use jerk_limited::{JerkLimited, JerkLimitedDraft, JerkLimitedPlan, LowerBound, WindowedJerkLimited, WindowedPlan};
pub use limits::AxisLimits;
#[cfg(feature = "std")]
pub use live::{FeedOverride, LiveSection, LiveStatus, LiveStep, MAX_SECTIONS, VelocityLimitCurve};
pub use online::{Adoption, FeedScheduler, FeedStatus, FeedStep, TargetTracker, TrackStatus, TrackStep};
#[cfg(feature = "std")]
pub use online::{SegmentStream, StreamStatus, StreamStep};
#[cfg(feature = "std")]
pub use problem::{FeedPlanner, FeedProblem, LimitPartition, live_speed};
pub use row::{IntervalBound, JerkRow, LimitId, Quantity, Row};
#[cfg(feature = "std")]
pub use scan::continuous_acceleration::{plan_continuous, plan_continuous_at_once};
#[cfg(feature = "std")]
pub use scan::fallback::{ChosenLaw, Fallback, JerkLimitedOrScan};
#[cfg(feature = "std")]
pub use scan::forward_backward::ForwardBackwardScan;
#[cfg(feature = "std")]
pub use scan::interpolated::InterpolatedReachability;
#[cfg(feature = "std")]
pub use scan::on_problem::{ContinuousAccelerationScan, PerSegmentScan};
#[cfg(feature = "std")]
pub use scan::per_segment::{boundary_speeds, plan_per_segment, plan_windowed};
#[cfg(feature = "std")]
pub use scan::reachability::Reachability;
#[cfg(feature = "std")]
pub use scan::streamed::{Streamed, StreamedScan};
#[cfg(feature = "std")]
pub use scan::{Segment, boundaries};
pub use scurve::change::SpeedChange;
pub use scurve::phase::Phase;
pub use scurve::profile::{Adjust, Adjusted, SProfile};
pub use scurve::solve::{distance_for_change, highest_speed_over, lowest_speed_over};
#[cfg(feature = "std")]
pub use speed_law::{Cursor, SpeedLaw};
pub use state::{AxisState, MotionLaw, MotionState};
pub use state_to_state::{AxisProblem, BoundedProblem, Durations, PositionLimits, PositionRange, StateToState};
