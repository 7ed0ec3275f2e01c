//! What the look-ahead of a stream of segments cost.

use serde::Serialize;

/// A plan whose segments arrived while it ran.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StreamReport {
    /// Segments behind the present one that the controller holds.
    pub look_ahead: usize,
    /// Time between two arrivals, in s; 0 where the window is filled in every cycle.
    pub gap_s: f64,
    /// Duration of the same stream with the whole path known before the start, in s.
    pub whole_duration_s: f64,
    /// Stretches of the path, in m, in which the look-ahead held the motion back.
    pub held_back_m: Vec<(f64, f64)>,
    /// Place, in m, and duration, in s, of each wait for a segment.
    pub waits_m_s: Vec<(f64, f64)>,
}

impl StreamReport {
    /// Length, in m, on which the look-ahead held the motion back.
    pub fn held_back(&self) -> f64 {
        self.held_back_m.iter().map(|(from, to)| to - from).sum()
    }

    /// Time spent waiting, in s.
    pub fn waited(&self) -> f64 {
        self.waits_m_s.iter().map(|wait| wait.1).sum()
    }
}
