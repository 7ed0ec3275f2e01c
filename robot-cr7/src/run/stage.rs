//! Path, arm and limits of a scenario made ready, and its events as commands.

use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, OrientationPath, PosePath};
use arcfeed_interp::{
    Command, Excursion, FeedSection, Limits, LiveError, LivePath, LiveRoute, MotionPath, PathArm, Planner, ToolPath,
};
use arcfeed_kinematics::{AnalyticInverse, JointLimits, Joints};

use super::error::Cr7Error;
use super::placed_path::{ARC_LENGTH_TOLERANCE, PlacedPath, tool_of};
use super::plan_error::live_error;
use super::samples::MOST_CYCLES;
use crate::input::error::InputError;
use crate::input::joint_values::JointValues;
use crate::input::path_file::PathFile;
use crate::input::scenario::{Action, Place, Scenario, ScenarioPath, When};
use crate::input::toml_check::Check;

/// A scenario for one arm, ready to be played.
#[derive(Clone)]
pub struct Stage<'a> {
    pub(crate) scenario: &'a Scenario,
    pub(crate) arm: &'a dyn PathArm<6>,
    pub(crate) name: String,
    pub(crate) route: LiveRoute<'a>,
    pub(crate) orders: Vec<Order>,
    pub(crate) drive: Joints<6>,
    pub(crate) warnings: Vec<String>,
}

/// An event, with all that it needs.
#[derive(Debug, Clone)]
pub(crate) struct Order {
    pub when: When,
    pub what: What,
}

#[derive(Debug, Clone)]
pub(crate) enum What {
    Command(Box<Command>),
    /// The place depends on where the tool is by then.
    StepBackBy(f64),
}

impl<'a> Stage<'a> {
    /// Name of the path.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The path, made ready: in one part, or in several with ways round between them.
    pub fn route(&self) -> &LiveRoute<'a> {
        &self.route
    }

    /// The first part of the path, with the limits of the arm and the tool.
    pub fn live(&self) -> &LivePath<'a> {
        self.route.first()
    }

    /// Time constants of the simulated drives, s.
    pub fn drive(&self) -> &Joints<6> {
        &self.drive
    }

    /// The number of cycles after which a scenario has to be over.
    pub(crate) fn most_cycles(&self) -> usize {
        (self.scenario.longest / self.live().period()).ceil().min(MOST_CYCLES as f64) as usize
    }

    /// Adds what a person should know, such as an assumption about the arm.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.warnings.extend(warnings);
    }
}

/// The path of a scenario.
struct Loaded {
    name: String,
    /// The file for messages.
    shown: String,
    path: PosePath,
    sections: Vec<FeedSection>,
    stops: Vec<f64>,
    warnings: Vec<String>,
    /// Where the arm stands at its start, if the file says so.
    first: Option<Joints<6>>,
}

impl Scenario {
    /// Makes the scenario ready for `arm` (tool included) under joint `limits`.
    ///
    /// # Errors
    /// [`Cr7Error::Input`] naming the line for a place the arm cannot take, a place behind the end of the path, a list of another length than
    /// the arm has joints; [`Cr7Error::Plan`] for a path that cannot be followed.
    pub fn stage<'a, A>(&'a self, arm: &'a A, limits: &JointLimits<6>) -> Result<Stage<'a>, Cr7Error>
    where
        A: PathArm<6> + AnalyticInverse<6>,
    {
        let Loaded { name, shown, path, sections, stops, warnings, first } = self.load(arm)?;
        let near = match (&self.start, first) {
            (Some(place), _) => Some(self.joints_at("run.start", place, arm, &Joints::zeros())?),
            (None, first) => first,
        };
        let job = &self.job;
        let route = || {
            let path = match near {
                Some(near) => ToolPath::starting_near(arm, path, &near)?,
                None => ToolPath::new(arm, path, limits.range())?,
            };
            let path = path.with_stops(&stops);
            Planner::new(arm, Limits::new(*limits).with_tool(tool_of(job, job.feed.feed)?))
                .with_chord_tolerance(job.chord_tolerance)?
                .with_period(job.period)?
                .with_sections(sections)
                .route(arm, path, self.singularities)
        };
        let route = route().map_err(|error: LiveError| live_error(&shown, error))?;
        let orders = self.orders(arm, route.first())?;
        let drive = self.values("run.drive_time_constant_ms", &self.drive)?;
        Ok(Stage { scenario: self, arm, name, route, orders, drive, warnings })
    }

    pub(crate) fn check(&self) -> Check<'_> {
        Check::new(&self.text, &self.file)
    }

    fn load<A>(&self, arm: &A) -> Result<Loaded, Cr7Error>
    where
        A: PathArm<6> + AnalyticInverse<6>,
    {
        let job = &self.job;
        let mut warnings = job.warnings.clone();
        let file = match &self.path {
            ScenarioPath::File(file) => PathFile::read_for_job(file, None, job)?,
            ScenarioPath::BuiltIn(sample) => sample.load()?,
            ScenarioPath::Line([from, to]) => {
                let from = self.joints_at("path.line[0]", from, arm, &Joints::zeros())?;
                let to = self.joints_at("path.line[1]", to, arm, &from)?;
                let (a, b) = (arm.forward(&from), arm.forward(&to));
                let shown = self.file.display().to_string();
                let wrong = |source| Cr7Error::Curve { file: shown.clone(), source };
                let curve = NurbsCurve::line(a.translation.vector, b.translation.vector).map_err(wrong)?;
                let curve = ArcLengthCurve::new(curve, ARC_LENGTH_TOLERANCE).map_err(wrong)?;
                let turn = OrientationPath::slerp(curve.length(), a.rotation, b.rotation).map_err(wrong)?;
                let (name, path, sections) = ("line".to_owned(), PosePath::new(curve, turn), job.sections.clone());
                return Ok(Loaded { name, shown, path, sections, stops: Vec::new(), warnings, first: Some(from) });
            }
        };
        warnings.extend(file.warnings.iter().cloned());
        let shown = file.file.display().to_string();
        let placed = PlacedPath::new(job, &file)?;
        warnings.extend(placed.warnings(job));
        let PlacedPath { path, mut sections, stops, .. } = placed;
        // While a path is run live no move is faster than the feed, rapid moves neither.
        sections.iter_mut().for_each(|section| section.feed = section.feed.min(job.feed.feed));
        Ok(Loaded { name: file.name, shown, path, sections, stops, warnings, first: None })
    }

    fn values(&self, key: &str, values: &JointValues) -> Result<Joints<6>, InputError> {
        self.check().of::<6>(key, values).map(Joints::from)
    }

    /// Joint values of a place, inside the range of every joint.
    fn joints_at<A>(&self, key: &str, place: &Place, arm: &A, near: &Joints<6>) -> Result<Joints<6>, InputError>
    where
        A: PathArm<6> + AnalyticInverse<6>,
    {
        match place {
            Place::Joints(values) => Ok(self.values(key, values)? + self.values("joints.zero_deg", &self.zero)?),
            Place::Pose(pose) => arm.inverse(pose, near).map_err(|source| {
                let p = pose.translation.vector * 1e3;
                let value = format!("the pose at {:.3}, {:.3}, {:.3} mm: {source}", p.x, p.y, p.z);
                self.check().wrong(key, value, "the tool has to reach the place", "move it, or turn the tool")
            }),
        }
    }

    /// The events as commands.
    fn orders<A>(&self, arm: &A, live: &LivePath<'_>) -> Result<Vec<Order>, Cr7Error>
    where
        A: PathArm<6> + AnalyticInverse<6>,
    {
        let length = live.path().length();
        let on_path = |key: String, s: f64, last: bool| {
            if s < length || last && s == length {
                return Ok(());
            }
            let value = format!("{} on a path of {:.3} mm", s * 1e3, length * 1e3);
            let rule = "it lies before the end of the path, where the motion is over";
            Err(self.check().wrong(&key, value, rule, "lower it"))
        };
        let mut orders = Vec::with_capacity(self.events.len());
        for (i, event) in self.events.iter().enumerate() {
            if let When::Length(s) = event.when {
                on_path(format!("event[{i}].at_mm"), s, false)?;
            }
            let command = match &event.action {
                Action::Feed(feed) => Command::Feed(*feed),
                Action::Override(factor) => Command::Override(*factor),
                Action::Section(section) => {
                    on_path(format!("event[{i}].from_mm"), section.from, false)?;
                    Command::Section(*section)
                }
                Action::ClearSections => Command::ClearSections,
                Action::Hold => Command::Hold,
                Action::Resume => Command::Resume,
                Action::StepBackTo(place) => {
                    on_path(format!("event[{i}].to_mm"), *place, true)?;
                    Command::StepBack(*place)
                }
                Action::StepBackBy(way) => {
                    orders.push(Order { when: event.when, what: What::StepBackBy(*way) });
                    continue;
                }
                Action::Leave(way) => {
                    let mut points = Vec::with_capacity(way.points.len());
                    let mut near = live.joint_path().nodes()[0].q;
                    for (k, place) in way.points.iter().enumerate() {
                        let key = format!("event[{i}].points[{k}]");
                        near = self.joints_at(&key, place, arm, &near)?;
                        self.inside(&key, &near, live.joints())?;
                        points.push(near);
                    }
                    let excursion = Excursion::new(&points, way.leave).and_then(|e| e.with_passing(way.within));
                    let excursion = excursion.map_err(|e| {
                        let rule = "an excursion has 1 to 8 points, the goal last, passed within 0 deg or more";
                        self.check().wrong(&format!("event[{i}].points"), e, rule, "add or remove points")
                    })?;
                    Command::Leave(excursion.with_joint_moves(way.by))
                }
                Action::Return => Command::Return,
                Action::Stop => Command::Stop,
            };
            orders.push(Order { when: event.when, what: What::Command(Box::new(command)) });
        }
        Ok(orders)
    }

    fn inside(&self, key: &str, q: &Joints<6>, limits: &JointLimits<6>) -> Result<(), InputError> {
        let bad = (0..6).find(|&k| !(limits.lower()[k]..=limits.upper()[k]).contains(&q[k]));
        let Some(k) = bad else { return Ok(()) };
        let degrees = |v: f64| format!("{:.3}", v.to_degrees());
        let (at, low, high) = (degrees(q[k]), degrees(limits.lower()[k]), degrees(limits.upper()[k]));
        let value = format!("joint {} at {at} deg, range {low} to {high} deg", k + 1);
        let rule = "every joint stays in its range";
        Err(self.check().wrong(key, value, rule, "choose a place inside; joints.zero_deg is added to joint values"))
    }
}
