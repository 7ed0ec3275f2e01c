//! Shape, speed and arm together: from a path to a verified, sampled joint trajectory.
//!
//! # From path to setpoints
//! ```text
//! MotionPath      s -> q, q', q'', q''' and, where there is one, the pose of the tool:
//!   |             ToolPath, PoseMove, JointSpline, JointLines, or a type of your own
//! PathProblem     the path on a grid, every limit stated once: as a row, as a bound over an interval, as a cap for live motion
//!   |
//! FeedPlanner     any planner of the feedrate crate: rows in, SpeedLaw out; Method names those that Planner uses
//!   |
//! SpeedLaw        s(t)
//!   |
//! Trajectory      path, law and arm; verified before it is returned
//!   |
//! Setpoint        joint position, velocity, acceleration, jerk, and the pose of the tool
//! ```
//!
//! At a place with joint derivatives `q', q'', q'''` and tool curvature `kappa` a motion `(v, a, j)` along the path means
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
//! The [`Planner`] states these as rows and holds the result against the limits themselves with [`verify`], which knows nothing of
//! rows or planners. A [`Trajectory`] that comes out has passed.
//!
//! | folder | holds |
//! |---|---|
//! | `path` | [`MotionPath`] and its four kinds, the choice of a configuration, the walk by continuity |
//! | `limits` | [`Limits`], [`ToolLimits`], [`TorqueLimits`], [`JointTables`], [`FeedSection`] |
//! | `problem` | [`PathProblem`]: grid, bounds, torque |
//! | `planner`, `method`, `trajectory` | [`Planner`], [`Method`], [`Trajectory`] |
//! | `verify` | [`Verification`]: the independent check |
//! | `vibration`, `rms_torque` | [`Vibration`] of a flexible structure; the thermal load of the drives |
//! | `compiled` | [`JointTrajectory`]: polynomials of the time; [`Certificate`]: what they do between samples |
//! | `live` | motion that is changed, left and resumed while it runs: [`LivePath`], [`HybridMotion`] |
//! | [`parameter`] | Taylor steps, closed-loop steps and the arc-length map behind one trait |
//! | `error` | [`PlanError`], split by what a caller can do |
//!
//! Units: m, rad, s. Poses: tool in base. The arm of a tool path or a pose move is any [`PathArm`]: of six joints, anything with
//! [`ForwardKinematics`](arcfeed_kinematics::ForwardKinematics) and
//! [`InverseKinematics`](arcfeed_kinematics::InverseKinematics); of seven, a [`LockedArm`].
#![forbid(unsafe_code)]

mod arm;
mod compiled;
mod diagnosis;
mod error;
mod limits;
mod live;
mod lowering;
mod method;
pub mod parameter;
mod path;
mod place;
mod planner;
mod problem;
mod rms_torque;
mod setpoint;
mod time_pieces;
mod trajectory;
mod verify;
mod vibration;

pub use arcfeed_feedrate::{LimitId, Quantity};
pub use arm::{MIN_SINGULAR_VALUE, PathArm};
pub use compiled::{
    Certificate, CertifiedBound, CertifiedFeed, CertifiedJump, CertifiedLimit, CompileError, CompiledPlan, Deviation,
    Interpolation, JointCursor, JointPoint, JointSetpoint, JointSetpoints, JointTrajectory, JointTrajectoryError,
    MotionCertificate, TableBound, TableCertificate, ToolBound, ToolCertificate, TorqueBound, TorqueCertificate,
    certify,
};
pub use error::{Cause, Infeasibility, LimitError, PathEnd, PathError, PlanError, SpeedError};
pub use limits::{
    Extent, FeedSection, JointTables, LimitTable, Limits, PayloadTable, Section, TableKind, ToolLimits, TorqueLimits,
};
pub use live::{
    Command, Detour, DriveLag, Excursion, HybridError, HybridMotion, HybridState, HybridStep, JointMoveBy, LeaveBy,
    LiveError, LivePath, LiveRoute, LiveTool, LiveToolStep, MAX_CYCLES, MAX_POINTS, SingularInterval, SingularityKind,
    SingularityPolicy, ToolTargetError,
};
pub use method::Method;
pub use nalgebra;
pub use path::{JointJet, JointLines, JointPath, JointSpline, LockedArm, MotionPath, PoseMove, ToolPath};
pub use place::{PathParameter, PathPlace};
pub use planner::Planner;
pub use problem::{PathProblem, RowsNeeded};
pub use setpoint::Setpoint;
pub use trajectory::{LimitPoint, PlanInfo, PlanWindows, Setpoints, Timings, Trajectory};
pub use verify::{Binding, Check, JointCheck, JointRates, JointSample, Requirement, Verification, verify};
pub use vibration::{AccelerationPiece, Oscillator, Vibration};
