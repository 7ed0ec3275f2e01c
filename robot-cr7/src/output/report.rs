//! The result of a plan on one screen, and as JSON.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::time::Duration;

use arcfeed_geometry::{Segmentation, SegmentationMethod};
use serde::Serialize;

use super::binding_line::{BindingLine, limited_by};
use super::bound_report::BoundReport;
use super::compiled_report::{CompiledReport, LINES};
use super::limit_table::{ending, limit_table};
use super::part_report::{PartReport, parts_line, rapids_line};
use super::program_report::ProgramReport;
use crate::run::limit_line::{LimitLine, worst};
use crate::run::limit_lines::limit_lines;
use crate::run::motion::Motion;
use crate::run::placed_path::PointFit;
use crate::run::side_effects::{ThermalLine, VibrationLine, thermal_words, vibration_words};
use crate::run::stream::StreamReport;
use crate::text::{WIDTH, clip, duration, number};

/// The number of segments that one method needs for the chord tolerance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SegmentCount {
    /// Name of the segmentation.
    pub method: String,
    /// Number of segments.
    pub segments: usize,
    /// Largest deviation of any of them from the path, in m.
    pub max_deviation_m: f64,
}

/// The report of a plan. Its fields are keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Name of the path.
    pub name: String,
    /// Length of the path in m.
    pub length_m: f64,
    /// Duration of the motion in s.
    pub duration_s: f64,
    /// The planner whose speed law it is.
    pub planner: String,
    /// Why it is not the jerk-limited planner's, where that was asked for.
    pub fallback: Option<String>,
    /// The number of planning rounds until the verification passed.
    pub planning_rounds: usize,
    /// The number of windows in which the speed along very long paths was planned; 0 where each path was planned at once.
    pub planning_windows: usize,
    /// Number of samples.
    pub samples: usize,
    /// Control period in s.
    pub period_s: f64,
    /// Segments by method; the first is the one that was used.
    pub segments: Vec<SegmentCount>,
    /// Chord tolerance in m.
    pub chord_tolerance_m: f64,
    /// Largest deviation of the segments used from the path, in m.
    pub max_deviation_m: f64,
    /// Time spent on planning, in s.
    pub planning_time_s: f64,
    /// Time spent on verifying the plan on dense samples, in s.
    pub verification_time_s: f64,
    /// Time spent on sampling, in s.
    pub sampling_time_s: f64,
    /// Seconds of motion per second of computing.
    pub motion_per_computing: f64,
    /// Every limit with its worst place.
    pub limits: Vec<LimitLine>,
    /// The intervals in which each limit binds (99.9 % of it and more is used), by the way along the path, m.
    pub binding: Vec<BindingLine>,
    /// The vibration of each structure that the job names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub vibration: Vec<VibrationLine>,
    /// The thermal load of the drives, where torque is limited.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub thermal: Vec<ThermalLine>,
    /// How much shorter any motion can be, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<BoundReport>,
    /// The compiled motion, where one was asked for.
    pub compiled: Option<CompiledReport>,
    /// How near the path is to the points of its file, where it is a smooth curve through such.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<PointFit>,
    /// The lines of the path file along the motion, where it has such.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<ProgramReport>,
    /// The parts of a program that waits, or whose rapid moves are motions of the joints.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartReport>,
    /// What the look-ahead cost, where segments arrived while the motion ran.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<StreamReport>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

impl Report {
    /// The lines on a program and its parts, on vibration and on thermal load; their number.
    fn program_lines(&self, f: &mut Formatter<'_>) -> Result<usize, fmt::Error> {
        // Beside a bound and a compiled motion the screen is full; JSON has it.
        let fit = self.fit.as_ref().filter(|_| self.bound.is_none() || self.compiled.is_none());
        let fit = fit.map(|fit| (' ', "points", fit_words(fit)));
        let corners = self.program.as_ref().map(|program| (' ', "corners", program.line()));
        let parts = parts_line(&self.parts).map(|parts| (' ', "parts", parts));
        let rapids = rapids_line(&self.parts).map(|(line, exceeds)| (if exceeds { '!' } else { ' ' }, "rapids", line));
        let side = |name, words: Option<(bool, String)>| {
            words.map(|(holds, line)| (if holds { ' ' } else { '!' }, name, line))
        };
        let vibration = side("vibration", vibration_words(&self.vibration));
        let thermal = side("rms torque", thermal_words(&self.thermal));
        let lines = [fit, corners, parts, rapids, vibration, thermal];
        for (mark, name, line) in lines.iter().flatten() {
            writeln!(f, "{mark} {name:<11}{}", clip(line, WIDTH - 13))?;
        }
        Ok(lines.iter().flatten().count())
    }

    /// The line that uses most of its limit; lines with a ratio that is not a number count as the worst.
    pub fn worst(&self) -> Option<&LimitLine> {
        worst(&self.limits)
    }
}

impl<const N: usize> Motion<'_, N> {
    /// The report of the motion; `samples` setpoints were computed in `sampling`.
    pub fn report(&self, samples: usize, sampling: Duration) -> Report {
        let (plan, info) = (self.trajectory(), self.trajectory().info());
        let slowed = info.windows.as_ref().filter(|windows| !windows.stops.is_empty());
        let planning_time_s = self.planning_time().as_secs_f64();
        let verification_time_s = plan.timings().verification.as_secs_f64();
        let sampling_time_s = sampling.as_secs_f64();
        Report {
            name: self.name().to_owned(),
            length_m: plan.path().length(),
            duration_s: plan.duration(),
            planner: info.method.map_or_else(|| STREAMED.to_owned(), |method| method.to_string()),
            fallback: info.fallback.map(|reason| reason.to_string()),
            planning_rounds: info.rounds,
            planning_windows: info.windows.as_ref().map_or(0, |windows| windows.count),
            samples,
            period_s: plan.period(),
            segments: self.segment_counts(),
            chord_tolerance_m: plan.chord_tolerance(),
            max_deviation_m: plan.segmentation().map_or(0.0, |segments| segments.max_deviation()),
            planning_time_s,
            verification_time_s,
            sampling_time_s,
            motion_per_computing: plan.duration() / (planning_time_s + verification_time_s + sampling_time_s),
            limits: self.limits(),
            binding: BindingLine::of(plan.verification().bindings(), 0.0),
            vibration: self.vibration().to_vec(),
            thermal: self.thermal().to_vec(),
            bound: None,
            fit: self.fit(),
            program: None,
            parts: Vec::new(),
            compiled: None,
            stream: self.stream().cloned(),
            warnings: self
                .warnings()
                .iter()
                .cloned()
                .chain(slowed.map(|windows| format!("planned in {windows}")))
                .collect(),
            files: Vec::new(),
        }
    }

    /// Every limit with its worst place, and the line of the file there.
    pub(crate) fn limits(&self) -> Vec<LimitLine> {
        let mut limits = limit_lines(self.trajectory().verification(), self.trajectory().path().parameter());
        for limit in &mut limits {
            limit.lines = self.outline().zip(limit.at_s_m).map(|(outline, s)| outline.lines_at(s));
        }
        limits
    }

    /// Segments by each method for the chord tolerance, the one in use first.
    pub(crate) fn segment_counts(&self) -> Vec<SegmentCount> {
        let plan = self.trajectory();
        let (Some(used), Some(path)) = (plan.segmentation(), plan.path().tool_curve()) else { return Vec::new() };
        let curve = path.curve().curve();
        let others = [(SegmentationMethod::CType, "C-type, bisected"), (SegmentationMethod::Hull, "hull, bisected")];
        let others = others
            .into_iter()
            .filter_map(|(method, name)| Some((name, curve.segment(method, plan.chord_tolerance()).ok()?)));
        let count = |(name, segmentation): (&str, &Segmentation)| SegmentCount {
            method: name.to_owned(),
            segments: segmentation.len(),
            max_deviation_m: segmentation.max_deviation(),
        };
        std::iter::once(count(("longest pieces", used))).chain(others.map(|(name, s)| count((name, &s)))).collect()
    }
}

/// Name of the planner of a streamed motion.
const STREAMED: &str = "per-segment, streamed";
/// Lines that warnings and files may take, so that all of the report stays on one screen of 40 lines.
const MOST_WARNINGS: usize = 3;
const MOST_FILES: usize = 2;

fn fit_words(fit: &PointFit) -> String {
    format!(
        "{}, at most {} um off the curve, which leaves the lines between them by {} mm at most (line {})",
        fit.points,
        number(fit.deviation_m * 1e6),
        number(fit.bulge_m * 1e3),
        fit.bulge_line
    )
}

fn stream_words(stream: &StreamReport) -> String {
    format!(
        "{} ahead: held back {} times, on {} mm, waits {} s; whole path known: {} s",
        stream.look_ahead,
        stream.held_back_m.len(),
        number(stream.held_back() * 1e3),
        number(stream.waited()),
        number(stream.whole_duration_s)
    )
}

impl Display for Report {
    /// The report for a terminal: at most 40 lines of 100 columns, lengths in mm, angles in degrees.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", clip(&self.name, WIDTH))?;
        let limited = limited_by(&self.binding, self.length_m).unwrap_or_else(|| "nothing for long".to_owned());
        writeln!(f, "  {:<11}{}", "limited by", clip(&limited, WIDTH - 13))?;
        let pair = |f: &mut Formatter<'_>, a: (&str, String), b: (&str, String)| {
            writeln!(f, "  {:<11}{:<36} {:<11}{}", a.0, clip(&a.1, 36), b.0, clip(&b.1, 39))
        };
        pair(
            f,
            ("length", format!("{} mm", number(self.length_m * 1e3))),
            (
                "duration",
                format!(
                    "{} s, {} samples at {} ms",
                    number(self.duration_s),
                    self.samples,
                    number(self.period_s * 1e3)
                ),
            ),
        )?;
        pair(
            f,
            ("tolerance", format!("{} um", number(self.chord_tolerance_m * 1e6))),
            ("deviation", format!("{} um at most", number(self.max_deviation_m * 1e6))),
        )?;
        let rounds =
            if self.planning_rounds > 1 { format!(", {} rounds", self.planning_rounds) } else { String::new() };
        let windows =
            if self.planning_windows > 0 { format!(", {} windows", self.planning_windows) } else { String::new() };
        let why = self.fallback.as_ref().map(|why| format!(" instead of jerk-limited: {why}")).unwrap_or_default();
        let planner = format!("{}{rounds}{windows}{why}", self.planner);
        // The whole reason, and it may take a second line.
        let words: Vec<char> = planner.chars().collect();
        writeln!(f, "  {:<11}{}", "planner", words.iter().take(WIDTH - 13).collect::<String>())?;
        let second = words.len() > WIDTH - 13;
        if second {
            let rest: String = words.iter().skip(WIDTH - 13).collect();
            writeln!(f, "  {:<11}{}", "", clip(&rest, WIDTH - 13))?;
        }
        if let Some(bound) = &self.bound {
            writeln!(f, "  {:<11}{}", "bound", clip(&bound.line(), WIDTH - 13))?;
        }
        if let Some(stream) = &self.stream {
            writeln!(f, "  {:<11}{}", "stream", clip(&stream_words(stream), WIDTH - 13))?;
        }
        writeln!(
            f,
            "  {:<11}{} plan, {} verify, {} sample: {} s of motion per second of computing",
            "computing",
            duration(self.planning_time_s),
            duration(self.verification_time_s),
            duration(self.sampling_time_s),
            number(self.motion_per_computing)
        )?;
        let of_program = self.program_lines(f)?;
        let compiled = self.compiled.as_ref().map(CompiledReport::lines);
        for (name, line) in ["compiled", "", ""].into_iter().zip(compiled.iter().flatten()) {
            writeln!(f, "  {name:<11}{}", clip(line, WIDTH - 13))?;
        }

        limit_table(f, &self.limits)?;
        let taken = usize::from(second)
            + usize::from(self.bound.is_some())
            + LINES * usize::from(compiled.is_some())
            + usize::from(self.stream.is_some())
            + of_program;
        ending(
            f,
            &self.warnings,
            &self.files,
            [MOST_WARNINGS.saturating_sub(taken), MOST_FILES.saturating_sub(taken.saturating_sub(MOST_WARNINGS))],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::compiled_report::CertifiedRatio;
    use crate::run::limit_line::LimitUnit;

    fn line(name: &str, joint: Option<usize>, unit: LimitUnit, value: f64, limit: f64) -> LimitLine {
        let ratio = (value / limit).abs();
        LimitLine {
            name: name.to_owned(),
            joint,
            unit,
            value,
            limit,
            ratio,
            at_s_m: Some(0.123456),
            at_t_s: 1.234567,
            lines: None,
        }
    }

    fn report() -> Report {
        let mut limits = vec![
            line("feed", None, LimitUnit::MetrePerSecond, 0.1, 0.1),
            line("tangential acceleration", None, LimitUnit::MetrePerSecond2, -0.998, 1.0),
        ];
        for (name, unit) in [
            ("joint position", LimitUnit::Radian),
            ("joint velocity", LimitUnit::RadianPerSecond),
            ("joint acceleration", LimitUnit::RadianPerSecond2),
            ("joint jerk", LimitUnit::RadianPerSecond3),
        ] {
            limits.extend((1..=6).map(|j| line(name, Some(j), unit, 0.1 * j as f64, 3.0)));
        }
        Report {
            name: "butterfly".to_owned(),
            length_m: 0.382860311,
            duration_s: 5.4321,
            planner: "jerk-limited".to_owned(),
            fallback: None,
            planning_rounds: 1,
            planning_windows: 0,
            samples: 5434,
            period_s: 1e-3,
            segments: vec![
                SegmentCount { method: "longest pieces".to_owned(), segments: 1174, max_deviation_m: 1e-6 },
                SegmentCount { method: "hull halving".to_owned(), segments: 1911, max_deviation_m: 0.9e-6 },
            ],
            chord_tolerance_m: 1e-6,
            max_deviation_m: 0.999e-6,
            planning_time_s: 0.0123,
            verification_time_s: 0.1,
            sampling_time_s: 0.0045,
            motion_per_computing: 323.4,
            limits,
            binding: vec![BindingLine { limit: "jerk of joint 3".to_owned(), intervals: vec![[0.0, 0.157]] }],
            vibration: Vec::new(),
            thermal: Vec::new(),
            bound: None,
            fit: None,
            program: None,
            parts: Vec::new(),
            compiled: None,
            stream: None,
            warnings: vec!["the path passes the wrist singularity at 3 deg".to_owned()],
            files: vec!["out/butterfly.csv".into(), "out/path.svg".into()],
        }
    }

    #[test]
    fn text_fits_one_screen_and_names_the_worst_of_each_limit() {
        let text = report().to_string();
        println!("{text}");
        assert!(text.lines().count() <= 40);
        assert!(text.lines().all(|l| l.chars().count() <= 100));
        let velocity = text.lines().find(|l| l.contains("joint velocity")).expect("a line for it");
        for part in ["J6", "34.377", "171.89", "deg/s", "20.00 %", "123.46", "1.235"] {
            assert!(velocity.contains(part), "{part} in {velocity}");
        }
        let feed = text.lines().find(|l| l.trim_start().starts_with("feed")).expect("a line for it");
        assert!(feed.contains("100 ") && feed.contains("mm/s") && feed.contains("100.00 %"), "{feed}");
    }

    #[test]
    fn text_stays_on_one_screen_whatever_is_in_it() {
        let mut r = report();
        r.name = "x\n".repeat(300);
        r.warnings = vec!["w".repeat(500); 50];
        r.files = vec!["f".repeat(500).into(); 50];
        r.fallback = Some("because ".repeat(50));
        let worst =
            CertifiedRatio { name: "q".repeat(50), joint: 9, seen: f64::NAN, ratio: f64::INFINITY, at_t_s: f64::NAN };
        r.bound = Some(BoundReport {
            lower_bound_s: f64::MIN_POSITIVE,
            gap: f64::NAN,
            conditional_intervals: usize::MAX,
            intervals: usize::MAX,
        });
        r.compiled = Some(CompiledReport {
            tolerance_rad: 1e-300,
            pieces: usize::MAX,
            deviation_bound_rad: f64::NAN,
            deviation_measured_rad: 1e300,
            certified: vec![worst; 9],
            certified_tool: Vec::new(),
            tool_deviation_bound_m: f64::NAN,
        });
        let stream = Some(StreamReport {
            look_ahead: usize::MAX,
            gap_s: f64::NAN,
            whole_duration_s: f64::MAX,
            held_back_m: vec![(0.0, f64::MAX); 99],
            waits_m_s: vec![(0.0, f64::MAX); 99],
        });
        for i in 0..40 {
            r.limits.extend((1..=6).map(|j| line(&format!("kind {i}"), Some(j), LimitUnit::One, f64::NAN, 1e300)));
        }
        r.segments.extend(vec![SegmentCount { method: "m".repeat(50), segments: usize::MAX, max_deviation_m: 0.0 }; 9]);
        for v in [&mut r.length_m, &mut r.duration_s, &mut r.motion_per_computing, &mut r.planning_time_s] {
            *v = f64::NEG_INFINITY;
        }
        r.fit = Some(PointFit {
            points: usize::MAX,
            control_points: usize::MAX,
            deviation_m: f64::NAN,
            bulge_m: f64::MAX,
            bulge_line: u64::MAX,
        });
        // A stream has neither a compiled motion nor a bound.
        let streamed = Report { bound: None, compiled: None, stream, ..r.clone() };
        let planned = Report { bound: None, ..r.clone() };
        for text in [r.to_string(), planned.to_string(), streamed.to_string()] {
            assert!(text.lines().count() <= 40, "{} lines", text.lines().count());
            for l in text.lines() {
                assert!(l.chars().count() <= 100, "{} columns: {l}", l.chars().count());
            }
        }
    }

    #[test]
    fn a_broken_limit_is_marked_and_never_rounded_to_one_hundred_percent() {
        let mut r = report();
        r.limits[0].ratio = 1.00001;
        assert_eq!(r.worst().map(|l| l.name.as_str()), Some("feed"));
        let text = r.to_string();
        let feed = text.lines().find(|l| l.contains(" feed")).expect("a line for it");
        assert!(feed.starts_with('!') && feed.contains(">100 %"), "{feed}");
    }

    #[test]
    fn json_keeps_si_with_units_in_the_keys() {
        let text = crate::text::json(&report());
        assert!(!text.contains('\n'));
        let v: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
        assert_eq!(v["length_m"], 0.382860311);
        assert_eq!(v["samples"], 5434);
        assert_eq!(v["segments"][1]["segments"], 1911);
        assert_eq!(v["limits"][2]["name"], "joint position");
        assert_eq!(v["limits"][2]["joint"], 1);
        assert_eq!(v["limits"][0]["unit"], "m/s");
        assert_eq!(v["limits"][0]["joint"], serde_json::Value::Null);
        for key in ["ratio", "value", "limit", "at_s_m", "at_t_s"] {
            assert!(v["limits"][0][key].is_number(), "{key}");
        }
        assert_eq!(v["files"][0], "out/butterfly.csv");
    }

    #[test]
    fn numbers_are_short_and_keep_five_digits() {
        for (v, text) in [
            (0.0, "0"),
            (100.0, "100"),
            (382.860311, "382.86"),
            (0.00123456, "0.0012346"),
            (-5.4321, "-5.4321"),
            (20000.0, "20000"),
            (1e12, "1.000e12"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(v), text);
        }
    }
}
