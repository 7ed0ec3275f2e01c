//! A simulated drive: what the joints do with the setpoints.

use arcfeed_kinematics::Joints;

use crate::error::{LimitError, positive};

/// The joints behind their setpoints: a lag of first order in every joint, `tau dq/dt = u - q`, as a position loop of gain `1 / tau` shows.
///
/// The setpoint `u` goes in a straight line from one cycle to the next, as drives interpolate, and the step is the exact solution for that:
/// no cycle length makes it unstable. In steady motion the joint is behind by `velocity * tau`. Nothing is allocated.
///
/// ```
/// use arcfeed_interp::DriveLag;
/// use arcfeed_kinematics::Joints;
///
/// let mut drive = DriveLag::new(Joints::<6>::zeros(), Joints::repeat(0.01), 0.001)?;
/// for cycle in 1..=1000 {
///     drive.step(&Joints::repeat(0.5 * 0.001 * f64::from(cycle))); // 0.5 rad/s
/// }
/// assert!((drive.following_error()[0] - 0.5 * 0.01).abs() < 1e-12);
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLag<const N: usize = 6> {
    q: Joints<N>,
    setpoint: Joints<N>,
    /// Time constants, s.
    tau: Joints<N>,
    /// The part of a lag that is left after one cycle.
    left: Joints<N>,
    /// The distance that a joint follows while its setpoint moves by 1 within one cycle.
    gained: Joints<N>,
}

impl<const N: usize> DriveLag<N> {
    /// At rest at `q` (rad), with time constants `tau` (s; 0 follows without lag) and a control `period` (s).
    ///
    /// # Errors
    /// [`LimitError::NotPositive`] for a time constant that is negative or not finite, a period that is not above 0, a position that is not finite.
    pub fn new(q: Joints<N>, tau: Joints<N>, period: f64) -> Result<Self, LimitError> {
        positive("control period", period)?;
        for k in 0..N {
            if !(tau[k].is_finite() && tau[k] >= 0.0) {
                return Err(LimitError::NotPositive { what: "time constant of a drive", value: tau[k] });
            }
            if !q[k].is_finite() {
                return Err(LimitError::NotPositive { what: "position of a drive", value: q[k] });
            }
        }
        // Over one cycle, x = period / tau: what was left decays by exp(-x), a setpoint on the move is followed by 1 - (1 - exp(-x)) / x.
        let left = tau.map(|tau| if tau > 0.0 { (-period / tau).exp() } else { 0.0 });
        let gained = tau.map(|tau| {
            let x = period / tau;
            if x > 1e-4 { 1.0 + (-x).exp_m1() / x } else { x / 2.0 - x * x / 6.0 }
        });
        let gained = gained.zip_map(&tau, |g, tau| if tau > 0.0 { g } else { 1.0 });
        Ok(Self { q, setpoint: q, tau, left, gained })
    }

    /// Moves on by one cycle, at whose end the setpoint is `setpoint` (rad); returns the joints at that moment.
    pub fn step(&mut self, setpoint: &Joints<N>) -> Joints<N> {
        let moved = setpoint - self.setpoint;
        let lag = self.q - self.setpoint;
        self.q = self.setpoint + lag.component_mul(&self.left) + moved.component_mul(&self.gained);
        self.setpoint = *setpoint;
        self.q
    }

    /// The joints (rad).
    pub fn position(&self) -> &Joints<N> {
        &self.q
    }

    /// Velocity of the joints (rad/s); 0 for a joint without lag, whose velocity is that of its setpoint.
    pub fn velocity(&self) -> Joints<N> {
        self.following_error().zip_map(&self.tau, |error, tau| if tau > 0.0 { error / tau } else { 0.0 })
    }

    /// By how much the joints are behind their setpoints (rad).
    pub fn following_error(&self) -> Joints<N> {
        self.setpoint - self.q
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAUS: [f64; 5] = [1e-3, 5e-3, 0.02, 0.3, 40.0];

    #[test]
    fn a_step_is_answered_by_an_exponential() -> Result<(), LimitError> {
        for tau in TAUS {
            for period in [1e-3, 2e-3, 0.05] {
                let mut drive = DriveLag::<1>::new(Joints::zeros(), Joints::repeat(tau), period)?;
                // The setpoint goes from 0 to 1 within the first cycle; the answer to that ramp in closed form.
                let first = 1.0 - tau / period * (1.0 - (-period / tau).exp());
                let mut q = drive.step(&Joints::repeat(1.0))[0];
                assert!((q - first).abs() < 1e-11, "{tau} {period}: {q} {first}");
                for cycle in 1..200 {
                    q = drive.step(&Joints::repeat(1.0))[0];
                    let t = period * f64::from(cycle);
                    let wanted = 1.0 - (1.0 - first) * (-t / tau).exp();
                    assert!((q - wanted).abs() < 1e-11, "{tau} {period} {cycle}: {q} {wanted}");
                    assert!((drive.velocity()[0] - (1.0 - wanted) / tau).abs() < 1e-7);
                }
            }
        }
        Ok(())
    }

    #[test]
    fn in_steady_motion_it_is_behind_by_velocity_times_time_constant() -> Result<(), LimitError> {
        let (period, v) = (2e-3, -0.7);
        let tau = Joints::from(TAUS);
        let mut drive = DriveLag::<5>::new(Joints::zeros(), tau, period)?;
        for cycle in 1..=5000 {
            let t = period * f64::from(cycle);
            let q = drive.step(&Joints::repeat(v * t));
            // The whole answer to a ramp: q = v (t - tau (1 - exp(-t / tau))).
            let wanted = tau.map(|tau| v * (t + tau * (-t / tau).exp_m1()));
            assert!((q - wanted).amax() < 1e-9, "{t}: {q} {wanted}");
        }
        let behind = drive.following_error();
        assert!((0..4).all(|k| (behind[k] - v * tau[k]).abs() < 1e-9), "{behind}");
        assert!((0..4).all(|k| (drive.velocity()[k] - v).abs() < 1e-8));
        Ok(())
    }

    #[test]
    fn without_lag_it_follows_exactly_and_bad_numbers_are_refused() -> Result<(), LimitError> {
        let mut drive = DriveLag::<2>::new(Joints::repeat(0.3), Joints::zeros(), 1e-3)?;
        for i in 0..100 {
            let u = Joints::repeat(f64::from(i).sin());
            assert!((drive.step(&u) - u).amax() < 1e-15);
        }
        for (q, tau, period) in [
            (0.0, -1.0, 1e-3),
            (0.0, f64::NAN, 1e-3),
            (f64::INFINITY, 0.1, 1e-3),
            (0.0, 0.1, 0.0),
            (0.0, 0.1, f64::NAN),
        ] {
            assert!(DriveLag::<2>::new(Joints::repeat(q), Joints::repeat(tau), period).is_err());
        }
        Ok(())
    }
}
