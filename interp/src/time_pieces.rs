//! The time of a law in short pieces, on each of which the motion is smooth.

use arcfeed_feedrate::SpeedLaw;

/// The longest piece, s.
const LONGEST: f64 = 1e-3;

/// Start and duration (s) of pieces that begin and end where the law has its knots, one after the other.
pub(crate) fn time_pieces(law: &SpeedLaw) -> Vec<[f64; 2]> {
    let ends = law.knots().skip(1).map(|(t, _)| t).chain([law.duration()]);
    let mut pieces = Vec::with_capacity((law.duration() / LONGEST) as usize + law.knots().len());
    for (from, to) in law.knots().map(|(t, _)| t).zip(ends).filter(|(from, to)| from < to) {
        let parts = ((to - from) / LONGEST).ceil().max(1.0);
        let duration = (to - from) / parts;
        pieces.extend((0..parts as usize).map(|part| [from + part as f64 * duration, duration]));
    }
    pieces
}
