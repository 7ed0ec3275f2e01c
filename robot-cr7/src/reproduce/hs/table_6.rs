//! Liu et al. 2024, section 5.1: the butterfly with feeds that change while it runs (Table 6,
//! Figures 11 and 12).

use arcfeed_geometry::SegmentationMethod;
use arcfeed_interp::HybridState;
use nalgebra::Vector3;

use super::conditions::played;
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};
use crate::reproduce::spline::{Spline, off_segment};
use crate::reproduce::{Reproduction, cr7_dh};
use crate::run::error::Cr7Error;

const PLACE: &str = "Table 6, figures 11 and 12: butterfly at 0.05 mm, feeds ordered while it runs (mm, s)";
/// Segments that the paper counts.
const COUNT: usize = 193;
/// Table 6 in m and s: chord error, feed, tangential acceleration and jerk, normal acceleration.
const CHORD: f64 = 5e-5;
const FEED: f64 = 0.010;
const TANGENTIAL: (f64, f64) = (0.1, 1.0);
const NORMAL: f64 = 0.12;
/// First and last segment of each section (from 1) with its feed, mm/s.
const SECTIONS: [(usize, usize, f64); 5] =
    [(20, 45, 12.0), (50, 60, 8.0), (70, 85, 14.0), (95, 100, 11.0), (150, 180, 15.0)];
/// Round-off of feeds from differences of tool points, relative.
const SLACK: f64 = 1e-6;

/// One cycle of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathCycle {
    /// Arc length, m.
    pub s: f64,
    /// Feed that was asked for, m/s.
    pub asked: f64,
    /// Tool point from the joints by the Denavit-Hartenberg table, m.
    pub tool: [f64; 3],
}

/// A section with a feed of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedSection {
    /// Segments, as Table 6 counts them.
    pub name: String,
    /// Arc lengths, m.
    pub from: f64,
    /// Arc lengths, m.
    pub to: f64,
    /// Feed, mm/s.
    pub feed: f64,
}

/// The motion of Table 6.
#[derive(Debug, Clone, PartialEq)]
pub struct Table6Run {
    /// Arc length, feed and tangential acceleration over time.
    pub motion: SampledMotion,
    /// The cycles of `motion`.
    pub cycles: Vec<PathCycle>,
    /// The sections of Table 6.
    pub sections: Vec<FeedSection>,
    /// The butterfly where the tool runs it.
    pub curve: Spline,
    /// Parameters where segments end, by halving.
    pub breaks: Vec<f64>,
    /// Arc lengths of the same, m.
    pub lengths: Vec<f64>,
    /// Median time of one cycle, s.
    pub cycle_time: f64,
}

fn job() -> String {
    format!(
        "[path]\nbuilt_in = \"butterfly\"\n[feed]\nfeed_mm_s = 15.0\ntangential_acceleration_mm_s2 = 100.0\n\
         tangential_jerk_mm_s3 = 1000.0\nnormal_acceleration_mm_s2 = 120.0\n[tolerance]\nchord_mm = 0.05\n\
         [sampling]\nperiod_ms = 1.0\n[run]\nfeed_mm_s = {:.1}\n",
        FEED * 1e3
    )
}

/// Ends of the segments by halving: parameters and arc lengths (m).
fn segments() -> Result<(Vec<f64>, Vec<f64>), Cr7Error> {
    let curve = crate::input::sample_paths::butterfly()?;
    let nurbs = curve.curve_with(|_| Err(arcfeed_geometry::GeometryError::DegreeZero))?;
    let failed = |source| Cr7Error::Curve { file: "butterfly".to_owned(), source };
    let breaks = nurbs.segment(SegmentationMethod::CType, CHORD).map_err(failed)?.breaks().to_vec();
    let curve = arcfeed_geometry::ArcLengthCurve::new(nurbs, 1e-12).map_err(failed)?;
    let lengths = breaks.iter().map(|&u| curve.arc_length_at(u)).collect();
    Ok((breaks, lengths))
}

/// Segments `first` to `last` of the paper's 193 are the same share of ours.
fn section(lengths: &[f64], (first, last, feed): (usize, usize, f64)) -> FeedSection {
    let ours = lengths.len() - 1;
    let place = |n: usize| lengths[((n * ours + COUNT / 2) / COUNT).min(ours)];
    FeedSection { name: format!("{first}-{last}"), from: place(first - 1), to: place(last), feed }
}

impl Table6Run {
    /// Plays the scenario of Table 6.
    ///
    /// # Errors
    /// [`Cr7Error`] when the embedded path cannot be planned.
    pub fn measure() -> Result<Self, Cr7Error> {
        let (breaks, lengths) = segments()?;
        let sections: Vec<FeedSection> = SECTIONS.iter().map(|&s| section(&lengths, s)).collect();
        let mut text = job();
        for FeedSection { from, to, feed, .. } in &sections {
            text += &format!(
                "[[event]]\nat_cycle = 0\ndo = \"section\"\nfrom_mm = {}\nto_mm = {}\nfeed_mm_s = {feed:.1}\n",
                from * 1e3,
                to * 1e3
            );
        }
        played(&text, "table 6", |stage, played| {
            let curve = stage.live().path().pose_path().curve().curve();
            let spline = Spline::new(curve);
            let (lo, hi) = spline.domain();
            let length = spline.length(lo, hi, 4000);
            let points: Vec<_> =
                std::iter::once(played.start()).chain(played.cycles().iter().map(|c| &c.setpoint)).collect();
            let t: Vec<f64> = points.iter().map(|p| p.t).collect();
            let bounds = AxisBounds { v: (0.0, 0.015), ..AxisBounds::symmetric(0.015, TANGENTIAL.0, TANGENTIAL.1) };
            let axis = SampledAxis::of_path(points.iter().copied(), length, bounds);
            let asked = std::iter::once(FEED).chain(played.cycles().iter().map(|c| c.asked));
            let cycle = |(p, asked): (&&arcfeed_interp::Setpoint, f64)| PathCycle {
                s: p.s,
                asked,
                tool: cr7_dh::position(&p.q.into()).into(),
            };
            Self {
                cycles: points.iter().zip(asked).map(cycle).collect(),
                motion: SampledMotion {
                    t,
                    axes: vec![axis],
                    arrived: Some(played.cycles().last().is_some_and(|c| c.state == HybridState::Done)),
                    tolerance: 1e-12,
                },
                sections,
                curve: spline,
                breaks,
                lengths,
                cycle_time: played.times().median_s,
            }
        })
    }

    /// Speed of each cycle from the tool points, m/s, and the arc length at its start.
    fn speeds(&self) -> Vec<(f64, f64)> {
        let of = |(c, t): (&[PathCycle], &[f64])| {
            let way = Vector3::from(c[1].tool) - Vector3::from(c[0].tool);
            (c[0].s, way.norm() / (t[1] - t[0]))
        };
        self.cycles.windows(2).zip(self.motion.t.windows(2)).map(of).collect()
    }

    /// Largest distance of tool points from the curve, of the curve from the chords between them,
    /// and normal acceleration.
    fn tool(&self) -> [f64; 3] {
        let mut worst = [0.0f64; 3];
        let mut u = self.curve.domain().0;
        let mut before: Option<(f64, Vector3<f64>)> = None;
        for cycle in &self.cycles {
            let point = Vector3::from(cycle.tool);
            u = self.curve.nearest(&point, u);
            worst[0] = worst[0].max((self.curve.point(u) - point).norm());
            if let Some((last, from)) = before {
                let middle = self.curve.point(0.5 * (last + u));
                worst[1] = worst[1].max(off_segment(&middle, &from, &point));
            }
            before = Some((u, point));
        }
        for (c, t) in self.cycles.windows(3).zip(self.motion.t.windows(3)) {
            let [a, b, d] = [0, 1, 2].map(|i| Vector3::from(c[i].tool));
            let h = 0.5 * (t[2] - t[0]);
            let (way, bend) = (d - a, (a + d - b * 2.0) / (h * h));
            if way.norm() > 0.0 {
                let along = way.normalize();
                worst[2] = worst[2].max((bend - along * bend.dot(&along)).norm());
            }
        }
        worst
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        r.information(PLACE, "segments by halving", "193", (self.breaks.len() - 1).to_string())
            .note("no reading of the paper gives its count; a section is the same share of ours");
        let deviation = self.curve.largest_deviation(&self.breaks, 200);
        let shown = format!("{:.6}", deviation * 1e3);
        r.independent(PLACE, "largest chord error of a segment, by de Boor", "0.05", shown, deviation <= CHORD);
        self.motion.judge(r, PLACE, "path");
        let speeds = self.speeds();
        let fastest = |inside: &dyn Fn(f64) -> bool| {
            speeds.iter().filter(|(s, _)| inside(*s)).fold(0.0f64, |most, (_, v)| most.max(*v)) * 1e3
        };
        for section in &self.sections {
            let ours = fastest(&|s| (section.from..section.to).contains(&s));
            let what = format!(
                "highest feed, segments {} ({:.1}-{:.1} mm)",
                section.name,
                section.from * 1e3,
                section.to * 1e3
            );
            let holds = ours <= section.feed * (1.0 + SLACK) && ours > 0.99 * section.feed;
            r.independent(PLACE, what, section.feed.to_string(), format!("{ours:.6}"), holds)
                .note("from differences of the tool points; at least 99 % of the feed is reached");
        }
        let ours = fastest(&|s| self.sections.iter().all(|x| !(x.from..x.to).contains(&s)));
        r.independent(PLACE, "highest feed elsewhere", "10", format!("{ours:.6}"), ours <= FEED * 1e3 * (1.0 + SLACK));
        let [off, chord, normal] = self.tool();
        r.independent(
            PLACE,
            "tool off the curve, by its DH table and de Boor",
            "",
            format!("{:.1e}", off * 1e3),
            off < 1e-12,
        );
        r.independent(PLACE, "chord error of a cycle", "0.05", format!("{:.6}", chord * 1e3), chord <= CHORD);
        r.independent(
            PLACE,
            "normal acceleration from differences of the tool points",
            "120",
            format!("{:.3}", normal * 1e3),
            normal <= NORMAL * 1.001,
        );
        r.information(PLACE, "median time of one cycle, us", "", format!("{:.2}", self.cycle_time * 1e6));
    }
}
