//! Scenarios of motion in both spaces: a tool path, and what happens while it runs.
//!
//! `file` is the TOML file as it is written, `read` checks it, `order` refuses events that cannot come in their order.

mod file;
mod order;
mod read;

use std::path::{Path, PathBuf};

use arcfeed_feedrate::LiveSection;
use arcfeed_interp::{JointMoveBy, LeaveBy, SingularityPolicy};
use nalgebra::Isometry3;

use super::job::Job;
use crate::input::joint_values::JointValues;
use crate::input::sample_paths::SamplePath;
use crate::text::number;

/// A checked scenario, in SI units.
///
/// ```
/// use robot_cr7::{Clock, Cr7, RunReport, Scenario};
///
/// let scenario = Scenario::parse(Scenario::EXAMPLE, "event.toml".as_ref())?;
/// let cr7 = Cr7::of(scenario.job())?;
/// let stage = scenario.stage(cr7.arm(), cr7.limits())?;
/// let played = stage.play(Clock::Simulated)?;
/// let report = RunReport::new(&stage, &played);
/// assert!(report.holds);
/// assert_eq!(report.excursions.len(), 1);
/// # Ok::<(), robot_cr7::Cr7Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    pub(crate) file: PathBuf,
    pub(crate) text: String,
    /// Frames, orientation, limits, tolerance and period; its feed is the highest that any override leads to.
    pub(crate) job: Job,
    pub(crate) path: ScenarioPath,
    pub(crate) feed: f64,
    pub(crate) start: Option<Place>,
    pub(crate) drive: JointValues,
    pub(crate) longest: f64,
    pub(crate) zero: JointValues,
    pub(crate) singularities: SingularityPolicy,
    pub(crate) events: Vec<Event>,
}

/// The source of the tool path.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ScenarioPath {
    File(PathBuf),
    BuiltIn(SamplePath),
    /// A straight line between two places of the arm.
    Line([Place; 2]),
}

/// A place of the arm.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Place {
    /// Joint values of the file, rad.
    Joints(JointValues),
    /// Tool pose in the base frame.
    Pose(Isometry3<f64>),
}

/// Something that is ordered, and when.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Event {
    pub(crate) when: When,
    pub(crate) action: Action,
}

/// The condition of an event: it comes at the first cycle at which this holds and all events before it have come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum When {
    /// From this time on, s.
    Time(f64),
    /// From this cycle on.
    Cycle(u64),
    /// At this arc length or beyond, on the task path, m.
    Length(f64),
    /// After the arm has stood for so long, s: at the goal of an excursion or in a hold.
    Stood(f64),
}

/// A way off the path.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Leave {
    pub(crate) points: Vec<Place>,
    pub(crate) leave: LeaveBy,
    /// Distance of the joints at which a point before the goal is passed, rad; 0 to stop there.
    pub(crate) within: f64,
    pub(crate) by: JointMoveBy,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Action {
    Feed(f64),
    Override(f64),
    Section(LiveSection),
    ClearSections,
    Hold,
    Resume,
    StepBackTo(f64),
    StepBackBy(f64),
    Leave(Leave),
    Return,
    Stop,
}

impl Action {
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Feed(_) => "feed",
            Self::Override(_) => "override",
            Self::Section(_) => "section",
            Self::ClearSections => "clear sections",
            Self::Hold => "hold",
            Self::Resume => "resume",
            Self::StepBackTo(_) | Self::StepBackBy(_) => "step back",
            Self::Leave(..) => "leave",
            Self::Return => "return",
            Self::Stop => "stop",
        }
    }

    /// The order in words.
    pub(crate) fn words(&self) -> String {
        let mm = |v: f64| number(v * 1e3);
        match self {
            Self::Feed(feed) => format!("feed {} mm/s", mm(*feed)),
            Self::Override(factor) => format!("override {} %", number(factor * 100.0)),
            Self::Section(s) => format!("section {} to {} mm at {} mm/s", mm(s.from), mm(s.to), mm(s.feed)),
            Self::StepBackTo(place) => format!("step back to {} mm", mm(*place)),
            Self::StepBackBy(way) => format!("step back by {} mm", mm(*way)),
            Self::Leave(Leave { points, leave, .. }) => {
                let how = if *leave == LeaveBy::Braking { ", braking," } else { " at once," };
                format!("leave{how} over {} points", points.len())
            }
            _ => self.name().to_owned(),
        }
    }
}

impl Scenario {
    /// A scenario with every key and what it means: an event on a straight path, as in Liu et al. 2024, section 5.3.
    pub const EXAMPLE: &'static str = include_str!("../../../scenarios/event.toml");

    /// The scenarios that come with the program: name of the file, and its text.
    pub const ALL: [(&'static str, &'static str); 3] = [
        ("event.toml", Self::EXAMPLE),
        ("event_middle.toml", include_str!("../../../scenarios/event_middle.toml")),
        ("butterfly_live.toml", include_str!("../../../scenarios/butterfly_live.toml")),
    ];

    /// Frames, orientation, limits, tolerance and period. `feed.feed` is the highest feed that any override leads to.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The file of the path, where it comes from one.
    pub fn path_file(&self) -> Option<&Path> {
        match &self.path {
            ScenarioPath::File(file) => Some(file),
            _ => None,
        }
    }

    /// The programmed feed at the start, m/s.
    pub fn feed(&self) -> f64 {
        self.feed
    }

    /// Number of events.
    pub fn events(&self) -> usize {
        self.events.len()
    }
}
