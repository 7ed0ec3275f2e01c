//! The compiled motion of a plan, as its report states it.

use arcfeed_interp::{Certificate, JointTrajectory, Quantity};
use serde::Serialize;

use crate::text::percent;

/// The largest part of one kind of limit that a compiled motion certainly does not exceed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedRatio {
    /// Name of the quantity.
    pub name: String,
    /// The joint that uses most of its limit, from 1.
    pub joint: usize,
    /// What is not exceeded, divided by the limit.
    pub ratio: f64,
    /// The time at which it is attained, in s.
    pub at_t_s: f64,
}

/// The compiled motion of a plan. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompiledReport {
    /// Largest deviation of a joint from the plan that was allowed, in rad.
    pub tolerance_rad: f64,
    /// Number of polynomial pieces.
    pub pieces: usize,
    /// Deviation of any joint from the plan that is not exceeded, in rad.
    pub deviation_bound_rad: f64,
    /// Largest deviation of any joint at a sample, in rad.
    pub deviation_measured_rad: f64,
    /// Position, velocity, acceleration and jerk, each with the joint that uses most of its limit.
    pub certified: Vec<CertifiedRatio>,
}

impl CompiledReport {
    /// The report of `compiled`, made for `tolerance` (rad) and certified by `certificate`.
    pub fn new<const N: usize>(tolerance: f64, compiled: &JointTrajectory<N>, certificate: &Certificate) -> Self {
        let quantities =
            [Quantity::JointPosition, Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk];
        let certified = quantities.into_iter().filter_map(|quantity| {
            let bounds = certificate.bounds().iter().filter(|bound| bound.id.quantity == quantity);
            let worst = bounds.max_by(|a, b| a.ratio().total_cmp(&b.ratio()))?;
            let joint = worst.id.joint.map_or(0, usize::from) + 1;
            Some(CertifiedRatio { name: quantity.to_string(), joint, ratio: worst.ratio(), at_t_s: worst.t })
        });
        let deviation = compiled.deviation();
        Self {
            tolerance_rad: tolerance,
            pieces: compiled.len(),
            deviation_bound_rad: deviation.map_or(f64::NAN, |deviation| deviation.bound),
            deviation_measured_rad: deviation.map_or(f64::NAN, |deviation| deviation.measured),
            certified: certified.collect(),
        }
    }

    /// The two lines of a report for a terminal.
    pub(crate) fn lines(&self) -> [String; 2] {
        let parts: Vec<String> = self
            .certified
            .iter()
            .map(|line| format!("{} {}", line.name.trim_start_matches("joint "), percent(line.ratio)))
            .collect();
        [
            format!("{} pieces, {:.3e} rad from the plan at most", self.pieces, self.deviation_bound_rad),
            format!("certified: {}", parts.join(", ")),
        ]
    }
}
