//! From the text of a job file to a checked [`Job`].

use std::path::Path;

use arcfeed_interp::{Extent, FeedSection, Method};
use arcfeed_kinematics::Posture;
use nalgebra::Unit;

use super::error::{InputError, read_text, text_of};
use super::job::{FeedLimits, Job, ToolOrientation};
use super::job_file::{
    RawFeed, RawJob, RawMode, RawOrientation, RawPath, RawPlan, RawRapid, RawSection, RawStart, RawThrough,
};
use super::rapid_moves::{RapidKind, RapidMoves};
use super::toml_check::{Check, read_toml, rotation};
use super::unit::LengthUnit;

const EXPECTED: &str = "a TOML job such as jobs/butterfly.toml";
/// The highest feed, m/s. No arm comes near it, and planning takes the longer the higher the feed is above what the arm can do.
const FASTEST: f64 = 1e3;
/// The longest lift of the tool, m.
const HIGHEST_LIFT: f64 = 10.0;

impl Job {
    /// A job file with every key, its default and what it means.
    pub const EXAMPLE: &'static str = include_str!("../../jobs/butterfly.toml");

    /// Reads and checks a job file.
    ///
    /// # Errors
    /// Fails when the file cannot be read, is not TOML, has an unknown key, or a value breaks its rule; the message names file,
    /// line, key and value, and what to do.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        Self::parse(&read_text(file, EXPECTED)?, file)
    }

    /// Like [`Job::read`], from bytes that are in memory already; `file` is the name used in messages, and its folder
    /// the one that relative paths start from.
    ///
    /// # Errors
    /// As [`Job::read`].
    pub fn from_bytes(bytes: &[u8], file: &Path) -> Result<Self, InputError> {
        Self::parse(&text_of(bytes, file, EXPECTED)?, file)
    }

    fn parse(text: &str, file: &Path) -> Result<Self, InputError> {
        let raw: RawJob = read_toml(text, file, "jobs/butterfly.toml")?;
        JobCheck(Check::new(text, file)).job(&raw)
    }
}

/// The checks of a job.
pub(crate) struct JobCheck<'a>(pub(crate) Check<'a>);

impl JobCheck<'_> {
    pub(crate) fn job(mut self, raw: &RawJob) -> Result<Job, InputError> {
        let default = Job::default();
        let csv_unit = raw.path.csv_unit.as_deref().map(|symbol| {
            LengthUnit::from_symbol(symbol).ok_or_else(|| InputError::UnknownUnit {
                file: self.0.file.to_owned(),
                place: self
                    .0
                    .line_of("path.csv_unit")
                    .map_or("path.csv_unit".into(), |l| format!("path.csv_unit (line {l})")),
                unit: symbol.to_owned(),
            })
        });
        let mm = 1e3;
        let feed = self.feeds(&raw.feed, &default.feed)?;
        if raw.feed.feed_mm_s.is_some_and(|v| v < 1.0) {
            self.0.warn("feed.feed_mm_s", feed.feed * 1e3, "mm/s is very slow: did you mean m/s? Write 1000 for 1 m/s");
        }
        let job = Job {
            path_file: raw.path.file.as_ref().map(|p| self.0.file.parent().unwrap_or(Path::new("")).join(p)),
            csv_unit: csv_unit.transpose()?,
            fit_tolerance: self.0.limit_or(
                "path.fit_tolerance_mm",
                raw.path.fit_tolerance_mm,
                mm,
                default.fit_tolerance,
            )?,
            polyline: raw.path.through == RawThrough::Polyline,
            bulge: self.0.limit("path.bulge_mm", raw.path.bulge_mm, mm)?,
            smooth: self.0.limit("path.smooth_mm", raw.path.smooth_mm, mm)?,
            blend: self.0.limit("path.blend_mm", raw.path.blend_mm, mm)?,
            blend_angle: self.0.limit_or(
                "path.blend_deg",
                raw.path.blend_deg,
                180.0 / std::f64::consts::PI,
                default.blend_angle,
            )?,
            layers: self.layers(&raw.path)?,
            lift: self.lift(&raw.path)?.unwrap_or(default.lift),
            start_near: raw
                .start
                .near_deg
                .as_ref()
                .map(|near| self.0.places("start.near_deg", near, std::f64::consts::PI / 180.0))
                .transpose()?,
            start_posture: self.posture(&raw.start)?,
            workpiece: self.0.frame("workpiece", &raw.workpiece, default.workpiece)?,
            tool: self.0.frame("tool", &raw.tool, default.tool)?,
            orientation: self.orientation(&raw.orientation)?,
            feed,
            rapid: self.rapid(&raw.feed, default.rapid)?,
            sections: raw.sections.iter().enumerate().map(|(i, raw)| self.section(i, raw)).collect::<Result<_, _>>()?,
            torque: self.torque(raw)?,
            tables: self.tables(raw)?,
            vibrations: self.vibrations(raw)?,
            joints: self.0.overrides("joints", &raw.joints)?,
            chord_tolerance: self.0.limit_or(
                "tolerance.chord_mm",
                raw.tolerance.chord_mm,
                mm,
                default.chord_tolerance,
            )?,
            period: self.0.period(raw.sampling.period_ms)?.unwrap_or(default.period),
            whole_cycles: self.0.whole_cycles(&raw.sampling, feed.end_speeds)?,
            method: self.method(&raw.plan)?,
            warnings: Vec::new(),
        };
        if job.chord_tolerance > 0.01 {
            self.0.warn(
                "tolerance.chord_mm",
                job.chord_tolerance * 1e3,
                "mm is coarse for a tool path: did you mean um?",
            );
        }
        Ok(Job { warnings: self.0.warnings, ..job })
    }

    /// The layers of a drawing: none where the key is missing, for that means all.
    fn layers(&self, raw: &RawPath) -> Result<Vec<String>, InputError> {
        match &raw.layers {
            Some(layers) if layers.is_empty() => {
                let rule = "a list of layers has to name one";
                Err(self.0.wrong("path.layers", "[]", rule, "name a layer, or remove the key to follow all of them"))
            }
            layers => Ok(layers.clone().unwrap_or_default()),
        }
    }

    /// The lift between two contours of a drawing, m.
    fn lift(&self, raw: &RawPath) -> Result<Option<f64>, InputError> {
        let lift = self.0.limit("path.lift_mm", raw.lift_mm, 1e3)?;
        match raw.lift_mm {
            Some(mm) if lift.is_some_and(|lift| lift > HIGHEST_LIFT) => {
                let rule = "a lift is 10000 mm at the most";
                Err(self.0.wrong("path.lift_mm", mm, rule, "check the unit: the number is in mm"))
            }
            _ => Ok(lift),
        }
    }

    /// The limits along the path, `default` where the job gives none.
    fn feeds(&self, raw: &RawFeed, default: &FeedLimits) -> Result<FeedLimits, InputError> {
        let mm = 1e3;
        Ok(FeedLimits {
            feed: self.feed("feed.feed_mm_s", raw.feed_mm_s)?.unwrap_or(default.feed),
            tangential_acceleration: self.0.limit_or(
                "feed.tangential_acceleration_mm_s2",
                raw.tangential_acceleration_mm_s2,
                mm,
                default.tangential_acceleration,
            )?,
            tangential_jerk: self.0.limit_or(
                "feed.tangential_jerk_mm_s3",
                raw.tangential_jerk_mm_s3,
                mm,
                default.tangential_jerk,
            )?,
            normal_acceleration: self.0.limit_or(
                "feed.normal_acceleration_mm_s2",
                raw.normal_acceleration_mm_s2,
                mm,
                default.normal_acceleration,
            )?,
            normal_jerk: self.0.limit("feed.normal_jerk_mm_s3", raw.normal_jerk_mm_s3, mm)?,
            tool_acceleration: self.0.limit("feed.tool_acceleration_mm_s2", raw.tool_acceleration_mm_s2, mm)?,
            tool_jerk: self.0.limit("feed.tool_jerk_mm_s3", raw.tool_jerk_mm_s3, mm)?,
            angular_speed: self.0.limit(
                "feed.angular_speed_deg_s",
                raw.angular_speed_deg_s,
                180.0 / std::f64::consts::PI,
            )?,
            end_speeds: [self.speed("feed.start_mm_s", raw.start_mm_s)?, self.speed("feed.end_mm_s", raw.end_mm_s)?],
        })
    }

    /// How rapid moves are made.
    fn rapid(&mut self, raw: &RawFeed, default: RapidMoves) -> Result<RapidMoves, InputError> {
        let kind = match raw.rapid {
            RawRapid::Line => RapidKind::Line,
            RawRapid::Joints => RapidKind::Joints,
        };
        let speed = self.feed("feed.rapid_mm_s", raw.rapid_mm_s)?;
        if let (RapidKind::Joints, Some(mm_s)) = (kind, raw.rapid_mm_s) {
            let hint = "has no effect with feed.rapid = \"joints\": these moves keep the limits of the joints";
            self.0.warn("feed.rapid_mm_s", mm_s, hint);
        }
        let blend = self.0.limit_or("feed.rapid_blend_mm", raw.rapid_blend_mm, 1e3, default.blend)?;
        Ok(RapidMoves { kind, speed, blend })
    }

    /// A speed at an end of the path, m/s.
    fn speed(&self, key: &str, mm_s: Option<f64>) -> Result<f64, InputError> {
        match mm_s {
            None => Ok(0.0),
            Some(v) if v.is_finite() && v >= 0.0 => Ok(v / 1e3),
            Some(v) => {
                let rule = "it has to be a finite number, 0 or more";
                Err(self.0.wrong(key, v, rule, "raise it, or remove the key to start and end at rest"))
            }
        }
    }

    /// A feed in m/s, no faster than [`FASTEST`].
    fn feed(&self, key: &str, mm_s: Option<f64>) -> Result<Option<f64>, InputError> {
        let feed = self.0.limit(key, mm_s, 1e3)?;
        if let (Some(mm_s), Some(_)) = (mm_s, feed.filter(|feed| *feed > FASTEST)) {
            let rule = "a feed is 1000000 mm/s at the most, a thousand metres a second";
            return Err(self.0.wrong(key, mm_s, rule, "check the unit: the number is in mm/s"));
        }
        Ok(feed)
    }

    fn section(&self, index: usize, raw: &RawSection) -> Result<FeedSection, InputError> {
        let key = |name: &str| format!("sections[{index}].{name}");
        let Some(feed) = self.feed(&key("feed_mm_s"), raw.feed_mm_s)? else {
            let rule = "a section needs a feed of its own";
            return Err(self.0.wrong(&key("feed_mm_s"), "missing", rule, "add the key, or remove the section"));
        };
        for (name, value) in
            [("from_mm", raw.from_mm), ("to_mm", raw.to_mm), ("from_u", raw.from_u), ("to_u", raw.to_u)]
        {
            if let Some(value) = value.filter(|v| !v.is_finite()) {
                return Err(self.0.wrong(&key(name), value, "it has to be a finite number", "write a plain number"));
            }
        }
        let before = |name: &str, from: String| {
            let rule = "a section has to begin before it ends";
            Err(self.0.wrong(&key(name), from, rule, "lower it, or raise the end"))
        };
        let lengths = (raw.from_mm, raw.to_mm);
        let parameters = (raw.from_u, raw.to_u);
        let segments = (raw.from_segment, raw.to_segment);
        let extent = match (lengths, parameters, segments) {
            ((Some(from), Some(to)), (None, None), (None, None)) => {
                if from >= to {
                    return before("from_mm", from.to_string());
                }
                Extent::Length { from: from / 1e3, to: to / 1e3 }
            }
            ((None, None), (Some(from), Some(to)), (None, None)) => {
                if from >= to {
                    return before("from_u", from.to_string());
                }
                Extent::Parameter { from, to }
            }
            ((None, None), (None, None), (Some(from), Some(to))) => {
                let number = |name: &str, n: i64| {
                    usize::try_from(n).ok().filter(|&n| n > 0).ok_or_else(|| {
                        let rule = "segments count from 1";
                        self.0.wrong(&key(name), n, rule, "raise it, or give the section by from_mm and to_mm")
                    })
                };
                let (first, last) = (number("from_segment", from)?, number("to_segment", to)?);
                if first > last {
                    return before("from_segment", from.to_string());
                }
                Extent::Segments { first, last }
            }
            _ => {
                let rule =
                    "a section is given by from_mm and to_mm, or from_u and to_u, or from_segment and to_segment";
                let given = "not one such pair";
                return Err(self.0.wrong(
                    &format!("sections[{index}]"),
                    given,
                    rule,
                    "give exactly one of the three pairs",
                ));
            }
        };
        Ok(FeedSection { extent, feed })
    }

    fn posture(&self, raw: &RawStart) -> Result<Option<Posture>, InputError> {
        let Some(text) = &raw.configuration else { return Ok(None) };
        if raw.near_deg.is_some() {
            let rule = "the start is near given joints, or in a configuration by name";
            return Err(self.0.wrong("start.configuration", format!("\"{text}\""), rule, "remove one of the two keys"));
        }
        text.parse().map(Some).map_err(|_| {
            let rule = "a configuration is named by side, elbow and wrist";
            let remedy = "write front or back, up or down, flip or no-flip, as in \"front up no-flip\"";
            self.0.wrong("start.configuration", format!("\"{text}\""), rule, remedy)
        })
    }

    fn method(&self, raw: &RawPlan) -> Result<Method, InputError> {
        let method = match &raw.planner {
            None => Method::default(),
            Some(name) => Method::from_name(name).ok_or_else(|| {
                let rule = "it has to be the name of a planner";
                let remedy = "choose one of jerk-limited, continuous-acceleration, per-segment, forward-backward, reachability, \
                              interpolated-reachability";
                self.0.wrong("plan.planner", format!("\"{name}\""), rule, remedy)
            })?,
        };
        let Some(ahead) = raw.lookahead else { return Ok(method) };
        let window = usize::try_from(ahead).ok().filter(|&n| n > 0).ok_or_else(|| {
            let rule = "it counts segments and has to be a whole number from 1 on";
            self.0.wrong("plan.lookahead", ahead, rule, "raise it, or remove the key to look ahead to the end")
        })?;
        match method {
            Method::PerSegment { .. } => Ok(Method::PerSegment { window: Some(window) }),
            _ => {
                let rule = "only the planner per-segment looks ahead by segments";
                Err(self.0.wrong("plan.lookahead", ahead, rule, "remove it, or set planner = \"per-segment\""))
            }
        }
    }

    fn orientation(&mut self, raw: &RawOrientation) -> Result<ToolOrientation, InputError> {
        let allowed: &[&str] = match raw.mode {
            RawMode::Constant => &["rpy_deg"],
            RawMode::Slerp => &["from_rpy_deg", "to_rpy_deg"],
            RawMode::Tangent => &["axis"],
        };
        let given = [
            ("rpy_deg", raw.rpy_deg),
            ("from_rpy_deg", raw.from_rpy_deg),
            ("to_rpy_deg", raw.to_rpy_deg),
            ("axis", raw.axis),
        ];
        for (name, value) in given {
            if let Some(value) = value.filter(|_| !allowed.contains(&name)) {
                let rule = match raw.mode {
                    RawMode::Constant => "mode \"constant\" knows rpy_deg only",
                    RawMode::Slerp => "mode \"slerp\" knows from_rpy_deg and to_rpy_deg only",
                    RawMode::Tangent => "mode \"tangent\" knows axis only",
                };
                let value = format!("{value:?}");
                return Err(self.0.wrong(
                    &format!("orientation.{name}"),
                    value,
                    rule,
                    "remove the key, or change the mode",
                ));
            }
        }
        let angles = |name: &str, value: Option<[f64; 3]>| match value {
            Some(degrees) => self.0.angles(&format!("orientation.{name}"), degrees),
            None if raw.mode == RawMode::Constant => Ok(rotation([180.0, 0.0, 0.0])),
            None => {
                let rule = "mode \"slerp\" needs from_rpy_deg and to_rpy_deg";
                Err(self.0.wrong(&format!("orientation.{name}"), "missing", rule, "add the key"))
            }
        };
        Ok(match raw.mode {
            RawMode::Constant => ToolOrientation::Constant(angles("rpy_deg", raw.rpy_deg)?),
            RawMode::Slerp => ToolOrientation::Slerp {
                from: angles("from_rpy_deg", raw.from_rpy_deg)?,
                to: angles("to_rpy_deg", raw.to_rpy_deg)?,
            },
            RawMode::Tangent => {
                let value = raw.axis.unwrap_or([0.0, 0.0, -1.0]);
                let v = self.0.finite("orientation.axis", value)?;
                // Scaled first: the squares of very large or small components leave the range of doubles.
                let axis = Some(v.amax()).filter(|&m| m > 0.0).and_then(|m| Unit::try_new(v / m, 0.0));
                let axis = axis.ok_or_else(|| {
                    let rule = "an axis needs a direction";
                    self.0.wrong(
                        "orientation.axis",
                        format!("{value:?}"),
                        rule,
                        "write [0, 0, -1] for a tool that points down",
                    )
                })?;
                ToolOrientation::Tangent { axis }
            }
        })
    }
}
