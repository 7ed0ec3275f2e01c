//! Programmed feed per section of a path.

use arcfeed_geometry::{Curve, PosePath};

use crate::error::{LimitError, positive};

/// Which part of a path a section is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Extent {
    /// Between two arc lengths, m.
    Length {
        /// The start.
        from: f64,
        /// The end.
        to: f64,
    },
    /// Between two values of the curve's own parameter.
    Parameter {
        /// The start.
        from: f64,
        /// The end.
        to: f64,
    },
    /// Chord segments by number, both included, counted from 1. Which segments there are depends on the chord tolerance:
    /// [`Trajectory::breaks`](crate::Trajectory::breaks) tells.
    Segments {
        /// The first one.
        first: usize,
        /// The last one.
        last: usize,
    },
}

/// A part of a path with a feed of its own (Liu et al. 2024, Table 6): there it takes the place of
/// [`ToolLimits::feed`](crate::ToolLimits::feed), whether lower or higher.
///
/// The lower feed counts where two sections, or a section and the rest, meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedSection {
    /// Which part.
    pub extent: Extent,
    /// Programmed feed there, m/s.
    pub feed: f64,
}

/// A section by arc length, on a path that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// The start, m.
    pub from: f64,
    /// The end, m.
    pub to: f64,
    /// Programmed feed there, m/s.
    pub feed: f64,
}

/// By how much of the path's length a section may seem to reach beyond its end, through rounding.
const BEYOND: f64 = 1e-9;

impl FeedSection {
    fn resolve(&self, index: usize, path: &PosePath, breaks: &[f64]) -> Result<Section, LimitError> {
        let length = path.length();
        let (low, high) = path.curve().curve().domain();
        let wrong = |from: f64, to: f64, unit, rule| LimitError::Section { index, from, to, unit, rule };
        let (from, to) = match self.extent {
            Extent::Length { from, to } => {
                let slack = BEYOND * length;
                // Not a range that NaN would pass.
                if !(from >= -slack && from < to && to <= length + slack) {
                    return Err(wrong(from, to, "m of arc length", "it has to begin before it ends, both on the path"));
                }
                (from.max(0.0), to.min(length))
            }
            Extent::Parameter { from, to } => {
                if !(from >= low && from < to && to <= high) {
                    let rule = "it has to begin before it ends, both in the domain of the curve";
                    return Err(wrong(from, to, "of the curve's parameter", rule));
                }
                (path.curve().arc_length_at(from), path.curve().arc_length_at(to))
            }
            Extent::Segments { first, last } => match (breaks.get(first.wrapping_sub(1)), breaks.get(last)) {
                (Some(&from), Some(&to)) if first <= last => (from, to),
                _ => {
                    let rule = "segments count from 1, the last one is not before the first, and both have to exist at this chord tolerance";
                    return Err(wrong(first as f64, last as f64, "(chord segments)", rule));
                }
            },
        };
        positive("feed of a section", self.feed)?;
        Ok(Section { from, to, feed: self.feed })
    }
}

/// The feed along a path: that of the sections, and another one elsewhere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Feeds<'a> {
    pub elsewhere: f64,
    /// By arc length, without overlap.
    pub sections: &'a [Section],
}

impl Feeds<'_> {
    /// The highest feed anywhere.
    pub fn highest(&self) -> f64 {
        self.sections.iter().fold(self.elsewhere, |most, section| most.max(section.feed))
    }

    /// The feed at `s`.
    pub fn at(&self, s: f64) -> f64 {
        let i = self.sections.partition_point(|section| section.to <= s);
        self.sections.get(i).filter(|section| section.from <= s).map_or(self.elsewhere, |section| section.feed)
    }
}

/// The sections by arc length, in their order on the path.
pub(crate) fn resolve(sections: &[FeedSection], path: &PosePath, breaks: &[f64]) -> Result<Vec<Section>, LimitError> {
    let mut numbered = Vec::with_capacity(sections.len());
    for (index, section) in sections.iter().enumerate() {
        numbered.push((index, section.resolve(index, path, breaks)?));
    }
    numbered.sort_by(|a, b| a.1.from.total_cmp(&b.1.from));
    for pair in numbered.windows(2) {
        let [(first, a), (second, b)] = [pair[0], pair[1]];
        if b.from < a.to - BEYOND * path.length() {
            return Err(LimitError::SectionsOverlap { first, second, s: b.from });
        }
    }
    Ok(numbered.into_iter().map(|(_, section)| section).collect())
}

/// Moves the borders of sections onto the points of the grid they stand next to.
pub(crate) fn snap(sections: &mut [Section], grid: &[f64]) {
    let nearest = |s: f64| {
        let i = grid.partition_point(|&g| g < s);
        let around = [i.checked_sub(1).and_then(|i| grid.get(i)), grid.get(i)];
        around.into_iter().flatten().copied().min_by(|a, b| (a - s).abs().total_cmp(&(b - s).abs())).unwrap_or(s)
    };
    for section in sections {
        (section.from, section.to) = (nearest(section.from), nearest(section.to));
    }
}
