//! From the text of a scenario file to a checked [`Scenario`].

use std::path::Path;

use arcfeed_feedrate::LiveSection;
use arcfeed_interp::{JointMoveBy, LeaveBy, MAX_POINTS, SingularityPolicy};
use nalgebra::{Isometry3, Translation3};

use super::file::{
    RawAction, RawEvent, RawJointMoves, RawLeave, RawPlace, RawRun, RawScenario, RawScenarioJoints, RawSingularities,
};
use super::order::check_order;
use super::{Action, Event, Leave, Place, Scenario, ScenarioPath, When};
use crate::input::error::{InputError, read_text};
use crate::input::job::Job;
use crate::input::job_file::{RawJob, RawPath};
use crate::input::job_reader::JobCheck;
use crate::input::joint_values::{JointOverrides, JointValues};
use crate::input::sample_paths::SamplePath;
use crate::input::toml_check::{Check, read_toml};
use crate::input::unit::DEGREE;

const EXPECTED: &str = "a TOML scenario such as scenarios/event.toml";
const EXAMPLE: &str = "scenarios/event.toml";
/// Largest distance at which a point is passed, deg.
const MOST_WITHIN: f64 = 90.0;
/// Highest override that can be ordered.
const MOST_PERCENT: f64 = 150.0;

/// The speed that counts as a stall where the file names none.
const STALL: f64 = 0.05;

fn policy_of(check: &Check<'_>, raw: &RawRun) -> Result<SingularityPolicy, InputError> {
    let given = check.limit("run.stall_percent", raw.stall_percent, 100.0)?;
    if let Some(stall) = given.filter(|stall| *stall >= 1.0) {
        let rule = "a stall is slower than the highest feed";
        return Err(check.wrong("run.stall_percent", stall * 100.0, rule, "some 2 to 20 are usual"));
    }
    let stall = given.unwrap_or(STALL);
    match raw.singularities {
        Some(RawSingularities::GoRound) => Ok(SingularityPolicy::GoRound { stall }),
        Some(RawSingularities::Refuse) => Ok(SingularityPolicy::Refuse { stall }),
        Some(RawSingularities::SlowDown) | None if given.is_none() => Ok(SingularityPolicy::SlowDown),
        _ => {
            let rule = "only go_round and refuse need to know what a stall is";
            let remedy = "remove it, or set run.singularities";
            Err(check.wrong("run.stall_percent", stall * 100.0, rule, remedy))
        }
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// Fails when the file cannot be read, is not TOML, has an unknown key, a value breaks its rule, or the events cannot come in this order.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        Self::parse(&read_text(file, EXPECTED)?, file)
    }

    /// Like [`Scenario::read`], from text; `file` is the name used in messages, and its folder the one that relative paths start from.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawScenario = read_toml(text, file, EXAMPLE)?;
        let check = Check::new(text, file);
        let path = path_of(&check, &raw)?;
        let job = job_of(text, file, &raw)?;
        let feed = check.limit("run.feed_mm_s", Some(raw.run.feed_mm_s), 1e3)?.unwrap_or(job.feed.feed);
        if feed > job.feed.feed {
            let value = format!("{} with a highest feed of {}", raw.run.feed_mm_s, job.feed.feed * 1e3);
            let rule = "no feed is above the highest one, feed.feed_mm_s";
            return Err(check.wrong("run.feed_mm_s", value, rule, "lower it, or raise feed.feed_mm_s"));
        }
        let start = raw.run.start.as_ref().map(|place| place_of(&check, "run.start", place)).transpose()?;
        let events: Vec<Event> =
            raw.event.iter().enumerate().map(|(i, raw)| event_of(&check, i, raw)).collect::<Result<_, _>>()?;
        check_order(&check, &events, job.period)?;
        for (i, event) in events.iter().enumerate() {
            let given = match event.action {
                Action::Feed(feed) => feed,
                Action::Section(section) => section.feed,
                _ => continue,
            };
            if given > job.feed.feed * (1.0 + 1e-12) {
                let value = format!("{} with a highest feed of {}", given * 1e3, job.feed.feed * 1e3);
                let rule = "no feed is above the highest one, feed.feed_mm_s";
                return Err(check.wrong(&format!("event[{i}].feed_mm_s"), value, rule, "lower it, or raise that"));
            }
        }
        Ok(Self {
            file: file.to_owned(),
            text: text.to_owned(),
            path,
            feed,
            start,
            drive: lag_of(&check, raw.run.drive_time_constant_ms.as_ref())?,
            longest: check.limit("run.longest_s", raw.run.longest_s, 1.0)?.unwrap_or(300.0),
            zero: match &raw.joints.zero_deg {
                None => JointValues::All(0.0),
                Some(zero) => check.places("joints.zero_deg", zero, DEGREE)?,
            },
            singularities: policy_of(&check, &raw.run)?,
            events,
            job,
        })
    }
}

fn path_of(check: &Check<'_>, raw: &RawScenario) -> Result<ScenarioPath, InputError> {
    let path = &raw.path;
    let given = [path.file.is_some(), path.built_in.is_some(), path.line.is_some()];
    if given.iter().filter(|g| **g).count() != 1 {
        let rule = "a path comes from one place";
        let remedy = "give one of path.file, path.built_in and path.line";
        return Err(check.wrong("path", if given.contains(&true) { "given twice" } else { "missing" }, rule, remedy));
    }
    if let Some(name) = &path.built_in {
        let known = SamplePath::ALL.into_iter().find(|p| p.name() == name.as_str()).ok_or_else(|| {
            let rule = "there is no built-in path of that name";
            check.wrong("path.built_in", name, rule, "use butterfly, six_point, seven_point or fan")
        })?;
        return Ok(ScenarioPath::BuiltIn(known));
    }
    if let Some(places) = &path.line {
        for (key, given) in [("workpiece", raw.workpiece.is_some()), ("orientation", raw.orientation.is_some())] {
            if given {
                let rule = "a line between two places of the arm has its frame and orientation from them";
                return Err(check.wrong(key, "given", rule, "remove the section, or give the path as a file"));
            }
        }
        let [from, to] = places.as_slice() else {
            let rule = "a line goes from one place to another";
            let value = format!("a list of {}", places.len());
            return Err(check.wrong("path.line", value, rule, "give two places, { rad = [...] } or { deg = [...] }"));
        };
        return Ok(ScenarioPath::Line([place_of(check, "path.line[0]", from)?, place_of(check, "path.line[1]", to)?]));
    }
    let name = path.file.as_deref().unwrap_or_default();
    Ok(ScenarioPath::File(check.file.parent().unwrap_or(Path::new("")).join(name)))
}

/// The job in a scenario.
fn job_of(text: &str, file: &Path, raw: &RawScenario) -> Result<Job, InputError> {
    let check = Check::new(text, file);
    let joints = joints_of(&check, &raw.joints)?;
    let feed = &raw.feed;
    check.no_whole_cycles(&raw.sampling)?;
    for (key, given) in [
        ("angular_speed_deg_s", feed.angular_speed_deg_s),
        ("start_mm_s", feed.start_mm_s),
        ("end_mm_s", feed.end_mm_s),
    ] {
        if let Some(value) = given {
            let rule = "a scenario runs from rest to rest and limits no angular speed";
            return Err(check.wrong(&format!("feed.{key}"), value, rule, "remove the key"));
        }
    }
    let job = RawJob {
        path: RawPath {
            file: None,
            csv_unit: raw.path.csv_unit.clone(),
            fit_tolerance_mm: raw.path.fit_tolerance_mm,
            ..RawPath::default()
        },
        workpiece: raw.workpiece.clone().unwrap_or_default(),
        tool: raw.tool.clone(),
        orientation: raw.orientation.clone().unwrap_or_default(),
        feed: feed.clone(),
        tolerance: raw.tolerance.clone(),
        sampling: raw.sampling.clone(),
        ..RawJob::default()
    };
    Ok(Job { joints, ..JobCheck(check).job(&job)? })
}

fn joints_of(check: &Check<'_>, raw: &RawScenarioJoints) -> Result<JointOverrides, InputError> {
    let one = |name: &str, deg: &Option<JointValues>, rad: &Option<JointValues>, power: &str| {
        let (deg_key, rad_key) = (format!("joints.{name}_deg_{power}"), format!("joints.{name}_rad_{power}"));
        match (deg, rad) {
            (None, None) => Ok(None),
            (Some(deg), None) => check.limits(&deg_key, deg, 1.0 / DEGREE).map(Some),
            (None, Some(rad)) => check.limits(&rad_key, rad, 1.0).map(Some),
            (Some(_), Some(_)) => {
                let rule = "a limit is given once";
                Err(check.wrong(&rad_key, "given in degrees, too", rule, "remove one of the two"))
            }
        }
    };
    Ok(JointOverrides {
        velocity: one("velocity", &raw.velocity_deg_s, &raw.velocity_rad_s, "s")?,
        acceleration: one("acceleration", &raw.acceleration_deg_s2, &raw.acceleration_rad_s2, "s2")?,
        jerk: one("jerk", &raw.jerk_deg_s3, &raw.jerk_rad_s3, "s3")?,
    })
}

fn lag_of(check: &Check<'_>, raw: Option<&JointValues>) -> Result<JointValues, InputError> {
    let key = "run.drive_time_constant_ms";
    let Some(raw) = raw else { return Ok(JointValues::All(0.0)) };
    let values = check.values(key, raw, 1e-3)?;
    let all: &[f64] = match &values {
        JointValues::All(v) => std::slice::from_ref(v),
        JointValues::Each(list) => list,
    };
    if let Some(&bad) = all.iter().find(|&&v| !(0.0..=10.0).contains(&v)) {
        let rule = "a time constant lies between 0 and 10000 ms";
        return Err(check.wrong(key, bad * 1e3, rule, "0 follows without lag; drives have some 2 to 20 ms"));
    }
    Ok(values)
}

fn place_of(check: &Check<'_>, key: &str, raw: &RawPlace) -> Result<Place, InputError> {
    match (&raw.deg, &raw.rad, raw.position_mm, raw.rpy_deg) {
        (Some(deg), None, None, None) => Ok(Place::Joints(check.places(&format!("{key}.deg"), deg, DEGREE)?)),
        (None, Some(rad), None, None) => Ok(Place::Joints(check.places(&format!("{key}.rad"), rad, 1.0)?)),
        (None, None, Some(mm), Some(rpy)) => {
            let position = check.finite(&format!("{key}.position_mm"), mm)? / 1e3;
            let rotation = check.angles(&format!("{key}.rpy_deg"), rpy)?;
            Ok(Place::Pose(Isometry3::from_parts(Translation3::from(position), rotation)))
        }
        _ => {
            let rule = "a place is given by its joints or by the pose of the tool";
            let remedy = "give deg, or rad, or position_mm and rpy_deg";
            Err(check.wrong(key, "neither of them, or several", rule, remedy))
        }
    }
}

fn event_of(check: &Check<'_>, i: usize, raw: &RawEvent) -> Result<Event, InputError> {
    let when = when_of(check, i, raw)?;
    only_its_keys(check, i, raw)?;
    Ok(Event { when, action: EventKeys { check, i, raw }.action()? })
}

/// The keys of one event.
struct EventKeys<'a> {
    check: &'a Check<'a>,
    i: usize,
    raw: &'a RawEvent,
}

impl EventKeys<'_> {
    fn key(&self, name: &str) -> String {
        format!("event[{}].{name}", self.i)
    }

    fn wrong(&self, name: &str, value: impl ToString, rule: &'static str, remedy: &'static str) -> InputError {
        self.check.wrong(&self.key(name), value, rule, remedy)
    }

    fn missing(&self, name: &str) -> InputError {
        self.wrong("do", format!("without {name}"), "the event needs this key", "add the key")
    }

    fn feed(&self) -> Result<f64, InputError> {
        self.raw.feed_mm_s.ok_or_else(|| self.missing("feed_mm_s"))?;
        Ok(self.check.limit(&self.key("feed_mm_s"), self.raw.feed_mm_s, 1e3)?.unwrap_or_default())
    }

    fn length(&self, name: &str, value: Option<f64>) -> Result<f64, InputError> {
        let mm = value.ok_or_else(|| self.missing(name))?;
        if mm.is_finite() && mm >= 0.0 {
            return Ok(mm / 1e3);
        }
        let rule = "a length along the path is a finite number from 0 on";
        Err(self.wrong(name, mm, rule, "count from the start of the path"))
    }

    fn action(&self) -> Result<Action, InputError> {
        let raw = self.raw;
        Ok(match raw.action {
            RawAction::Feed => Action::Feed(self.feed()?),
            RawAction::Override => {
                let percent = raw.percent.ok_or_else(|| self.missing("percent"))?;
                if !(0.0..=MOST_PERCENT).contains(&percent) {
                    let rule = "an override lies between 0 and 150 %";
                    return Err(self.wrong("percent", percent, rule, "100 is the programmed feed, 0 holds"));
                }
                Action::Override(percent / 100.0)
            }
            RawAction::Section => Action::Section(self.section()?),
            RawAction::ClearSections => Action::ClearSections,
            RawAction::Hold => Action::Hold,
            RawAction::Resume => Action::Resume,
            RawAction::StepBack => match (raw.to_mm, raw.by_mm) {
                (Some(_), None) => Action::StepBackTo(self.length("to_mm", raw.to_mm)?),
                (None, Some(_)) => Action::StepBackBy(self.length("by_mm", raw.by_mm)?),
                _ => {
                    let rule = "a step back goes to a place or by a length";
                    return Err(self.wrong("do", "neither or both", rule, "give one of to_mm and by_mm"));
                }
            },
            RawAction::Leave => Action::Leave(self.leave()?),
            RawAction::Return => Action::Return,
            RawAction::Stop => Action::Stop,
        })
    }

    fn section(&self) -> Result<LiveSection, InputError> {
        let (from, to) = (self.length("from_mm", self.raw.from_mm)?, self.length("to_mm", self.raw.to_mm)?);
        if to <= from {
            let value = format!("{} after {}", to * 1e3, from * 1e3);
            return Err(self.wrong("to_mm", value, "a section ends behind its start", "raise to_mm"));
        }
        Ok(LiveSection { from, to, feed: self.feed()? })
    }

    fn leave(&self) -> Result<Leave, InputError> {
        let points = self.raw.points.as_deref().ok_or_else(|| self.missing("points"))?;
        if points.is_empty() || points.len() > MAX_POINTS {
            let value = format!("a list of {}", points.len());
            let rule = "an excursion has 1 to 8 points, the goal last";
            return Err(self.wrong("points", value, rule, "add or remove points"));
        }
        let place = |(k, raw)| place_of(self.check, &self.key(&format!("points[{k}]")), raw);
        let within = self.raw.pass_within_deg.unwrap_or(0.0);
        if !(0.0..=MOST_WITHIN).contains(&within) {
            let rule = "points are passed within 0 to 90 deg";
            return Err(self.wrong("pass_within_deg", within, rule, "0 stops at each point"));
        }
        Ok(Leave {
            points: points.iter().enumerate().map(place).collect::<Result<_, _>>()?,
            leave: match self.raw.leave {
                None | Some(RawLeave::Braking) => LeaveBy::Braking,
                Some(RawLeave::AtOnce) => LeaveBy::AtOnce,
            },
            within: within * DEGREE,
            by: match self.raw.joint_moves {
                None | Some(RawJointMoves::LeastTime) => JointMoveBy::LeastTime,
                Some(RawJointMoves::Projection) => JointMoveBy::Projection,
            },
        })
    }
}

fn when_of(check: &Check<'_>, i: usize, raw: &RawEvent) -> Result<When, InputError> {
    let from_zero = |name: &str, v: f64| {
        if v.is_finite() && v >= 0.0 {
            return Ok(v);
        }
        let rule = "nothing happens before the start: it is a finite number from 0 on";
        Err(check.wrong(&format!("event[{i}].{name}"), v, rule, "count from the start of the motion"))
    };
    match (raw.at_s, raw.at_cycle, raw.at_mm, raw.wait_s) {
        (Some(t), None, None, None) => Ok(When::Time(from_zero("at_s", t)?)),
        (None, Some(cycle), None, None) => {
            Ok(When::Cycle(u64::try_from(cycle).map_or_else(|_| from_zero("at_cycle", cycle as f64).map(|_| 0), Ok)?))
        }
        (None, None, Some(mm), None) => Ok(When::Length(from_zero("at_mm", mm)? / 1e3)),
        (None, None, None, Some(t)) => Ok(When::Stood(from_zero("wait_s", t)?)),
        (None, None, None, None) => {
            let rule = "an event needs a time";
            let remedy = "give at_s, at_cycle, at_mm (along the path), or wait_s (after the arm has come to stand)";
            Err(check.wrong(&format!("event[{i}]"), "without one", rule, remedy))
        }
        _ => {
            let rule = "an event has one time";
            Err(check.wrong(&format!("event[{i}]"), "several", rule, "keep one of at_s, at_cycle, at_mm and wait_s"))
        }
    }
}

/// Keys that the action does not know are a slip.
fn only_its_keys(check: &Check<'_>, i: usize, raw: &RawEvent) -> Result<(), InputError> {
    let known: &[&str] = match raw.action {
        RawAction::Feed => &["feed_mm_s"],
        RawAction::Override => &["percent"],
        RawAction::Section => &["from_mm", "to_mm", "feed_mm_s"],
        RawAction::StepBack => &["to_mm", "by_mm"],
        RawAction::Leave => &["leave", "points", "pass_within_deg", "joint_moves"],
        _ => &[],
    };
    let given = [
        ("feed_mm_s", raw.feed_mm_s.is_some()),
        ("percent", raw.percent.is_some()),
        ("from_mm", raw.from_mm.is_some()),
        ("to_mm", raw.to_mm.is_some()),
        ("by_mm", raw.by_mm.is_some()),
        ("leave", raw.leave.is_some()),
        ("points", raw.points.is_some()),
        ("pass_within_deg", raw.pass_within_deg.is_some()),
        ("joint_moves", raw.joint_moves.is_some()),
    ];
    match given.iter().find(|(name, given)| *given && !known.contains(name)) {
        None => Ok(()),
        Some((name, _)) => {
            let rule = "this event does not know the key";
            Err(check.wrong(&format!("event[{i}].{name}"), "given", rule, "remove it, or change what the event does"))
        }
    }
}
