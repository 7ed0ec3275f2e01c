//! Second-order cone programs in the shape all of ours have, solved by clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::error::FeedError;
use crate::problem::FeedProblem;

/// Rows `terms + slack = bound` with their nonzeros.
#[derive(Debug, Default)]
struct Rows {
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    bound: Vec<f64>,
}

impl Rows {
    fn push(&mut self, bound: f64, terms: &[(usize, f64)]) {
        for &(column, value) in terms {
            self.row.push(self.bound.len());
            self.column.push(column);
            self.value.push(value);
        }
        self.bound.push(bound);
    }

    fn append(&mut self, other: Self) {
        let first = self.bound.len();
        self.row.extend(other.row.iter().map(|row| row + first));
        self.column.extend(other.column);
        self.value.extend(other.value);
        self.bound.extend(other.bound);
    }
}

/// Minimise a cost under equations, bounds, roots and inverses.
#[derive(Debug)]
pub(crate) struct Program {
    cost: Vec<f64>,
    equations: Rows,
    bounds: Rows,
    cones: Rows,
}

/// The result of the solver.
#[derive(Debug)]
pub(crate) struct Optimum {
    pub variables: Vec<f64>,
    /// Objective of the dual program, which bounds the cost from below.
    pub dual: f64,
    /// True if the solver reached its full accuracy.
    pub accurate: bool,
}

impl Program {
    pub fn new(variables: usize) -> Self {
        let rows = Rows::default;
        Self { cost: vec![0.0; variables], equations: rows(), bounds: rows(), cones: rows() }
    }

    /// Adds `factor` times a variable to the cost.
    pub fn cost(&mut self, variable: usize, factor: f64) {
        self.cost[variable] += factor;
    }

    /// `terms = bound`.
    pub fn equal(&mut self, bound: f64, terms: &[(usize, f64)]) {
        self.equations.push(bound, terms);
    }

    /// `terms <= bound`.
    pub fn at_most(&mut self, bound: f64, terms: &[(usize, f64)]) {
        self.bounds.push(bound, terms);
    }

    /// `root <= sqrt(terms)`: `(terms + 1, terms - 1, 2 root)` in the second-order cone.
    pub fn root<const N: usize>(&mut self, root: usize, terms: [(usize, f64); N]) {
        let negative = terms.map(|(column, value)| (column, -value));
        self.cones.push(1.0, &negative);
        self.cones.push(-1.0, &negative);
        self.cones.push(0.0, &[(root, -2.0)]);
    }

    /// `inverse >= 1 / (p + q)`: `(p + q + inverse, p + q - inverse, 2)` in the second-order cone.
    pub fn inverse(&mut self, inverse: usize, [p, q]: [usize; 2]) {
        self.cones.push(0.0, &[(p, -1.0), (q, -1.0), (inverse, -1.0)]);
        self.cones.push(0.0, &[(p, -1.0), (q, -1.0), (inverse, 1.0)]);
        self.cones.push(2.0, &[]);
    }

    /// The optimum, of a program whose numbers are near 1.
    ///
    /// # Errors
    /// [`FeedError::NotConverged`].
    pub fn solve(self) -> Result<Optimum, FeedError> {
        let mut cones = vec![
            SupportedConeT::ZeroConeT(self.equations.bound.len()),
            SupportedConeT::NonnegativeConeT(self.bounds.bound.len()),
        ];
        cones.extend((0..self.cones.bound.len() / 3).map(|_| SupportedConeT::SecondOrderConeT(3)));
        let variables = self.cost.len();
        let mut rows = self.equations;
        rows.append(self.bounds);
        rows.append(self.cones);
        let Rows { row, column, value, bound } = rows;
        let matrix = CscMatrix::new_from_triplets(bound.len(), variables, row, column, value);
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let failed = |iterations: u32, residual: f64| FeedError::NotConverged {
            what: "clarabel",
            iterations: usize::try_from(iterations).unwrap_or(usize::MAX),
            residual,
        };
        let nothing = CscMatrix::zeros((variables, variables));
        let mut solver = DefaultSolver::new(&nothing, &self.cost, &matrix, &bound, &cones, settings)
            .map_err(|_| failed(0, f64::NAN))?;
        solver.solve();
        let solution = solver.solution;
        let accurate = solution.status == SolverStatus::Solved;
        if !accurate && solution.status != SolverStatus::AlmostSolved {
            return Err(failed(solution.iterations, solution.r_prim));
        }
        Ok(Optimum { variables: solution.x, dual: solution.obj_val_dual, accurate })
    }
}

/// Refuses rows with friction: their set is not convex, so that no cone holds it.
pub(crate) fn straight(problem: &FeedProblem) -> Result<(), FeedError> {
    for i in 0..=problem.intervals() {
        if let Some(row) = problem.rows(i).iter().find(|row| row.c != 0.0) {
            return Err(FeedError::BadRow { index: i, s: problem.grid()[i], row: row.source });
        }
    }
    Ok(())
}
