//! The one rule on limits: a motion that exceeds one of them is not handed out.

use thiserror::Error;

use super::limit_line::{LimitLine, worst};
use crate::text::{number, percent};

/// Proof that a motion was checked and keeps every limit; [`Staging::publish`](crate::Staging::publish) asks for it.
///
/// ```
/// use robot_cr7::{Exceeded, LimitsHold};
/// // What was not checked does not hold.
/// assert_eq!(LimitsHold::of(&[]).unwrap_err(), Exceeded::Unchecked);
/// ```
#[derive(Debug)]
pub struct LimitsHold(());

impl LimitsHold {
    /// The proof, from every limit of a check with its worst place.
    ///
    /// # Errors
    /// [`Exceeded`] with the limit that is exceeded most.
    pub fn of(limits: &[LimitLine]) -> Result<Self, Exceeded> {
        if limits.is_empty() {
            return Err(Exceeded::Unchecked);
        }
        match worst(limits.iter().filter(|line| !line.holds())) {
            None => Ok(Self(())),
            Some(worst) => Err(Exceeded::Limit(Box::new(worst.clone()))),
        }
    }
}

/// Why a motion is not handed out.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Exceeded {
    /// There is no check of it.
    #[error("the motion was not checked")]
    Unchecked,
    /// A limit that is exceeded.
    #[error("{}", words(.0))]
    Limit(Box<LimitLine>),
}

/// "joint acceleration of joint 3 reaches 103.80 % of its limit (20.76 of 20 deg/s^2) at s = 12.3 mm, t = 0.5 s".
fn words(line: &LimitLine) -> String {
    let (factor, unit) = line.unit.for_people();
    let joint = line.joint.map(|j| format!(" of joint {j}")).unwrap_or_default();
    let (value, limit) = (number(line.value * factor), number(line.limit * factor));
    let space = if unit.is_empty() { "" } else { " " };
    let place = line.at_s_m.map(|s| format!("s = {} mm, ", number(s * 1e3))).unwrap_or_default();
    let used = percent(line.ratio);
    let at = format!("{place}t = {} s", number(line.at_t_s));
    format!("{}{joint} reaches {used} of its limit ({value} of {limit}{space}{unit}) at {at}", line.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::limit_line::LimitUnit;

    fn line(ratio: f64) -> LimitLine {
        LimitLine {
            name: "joint velocity".to_owned(),
            joint: Some(2),
            unit: LimitUnit::RadianPerSecond,
            value: ratio,
            limit: 1.0,
            ratio,
            at_s_m: None,
            at_t_s: 0.25,
            lines: None,
        }
    }

    #[test]
    fn a_limit_holds_to_within_rounding_and_nothing_else_does() {
        assert!(LimitsHold::of(&[line(0.0), line(1.0), line(1.0 + 0.9e-6)]).is_ok());
        for ratio in [1.0 + 1.1e-6, 2.0, f64::INFINITY, f64::NAN] {
            let Err(Exceeded::Limit(worst)) = LimitsHold::of(&[line(1.0), line(ratio), line(0.5)]) else {
                panic!("{ratio} holds")
            };
            assert_eq!(worst.ratio.to_bits(), ratio.to_bits());
        }
    }

    #[test]
    fn the_worst_limit_is_named_with_joint_value_and_place() {
        let error = LimitsHold::of(&[line(1.01), line(1.5), line(1.2)]).expect_err("exceeded").to_string();
        for part in ["joint velocity of joint 2", "150.00 %", "85.944 of 57.296 deg/s", "t = 0.25 s"] {
            assert!(error.contains(part), "\"{part}\" is missing in: {error}");
        }
    }
}
