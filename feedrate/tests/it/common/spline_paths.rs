//! The 20 joint paths of `fixtures/path_scheduling.txt`: natural cubic splines through way-points, with limits and
//! reference durations.
#![allow(dead_code)]

pub const JOINTS: usize = 6;
pub const A_MAX: [f64; JOINTS] = [3.06, 2.31, 3.47, 3.74, 3.74, 5.5];
pub const V_A: [f64; JOINTS] = [1.02, 0.77, 1.16, 1.25, 1.25, 1.86];
pub const V_B: [f64; JOINTS] = [5.1, 3.85, 5.8, 6.25, 6.25, 9.3];
pub const TAU_C: [f64; JOINTS] = [7.0, 64.0, 18.0, 1.0, 0.7, 0.07];

/// Durations of one case at one N.
#[derive(Debug, Clone, Copy)]
pub struct Reference {
    pub case: char,
    pub n: usize,
    pub exact: f64,
    pub dual_bound: f64,
    pub conic: f64,
    pub published: f64,
    pub both_ends: f64,
}

/// Durations of the continuous problem.
#[derive(Debug, Clone, Copy)]
pub struct Fine {
    pub case: char,
    pub fine: f64,
    pub certified: f64,
    pub jerk_n: usize,
    pub jerk: f64,
}

#[derive(Debug, Clone)]
pub struct Path {
    pub seed: u32,
    pub spline: Spline,
    pub references: Vec<Reference>,
    pub fine: Vec<Fine>,
    /// Torque terms a, b, d at the 101 points of N = 100; empty where not recorded.
    pub torque: [Vec<f64>; 3],
}

pub fn paths() -> Vec<Path> {
    let mut paths = Vec::new();
    let mut way_points: Vec<[f64; JOINTS]> = Vec::new();
    for line in include_str!("../../fixtures/path_scheduling.txt").lines().chain(["path 0 0 0"]) {
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or("#");
        let words: Vec<&str> = words.collect();
        let numbers = |from: usize| words[from..].iter().map(|w| w.parse::<f64>().expect("a number"));
        match key {
            "path" => {
                if let Some(path) = paths.last_mut() {
                    let path: &mut Path = path;
                    path.spline = Spline::natural(&std::mem::take(&mut way_points));
                }
                let seed = words[0].parse().expect("a seed");
                let spline = Spline { knots: vec![], pieces: vec![] };
                paths.push(Path { seed, spline, references: vec![], fine: vec![], torque: Default::default() });
            }
            "w" => way_points.push(std::array::from_fn(|j| words[j].parse().expect("a number"))),
            "ref" => {
                let r: Vec<f64> = numbers(2).collect();
                paths.last_mut().expect("a path").references.push(Reference {
                    case: words[0].chars().next().expect("a case"),
                    n: words[1].parse().expect("a count"),
                    exact: r[0],
                    dual_bound: r[1],
                    conic: r[2],
                    published: r[3],
                    both_ends: r[4],
                });
            }
            "fine" => {
                let r: Vec<f64> = numbers(1).collect();
                let case = words[0].chars().next().expect("a case");
                let (jerk_n, jerk) = (r[2] as usize, r[3]);
                paths.last_mut().expect("a path").fine.push(Fine { case, fine: r[0], certified: r[1], jerk_n, jerk });
            }
            "t" => {
                let r: Vec<f64> = numbers(0).collect();
                for (term, values) in paths.last_mut().expect("a path").torque.iter_mut().zip(r.chunks(JOINTS)) {
                    term.extend_from_slice(values);
                }
            }
            _ => {}
        }
    }
    paths.pop();
    paths
}

/// A cubic spline of all joints; a piece holds its coefficients from the third power down.
#[derive(Debug, Clone)]
pub struct Spline {
    pub knots: Vec<f64>,
    pub pieces: Vec<[[f64; JOINTS]; 4]>,
}

impl Spline {
    /// The natural cubic spline on uniform knots over [0, 1].
    pub fn natural(points: &[[f64; JOINTS]]) -> Self {
        let n = points.len() - 1;
        let h = 1.0 / n as f64;
        let mut pieces = vec![[[0.0; JOINTS]; 4]; n];
        for j in 0..JOINTS {
            // Thomas' algorithm for the second derivatives m: m[i-1] + 4 m[i] + m[i+1] = 6 / h^2 * second difference.
            let mut m = vec![0.0; n + 1];
            let (mut c, mut d) = (vec![0.0; n + 1], vec![0.0; n + 1]);
            for i in 1..n {
                let rhs = 6.0 / (h * h) * (points[i + 1][j] - 2.0 * points[i][j] + points[i - 1][j]);
                let pivot = 4.0 - c[i - 1];
                c[i] = 1.0 / pivot;
                d[i] = (rhs - d[i - 1]) / pivot;
            }
            for i in (1..n).rev() {
                m[i] = d[i] - c[i] * m[i + 1];
            }
            for i in 0..n {
                pieces[i][0][j] = (m[i + 1] - m[i]) / (6.0 * h);
                pieces[i][1][j] = 0.5 * m[i];
                pieces[i][2][j] = (points[i + 1][j] - points[i][j]) / h - h * (2.0 * m[i] + m[i + 1]) / 6.0;
                pieces[i][3][j] = points[i][j];
            }
        }
        Self { knots: (0..=n).map(|i| i as f64 * h).collect(), pieces }
    }

    pub fn piece(&self, s: f64) -> usize {
        self.knots.partition_point(|&k| k <= s).clamp(1, self.pieces.len()) - 1
    }

    /// Derivatives 1 to 3 of joint `j` at `s` on the given piece.
    pub fn jet(&self, piece: usize, s: f64, j: usize) -> [f64; 3] {
        let [a, b, c, _] = self.pieces[piece].map(|row| row[j]);
        let d = s - self.knots[piece];
        [(3.0 * a * d + 2.0 * b) * d + c, 6.0 * a * d + 2.0 * b, 6.0 * a]
    }

    /// A uniform grid of `n` intervals.
    pub fn uniform(n: usize) -> Vec<f64> {
        (0..=n).map(|i| i as f64 / n as f64).collect()
    }

    /// A grid of about `n` intervals that contains the knots.
    pub fn on_knots(&self, n: usize) -> Vec<f64> {
        let per = n.div_ceil(self.pieces.len());
        let mut grid: Vec<f64> = (0..self.pieces.len())
            .flat_map(|k| {
                let (a, b) = (self.knots[k], self.knots[k + 1]);
                (0..per).map(move |i| a + (b - a) * i as f64 / per as f64)
            })
            .collect();
        grid.push(1.0);
        grid
    }

    pub fn samples(&self, grid: &[f64]) -> Samples {
        let mut samples = Samples::default();
        for &s in grid {
            let after = self.piece(s + 1e-12);
            let before = self.piece((s - 1e-12).max(0.0));
            for j in 0..JOINTS {
                let jet = self.jet(after, s, j);
                samples.first.push(jet[0]);
                samples.second.push(jet[1]);
                samples.third.push(jet[2]);
                samples.third_before.push(self.jet(before, s, j)[2]);
            }
        }
        samples
    }
}

/// Path derivatives on a grid, row-major.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    pub first: Vec<f64>,
    pub second: Vec<f64>,
    pub third: Vec<f64>,
    pub third_before: Vec<f64>,
}

impl Samples {
    pub fn path(&self) -> arcfeed_feedrate::constraint::PathDerivatives<'_> {
        arcfeed_feedrate::constraint::PathDerivatives::new(JOINTS, &self.first, &self.second)
            .and_then(|path| path.with_third(&self.third))
            .and_then(|path| path.with_values_before(&[], &[], &self.third_before))
            .expect("arrays of equal length")
    }
}

/// Greatest ratio of velocity, acceleration and jerk to their limits, over `per` samples of every grid interval.
pub fn worst(
    spline: &Spline,
    grid: &[f64],
    plan: &arcfeed_feedrate::SpeedLaw,
    per: usize,
    v: &[f64; JOINTS],
    jerk: &[f64; JOINTS],
) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for w in grid.windows(2) {
        let piece = spline.piece(0.5 * (w[0] + w[1]));
        for i in 0..=per {
            // A hair inside the interval, so that the plan is asked on this side of the grid points.
            let f = (i as f64 / per as f64).clamp(1e-9, 1.0 - 1e-9);
            let s = w[0] + (w[1] - w[0]) * f;
            let state = plan.at_position(s);
            for j in 0..JOINTS {
                let [p, q, r] = spline.jet(piece, s, j);
                let speed = p * state.v;
                let acceleration = p * state.a + q * state.v * state.v;
                let third = p * state.j + 3.0 * q * state.v * state.a + r * state.v.powi(3);
                worst[0] = worst[0].max(speed.abs() / v[j]);
                worst[1] = worst[1].max(acceleration.abs() / A_MAX[j]);
                worst[2] = worst[2].max(third.abs() / jerk[j]);
            }
        }
    }
    worst
}
