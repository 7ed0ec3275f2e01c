//! Lines below a table of limits, so that the limit becomes rows.
//!
//! A row states `|value| + slope y <= rest` for each of several lines, with `y` the speed of the joint or its square. Together they
//! describe a concave function of `y`. A table that is concave in `y` is described exactly. Of any other one, the least concave function
//! above it is taken and lowered by one factor until it lies below: no concave function below the table loses less of it at its
//! worst place.

use crate::limits::LimitTable;

/// `rest - slope y`, with a slope of 0 or more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub rest: f64,
    pub slope: f64,
}

/// The argument of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineBy {
    Speed,
    SquaredSpeed,
}

impl LineBy {
    /// The argument at a speed.
    pub fn measure(self, speed: f64) -> f64 {
        match self {
            Self::Speed => speed,
            Self::SquaredSpeed => speed * speed,
        }
    }
}

/// Speeds below this part of the highest one are not told from rest.
const NEAR: f64 = 1e-9;

/// Lines whose minimum is below `table`, for speeds from 0 to `most`.
pub(crate) fn lines_below(table: &LimitTable, most: f64, by: LineBy) -> Vec<Line> {
    let knots = falling_knots(table, most);
    let hull = concave_hull(&knots.iter().map(|[x, limit]| [by.measure(*x), *limit]).collect::<Vec<_>>());
    let fraction = least_ratio(&knots, &hull, by);
    let mut lines: Vec<Line> = hull
        .windows(2)
        .map(|pair| {
            let slope = (pair[0][1] - pair[1][1]) / (pair[1][0] - pair[0][0]);
            Line { rest: fraction * (pair[0][1] + slope * pair[0][0]), slope: fraction * slope }
        })
        .collect();
    if lines.is_empty() {
        lines.push(Line { rest: fraction * hull[0][1], slope: 0.0 });
    }
    lines
}

/// Points of a function that falls and is below `table`, from 0 to `most`.
fn falling_knots(table: &LimitTable, most: f64) -> Vec<[f64; 2]> {
    let least = table.least_between(0.0, f64::INFINITY);
    if !(most.is_finite() && most > 0.0) {
        return vec![[0.0, if most > 0.0 { least } else { table.at(0.0) }]];
    }
    // Points that are too near to rest for a slope count at rest.
    let near = NEAR * most;
    let inside = table.points().iter().copied().filter(|[x, _]| *x > near && *x < most);
    let mut low = f64::INFINITY;
    [[0.0, table.least_between(0.0, near)]]
        .into_iter()
        .chain(inside)
        .chain([[most, table.at(most)]])
        .map(|[x, limit]| {
            low = low.min(limit);
            [x, low]
        })
        .collect()
}

/// Corners of the least concave function above points, by their argument.
fn concave_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut hull: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for &point in points {
        while let [.., a, b] = hull[..] {
            // b is on or below the straight line from a to the new point.
            if (b[1] - a[1]) * (point[0] - a[0]) <= (point[1] - a[1]) * (b[0] - a[0]) {
                hull.pop();
            } else {
                break;
            }
        }
        hull.push(point);
    }
    hull
}

/// The least ratio of the function through `knots`, linear in the speed between them, to its hull.
fn least_ratio(knots: &[[f64; 2]], hull: &[[f64; 2]], by: LineBy) -> f64 {
    let mut least: f64 = 1.0;
    let mut corner = 0;
    for pair in knots.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        while corner + 2 < hull.len() && hull[corner + 1][0] <= by.measure(x0) {
            corner += 1;
        }
        let [[h0, g0], [h1, g1]] = [hull[corner], hull[corner + 1]];
        let fall = (g0 - g1) / (h1 - h0);
        let above = |speed: f64| g0 - fall * (by.measure(speed) - h0);
        let slope = (y0 - y1) / (x1 - x0);
        let ratio = |speed: f64| (y0 - slope * (speed - x0)) / above(speed);
        least = least.min(ratio(x0)).min(ratio(x1));
        if by == LineBy::SquaredSpeed && slope > 0.0 && fall > 0.0 {
            // The ratio (a - c w) / (b - d w^2) turns where c d w^2 - 2 a d w + c b = 0.
            let (a, b) = (y0 + slope * x0, g0 + fall * h0);
            let root = (a * a - slope * slope * b / fall).max(0.0).sqrt();
            // The smaller root without cancellation.
            let turns = [slope * b / (fall * (a + root)), (a + root) / slope];
            least = turns.into_iter().filter(|w| x0 < *w && *w < x1).map(ratio).fold(least, f64::min);
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lowest(lines: &[Line], y: f64) -> f64 {
        lines.iter().map(|line| line.rest - line.slope * y).fold(f64::INFINITY, f64::min)
    }

    /// The part of a table that lines leave at their worst place, by dense samples.
    fn kept(table: &LimitTable, most: f64, by: LineBy) -> f64 {
        let lines = lines_below(table, most, by);
        (0..=20_000).fold(f64::INFINITY, |least: f64, i| {
            let speed = most * f64::from(i) / 20_000.0;
            let y = if by == LineBy::Speed { speed } else { speed * speed };
            let (line, limit) = (lowest(&lines, y), table.at(speed));
            assert!(line <= limit * (1.0 + 1e-12), "{line} above {limit} at {speed}: {table:?}");
            least.min(line / limit)
        })
    }

    #[test]
    fn a_concave_table_loses_nothing_by_speed() {
        let table = LimitTable::new(&[[1.0, 8.0], [2.0, 6.0], [3.0, 2.0]]).expect("a table");
        assert!(kept(&table, 3.0, LineBy::Speed) > 1.0 - 1e-12);
        // One line for each piece.
        assert_eq!(lines_below(&table, 3.0, LineBy::Speed).len(), 3);
    }

    #[test]
    fn lines_lie_below_random_tables() {
        let mut seed = 11_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..200 {
            let (mut x, mut points) = (0.0, Vec::new());
            for _ in 0..1 + (5.0 * random()) as usize {
                x += 0.05 + random();
                points.push([x, 0.5 + 5.0 * random()]);
            }
            let table = LimitTable::new(&points).expect("a table");
            let most = 0.1 + 4.0 * random();
            for by in [LineBy::Speed, LineBy::SquaredSpeed] {
                kept(&table, most, by);
            }
        }
    }

    #[test]
    fn what_tables_of_drives_lose() {
        // Constant, then power: the torque of a motor, its hyperbola by five straight lines.
        let power: Vec<[f64; 2]> = (0..=5).map(|i| 1.0 + 0.2 * f64::from(i)).map(|w| [w, 1.0 / w]).collect();
        let power = LimitTable::new(&power).expect("a table");
        let kept_by = |table: &LimitTable, most: f64, by| (1e4 * kept(table, most, by)).round() / 1e4;
        assert_eq!(kept_by(&power, 2.0, LineBy::Speed), 0.8929);
        // Constant, then a straight fall to half: exact by speed.
        let knee = LimitTable::new(&[[1.0, 1.0], [2.0, 0.5]]).expect("a table");
        assert!(kept(&knee, 2.0, LineBy::Speed) > 1.0 - 1e-12);
        // (9 - 3 w) / (7 - w^2) at w = 3 - sqrt(2).
        assert_eq!(kept_by(&knee, 2.0, LineBy::SquaredSpeed), 0.9459);
        // A straight fall to half from the start.
        let fall = LimitTable::new(&[[0.0, 1.0], [2.0, 0.5]]).expect("a table");
        assert_eq!(kept_by(&fall, 2.0, LineBy::SquaredSpeed), 0.8536);
    }
}
