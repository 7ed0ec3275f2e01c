//! A verification as lines of a report.

use arcfeed_interp::{PathParameter, Quantity, Verification};

use super::limit_line::{LimitLine, LimitUnit};

/// Every limit with its worst place; a place on the path is shown where the parameter is its length.
pub fn limit_lines(verification: &Verification, parameter: PathParameter) -> Vec<LimitLine> {
    let line = |check: &arcfeed_interp::Check| LimitLine {
        name: check.quantity().name().to_owned(),
        joint: check.joint().map(|j| j + 1),
        unit: unit(check.quantity(), check.joint()),
        value: check.value,
        limit: check.limit,
        ratio: check.ratio,
        at_s_m: (parameter == PathParameter::ArcLength).then_some(check.s),
        at_t_s: check.t,
        lines: None,
    };
    verification.checks().iter().map(line).collect()
}

fn unit(quantity: Quantity, joint: Option<usize>) -> LimitUnit {
    match quantity {
        Quantity::JointPosition | Quantity::OrientationDeviation | Quantity::EndPosition => LimitUnit::Radian,
        Quantity::JointVelocity | Quantity::AngularSpeed | Quantity::EndVelocity => LimitUnit::RadianPerSecond,
        Quantity::JointTorque => LimitUnit::NewtonMetre,
        Quantity::JointAcceleration | Quantity::EndAcceleration => LimitUnit::RadianPerSecond2,
        Quantity::JointJerk => LimitUnit::RadianPerSecond3,
        Quantity::Feed => LimitUnit::MetrePerSecond,
        Quantity::TangentialAcceleration | Quantity::NormalAcceleration | Quantity::ToolAcceleration => {
            LimitUnit::MetrePerSecond2
        }
        Quantity::TangentialJerk | Quantity::NormalJerk | Quantity::ToolJerk => LimitUnit::MetrePerSecond3,
        Quantity::PathDeviation if joint.is_some() => LimitUnit::Radian,
        Quantity::ChordError | Quantity::PathDeviation => LimitUnit::Metre,
        _ => LimitUnit::One,
    }
}
