//! Feeds of their own on stretches of a path.

use crate::error::{FeedError, finite, positive};

/// At most so many sections: the time of a cycle must not depend on what an operator types.
pub const MAX_SECTIONS: usize = 16;

/// A stretch of a path on which another feed is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveSection {
    /// Position of the start (m).
    pub from: f64,
    /// Position of the end (m).
    pub to: f64,
    /// Highest speed on it (m/s).
    pub feed: f64,
}

/// The base feed and up to [`MAX_SECTIONS`] sections.
#[derive(Debug, Clone, Copy)]
pub(super) struct Feeds {
    base: f64,
    sections: [LiveSection; MAX_SECTIONS],
    count: usize,
}

impl Feeds {
    pub fn new(base: f64) -> Result<Self, FeedError> {
        let none = LiveSection { from: 0.0, to: 0.0, feed: 0.0 };
        Ok(Self { base: positive("feed", base)?, sections: [none; MAX_SECTIONS], count: 0 })
    }

    pub fn set_base(&mut self, base: f64) -> Result<(), FeedError> {
        self.base = positive("feed", base)?;
        Ok(())
    }

    pub fn base(&self) -> f64 {
        self.base
    }

    pub fn set_sections(&mut self, sections: &[LiveSection]) -> Result<(), FeedError> {
        if sections.len() > MAX_SECTIONS {
            let (value, limit) = (sections.len() as f64, MAX_SECTIONS as f64);
            return Err(FeedError::AboveLimit { what: "number of feed sections", value, limit });
        }
        for section in sections {
            finite("section start", section.from)?;
            finite("section end", section.to)?;
            positive("feed of a section", section.feed)?;
            if section.to <= section.from {
                return Err(FeedError::BelowLimit { what: "section end", value: section.to, limit: section.from });
            }
        }
        self.sections[..sections.len()].copy_from_slice(sections);
        self.count = sections.len();
        Ok(())
    }

    /// The feed asked for at `s`: the lowest of the sections around it, or else the base.
    pub fn at(&self, s: f64) -> f64 {
        let inside = self.list().iter().filter(|section| section.from <= s && s < section.to);
        inside.map(|section| section.feed).reduce(f64::min).unwrap_or(self.base)
    }

    /// Beginnings of sections ahead of `s` with the feed on them.
    pub fn ahead(&self, s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.list().iter().filter(move |section| section.from > s).map(|section| (section.from, section.feed))
    }

    /// Ends of sections ahead of `s`, where the base feed may be lower than theirs, with the feed
    /// behind them.
    pub fn ends_ahead(&self, s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.list().iter().filter(move |section| section.to > s).map(|section| (section.to, self.at(section.to)))
    }

    fn list(&self) -> &[LiveSection] {
        &self.sections[..self.count]
    }
}
