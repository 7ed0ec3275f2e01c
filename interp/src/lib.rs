//! Shape, speed and arm together: from a tool path to a verified, sampled joint trajectory.
//!
//! A tool path is a [`PosePath`](arcfeed_geometry::PosePath): pose by arc length `s`. Through the inverse kinematics it
//! becomes a [`JointPath`], `q(s)` with three derivatives, and every limit of tool and joints becomes a bound on the
//! motion `s(t)`:
//!
//! ```text
//! joint velocity      q' v                              v = ds/dt
//! joint acceleration  q' a + q'' v^2                    a = dv/dt
//! joint jerk          q' j + 3 q'' v a + q''' v^3       j = da/dt
//! joint torque        M q' a + (M q'' + C(q, q') q') v^2 + friction + gravity
//! normal acceleration kappa v^2
//! angular speed       omega v
//! chord error         of the curve between two control cycles, v T apart
//! ```
//!
//! The [`Planner`] hands these to a planner of the feedrate crate ([`Scan`]) as rows on a grid and bounds between its points, and
//! holds the result against the limits themselves with [`verify`], which knows nothing of either. A [`Plan`] that comes out of [`Planner::plan`] has passed; its [`Sampler`] yields setpoints for a
//! controller.
//!
//! | room | holds |
//! |---|---|
//! | `arm` | what is asked of an arm: [`PathArm`] |
//! | `locked` | arms of seven joints: [`LockedArm`] |
//! | `joint_path` | joint values and derivatives along the path, branch by continuity, best start |
//! | `grid`, `derivative_bounds` | where along the path limits are looked at, and how large its derivatives are between |
//! | `sections` | programmed feed per section of the path: [`FeedSection`] |
//! | `torque` | torque limits along the path: [`TorqueLimits`] |
//! | `path_problem` | all limits as rows and bounds, for the planners of the feedrate crate |
//! | `planner`, `plan` | the way from path to verified plan, and what came out |
//! | `schedule` | from pose to pose and through joint way-points, torque included: [`Scheduler`] |
//! | `sampler`, `trajectory` | setpoints at the control period, without allocation |
//! | `verify` | the independent check |
//! | `live_path`, `hybrid` | motion that is changed, left and resumed while it runs: [`LivePath`], [`HybridMotion`] |
//! | `singular` | stretches of a path near singular poses: slowed down, gone round or refused |
//! | `drive` | simulated drives behind their setpoints: [`DriveLag`] |
//! | [`parameter`] | Taylor steps, closed-loop steps and the arc-length map behind one trait |
//!
//! Units: m, rad, s. Poses: tool in base. The arm is any [`PathArm`]: of six joints, anything with
//! [`ForwardKinematics`](arcfeed_kinematics::ForwardKinematics) and
//! [`InverseKinematics`](arcfeed_kinematics::InverseKinematics).
#![forbid(unsafe_code)]

mod arm;
mod derivative_bounds;
mod drive;
mod error;
mod grid;
mod hybrid;
mod joint_path;
mod limits;
mod live_path;
mod locked;
pub mod parameter;
mod path_problem;
mod plan;
mod planner;
mod sampler;
mod schedule;
mod sections;
mod singular;
mod torque;
mod trajectory;
mod verify;
mod withheld;

pub use arm::{MIN_SINGULAR_VALUE, PathArm};
pub use drive::DriveLag;
pub use error::{Infeasibility, PlanError};
pub use hybrid::{Command, Excursion, HybridError, HybridMotion, HybridState, HybridStep, LeaveBy, MAX_POINTS};
pub use joint_path::{JointJet, JointPath, best_start, joint_jet};
pub use limits::ToolLimits;
pub use live_path::LivePath;
pub use locked::LockedArm;
pub use plan::{MadeBy, Method, Plan, Timings};
pub use planner::{Planner, Scan};
pub use sampler::Sampler;
pub use schedule::{
    ArmMotion, Binding, JointSpline, LimitPoint, LimitUse, RowsNeeded, Schedule, ScheduleCheck, ScheduleLimits,
    ScheduleParameter, SchedulePath, ScheduleSampler, Scheduler, SpeedPlanner,
};
pub use sections::{Extent, FeedSection, Section};
pub use singular::{Detour, LiveRoute, SingularityPolicy, Stretch, Trouble};
pub use torque::TorqueLimits;
pub use trajectory::Setpoint;
pub use verify::{Check, Quantity, Requirement, Verification, verify};
pub use withheld::Cause;
