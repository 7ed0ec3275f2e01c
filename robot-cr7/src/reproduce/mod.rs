//! A paper's claims beside what this library measures, with the guarantees that must hold.

mod all;
mod hs;
mod hs_live;
#[cfg(feature = "plot")]
mod hs_pictures;
mod qb;

pub use all::{Overview, PAPERS, Paper};
pub use hs::liu_2024;
#[cfg(feature = "plot")]
pub use hs_pictures::{NamedPicture, liu_2024_pictures};
pub use qb::{ScheduleFigures, huang_2025};

use std::fmt;
use std::time::Instant;

use arcfeed_feedrate::{AxisLimits, SProfile};
use arcfeed_geometry::{NurbsCurve, SegmentationMethod};
use arcfeed_interp::parameter::{
    ArcLengthStep, CompensatedTaylor, FirstTaylor, ParameterStep, SecondTaylor, fluctuation,
};
use arcfeed_interp::{Method, PlanError};
use serde::Serialize;

use crate::input::job::Job;
use crate::input::sample_paths::SamplePath;
use crate::run::error::Cr7Error;
use crate::run::task::{Motion, Task};

/// One number of a paper and ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// Where in the paper: "table 1", ...
    pub place: String,
    /// What the number is.
    pub what: String,
    /// The paper's value, as printed; empty where the paper has none.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// What a reader should know about the pair.
    pub note: String,
    /// Whether a guarantee of this library, tied to the number, holds; `None` where the number is only shown.
    pub holds: Option<bool>,
}

/// All claims of one paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reproduction {
    /// Which paper.
    pub paper: String,
    /// Its numbers and ours.
    pub claims: Vec<Claim>,
}

/// One figure of a paper, drawn anew: lines over time or path length.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file.
    pub file: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Conditions and results in words.
    pub facts: String,
    /// Quantity and unit of the horizontal axis.
    pub across: &'static str,
    /// Quantity and unit of the vertical axis.
    pub label: &'static str,
    /// The lines.
    pub lines: Vec<FigureLine>,
}

/// One line of a [`Figure`].
#[derive(Debug, Clone, PartialEq)]
pub struct FigureLine {
    /// Name in the legend.
    pub name: String,
    /// Place on the horizontal axis, and value.
    pub points: Vec<(f64, f64)>,
}

impl Reproduction {
    /// Guarantees that do not hold.
    pub fn broken(&self) -> impl Iterator<Item = &Claim> {
        self.claims.iter().filter(|c| c.holds == Some(false))
    }

    /// One JSON object on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }

    fn add(
        &mut self,
        place: &str,
        what: impl Into<String>,
        paper: impl Into<String>,
        ours: impl Into<String>,
    ) -> &mut Claim {
        self.claims.push(Claim {
            place: place.to_owned(),
            what: what.into(),
            paper: paper.into(),
            ours: ours.into(),
            note: String::new(),
            holds: None,
        });
        let last = self.claims.len() - 1;
        &mut self.claims[last]
    }
}

impl Claim {
    fn guaranteed(&mut self, holds: bool) -> &mut Self {
        self.holds = Some(holds);
        self
    }

    fn note(&mut self, note: impl Into<String>) -> &mut Self {
        self.note = note.into();
        self
    }
}

impl fmt::Display for Reproduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.paper)?;
        let mut place = "";
        for c in &self.claims {
            if c.place != place {
                place = &c.place;
                writeln!(f, "\n{place}")?;
                writeln!(f, "  {:<50} {:>20} {:>24}", "", "paper", "ours")?;
            }
            let mark = match c.holds {
                Some(true) => "  holds",
                Some(false) => "  BROKEN",
                None => "",
            };
            let line = format!("  {:<50} {:>20} {:>24}{mark}", c.what, c.paper, c.ours);
            writeln!(f, "{}", line.trim_end())?;
            if !c.note.is_empty() {
                writeln!(f, "      {}", c.note)?;
            }
        }
        let guarantees = self.claims.iter().filter(|c| c.holds.is_some()).count();
        let broken = self.broken().count();
        writeln!(f, "\n{} of {guarantees} guarantees hold", guarantees - broken)
    }
}

/// Liu et al. 2023, "A High-Precision Planar NURBS Interpolation System Based on Segmentation Method for Industrial
/// Robot", Appl. Sci. 13, 13210: tables 1 and 2, the segment counts, and the feed fluctuation of its interpolators.
///
/// # Errors
/// [`Cr7Error`] when an embedded path cannot be planned, which would be a bug.
pub fn liu_2023() -> Result<Reproduction, Cr7Error> {
    let mut r = Reproduction {
        paper: "X. Liu et al., A High-Precision Planar NURBS Interpolation System Based on Segmentation Method for \
                Industrial Robot, Appl. Sci. 2023, 13, 13210"
            .to_owned(),
        claims: Vec::new(),
    };
    table_1(&mut r)?;
    segment_counts(&mut r)?;
    // The paper scans; so does this, and the jerk-limited planner stands beside it below.
    let job = Job { method: Method::ContinuousAcceleration, ..Job::default() };
    let task = Task::of_cr7(&job, &SamplePath::Butterfly.load()?)?;
    let motion = task.plan()?;
    table_2(&mut r, &motion)?;
    interpolators(&mut r, &motion)?;
    joining(&mut r, &task, &motion)?;
    Ok(r)
}

fn curve_of(path: SamplePath) -> Result<NurbsCurve<3>, Cr7Error> {
    let file = path.load()?;
    Ok(file.curve_with(|_| unreachable_fit())?)
}

fn failed(source: PlanError) -> Cr7Error {
    Cr7Error::Plan { file: "butterfly".to_owned(), source: Box::new(source), hint: String::new() }
}

/// The embedded paths are curves, never points.
fn unreachable_fit() -> Result<NurbsCurve<3>, arcfeed_geometry::GeometryError> {
    Err(arcfeed_geometry::GeometryError::DegreeZero)
}

/// The Bezier control points of the six-point curve.
fn table_1(r: &mut Reproduction) -> Result<(), Cr7Error> {
    const PRINTED: [[(f64, f64); 4]; 3] = [
        [(5.0, 4.0), (6.0, 12.0), (8.5, 12.0), (9.25, 9.5)],
        [(9.25, 9.5), (10.0, 8.0), (9.0, 6.0), (9.5, 4.75)],
        [(9.5, 4.75), (10.0, 3.5), (12.0, 3.0), (11.0, 9.0)],
    ];
    const PLACE: &str = "Table 1: Bezier control points of the six-point curve, mm";
    let curve = curve_of(SamplePath::SixPoint)?;
    let beziers = curve.decompose();
    for (b, (bezier, printed)) in beziers.iter().zip(&PRINTED).enumerate() {
        for (i, (p, paper)) in bezier.control_points().zip(printed).enumerate() {
            let ours = (p.x * 1e3, p.y * 1e3);
            let claim = r.add(
                PLACE,
                format!("Bezier {}, point {}", b + 1, i + 1),
                format!("({}, {})", paper.0, paper.1),
                format!("({:.6}, {:.6})", ours.0, ours.1),
            );
            if (ours.0 - paper.0).abs() > 1e-9 || (ours.1 - paper.1).abs() > 1e-9 {
                claim.note("the print is wrong: with its own NURBS points the decomposition gives ours");
            }
        }
    }
    // The decomposition must not move the curve: compare with the curve itself, evaluated by other code.
    let mut worst = 0.0f64;
    for bezier in &beziers {
        let (a, b) = bezier.interval();
        for i in 0..=1000 {
            let u = a + (b - a) * f64::from(i) / 1000.0;
            worst = worst.max((bezier.point(u) - arcfeed_geometry::Curve::point(&curve, u)).norm());
        }
    }
    r.add(PLACE, "largest distance from the NURBS curve", "", format!("{:.1e} mm", worst * 1e3))
        .guaranteed(worst < 1e-16);
    Ok(())
}

/// Largest distance of a curve from the chords of a segmentation, measured by plain dense sampling.
fn dense_deviation(curve: &NurbsCurve<3>, breaks: &[f64]) -> f64 {
    use arcfeed_geometry::Curve;
    const SAMPLES: u32 = 200;
    let mut worst = 0.0f64;
    for pair in breaks.windows(2) {
        let (a, b) = (curve.point(pair[0]), curve.point(pair[1]));
        let chord = b - a;
        let length2 = chord.norm_squared();
        for i in 1..SAMPLES {
            let p = curve.point(pair[0] + (pair[1] - pair[0]) * f64::from(i) / f64::from(SAMPLES)) - a;
            let f = if length2 > 0.0 { (p.dot(&chord) / length2).max(0.0).min(1.0) } else { 0.0 };
            worst = worst.max((p - chord * f).norm());
        }
    }
    worst
}

fn segment_counts(r: &mut Reproduction) -> Result<(), Cr7Error> {
    const PLACE: &str =
        "Segments for a chord tolerance, and true deviation (the last two curves: counts of Actuators 2024, 13, 108)";
    // Name, curve, tolerance (m), the paper's count, and the most pieces ours may have: within knot spans, across knots.
    let cases = [
        ("six points, 0.001 mm", SamplePath::SixPoint, 1e-6, "143", Some((114, 112))),
        ("butterfly, 0.001 mm", SamplePath::Butterfly, 1e-6, "1579", Some((1174, 1155))),
        ("fan, 0.001 mm", SamplePath::Fan, 1e-6, "1454", None),
        ("seven points, 0.1 mm", SamplePath::SevenPoint, 1e-4, "47", Some((11, 10))),
        ("butterfly, 0.05 mm", SamplePath::Butterfly, 5e-5, "193", Some((184, 157))),
    ];
    for (name, path, tolerance, paper, most) in cases {
        let curve = curve_of(path)?;
        for (method, words, bound) in [
            (SegmentationMethod::CType, "the paper's method", None),
            (SegmentationMethod::Hull, "convex hull, bisected", None),
            (SegmentationMethod::Greedy { across_knots: false }, "longest pieces", most.map(|m| m.0)),
            (SegmentationMethod::Greedy { across_knots: true }, "longest pieces across knots", most.map(|m| m.1)),
        ] {
            let result =
                curve.segment(method, tolerance).map_err(|source| Cr7Error::Curve { file: name.to_owned(), source })?;
            let deviation = dense_deviation(&curve, result.breaks());
            let keeps = deviation <= tolerance && result.max_deviation() <= tolerance;
            let shown = if words == "the paper's method" { paper } else { "" };
            let claim = r.add(
                PLACE,
                format!("{name}: {words}"),
                shown,
                format!("{} ({:.7} mm)", result.len(), deviation * 1e3),
            );
            claim.guaranteed(keeps && bound.is_none_or(|b| result.len() <= b));
            if words == "the paper's method" && result.len().to_string() != paper {
                claim.note("no reading of the paper gives its count; the tolerance, measured densely, is what counts");
            }
        }
    }
    Ok(())
}

fn table_2(r: &mut Reproduction, motion: &Motion<'_>) -> Result<(), Cr7Error> {
    const PLACE: &str =
        "Table 2: butterfly at 0.001 mm, MATLAB on an i7-11800H (in brackets its columns X.D., L.H., L.F.)";
    let plan = motion.trajectory();
    let timings = plan.timings();
    let begin = Instant::now();
    let mut samples = 0usize;
    let mut last_s = 0.0;
    let mut sampling_error = None;
    match motion.setpoints() {
        Ok(sampler) => {
            for setpoint in sampler {
                match setpoint {
                    Ok(p) => {
                        samples += 1;
                        last_s = p.s;
                    }
                    Err(e) => sampling_error = Some(e),
                }
            }
        }
        Err(e) => sampling_error = Some(e.into()),
    }
    if let Some(source) = sampling_error {
        return Err(failed(source));
    }
    let sampling = begin.elapsed().as_secs_f64();

    let Some(path) = plan.path().tool_curve() else { return Ok(()) };
    let curve = path.curve().curve();
    let halved = curve
        .segment(SegmentationMethod::CType, 1e-6)
        .map_err(|source| Cr7Error::Curve { file: "butterfly".to_owned(), source })?;
    // Halvings of the most often halved knot span: its length over the shortest piece in it.
    let (a, b) = arcfeed_geometry::Curve::<3>::domain(curve);
    let longest = curve.decompose().iter().map(|p| p.interval().1 - p.interval().0).fold(0.0f64, f64::max);
    let shortest = halved.pieces().map(|(u0, u1, _)| u1 - u0).fold(b - a, f64::min);
    r.add(
        PLACE,
        "rounds of iteration (X.D. 0, L.H. 9, L.F. 0)",
        "5",
        format!("at most {}", (longest / shortest).log2().ceil()),
    )
    .note("ours by halving; the pieces in use are found by a search, without rounds");
    r.add(PLACE, "time to cut the curve, s (0, 8, 0)", "0.7", format!("{:.4}", timings.grid.as_secs_f64()));
    let deviation = dense_deviation(curve, plan.segmentation().map_or(&[], |s| s.breaks()));
    r.add(PLACE, "largest chord error, mm (1.8, 0.03, 2)", "0.001", format!("{:.7}", deviation * 1e3))
        .guaranteed(deviation <= 1e-6);
    let end = path.curve().parameter(last_s);
    r.add(PLACE, "end value of u (0.997, 0.997, 0.999)", "1", format!("{end}")).guaranteed(end == 1.0);
    let missing = plan.path().length() - last_s;
    r.add(PLACE, "truncation error, mm (0.001, 0.001, 0)", "0", format!("{}", missing * 1e3))
        .guaranteed(missing == 0.0);
    r.add(PLACE, "bidirectional scan, s (0.01, 0.1, 0.01)", "0.3", format!("{:.4}", timings.speed.as_secs_f64()))
        .note("ours: up to four scans with different shares of the joint limits, the fastest kept");
    r.add(PLACE, "one S-profile, s (6e-5, 6e-5, 6e-5)", "7e-5", format!("{:.1e}", s_profile_time()));
    r.add(PLACE, "interpolation of the whole path, s (9, 10, 13)", "10", format!("{sampling:.4}")).note(format!(
        "{samples} cycles of 1 ms with inverse kinematics: {:.2} us a cycle",
        sampling / samples as f64 * 1e6
    ));
    let total = motion.planning_time().as_secs_f64() + sampling;
    r.add(PLACE, "total computing time, s (10, 19, 14)", "12", format!("{total:.4}"));
    r.add(PLACE, "duration of the motion, s", "", format!("{:.3}", plan.duration()))
        .note("the paper prints neither its feed nor its limits; ours are the defaults of `cr7 plan`, scanned");
    let worst = plan.verification().worst().ratio;
    r.add(PLACE, "worst use of any limit, verified, %", "", format!("{:.4}", 100.0 * worst))
        .guaranteed(worst <= 1.0 + 1e-6);
    Ok(())
}

/// Median time of one S-profile, s.
fn s_profile_time() -> f64 {
    const BATCH: u32 = 1000;
    let Ok(limits) = AxisLimits::symmetric(0.1, 1.0, 20.0) else { return f64::NAN };
    let mut times: Vec<f64> = (0..31)
        .map(|_| {
            let begin = Instant::now();
            for i in 0..BATCH {
                let length = 1e-4 + 1e-4 * f64::from(i);
                std::hint::black_box(SProfile::new(std::hint::black_box(length), 0.01, 0.02, &limits)).ok();
            }
            begin.elapsed().as_secs_f64() / f64::from(BATCH)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn interpolators(r: &mut Reproduction, motion: &Motion<'_>) -> Result<(), Cr7Error> {
    const PLACE: &str = "Section 5: feed fluctuation by arc length, butterfly, 1 ms (largest / rms in %; end of u)";
    let Some(path) = motion.trajectory().path().tool_curve() else { return Ok(()) };
    let curve = path.curve();
    for feed in [0.01, 0.1] {
        let Ok(profile) =
            AxisLimits::symmetric(feed, 1.0, 20.0).and_then(|l| SProfile::new(curve.length(), 0.0, 0.0, &l))
        else {
            continue;
        };
        let compensated = CompensatedTaylor::new(curve.curve(), 1e-15)
            .map_err(|source| Cr7Error::Curve { file: "butterfly".to_owned(), source })?;
        let steps: [Box<dyn ParameterStep + '_>; 4] = [
            Box::new(FirstTaylor::new(curve.curve())),
            Box::new(SecondTaylor::new(curve.curve())),
            Box::new(compensated),
            Box::new(ArcLengthStep::new(curve)),
        ];
        for (i, mut step) in steps.into_iter().enumerate() {
            let f = fluctuation(curve, &profile, 1e-3, step.as_mut()).map_err(failed)?;
            let what = format!("{} at {} mm/s", step.name(), feed * 1e3);
            let ours = format!("{:.1e} / {:.1e}; {:.6}", 100.0 * f.largest, 100.0 * f.rms, f.end);
            let claim = r.add(PLACE, what, "", ours);
            if i >= 2 {
                claim.guaranteed(f.end == 1.0 && f.truncation.abs() < 1e-15);
            }
            if i == 3 && feed == 0.01 {
                claim.guaranteed(f.largest < 1e-9 && f.end == 1.0);
            }
        }
    }
    Ok(())
}

/// What zero acceleration at every segment boundary costs.
fn joining(r: &mut Reproduction, task: &Task, motion: &Motion<'_>) -> Result<(), Cr7Error> {
    const PLACE: &str = "Section 4: what zero acceleration at every segment boundary costs, butterfly";
    let joined = motion.trajectory();
    let path = task.tool_path()?;
    let with = |method| task.planner()?.with_method(method).plan(&path).map_err(failed);
    let (least, separate) = (with(Method::JerkLimited)?, with(Method::PerSegment { window: None })?);
    r.add(PLACE, "zero acceleration at each boundary, s", "", format!("{:.3}", separate.duration()));
    r.add(PLACE, "joined between the speed minima, s", "", format!("{:.3}", joined.duration()))
        .note(format!("saves {:.1} % of the time", 100.0 * (1.0 - joined.duration() / separate.duration())))
        .guaranteed(joined.duration() <= separate.duration());
    r.add(PLACE, "jerk-limited under all limits at once, s", "", format!("{:.3}", least.duration()))
        .note(format!("saves {:.1} %; in {:.2} s", 100.0 * (1.0 - least.duration() / separate.duration()), {
            least.timings().speed.as_secs_f64()
        }))
        .guaranteed(least.duration() <= joined.duration());
    Ok(())
}
