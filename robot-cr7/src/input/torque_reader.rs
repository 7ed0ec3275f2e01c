//! The torque of a job: limits, ratings and load.

use super::error::InputError;
use super::job::{Payload, TorqueJob};
use super::job_file::RawJob;
use super::job_reader::JobCheck;

impl JobCheck<'_> {
    /// Limits of the torque, where it counts.
    pub(crate) fn torque(&self, job: &RawJob) -> Result<Option<TorqueJob>, InputError> {
        let raw = &job.torque;
        let limit = raw.limit_nm.as_ref().map(|values| self.0.limits("torque.limit_nm", values, 1.0)).transpose()?;
        let rated = raw.rated_nm.as_ref().map(|values| self.0.limits("torque.rated_nm", values, 1.0)).transpose()?;
        // No load is a load of 0 kg, which tables by payload ask for.
        let mass = self.0.limit("torque.payload_kg", raw.payload_kg.filter(|mass| *mass != 0.0), 1.0)?;
        let centre = raw.payload_centre_mm.map(|mm| self.0.finite("torque.payload_centre_mm", mm)).transpose()?;
        let without = |key: &str, rule, remedy| Err(self.0.wrong(key, "given", rule, remedy));
        if centre.is_some() && mass.is_none() {
            let rule = "a centre of mass needs a mass";
            return without("torque.payload_centre_mm", rule, "add torque.payload_kg, or remove the key");
        }
        let limited = raw.limited.unwrap_or(limit.is_some());
        if !limited && limit.is_some() {
            let rule = "torque.limited = false leaves the torque out of account";
            return without("torque.limit_nm", rule, "remove one of the two keys");
        }
        if !limited && rated.is_some() {
            let rule = "a rated torque is held against the torque of a motion, which has to be limited";
            return without("torque.rated_nm", rule, "add torque.limited = true, or torque.limit_nm");
        }
        if !limited && mass.is_some() && !job.tables.iter().any(|table| table.payload_kg.is_some()) {
            let rule = "a payload counts only where the torque is limited, or a table of limits has payloads";
            return without("torque.payload_kg", rule, "add torque.limited = true, torque.limit_nm, or such a table");
        }
        let payload = mass.map(|mass| Payload { mass, centre: centre.unwrap_or_default() / 1e3 });
        Ok(limited.then_some(TorqueJob { limit, rated, payload }))
    }
}
