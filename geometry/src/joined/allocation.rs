//! How blends share the pieces between them.

/// Rounds in which blends take what their neighbours leave.
const ROUNDS: usize = 3;
/// Least part of a piece that is left between two blends that do not meet.
const LEAST_LEFT: f64 = 0.1;
/// What is left of a piece counts as nothing below this part of it.
const NOTHING: f64 = 1e-9;

/// Lengths that the blends at joints may take before and after them, given the lengths of the pieces and what each
/// joint wants on both of its sides. Joint `i` is between the pieces `i` and `i + 1`.
///
/// Every joint gets what it wants, up to half of either piece. What its neighbour does not need or cannot use it
/// gets as well; where both can use more they share it. Each joint takes as much before it as after it, except that
/// blends on one piece either meet or leave a tenth of the piece between them. All joints are served alike, in
/// three passes over them.
pub(super) fn allocate(lengths: &[f64], wishes: &[f64]) -> Vec<[f64; 2]> {
    let n = wishes.len();
    let mut taken: Vec<f64> = (0..n).map(|i| wishes[i].min(0.5 * lengths[i]).min(0.5 * lengths[i + 1])).collect();
    for _ in 0..ROUNDS {
        let slack = |piece: usize| {
            let before = if piece > 0 { taken[piece - 1] } else { 0.0 };
            let after = if piece < n { taken[piece] } else { 0.0 };
            lengths[piece] - before - after
        };
        // What a joint can use of a piece, when `other` is the joint at its other end and `behind` the piece behind
        // that.
        let share = |piece: usize, other: Option<usize>, behind: usize| match other {
            Some(j) if taken[j] < wishes[j] && slack(behind) > NOTHING * lengths[behind] => 0.5 * slack(piece),
            _ => slack(piece),
        };
        let next = (0..n)
            .map(|i| {
                let before = share(i, i.checked_sub(1), i.saturating_sub(1));
                let after = share(i + 1, Some(i + 1).filter(|&j| j < n), (i + 2).min(n));
                let more = before.min(after).max(0.0);
                wishes[i].min(taken[i] + more)
            })
            .collect();
        taken = next;
    }
    let mut out: Vec<[f64; 2]> = taken.iter().map(|&a| [a, a]).collect();
    for (piece, &length) in lengths.iter().enumerate() {
        let before = piece.checked_sub(1).map_or(0.0, |i| out[i][1]);
        let after = if piece < n { out[piece][0] } else { 0.0 };
        let missing = LEAST_LEFT * length - (length - before - after);
        let meet = (length - before - after).abs() <= 1e-13 * length;
        if meet || missing <= 0.0 {
            continue;
        }
        if before >= after {
            out[piece - 1][1] = (before - missing).max(0.0);
        } else {
            out[piece][0] = (after - missing).max(0.0);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_get_half_where_both_want_it() {
        assert_eq!(allocate(&[9.0, 2.0, 9.0], &[5.0, 5.0]), [[1.0, 1.0], [1.0, 1.0]]);
    }

    #[test]
    fn what_one_does_not_need_the_other_takes() {
        assert_eq!(allocate(&[9.0, 2.0, 9.0], &[0.5, 5.0]), [[0.5, 0.5], [1.5, 1.5]]);
        assert_eq!(allocate(&[9.0, 2.0, 9.0], &[0.0, 5.0]), [[0.0, 0.0], [2.0, 2.0]]);
    }

    #[test]
    fn what_one_cannot_use_the_other_takes() {
        // The first is held to 0.5 by the piece before it, all of which it may take.
        assert_eq!(allocate(&[0.5, 2.0, 9.0], &[5.0, 5.0]), [[0.5, 0.5], [1.5, 1.5]]);
    }

    #[test]
    fn blends_meet_or_leave_a_tenth() {
        let [[_, a], [b, _]] = allocate(&[9.0, 2.0, 9.0], &[0.9, 1.05])[..] else { panic!() };
        assert!((a - 0.9).abs() < 1e-15 && (b - 0.9).abs() < 1e-15);
    }
}
