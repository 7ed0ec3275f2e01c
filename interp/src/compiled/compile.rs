//! From a planned trajectory to polynomial pieces.

use super::error::CompileError;
use super::fit::{Bounds, Misfit, PieceDeviation};
use super::joint_trajectory::{Deviation, Interpolation, JointTrajectory};
use super::nodes::{Kind, Nodes};
use super::piece::{Coefficients, State, constant_jerk, cubic, quartic, quintic, state};
use super::steps::steps;
use crate::error::positive;
use crate::trajectory::Trajectory;
use crate::verify::JointRates;
use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::Joints;

/// By how much a compiled motion may exceed a limit, relative: as much as a plan.
const EXCESS: f64 = 1e-6;
/// Samples in one piece, at most.
const MOST_SAMPLES: usize = 2048;
/// Numbers of samples that are tried until one does. Where a short piece does not do, a longer one may: rounding and offsets count
/// less.
const TRIED: [usize; 11] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48];
/// The search for a longer piece goes up to twice the length that doubling found, and so many samples beyond.
const BEYOND: usize = 8;

impl<const N: usize> Trajectory<'_, N> {
    /// The motion as polynomials of degree 5, without path and arm: [`Trajectory::compile_with`] for [`Interpolation::Quintic`].
    ///
    /// ```
    /// use arcfeed_interp::{JointSpline, Limits, Planner};
    /// use arcfeed_kinematics::{Joints, models};
    ///
    /// let arm = models::ur5e();
    /// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
    /// let path = JointSpline::through(&[Joints::repeat(0.0), Joints::repeat(0.5), Joints::repeat(-0.2)])?;
    /// let trajectory = Planner::new(&arm, Limits::new(joints)).plan(&path)?;
    ///
    /// let compiled = trajectory.compile(1e-6)?; // rad
    /// assert!(compiled.deviation().is_some_and(|deviation| deviation.bound <= 1e-6));
    /// assert!(compiled.certify(joints.range(), &(&joints).into()).holds(1e-6));
    /// let setpoint = compiled.at(0.25);
    /// # assert!((setpoint.q[0] - trajectory.setpoints(1e-3)?.at(0.25)?.q[0]).abs() <= 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Trajectory::compile_with`].
    pub fn compile(&self, tolerance: f64) -> Result<JointTrajectory<N>, CompileError> {
        self.compile_with(tolerance, Interpolation::Quintic)
    }

    /// The motion as polynomials of the time, no joint of which deviates from the planned one by more than `tolerance`, rad.
    ///
    /// The result keeps the limits on position, velocity and acceleration that the trajectory was planned for at all times, and with
    /// [`Interpolation::Quintic`] the limit on jerk, by the same 1e-6 as the plan. It was certified. Each piece is the longest one
    /// that the search finds from where the last one ends: it doubles the length as long as that does, and then tries all lengths up to
    /// twice that from the longest downwards. Pieces end at knots of the speed law or at samples between them, 1 ms apart at most.
    /// Pieces that end at knots alone are more. Where the planned acceleration steps, because the curvature of the path jumps, the piece
    /// around the step has constant jerk over one control period, and the next piece takes up the offset.
    ///
    /// Limits of the tool are not looked at. [`JointTrajectory::certify_tool`] states what the tool does, and
    /// [`Planner::plan_compiled`](crate::Planner::plan_compiled) plans motions whose compiled tool keeps its limits.
    ///
    /// With [`Interpolation::Cubic`] the acceleration jumps from piece to piece. Each piece keeps the limit on acceleration at both
    /// its ends. Nothing is said about jerk.
    ///
    /// # Errors
    /// [`CompileError::Tolerance`], [`CompileError::AccelerationSteps`] for quintic pieces of a plan without limits on jerk,
    /// [`CompileError::Deviation`] and [`CompileError::Limit`] with joint, time and limit where no piece does.
    pub fn compile_with(
        &self,
        tolerance: f64,
        interpolation: Interpolation,
    ) -> Result<JointTrajectory<N>, CompileError> {
        self.compile_following(tolerance, interpolation, false)
    }

    /// The same, where it goes with pieces whose jerk stays between the smallest and the largest of the plan (`follows_jerk`).
    pub(super) fn compile_following(
        &self,
        tolerance: f64,
        interpolation: Interpolation,
        follows_jerk: bool,
    ) -> Result<JointTrajectory<N>, CompileError> {
        positive("tolerance", tolerance)?;
        let plan_keeps_jerk = self.verification().worst_of(Quantity::JointJerk).is_some();
        let keeps_jerk = interpolation == Interpolation::Quintic;
        if keeps_jerk && !plan_keeps_jerk {
            return Err(CompileError::AccelerationSteps);
        }
        let limits = self.limits().joints();
        let steps = if plan_keeps_jerk { steps(self)? } else { Vec::new() };
        let mut compiler = Compiler {
            nodes: Nodes::new(self, steps, tolerance, plan_keeps_jerk)?.with_jerk(follows_jerk),
            bounds: Bounds::new(limits, tolerance, keeps_jerk, plan_keeps_jerk).following_jerk(follows_jerk),
            interpolation,
            times: vec![0.0],
            pieces: Vec::new(),
            deviation: Deviation { bound: 0.0, measured: 0.0 },
        };
        compiler.run()?;
        let Compiler { times, pieces, deviation, .. } = compiler;
        let compiled = JointTrajectory::from_pieces(times, pieces, interpolation)?.with_deviation(Some(deviation));
        let mut rates = JointRates::from(limits);
        if !keeps_jerk {
            rates.jerk = Joints::repeat(f64::INFINITY);
        }
        let certificate = compiled.certify(limits.range(), &rates);
        match certificate.worst() {
            Some(worst) if !certificate.holds(EXCESS) => {
                let (limit, value, allowed, t) = (worst.id, worst.bound, worst.limit, worst.t);
                Err(CompileError::Limit { limit, value, allowed, t })
            }
            _ => Ok(compiled),
        }
    }
}

/// A piece that does.
struct Fit<const N: usize> {
    end: usize,
    piece: Coefficients<N>,
    /// The state in which it ends.
    state: State<N>,
    deviation: PieceDeviation,
}

/// A kind of piece, by what it takes from the plan at its end.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// All that the interpolation joins.
    Full,
    /// Velocity and acceleration.
    WithoutPosition,
    /// The acceleration alone.
    ConstantJerk,
}

struct Compiler<'t, 'p, const N: usize> {
    nodes: Nodes<'t, 'p, N>,
    bounds: Bounds<N>,
    interpolation: Interpolation,
    times: Vec<f64>,
    pieces: Vec<Coefficients<N>>,
    deviation: Deviation,
}

impl<const N: usize> Compiler<'_, '_, N> {
    fn run(&mut self) -> Result<(), CompileError> {
        let Some(mut state) = self.nodes.get(0)?.map(|node| node.state) else { return Ok(()) };
        let mut begin = 0;
        while let Some(kind) = self.kind(begin)? {
            let Some(last) = self.last(begin)? else { break };
            let fit = match kind {
                Kind::StepBegins if self.interpolation == Interpolation::Quintic => {
                    self.attempt(begin, last, &state, Shape::ConstantJerk).map_err(|misfit| misfit.error)?
                }
                _ => self.longest(begin, last, &state)?,
            };
            state = fit.state;
            begin = fit.end;
            self.accept(fit);
        }
        Ok(())
    }

    fn kind(&mut self, i: usize) -> Result<Option<Kind>, CompileError> {
        Ok(self.nodes.get(i)?.map(|node| node.kind))
    }

    /// The sample up to which a piece from `begin` may run; `None` at the end.
    fn last(&mut self, begin: usize) -> Result<Option<usize>, CompileError> {
        for end in begin + 1..=begin + MOST_SAMPLES {
            match self.kind(end)? {
                None => return Ok((end > begin + 1).then_some(end - 1)),
                Some(kind) if kind.is_border() => return Ok(Some(end)),
                Some(_) => {}
            }
        }
        Ok(Some(begin + MOST_SAMPLES))
    }

    /// The longest piece from `begin` to `last` at the most that the search finds.
    fn longest(&mut self, begin: usize, last: usize, from: &State<N>) -> Result<Fit<N>, CompileError> {
        let most = last - begin;
        let (mut length, mut best) = match self.first(begin, most, from) {
            Ok(first) => first,
            Err(least) => return self.otherwise(begin, last, from, least).map_err(|least| least.error),
        };
        while 2 * length <= most {
            let Ok(fit) = self.attempt(begin, begin + 2 * length, from, Shape::Full) else { break };
            (length, best) = (2 * length, fit);
        }
        // A piece may do although shorter ones do not, as the steps of the planned jerk lie differently in it.
        for longer in (length + 1..=(2 * length + BEYOND).min(most)).rev() {
            if let Ok(fit) = self.attempt(begin, begin + longer, from, Shape::Full) {
                return Ok(fit);
            }
        }
        Ok(best)
    }

    /// A short piece from `begin` over `most` samples at the most, and its length; otherwise what comes closest.
    fn first(&mut self, begin: usize, most: usize, from: &State<N>) -> Result<(usize, Fit<N>), Misfit> {
        let mut least: Option<Misfit> = None;
        for length in TRIED.into_iter().filter(|length| *length <= most) {
            match self.attempt(begin, begin + length, from, Shape::Full) {
                Ok(fit) => return Ok((length, fit)),
                Err(misfit) if least.as_ref().is_none_or(|least| misfit.excess < least.excess) => least = Some(misfit),
                Err(_) => {}
            }
        }
        Err(least.unwrap_or(Misfit { excess: f64::INFINITY, error: CompileError::AccelerationSteps }))
    }

    /// A piece where none follows the jerk of the plan: one that keeps the limits, or one that does not end in the planned state.
    /// Otherwise what comes closest to the limits, `least` where the jerk of the plan does not matter.
    fn otherwise(&mut self, begin: usize, last: usize, from: &State<N>, least: Misfit) -> Result<Fit<N>, Misfit> {
        let follows_jerk = self.bounds.follows_jerk();
        self.bounds = self.bounds.following_jerk(false);
        let short = if follows_jerk { self.first(begin, last - begin, from) } else { Err(least) };
        let fit = match short {
            Ok((_, fit)) => Ok(fit),
            Err(least) => self.partial(begin, last, from).map_err(|_| least),
        };
        self.bounds = self.bounds.following_jerk(follows_jerk);
        fit
    }

    /// A short piece that does not end in the planned state: a later one makes up for it.
    fn partial(&mut self, begin: usize, last: usize, from: &State<N>) -> Result<Fit<N>, Misfit> {
        let shapes = [(Shape::WithoutPosition, 2), (Shape::ConstantJerk, 1), (Shape::ConstantJerk, 2)];
        let mut result = self.attempt(begin, begin + 1, from, Shape::WithoutPosition);
        for (shape, n) in shapes {
            if result.is_err() && begin + n < last {
                result = self.attempt(begin, begin + n, from, shape);
            }
        }
        // The piece that spreads a step may begin beside the plan, too.
        let is_step_next = matches!(self.kind(last), Ok(Some(Kind::StepBegins)));
        for (shape, n) in shapes {
            if result.is_err() && is_step_next && begin + n == last {
                result = self.attempt(begin, begin + n, from, shape);
            }
        }
        result
    }

    fn attempt(&mut self, begin: usize, end: usize, from: &State<N>, shape: Shape) -> Result<Fit<N>, Misfit> {
        let nodes = self.nodes.made(begin, end);
        let ends = (self.nodes.made(begin, begin).next(), self.nodes.made(end, end).next());
        let (Some(first), Some(last)) = ends else {
            return Err(Misfit { excess: f64::INFINITY, error: CompileError::AccelerationSteps });
        };
        let (h, to) = (last.t - first.t, last.state);
        let piece = match (shape, self.interpolation) {
            (Shape::Full, Interpolation::Quintic) => quintic(from, &to, h),
            (Shape::Full, Interpolation::Cubic) => cubic(from, &to, h),
            (Shape::WithoutPosition, _) => quartic(from, &to, h),
            (Shape::ConstantJerk, _) => constant_jerk(from, &to.qdd, h),
        };
        // Other shapes are there for what the plan cannot be followed in.
        let follows_jerk = self.bounds.follows_jerk() && shape == Shape::Full;
        let deviation = self.bounds.following_jerk(follows_jerk).check(&piece, h, nodes)?;
        let state = if shape == Shape::Full { to } else { state(&piece, h) };
        Ok(Fit { end, piece, state, deviation })
    }

    fn accept(&mut self, fit: Fit<N>) {
        let end = self.nodes.made(fit.end, fit.end).next().map_or(0.0, |node| node.t);
        self.times.push(end);
        self.pieces.push(fit.piece);
        self.deviation.bound = self.deviation.bound.max(fit.deviation.bound);
        self.deviation.measured = self.deviation.measured.max(fit.deviation.measured);
        self.nodes.drop_before(fit.end);
    }
}
