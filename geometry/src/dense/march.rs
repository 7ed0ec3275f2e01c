//! The choice of the spans: as wide as the tolerance permits, window by window.

use super::piece::{ORDER, Piece};
use super::window::{End, Window};

/// Number of equal spans of a window that goes on.
const SPANS: usize = 8;
/// Number of them that are kept. The others see to it that what follows does not need a turn that the tolerance
/// forbids.
const KEPT: usize = 3;
/// Number of them that have to keep the tolerance.
const CHECKED: usize = 5;
/// Part of the tolerance that a wider span aims at.
const AIM: f64 = 0.6;
/// Factor by which the spans are narrower in a second trial, where the first had to halve some.
const NARROWER: f64 = 0.75;
/// Factor by which the spans are wider, at least, in a second trial, where the first had to halve none.
const WIDER: f64 = 1.2;
/// A span is halved, too, where one beside it is and is narrower by more than this factor.
const WIDE: f64 = 3.0;
/// Chords that the first window of a curve covers.
const FIRST_CHORDS: usize = 32;
/// The narrowest span, as a part of the tolerance.
const NARROWEST_SPAN: f64 = 1.0 / 16.0;
/// Most spans of a window, for each chord in it.
const MOST_SPANS: usize = 8;

/// Fits windows, one after the other.
#[derive(Debug, Clone)]
pub(super) struct March {
    /// Bound that the deviations of the pieces keep.
    tolerance: f64,
    /// Width of the spans to begin with; 0 at the start of a curve.
    width: f64,
    /// Number of parts of chords that were read.
    pub visits: u64,
}

/// A fit of a window that keeps the tolerance.
struct Trial<const D: usize> {
    /// The pieces to keep.
    pieces: Vec<Piece<D>>,
    /// Width of the spans before any was halved.
    width: f64,
    /// True where a span was halved.
    halved: bool,
}

impl<const D: usize> Trial<D> {
    /// Length for each piece.
    fn efficiency(&self) -> f64 {
        let length: f64 = self.pieces.iter().map(Piece::width).sum();
        length / self.pieces.len() as f64
    }

    /// The factor by which the spans can be wider, judged by the order of the error.
    fn growth(&self, tolerance: f64) -> f64 {
        let deviation = self.pieces.iter().fold(0.0f64, |m, p| m.max(p.deviation));
        growth(deviation, tolerance)
    }
}

fn growth(deviation: f64, tolerance: f64) -> f64 {
    (AIM * tolerance / deviation).powf(1.0 / ORDER as f64).min(4.0)
}

/// The equal spans with which a window is tried first.
struct Layout {
    count: usize,
    width: f64,
    /// True where they reach the end of a window that does not go on.
    whole: bool,
}

impl March {
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, width: 0.0, visits: 0 }
    }

    /// Forgets the width of the spans.
    pub fn restart(&mut self) {
        self.width = 0.0;
    }

    /// Length that is enough for the next window, wider spans included.
    pub fn wanted(&self) -> f64 {
        2.0 * SPANS as f64 * self.width
    }

    pub fn narrowest(&self) -> f64 {
        NARROWEST_SPAN * self.tolerance
    }

    /// The next pieces from the start of the window on; `None` where none keeps the tolerance.
    pub fn advance<const D: usize>(&mut self, window: &Window<'_, D>) -> Option<Vec<Piece<D>>> {
        let mut width = if self.width > 0.0 { self.width } else { first_width(window) };
        let mut best = self.trial(window, width);
        while best.is_none() && width > self.narrowest() {
            width *= 0.25;
            best = self.trial(window, width);
        }
        let mut best = best?;
        if best.halved && best.efficiency() < NARROWER * best.width {
            let narrower = self.trial(window, NARROWER * best.width);
            best = narrower.filter(|n| n.efficiency() > best.efficiency()).unwrap_or(best);
        }
        loop {
            let factor = best.growth(self.tolerance).max(WIDER);
            let layout = layout(window, best.width);
            let wider = layout_wider(window, &layout, factor);
            if best.halved || wider <= 1.1 * best.width {
                break;
            }
            match self.trial(window, wider) {
                Some(trial) if trial.efficiency() > best.efficiency() => best = trial,
                _ => break,
            }
        }
        if let Some(last) = best.pieces.last() {
            self.width = last.width() * growth(last.deviation, self.tolerance).max(1.0).min(2.0);
        }
        Some(best.pieces)
    }

    /// The pieces to halve: those before `checked` that exceed the tolerance, those shortly behind the last of
    /// them that do so, too, and those beside them that are far wider. A piece cannot turn where the next one
    /// does not.
    fn marked<const D: usize>(&self, pieces: &[Piece<D>], checked: f64) -> Vec<bool> {
        let mut exceeds: Vec<bool> = pieces.iter().map(|p| p.deviation > self.tolerance).collect();
        let last = (0..pieces.len()).rev().find(|&i| exceeds[i] && pieces[i].start < checked);
        let end = last.map_or(0, |last| last + ORDER);
        exceeds.iter_mut().skip(end).for_each(|e| *e = false);
        with_wide_neighbours(pieces, &exceeds)
    }

    /// Fits the window with equal spans, and halves those that exceed the tolerance until none does.
    fn trial<const D: usize>(&mut self, window: &Window<'_, D>, width: f64) -> Option<Trial<D>> {
        let Layout { count, width, whole } = layout(window, width);
        let mut breaks: Vec<f64> = (0..=count).map(|i| window.at + width * i as f64).collect();
        if whole {
            breaks[count] = window.limit;
        }
        let end = if whole { window.end } else { End::Open };
        let (kept, checked) = if whole { (breaks[count], breaks[count]) } else { (breaks[KEPT], breaks[CHECKED]) };
        let before = |at: f64| window.vertices.partition_point(|v| v.at < at);
        let chords = before(breaks[count]) - before(window.at);
        let mut halved = false;
        while breaks.len() <= MOST_SPANS * (chords + 1 + SPANS) {
            let mut pieces = window.fit(&breaks, &end, &mut self.visits)?;
            let marked = self.marked(&pieces, checked);
            let mut refined = Vec::with_capacity(2 * breaks.len());
            for (piece, marked) in pieces.iter().zip(marked) {
                refined.push(piece.start);
                if marked {
                    if piece.width() < 2.0 * self.narrowest() {
                        return None;
                    }
                    refined.push(0.5 * (piece.start + piece.end));
                }
            }
            refined.push(breaks[breaks.len() - 1]);
            if refined.len() == breaks.len() {
                pieces.retain(|p| p.start < kept);
                return Some(Trial { pieces, width, halved });
            }
            halved = true;
            breaks = refined;
        }
        None
    }
}

/// Marks the pieces that `exceeds` states, and those beside them that are far wider.
fn with_wide_neighbours<const D: usize>(pieces: &[Piece<D>], exceeds: &[bool]) -> Vec<bool> {
    let narrow = |i: usize, j: usize| exceeds[j] && pieces[j].width() * WIDE < pieces[i].width();
    let beside = |i: usize| (i > 0 && narrow(i, i - 1)) || (i + 1 < pieces.len() && narrow(i, i + 1));
    (0..pieces.len()).map(|i| exceeds[i] || beside(i)).collect()
}

fn first_width<const D: usize>(window: &Window<'_, D>) -> f64 {
    let first = window.vertices.partition_point(|v| v.at <= window.at);
    let far = &window.vertices[(first + FIRST_CHORDS).min(window.vertices.len() - 1)];
    (far.at.min(window.limit) - window.at) / SPANS as f64
}

fn layout<const D: usize>(window: &Window<'_, D>, width: f64) -> Layout {
    let rest = window.limit - window.at;
    match window.end {
        End::Open => Layout { count: SPANS, width: width.min(rest / SPANS as f64), whole: false },
        _ if rest > (SPANS as f64 + 1e-6) * width => Layout { count: SPANS, width, whole: false },
        _ => {
            let count = ((rest / width - 1e-6).ceil() as usize).max(window.least_spans());
            Layout { count, width: rest / count as f64, whole: true }
        }
    }
}

/// The width of the next trial, wider by at most `factor`.
fn layout_wider<const D: usize>(window: &Window<'_, D>, now: &Layout, factor: f64) -> f64 {
    let wider = layout(window, now.width * factor);
    // Not fewer spans, and so not another fit.
    if wider.whole && now.whole && wider.count >= now.count { now.width } else { wider.width }
}
