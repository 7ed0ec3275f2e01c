//! Vibration that a motion excites in a flexible structure.
//!
//! A mass on a spring and a damper, whose foot moves with acceleration `a`, is deflected by `y` (two-mass model with a base that the
//! drive holds):
//!
//! ```text
//! y'' + 2 zeta omega y' + omega^2 y = -a(t)
//! ```
//!
//! Where `a` is a polynomial the solution is a power series that converges everywhere. It is evaluated in steps short enough for its terms
//! to fall below rounding, so that nothing is integrated by approximation and nothing cancels.

use arcfeed_kinematics::ForwardKinematics;

use crate::error::{LimitError, PlanError};
use crate::setpoint::Setpoint;
use crate::time_pieces::time_pieces;
use crate::trajectory::Trajectory;

/// Terms of the series, and the greatest step in units of 1 / omega: the first term left out is below 1e-20.
const TERMS: usize = 20;
const STEP: f64 = 0.5;

/// A mass on a spring and a damper.
///
/// ```
/// use arcfeed_interp::{AccelerationPiece, Oscillator};
/// // 10 Hz without damping; constant acceleration for half a period, then none: twice the static deflection is left.
/// let oscillator = Oscillator::new(10.0, 0.0)?;
/// let piece = AccelerationPiece { duration: 0.05, coefficients: [[1.0, 0.0, 0.0, 0.0]] };
/// let vibration = oscillator.respond([piece]);
/// let omega = 20.0 * std::f64::consts::PI;
/// assert!((vibration.deflection * omega * omega - 2.0).abs() < 1e-12);
/// assert!((vibration.residual * omega * omega - 2.0).abs() < 1e-12);
/// # Ok::<(), arcfeed_interp::LimitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    frequency: f64,
    damping: f64,
}

/// A part of a motion on which the acceleration is a cubic of the time, in `D` directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelerationPiece<const D: usize> {
    /// Duration, s.
    pub duration: f64,
    /// Coefficients of the powers 0 to 3 of the time since its start, for each direction.
    pub coefficients: [[f64; 4]; D],
}

/// Magnitudes of the deflection that a motion causes, rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// The largest one during the motion.
    pub deflection: f64,
    /// The largest one after its end.
    pub residual: f64,
}

/// Deflections and their rates.
#[derive(Debug, Clone, Copy)]
struct State<const D: usize> {
    y: [f64; D],
    rate: [f64; D],
}

impl Oscillator {
    /// With a natural frequency (Hz) and the part of the critical damping, 0 for none.
    ///
    /// # Errors
    /// [`LimitError::Oscillator`] for a frequency that is not from 1 mHz to 10 kHz, or a damping that is not from 0 to below 1.
    pub fn new(frequency: f64, damping: f64) -> Result<Self, LimitError> {
        // The highest frequency, Hz: far above what a drive excites, and each period takes some steps.
        const HIGHEST: f64 = 1e4;
        // The lowest one, Hz: a structure that takes a quarter of an hour to swing once is none.
        const LOWEST: f64 = 1e-3;
        if !(LOWEST..=HIGHEST).contains(&frequency) {
            let rule = "a natural frequency is from 0.001 to 10000 Hz";
            return Err(LimitError::Oscillator { value: frequency, rule });
        }
        if !(0.0..1.0).contains(&damping) {
            let rule = "damping is a part of the critical one, from 0 to below 1: 0.02 is 2 %";
            return Err(LimitError::Oscillator { value: damping, rule });
        }
        Ok(Self { frequency, damping })
    }

    /// Natural frequency, Hz.
    pub const fn frequency(&self) -> f64 {
        self.frequency
    }

    /// Part of the critical damping.
    pub const fn damping(&self) -> f64 {
        self.damping
    }

    /// The response from rest to a motion in pieces, one after the other. Of several directions the magnitude of all counts.
    pub fn respond<const D: usize>(&self, pieces: impl IntoIterator<Item = AccelerationPiece<D>>) -> Vibration {
        let mut state = State { y: [0.0; D], rate: [0.0; D] };
        let mut deflection = 0.0;
        for piece in pieces {
            (state, deflection) = self.over(state, &piece, deflection);
        }
        // The first turning point after the end is the largest one.
        let free = AccelerationPiece { duration: 1.0 / self.frequency, coefficients: [[0.0; 4]; D] };
        let residual = self.over(state, &free, magnitude(&state.y)).1;
        Vibration { deflection, residual }
    }

    /// The state at the end of a piece, and the largest deflection so far.
    fn over<const D: usize>(
        &self,
        mut state: State<D>,
        piece: &AccelerationPiece<D>,
        mut most: f64,
    ) -> (State<D>, f64) {
        // Halvings in which a turning point is found.
        const HALVINGS: usize = 60;
        let omega = std::f64::consts::TAU * self.frequency;
        let steps = (piece.duration * omega / STEP).ceil().max(1.0);
        let h = piece.duration / steps;
        let mut step = 0.0;
        while step < steps {
            let series = self.series(&state, &shifted(&piece.coefficients, step * h), omega);
            let end = at(&series, h);
            // Where the magnitude stops growing inside the step it has its largest value.
            if grows(&state) > 0.0 && grows(&end) < 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    *(if grows(&at(&series, middle)) > 0.0 { &mut low } else { &mut high }) = middle;
                }
                most = not_below(most, magnitude(&at(&series, low).y));
            }
            most = not_below(most, magnitude(&end.y));
            state = end;
            step += 1.0;
        }
        (state, most)
    }

    /// The power series of the deflections from a state on.
    fn series<const D: usize>(&self, state: &State<D>, a: &[[f64; 4]; D], omega: f64) -> [[f64; TERMS]; D] {
        std::array::from_fn(|d| {
            let mut terms = [0.0; TERMS];
            (terms[0], terms[1]) = (state.y[d], state.rate[d]);
            for k in 0..TERMS - 2 {
                let n = (k + 1) as f64;
                let driven = a[d].get(k).copied().unwrap_or(0.0);
                let held = 2.0 * self.damping * omega * n * terms[k + 1] + omega * omega * terms[k];
                terms[k + 2] = -(driven + held) / (n * (n + 1.0));
            }
            terms
        })
    }
}

/// The larger one of two numbers; a NaN stays.
fn not_below(most: f64, value: f64) -> f64 {
    if value > most || value.is_nan() { value } else { most }
}

fn magnitude<const D: usize>(y: &[f64; D]) -> f64 {
    y.iter().fold(0.0, |sum: f64, y| sum.hypot(*y))
}

/// The rate of half the squared magnitude.
fn grows<const D: usize>(state: &State<D>) -> f64 {
    state.y.iter().zip(&state.rate).map(|(y, rate)| y * rate).sum()
}

/// Deflections and rates of a series after the time `t`.
fn at<const D: usize>(series: &[[f64; TERMS]; D], t: f64) -> State<D> {
    let y = std::array::from_fn(|d| series[d].iter().rev().fold(0.0, |sum, term| sum * t + term));
    let rate = std::array::from_fn(|d| (1..TERMS).rev().fold(0.0, |sum, k| sum * t + k as f64 * series[d][k]));
    State { y, rate }
}

/// Coefficients of the same cubics, counted from the time `t` on.
fn shifted<const D: usize>(coefficients: &[[f64; 4]; D], t: f64) -> [[f64; 4]; D] {
    coefficients
        .map(|[a, b, c, d]| [a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * 3.0 * d), c + 3.0 * d * t, d])
}

/// The cubic through values at 0, 1/3, 2/3 and the whole of a duration.
fn through([p, q, r, s]: [f64; 4], duration: f64) -> [f64; 4] {
    let third = duration / 3.0;
    // Divided differences on equal steps.
    let (first, second, third_difference) = (q - p, r - 2.0 * q + p, s - 3.0 * r + 3.0 * q - p);
    [
        p,
        (first - second / 2.0 + third_difference / 3.0) / third,
        (second / 2.0 - third_difference / 2.0) / (third * third),
        third_difference / 6.0 / (third * third * third),
    ]
}

impl<const N: usize> Trajectory<'_, N> {
    /// The vibration of a mass that joint `joint` (from 0) carries, rad (m for slides): driven by the acceleration of the joint.
    ///
    /// # Errors
    /// [`LimitError::NoSuchJoint`]; [`PlanError::Path`] as for setpoints.
    pub fn joint_vibration(&self, joint: usize, oscillator: &Oscillator) -> Result<Vibration, PlanError> {
        if joint >= N {
            return Err(LimitError::NoSuchJoint { what: "an oscillator", joint, joints: N }.into());
        }
        let pieces = self.acceleration_pieces(|at, _| [at.qdd[joint]])?;
        Ok(oscillator.respond(pieces))
    }

    /// The vibration of a mass at the tool point, m: the magnitude of its deflection, the same in all directions, driven by the
    /// acceleration of the tool point.
    ///
    /// # Errors
    /// [`PlanError::Path`] as for setpoints.
    pub fn tool_vibration(&self, oscillator: &Oscillator) -> Result<Vibration, PlanError> {
        let pieces = self.acceleration_pieces(|at, arm| {
            let configuration = arm.configuration(&at.q);
            let acceleration = configuration.jacobian() * at.qdd + configuration.acceleration_bias(&at.qd);
            [acceleration[0], acceleration[1], acceleration[2]]
        })?;
        Ok(oscillator.respond(pieces))
    }

    /// The acceleration that `of` takes from a setpoint, as cubics of the time through four places of each piece. Pieces begin and end
    /// where the law has its knots.
    fn acceleration_pieces<const D: usize>(
        &self,
        of: impl Fn(&Setpoint<N>, &dyn ForwardKinematics<N>) -> [f64; D],
    ) -> Result<Vec<AccelerationPiece<D>>, PlanError> {
        let arm = self.problem().settings.arm;
        let mut setpoints = self.setpoints(self.period())?;
        let mut pieces = Vec::new();
        for [from, duration] in time_pieces(self.law()) {
            // Just before its end: at a knot the acceleration may jump.
            let places = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0 - 1e-9].map(|place| from + place * duration);
            let mut values = [[0.0; D]; 4];
            for (value, t) in values.iter_mut().zip(places) {
                *value = of(&setpoints.at(t)?, arm);
            }
            let coefficients = std::array::from_fn(|d| through(values.map(|value| value[d]), duration));
            pieces.push(AccelerationPiece { duration, coefficients });
        }
        Ok(pieces)
    }
}
