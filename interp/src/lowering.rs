//! Which limits have to be lowered for a plan to pass its verification, and where.

use arcfeed_feedrate::{LimitId, MotionLaw, Quantity, SpeedLaw};

use crate::problem::LimitFractions;
use crate::verify::{Excess, Verification};

/// By how much a limit may seem to be exceeded in verification through rounding.
pub(crate) const TOLERANCE: f64 = 1e-6;
/// By how much more a limit is lowered than it was exceeded.
const MARGIN: f64 = 2e-7;

/// The fraction of a limit to use after it was exceeded by `ratio`.
pub(crate) fn fraction(ratio: f64) -> f64 {
    1.0 / (ratio + MARGIN)
}

/// The limits that are exceeded, with the ratios; `None` where one of them is nothing that less of a limit could mend.
pub(crate) fn lowerable(verification: &Verification, jerk_limited: bool) -> Option<Vec<(LimitId, f64)>> {
    let mut exceeded: Vec<(LimitId, f64)> = Vec::new();
    for check in
        verification.checks().iter().filter(|check| check.ratio > 1.0 + 0.5 * TOLERANCE || check.ratio.is_nan())
    {
        let id = lowered_for(check.id, jerk_limited)?;
        if !check.ratio.is_finite() {
            return None;
        }
        match exceeded.iter_mut().find(|(known, _)| *known == id) {
            Some((_, ratio)) => *ratio = ratio.max(check.ratio),
            None => exceeded.push((id, check.ratio)),
        }
    }
    (!exceeded.is_empty()).then_some(exceeded)
}

/// The limit that is lowered where a check fails.
fn lowered_for(id: LimitId, jerk_limited: bool) -> Option<LimitId> {
    Some(match id.quantity {
        Quantity::JointPosition
        | Quantity::PathDeviation
        | Quantity::OrientationDeviation
        | Quantity::Ends
        | Quantity::SetpointAgreement
        | Quantity::EndPosition
        | Quantity::EndVelocity
        | Quantity::EndAcceleration => return None,
        Quantity::Continuity if jerk_limited => LimitId { quantity: Quantity::JointJerk, ..id },
        Quantity::Continuity => LimitId { quantity: Quantity::JointAcceleration, ..id },
        _ => id,
    })
}

/// Where an excess is, by the path's parameter. A difference of two samples shows at the later one; where the curvature jumps they
/// are a control period apart.
fn stretch(excess: &Excess, law: &SpeedLaw, period: f64) -> [f64; 2] {
    [excess.from - period, excess.until].map(|t| law.at(t.max(0.0).min(law.duration())).p)
}

/// The parts of the path on which a law exceeds limits.
pub(crate) fn exceeded_stretches(
    verification: &Verification,
    law: &SpeedLaw,
    period: f64,
) -> impl Iterator<Item = [f64; 2]> {
    let checks = verification.checks().iter().filter(|check| lowered_for(check.id, true).is_some());
    checks.flat_map(move |check| verification.excesses(check.id).map(move |excess| stretch(excess, law, period)))
}

/// Lowers the limits that a jerk-limited law exceeds: those on acceleration and jerk where they are exceeded, so that the rest of the
/// motion does not get slower; others, which are not stated by rows, everywhere.
pub(crate) fn lower_where_exceeded(
    used: &mut LimitFractions,
    verification: &Verification,
    law: &SpeedLaw,
    period: f64,
) {
    for check in verification.checks().iter().filter(|check| check.ratio > 1.0 + 0.5 * TOLERANCE) {
        let Some(id) = lowered_for(check.id, true) else { continue };
        let by_rows = matches!(
            id.quantity,
            Quantity::JointJerk
                | Quantity::JointAcceleration
                | Quantity::TangentialJerk
                | Quantity::TangentialAcceleration
                | Quantity::ToolAcceleration
                | Quantity::ToolJerk
        );
        if by_rows {
            for excess in verification.excesses(check.id) {
                used.lower_between(id, stretch(excess, law, period), fraction(excess.ratio));
            }
        } else {
            used.lower(id, fraction(check.ratio));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lower limit helps against what grows with the speed, and against nothing else.
    #[test]
    fn what_no_speed_mends_lowers_no_limit() {
        let of = |quantity| lowered_for(LimitId::joint(quantity, 2), true).map(|id| (id.quantity, id.joint));
        for quantity in [Quantity::JointVelocity, Quantity::JointTorque, Quantity::JointJerk] {
            assert_eq!(of(quantity), Some((quantity, Some(2))));
        }
        assert_eq!(of(Quantity::Continuity), Some((Quantity::JointJerk, Some(2))));
        for quantity in [
            Quantity::JointPosition,
            Quantity::PathDeviation,
            Quantity::OrientationDeviation,
            Quantity::Ends,
            Quantity::SetpointAgreement,
            Quantity::EndPosition,
            Quantity::EndVelocity,
            Quantity::EndAcceleration,
        ] {
            assert_eq!(of(quantity), None, "{quantity:?}");
        }
    }
}
