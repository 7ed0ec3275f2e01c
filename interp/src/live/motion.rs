//! The executor: one step a cycle.

use arcfeed_feedrate::{FeedOverride, LiveSection, LiveStatus, MAX_SECTIONS, MotionState};
use arcfeed_kinematics::Joints;

use super::command::{Command, Excursion, JointMoveBy};
use super::error::{HybridError, LiveError, MAX_POINTS};
use super::joints::JointSpace;
use super::live_path::LivePath;
use super::singular::LiveRoute;
use super::state::{HybridState, HybridStep};
use crate::error::{LimitError, SpeedError};
use crate::path::MotionPath;
use crate::setpoint::Setpoint;

/// A motion along a tool path that can be slowed down, held, stepped back, left for joint space, resumed and stopped in any cycle.
///
/// **Guarantees**, whatever is commanded and whenever: no limit of joints or tool is exceeded; position, velocity and acceleration of
/// every joint go on without a jump, with its jerk inside its limit; while [`HybridStep::on_path`] is true the tool is on the path; a path
/// that was left is resumed exactly where it was left. A step allocates nothing and takes a bounded number of operations.
///
/// The speed on the path is that of a [`FeedOverride`]; joint space is an [`OnlineGenerator`](arcfeed_sync::OnlineGenerator). Nothing is
/// known of obstacles: the points of an excursion are chosen by who gives it.
///
/// ```no_run
/// # fn example(path: arcfeed_geometry::PosePath) -> Result<(), Box<dyn std::error::Error>> {
/// use arcfeed_interp::{Command, Excursion, HybridMotion, HybridState, LeaveBy, Limits, Planner, ToolLimits, ToolPath};
/// use arcfeed_kinematics::{Joints, models};
///
/// let arm = models::ur5e();
/// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
/// // The highest feed that any override leads to.
/// let tool = ToolLimits::new().with_feed(0.15)?.with_tangential_acceleration(1.0)?.with_tangential_jerk(20.0)?;
/// let planner = Planner::new(&arm, Limits::new(joints).with_tool(tool));
/// let live = planner.live(ToolPath::new(&arm, path, arm.range())?)?;
/// let mut motion = HybridMotion::new(&live, 0.1)?;
/// let park = Excursion::new(&[Joints::repeat(0.3)], LeaveBy::Braking)?;
/// for cycle in 0.. {
///     let command = match cycle {
///         1000 => Command::Override(0.5),
///         2000 => Command::Leave(park),
///         9000 => Command::Return,
///         _ => Command::None,
///     };
///     let step = motion.step(&command);
///     // send step.setpoint.q to the controller
///     if step.state == HybridState::Done {
///         break;
///     }
/// }
/// # Ok(()) }
/// ```
#[derive(Debug, Clone)]
pub struct HybridMotion<'a, const N: usize = 6> {
    pub(super) live: &'a LivePath<'a, N>,
    /// Parts of the path after this one, each reached through joint space.
    ahead: &'a [LivePath<'a, N>],
    pub(super) feed: FeedOverride<'a>,
    pub(super) sections: [LiveSection; MAX_SECTIONS],
    pub(super) section_count: usize,
    pub(super) joints: JointSpace<N>,
    pub(super) state: HybridState,
    pub(super) on_path: bool,
    /// The operator's wish for the motion on the path, whatever events do to it meanwhile.
    pub(super) held: bool,
    /// True while a hold keeps the motion where it stands to leave the path.
    pub(super) held_leaving: bool,
    pub(super) excursion: Option<Excursion<N>>,
    /// Points that were reached since the path was left, for the way back, and how many.
    passed: [Joints<N>; MAX_POINTS],
    pub(super) passed_count: usize,
    pub(super) last: Setpoint<N>,
    cycles: u64,
}

impl<'a, const N: usize> HybridMotion<'a, N> {
    /// At rest at the start of `live`, with a programmed `feed` (m/s).
    ///
    /// # Errors
    /// [`SpeedError::Feed`] for a feed that is not a finite number above 0.
    pub fn new(live: &'a LivePath<'a, N>, feed: f64) -> Result<Self, LiveError> {
        Self::over(live, &[], feed)
    }

    /// At rest at the start of a route, with a programmed `feed` (m/s): each detour is a joint move in the state
    /// [`HybridState::GoingRound`].
    ///
    /// # Errors
    /// As [`HybridMotion::new`].
    pub fn along(route: &'a LiveRoute<'a, N>, feed: f64) -> Result<Self, LiveError> {
        let Some((first, ahead)) = route.parts().split_first() else {
            return Err(LimitError::NotPositive { what: "number of parts of the route", value: 0.0 }.into());
        };
        Self::over(first, ahead, feed)
    }

    fn over(live: &'a LivePath<'a, N>, ahead: &'a [LivePath<'a, N>], feed: f64) -> Result<Self, LiveError> {
        let feed = FeedOverride::new(live.curve(), live.period(), feed).map_err(SpeedError::from)?;
        let start = live.joint_path().nodes()[0];
        let joints = JointSpace::new(live.joints(), live.period(), &start.q)?;
        let none = LiveSection { from: 0.0, to: 0.0, feed: 0.0 };
        let still = Joints::zeros();
        let pose = live.path().pose_path().jet(start.s).pose;
        let last = start.setpoint(0.0, &MotionState { p: start.s, ..MotionState::default() }, pose);
        Ok(Self {
            live,
            ahead,
            feed,
            sections: [none; MAX_SECTIONS],
            section_count: 0,
            joints,
            state: HybridState::TaskPath,
            on_path: true,
            held: false,
            held_leaving: false,
            excursion: None,
            passed: [still; MAX_POINTS],
            passed_count: 0,
            last,
            cycles: 0,
        })
    }

    /// Follows a command and moves on by one cycle.
    pub fn step(&mut self, command: &Command<N>) -> HybridStep<N> {
        let refused = self.tell(command).err();
        let refused = self.advance().err().or(refused);
        let stands = if self.on_path { self.feed.is_at_rest() } else { self.last.qd.amax() == 0.0 };
        let holding = self.is_held() && stands;
        HybridStep { setpoint: self.last, state: self.state, on_path: self.on_path, holding, refused }
    }

    /// The state of the motion.
    pub fn state(&self) -> HybridState {
        self.state
    }

    /// True while a hold or a step back keeps the motion from going on by itself, whether it stands already or not.
    pub fn is_held(&self) -> bool {
        match self.on_path {
            true => self.state == HybridState::TaskPath && self.held || self.held_leaving,
            false => self.joints.is_held(),
        }
    }

    /// The setpoint of the last cycle; before the first one, the start.
    pub fn setpoint(&self) -> &Setpoint<N> {
        &self.last
    }

    /// The motion along the path.
    pub fn feed(&self) -> &FeedOverride<'a> {
        &self.feed
    }

    /// The last of the `count` points still to be passed on the way back, or else the place where the path was left.
    pub(super) fn way_back(&self, count: usize) -> Joints<N> {
        if count > 0 { self.passed[count - 1] } else { self.place_left() }
    }

    /// Joint values at the place where the path was left.
    fn place_left(&self) -> Joints<N> {
        let s = self.feed.position();
        let near = self.live.joint_path().near(s).q;
        self.live.path().jet(s, &near).map_or(near, |jet| jet.q)
    }

    fn advance(&mut self) -> Result<(), HybridError> {
        self.cycles += 1;
        if self.on_path { self.advance_on_path() } else { self.advance_in_joint_space() }
    }

    fn advance_on_path(&mut self) -> Result<(), HybridError> {
        let step = self.feed.step();
        self.last = self.on_path_at(step.state);
        match self.state {
            // A held motion stays at the end of a part.
            HybridState::TaskPath if self.held && !self.ahead.is_empty() => {}
            HybridState::TaskPath if step.status == LiveStatus::Finished => match self.ahead.split_first() {
                Some((next, ahead)) => {
                    (self.live, self.ahead) = (next, ahead);
                    self.feed = self.feed.moved_to(next.curve());
                    self.feed.stand();
                    let still = Joints::zeros();
                    self.joints.move_by(JointMoveBy::LeastTime);
                    self.joints.start(&self.last.q, &still, &still, &next.joint_path().nodes()[0].q)?;
                    self.passed_count = 0;
                    self.on_path = false;
                    self.state = HybridState::GoingRound;
                }
                None => self.state = HybridState::Done,
            },
            HybridState::Stopping if self.feed.is_at_rest() => self.state = HybridState::Stopped,
            HybridState::Leaving if self.feed.is_at_rest() && !self.held_leaving => {
                if let Some(excursion) = self.excursion {
                    let still = Joints::zeros();
                    let first = excursion.points()[0];
                    self.joints.start(&self.last.q, &still, &still, &first)?;
                    self.feed.stand();
                    self.on_path = false;
                    self.state = HybridState::JointMove(0);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn advance_in_joint_space(&mut self) -> Result<(), HybridError> {
        let ([q, qd, qdd, jerk], arrived) = self.joints.step();
        let (pose, jacobian) = self.live.path().arm().forward_jacobian(&q);
        let feed = (jacobian * qd).fixed_rows::<3>(0).norm();
        let t = self.cycles as f64 * self.live.period();
        self.last = Setpoint { t, s: self.feed.position(), feed, acceleration: 0.0, q, qd, qdd, jerk, pose };
        if !arrived {
            self.pass();
            return Ok(());
        }
        if self.state == HybridState::Stopping {
            self.state = HybridState::Stopped;
        }
        if self.joints.is_held() {
            return Ok(());
        }
        match self.state {
            HybridState::Leaving => self.reached(0),
            HybridState::JointMove(point) => self.reached(point),
            HybridState::Returning if self.passed_count > 0 => self.back_by_one(),
            HybridState::Returning | HybridState::GoingRound => {
                self.on_path = true;
                self.excursion = None;
                self.state = HybridState::TaskPath;
                if self.held {
                    self.feed.hold();
                } else {
                    self.feed.resume();
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Goes for the next point where this one is near enough. Where that would lead out of the range of a joint the arm stops at this one.
    fn pass(&mut self) {
        let Some(excursion) = self.excursion.filter(|excursion| self.joints.is_near(excursion.within())) else {
            return;
        };
        let more = |point: usize| point + 1 < excursion.points().len();
        // A refusal leaves the motion as it is.
        let _refused = match self.state {
            HybridState::Leaving if more(0) => self.reached(0),
            HybridState::JointMove(point) if more(point) => self.reached(point),
            HybridState::Returning if self.passed_count > 0 => self.back_by_one(),
            _ => Ok(()),
        };
    }

    /// A point on the way back is reached.
    fn back_by_one(&mut self) -> Result<(), HybridError> {
        self.joints.retarget(&self.way_back(self.passed_count - 1))?;
        self.passed_count -= 1;
        Ok(())
    }

    /// A point of the excursion is reached.
    fn reached(&mut self, point: usize) -> Result<(), HybridError> {
        let Some(excursion) = self.excursion else { return Ok(()) };
        match excursion.points().get(point + 1) {
            Some(next) => {
                self.joints.retarget(next)?;
                // Points passed in an excursion that another one replaced are not gone back through.
                if self.passed_count < MAX_POINTS {
                    self.passed[self.passed_count] = excursion.points()[point];
                    self.passed_count += 1;
                }
                self.state = HybridState::JointMove(point + 1);
            }
            None => self.state = HybridState::Waiting,
        }
        Ok(())
    }

    /// The joints at a state of motion along the path.
    fn on_path_at(&self, state: MotionState) -> Setpoint<N> {
        let (path, t) = (self.live.path(), self.cycles as f64 * self.live.period());
        // The path was followed before, so that the inverse is there; should it fail by rounding, the series from the grid is good.
        match path.jet_with_tool(state.p, &self.last.q) {
            Ok((jet, Some(tool))) => jet.setpoint(t, &state, tool.pose),
            _ => self.live.joint_path().near(state.p).setpoint(t, &state, path.pose_path().jet(state.p).pose),
        }
    }
}
