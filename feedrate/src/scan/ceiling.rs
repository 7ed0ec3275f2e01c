//! The caps of many segments as few lines in the plane of position and squared speed.
//!
//! A line in that plane is motion at constant acceleration, so following it needs no jerk. For a
//! pass in one direction only rising caps have to be followed (falling ones are the other pass's
//! task), so every piece is flat or rises; between pieces the ceiling may jump either way.

use super::segment::Segment;

/// A cap that rises by more than this factor (of squared speed) from one segment to the next is a
/// jump, not a slope.
const JUMP_FACTOR: f64 = 1.6;
/// Segments whose acceleration or jerk bounds differ by more than this factor are not merged.
const MERGED_WITHIN: f64 = 1.03;

/// A stretch of ceiling: squared speed `x0 + 2 g (s - s0)` with `g >= 0`, and the least bounds of
/// the segments below it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub s0: f64,
    pub s1: f64,
    pub x0: f64,
    pub g: f64,
    pub a_max: f64,
    pub j_max: f64,
    /// Acceleration that may not be exceeded inside the piece so that the smaller bounds ahead can
    /// still be met.
    pub a_safe: f64,
}

impl Piece {
    #[inline]
    pub fn x(&self, s: f64) -> f64 {
        self.x0 + 2.0 * self.g * (s - self.s0)
    }
}

/// Builds the ceiling over `segments` in the order given; `s` are their boundaries in that
/// direction. A line may stay below the caps it replaces by the share `slack` of the squared speed.
/// `jerk` replaces the bounds of the segments.
pub(super) fn ceiling<'a>(
    segments: impl Iterator<Item = &'a Segment>,
    s: impl Fn(usize) -> f64,
    slack: f64,
    jerk: Option<f64>,
    out: &mut Vec<Piece>,
) {
    out.clear();
    let mut open: Option<Open> = None;
    for (k, segment) in segments.enumerate() {
        let segment = &Segment { j_max: jerk.unwrap_or(segment.j_max), ..*segment };
        let (s0, s1) = (s(k), s(k + 1));
        let cap = segment.v_max * segment.v_max;
        if let Some(line) = open.as_mut() {
            if line.take(s1, cap, segment) {
                continue;
            }
            let piece = line.close();
            out.push(piece);
            let end = piece.x(piece.s1);
            let x0 = if end <= cap && cap <= JUMP_FACTOR * end { end } else { cap };
            open = Some(Open::new(s0, s1, x0, cap, slack, segment));
        } else {
            open = Some(Open::new(s0, s1, cap, cap, slack, segment));
        }
    }
    if let Some(line) = open {
        out.push(line.close());
    }
    // Bounds on acceleration may fall from piece to piece; what is above the next one has to be
    // taken off in time.
    let mut ahead = f64::INFINITY;
    for piece in out.iter_mut().rev() {
        let fastest = piece.x(piece.s1).sqrt();
        piece.a_safe = piece.a_max.min(ahead);
        let shed = piece.j_max * (piece.s1 - piece.s0) / fastest;
        ahead = piece.a_max.min(ahead + shed);
    }
}

/// A line under construction: all slopes that stay under every cap so far, and within the slack of
/// it.
struct Open {
    s0: f64,
    s1: f64,
    x0: f64,
    slack: f64,
    g_lo: f64,
    g_hi: f64,
    a: (f64, f64),
    j: (f64, f64),
}

impl Open {
    fn new(s0: f64, s1: f64, x0: f64, cap: f64, slack: f64, segment: &Segment) -> Self {
        let run = 2.0 * (s1 - s0);
        let g_hi = ((cap - x0) / run).max(0.0);
        let g_lo = (((1.0 - slack) * cap - x0) / run).clamp(0.0, g_hi);
        let (a, j) = (segment.a_max, segment.j_max);
        Self { s0, s1, x0, slack, g_lo, g_hi, a: (a, a), j: (j, j) }
    }

    /// Adds a segment if one line can serve it too.
    fn take(&mut self, s1: f64, cap: f64, segment: &Segment) -> bool {
        let widen = |(lo, hi): (f64, f64), x: f64| (lo.min(x), hi.max(x));
        let (a, j) = (widen(self.a, segment.a_max), widen(self.j, segment.j_max));
        if a.1 > MERGED_WITHIN * a.0 || j.1 > MERGED_WITHIN * j.0 {
            return false;
        }
        let run = 2.0 * (s1 - self.s0);
        let g_hi = self.g_hi.min((cap - self.x0) / run);
        let g_lo = self.g_lo.max(((1.0 - self.slack) * cap - self.x0) / run);
        if g_hi < g_lo || g_hi < 0.0 {
            return false;
        }
        (self.s1, self.g_lo, self.g_hi, self.a, self.j) = (s1, g_lo, g_hi, a, j);
        true
    }

    fn close(&self) -> Piece {
        Piece {
            s0: self.s0,
            s1: self.s1,
            x0: self.x0,
            g: self.g_hi,
            a_max: self.a.0,
            j_max: self.j.0,
            a_safe: self.a.0,
        }
    }
}
