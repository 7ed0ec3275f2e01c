//! Liu et al. 2023, Table 2 and Figure 11: the methods that the paper compares, from one run.
//!
//! The paper names the methods and does not print them; the reading of each stands at [`Compared`].

use std::time::Instant;

use arcfeed_feedrate::{MotionLaw, MotionState};
use arcfeed_geometry::{ArcLengthCurve, Curve, NurbsCurve, SegmentationMethod, Spacing};
use arcfeed_interp::parameter::{
    ArcLengthStep, CompensatedTaylor, FeedCycle, FirstTaylor, ParameterStep, SecondTaylor,
};

use super::curves::failed;
use super::open_loop::{curvature_maxima, feed_sensitive_maxima, radius_extremes};
use crate::reproduce::Reproduction;
use crate::reproduce::spline::Spline;
use crate::run::error::Cr7Error;

const PLACE: &str = "Table 2: methods compared, butterfly at 0.001 mm, all under one feed law of 1 ms";
/// Chord tolerance of section 6.1, m.
const TOLERANCE: f64 = 1e-6;
/// The deviation that the paper prints for L.H., m.
const REFIT: f64 = 3e-5;
/// Curvature from which on the feed of 100 mm/s has to be lowered, 1/m: there the normal acceleration is 1 m/s^2.
const SHARP: f64 = 100.0;
/// Difference that counts as equal in a column of quality: m, or a share of u.
const EQUAL: f64 = 1e-12;

/// The methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// First-order Taylor steps, split at maxima of curvature. Not in Table 2; the paper cites it
    /// for its error.
    FirstOrder,
    /// X.D. (its reference 14): split at the extremes of the radius of curvature, second-order
    /// Taylor steps, open loop.
    Xd,
    /// L.H. (reference 8): the curve is laid anew through more and more of its points until it
    /// deviates by less than 0.03 mm; second-order Taylor steps on the new curve.
    Lh,
    /// L.F. (reference 32): split at the maxima of curvature at which the feed has to be lowered; u
    /// by bisection on the arc length by Simpson's rule.
    Lf,
    /// The paper: type C by halving, second-order Taylor steps with compensation (eqs. 37 to 39,
    /// corrected).
    Paper,
    /// This library: longest pieces, u from the arc-length map.
    Ours,
}

/// What one method came to.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodRun {
    /// The method.
    pub method: Compared,
    /// Rounds of iteration.
    pub rounds: usize,
    /// The curve that the method runs along.
    pub curve: Spline,
    /// Largest distance of that curve from the one asked for, m.
    pub refit: f64,
    /// Parameters where segments end.
    pub breaks: Vec<f64>,
    /// Arc length asked for at the end of each cycle, m.
    pub asked: Vec<f64>,
    /// Parameter at the end of each cycle.
    pub parameters: Vec<f64>,
    /// Time to cut and to interpolate, s.
    pub times: (f64, f64),
}

/// The columns of quality, measured by de Boor's algorithm and Simpson's rule.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quality {
    /// Largest distance of the chords from the curve, m. For L.H. the sum of refit and chord
    /// deviation, a bound of it.
    pub chord: f64,
    /// End of u as a share of the domain.
    pub end: f64,
    /// Arc length missing at the end, m.
    pub truncation: f64,
    /// Largest difference between arc length asked for and reached, m.
    pub drift: f64,
    /// Largest error of the way of one cycle, m.
    pub cycle: f64,
    /// Largest relative error of the way of a cycle; cycles below a thousandth of the longest are
    /// left out.
    pub fluctuation: f64,
}

impl MethodRun {
    /// Arc length reached less arc length asked for at the end of each cycle, m.
    pub fn drifts(&self) -> Vec<f64> {
        let (mut reached, mut before) = (0.0, self.curve.domain().0);
        let drift = |(u, asked): (&f64, &f64)| {
            reached += self.curve.length(before, *u, 16);
            before = *u;
            reached - asked
        };
        self.parameters.iter().zip(&self.asked).map(drift).collect()
    }

    /// Measures the run.
    pub fn quality(&self) -> Quality {
        let (from, to) = self.curve.domain();
        let steps = || std::iter::once(0.0).chain(self.asked.iter().copied()).zip(self.asked.iter().copied());
        let longest = steps().map(|(a, b)| b - a).fold(0.0, f64::max);
        let (mut reached, mut before) = (0.0, from);
        let mut q = Quality::default();
        for (u, (last, next)) in self.parameters.iter().zip(steps()) {
            let (way, asked) = (self.curve.length(before, *u, 16), next - last);
            reached += way;
            q.drift = q.drift.max((reached - next).abs());
            q.cycle = q.cycle.max((way - asked).abs());
            if asked > 1e-3 * longest {
                q.fluctuation = q.fluctuation.max((way / asked - 1.0).abs());
            }
            before = *u;
        }
        q.truncation = self.asked.last().copied().unwrap_or(0.0) - reached;
        q.end = (before - from) / (to - from);
        q.chord = self.refit + self.curve.largest_deviation(&self.breaks, 200);
        q
    }
}

/// All methods of Table 2.
#[derive(Debug, Clone, PartialEq)]
pub struct Table2Run {
    /// One for each method; ours is the last.
    pub methods: Vec<MethodRun>,
    /// The butterfly.
    pub curve: Spline,
    /// Breaks of X.D. and of L.F.
    pub open_loop: [Vec<f64>; 2],
    /// The curve of L.H.
    pub refitted: Spline,
}

impl Compared {
    const ALL: [Self; 6] = [Self::FirstOrder, Self::Xd, Self::Lh, Self::Lf, Self::Paper, Self::Ours];

    /// Name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstOrder => "first-order Taylor",
            Self::Xd => "X.D.",
            Self::Lh => "L.H.",
            Self::Lf => "L.F.",
            Self::Paper => "the paper",
            Self::Ours => "ours",
        }
    }

    /// Rounds, largest chord error (mm), end of u, truncation (mm), time of interpolation (s), as
    /// Table 2 prints them.
    fn printed(self) -> [&'static str; 5] {
        match self {
            Self::Xd => ["0", "1.8", "0.997", "0.001", "9"],
            Self::Lh => ["9", "0.03", "0.997", "0.001", "10"],
            Self::Lf => ["0", "2", "0.999", "0", "13"],
            Self::Paper => ["5", "0.001", "1", "0", "10"],
            Self::FirstOrder | Self::Ours => [""; 5],
        }
    }
}

/// u by bisection on the arc length by Simpson's rule.
struct Bisection<'a> {
    curve: &'a NurbsCurve<3>,
    u: f64,
    s: f64,
}

impl Bisection<'_> {
    fn length(&self, to: f64) -> f64 {
        const INTERVALS: u32 = 8;
        let h = (to - self.u) / f64::from(INTERVALS);
        let speed = |i: u32| self.curve.jet(self.u + h * f64::from(i)).speed();
        let weight = |i: u32| if i == 0 || i == INTERVALS { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        (0..=INTERVALS).map(|i| weight(i) * speed(i)).sum::<f64>() * h / 3.0
    }
}

impl ParameterStep for Bisection<'_> {
    fn name(&self) -> &'static str {
        "bisection"
    }

    fn step(&mut self, cycle: &FeedCycle) -> f64 {
        let (wanted, end) = (cycle.s - self.s, self.curve.domain().1);
        // A step of a cycle is far shorter than a hundredth of the domain.
        let (mut lo, mut hi) = (self.u, (self.u + 0.01).min(end));
        for _ in 0..40 {
            let middle = 0.5 * (lo + hi);
            if self.length(middle) < wanted { lo = middle } else { hi = middle }
        }
        let u = hi;
        self.s += self.length(u);
        self.u = u;
        u
    }
}

/// L.H.: an interpolating spline through twice as many points in each round.
fn refit(curve: &NurbsCurve<3>) -> Result<(NurbsCurve<3>, usize, f64), Cr7Error> {
    let spline = Spline::new(curve);
    let (from, to) = spline.domain();
    let (mut count, mut rounds) = (32u32, 0);
    loop {
        rounds += 1;
        let points: Vec<_> =
            (0..=count).map(|i| spline.point(from + (to - from) * f64::from(i) / f64::from(count))).collect();
        let fitted = NurbsCurve::interpolate(&points, 3, Spacing::Chord).map_err(failed)?.curve;
        let new = Spline::new(&fitted);
        let (a, b) = new.domain();
        let mut u = from;
        let off = (0..=20_000).map(|i| new.point(a + (b - a) * f64::from(i) / 20_000.0)).map(|p| {
            u = spline.nearest(&p, u);
            (spline.point(u) - p).norm()
        });
        let off = off.fold(0.0, f64::max);
        if off <= REFIT || rounds == 12 {
            return Ok((fitted, rounds, off));
        }
        count *= 2;
    }
}

/// Steps over the whole law: parameters, and the time it took.
fn walk(law: &impl MotionLaw, step: &mut dyn ParameterStep, scale: f64) -> (Vec<f64>, Vec<MotionState>, f64) {
    const PERIOD: f64 = 1e-3;
    let cycles = (law.duration() / PERIOD * (1.0 - 1e-12)).floor() as usize + 1;
    let states: Vec<MotionState> = (0..=cycles).map(|i| law.at(i as f64 * PERIOD)).collect();
    let begin = Instant::now();
    let next = |w: &[MotionState]| {
        step.step(&FeedCycle { period: PERIOD, feed: w[0].v * scale, acceleration: w[0].a * scale, s: w[1].p * scale })
    };
    let parameters: Vec<f64> = states.windows(2).map(next).collect();
    (parameters, states, begin.elapsed().as_secs_f64())
}

impl Table2Run {
    /// Runs all methods under `law` on `curve`.
    ///
    /// # Errors
    /// [`Cr7Error::Curve`] when the curve cannot be cut or fitted.
    pub fn measure(curve: &ArcLengthCurve<3>, law: &impl MotionLaw) -> Result<Self, Cr7Error> {
        let nurbs = curve.curve();
        let spline = Spline::new(nurbs);
        let open_loop = [radius_extremes(&spline), feed_sensitive_maxima(&spline, SHARP)];
        let (fitted, _, _) = refit(nurbs)?;
        let refitted = Spline::new(&fitted);
        let runs = Compared::ALL.iter().map(|&method| measure(method, curve, law));
        Ok(Self { methods: runs.collect::<Result<_, _>>()?, curve: spline, open_loop, refitted })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        let measured: Vec<(&MethodRun, Quality)> = self.methods.iter().map(|m| (m, m.quality())).collect();
        for (m, q) in &measured {
            let (name, printed) = (m.method.name(), m.method.printed());
            r.information(PLACE, format!("{name}: rounds"), printed[0], m.rounds.to_string());
            let chord = format!("{:.6}", q.chord * 1e3);
            r.information(PLACE, format!("{name}: largest chord error, mm"), printed[1], chord)
                .note(format!("{} segments", m.breaks.len() - 1));
            r.information(PLACE, format!("{name}: end value of u"), printed[2], format!("{:.9}", q.end));
            let truncation = format!("{:.1e}", q.truncation * 1e3);
            r.information(PLACE, format!("{name}: truncation error, mm"), printed[3], truncation).note(format!(
                "on the way up to {:.1e} mm; feed fluctuation {:.1e} %",
                q.drift * 1e3,
                q.fluctuation * 1e2
            ));
            let time = format!("{:.4}", m.times.1);
            r.information(PLACE, format!("{name}: interpolation, s"), printed[4], time)
                .note(format!("cut in {:.4} s", m.times.0));
        }
        if let Some(((ours, quality), others)) = measured.split_last() {
            judge_columns(r, quality, others);
            let fluctuation = |(_, q): &&(&MethodRun, Quality)| q.fluctuation < quality.fluctuation;
            let time = |m: &MethodRun| m.times.0 + m.times.1;
            let names = |found: Vec<&(&MethodRun, Quality)>| match found.len() {
                0 => "none".to_owned(),
                _ => found.iter().map(|(m, _)| m.method.name()).collect::<Vec<_>>().join(", "),
            };
            let steadier = names(others.iter().filter(fluctuation).collect());
            r.information(PLACE, "methods with less feed fluctuation than ours", "", steadier).note(format!(
                "ours: {:.1e} %, rounding of the shortest steps; lengths are equal within {EQUAL:e} m",
                quality.fluctuation * 1e2
            ));
            let faster = names(others.iter().filter(|(m, _)| time(m) < time(ours)).collect());
            r.information(PLACE, "methods that took less time than ours", "", faster)
                .note("time is no column of quality");
        }
    }
}

/// Ours beside the best of the others, column by column.
fn judge_columns(r: &mut Reproduction, ours: &Quality, others: &[(&MethodRun, Quality)]) {
    type Column = (&'static str, fn(&Quality) -> f64, f64);
    const COLUMNS: [Column; 5] = [
        ("chord error, mm", |q| q.chord, 1e3),
        ("end value of u, distance from 1", |q| (q.end - 1.0).abs(), 1.0),
        ("truncation error, mm", |q| q.truncation.abs(), 1e3),
        ("error of arc length on the way, mm", |q| q.drift, 1e3),
        ("error of the way of one cycle, mm", |q| q.cycle, 1e3),
    ];
    let chord = format!("{:.7}", ours.chord * 1e3);
    r.independent(PLACE, "ours keeps the chord tolerance, mm", "0.001", chord, ours.chord <= TOLERANCE);
    let end = (ours.end - 1.0).abs();
    r.independent(PLACE, "ours ends on the end of the curve, 1 - u", "0", format!("{end:.1e}"), end < 1e-14);
    for (what, of, factor) in COLUMNS {
        let best = others.iter().map(|(_, q)| of(q)).fold(f64::INFINITY, f64::min);
        // A chord error inside the tolerance is as good as another one.
        let level = if what.starts_with("chord") { best.max(TOLERANCE) } else { best };
        let holds = of(ours) <= level + EQUAL;
        let (best, shown) = (format!("{:.2e}", best * factor), format!("{:.2e}", of(ours) * factor));
        r.independent(PLACE, format!("ours is best or equal: {what}"), best, shown, holds);
    }
}

fn measure(method: Compared, curve: &ArcLengthCurve<3>, law: &impl MotionLaw) -> Result<MethodRun, Cr7Error> {
    let nurbs = curve.curve();
    let own = Spline::new(nurbs);
    let begin = Instant::now();
    let (mut rounds, mut off, mut refitted) = (0, 0.0, None);
    let halvings = |breaks: &[f64]| {
        let shortest = breaks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
        let longest = own.breaks().windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        (longest / shortest).log2().ceil() as usize
    };
    let breaks = match method {
        Compared::FirstOrder => curvature_maxima(&own),
        Compared::Xd => radius_extremes(&own),
        Compared::Lf => feed_sensitive_maxima(&own, SHARP),
        Compared::Lh => {
            let (fitted, n, deviation) = refit(nurbs)?;
            (rounds, off) = (n, deviation);
            let breaks = Spline::new(&fitted).breaks();
            refitted = Some(fitted);
            breaks
        }
        Compared::Paper => nurbs.segment(SegmentationMethod::CType, TOLERANCE).map_err(failed)?.breaks().to_vec(),
        Compared::Ours => {
            let greedy = SegmentationMethod::Greedy { across_knots: true };
            nurbs.segment(greedy, TOLERANCE).map_err(failed)?.breaks().to_vec()
        }
    };
    let cut = begin.elapsed().as_secs_f64();
    if method == Compared::Paper {
        rounds = halvings(&breaks);
    }
    // L.H. moves along its own curve: the same law, over its own length.
    let run = refitted.as_ref().unwrap_or(nurbs);
    let spline = Spline::new(run);
    let length = run.arc_length(1e-13).map_err(failed)?;
    let mut step: Box<dyn ParameterStep + '_> = match method {
        Compared::FirstOrder => Box::new(FirstTaylor::new(run)),
        Compared::Xd | Compared::Lh => Box::new(SecondTaylor::new(run)),
        Compared::Lf => Box::new(Bisection { curve: run, u: spline.domain().0, s: 0.0 }),
        Compared::Paper => Box::new(CompensatedTaylor::new(run, 1e-15).map_err(failed)?),
        Compared::Ours => Box::new(ArcLengthStep::new(curve)),
    };
    let scale = length / curve.length();
    let (parameters, states, interpolation) = walk(law, step.as_mut(), scale);
    Ok(MethodRun {
        method,
        rounds,
        curve: spline,
        refit: off,
        breaks,
        asked: states[1..].iter().map(|state| state.p * scale).collect(),
        parameters,
        times: (cut, interpolation),
    })
}
