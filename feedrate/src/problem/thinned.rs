//! A problem on a part of its grid points, for a first idea of its solution.

use super::feed_problem::FeedProblem;
use crate::constraint::Within;
use crate::row::JerkRow;

impl FeedProblem {
    /// The problem on about every `every`th of its points; both ends and all stops stay, and more points next to them.
    ///
    /// Its solution keeps the rows and caps at the points that stay, and steps of the acceleration anywhere.
    pub(crate) fn thinned(&self, every: usize) -> Self {
        let kept = self.kept_points(every);
        let places = kept.len();
        let mut new = self.emptied(places);
        for &i in &kept {
            new.s.push(self.s[i]);
            new.points.push(self.rows(i), self.x_max(i), self.points.source(i));
        }
        for pair in kept.windows(2) {
            self.join(pair[0], pair[1], &mut new);
        }
        new
    }

    /// The interval from grid point `from` to grid point `to`, at the end of `new`.
    fn join(&self, from: usize, to: usize, new: &mut Self) {
        if to == from + 1 {
            new.middles.push(self.middle_rows(from), self.middle_x_max(from), self.middles.source(from));
            new.speed_bounds.push(self.speed_bounds[from]);
            let rows = 3 * self.jerk_rows_per_place;
            new.jerk_rows.extend_from_slice(&self.jerk_rows[from * rows..to * rows]);
            return;
        }
        let centre = 0.5 * (self.s[from] + self.s[to]);
        let middle = from + self.s[from..=to].partition_point(|&s| s < centre).max(1).min(to - from - 1);
        new.middles.push(self.rows(middle), self.x_max(middle), self.points.source(middle));
        let mut bound = self.speed_bounds[from];
        // The coefficients of a smooth function are about its values.
        for (i, value) in bound.coefficients.iter_mut().enumerate().skip(1) {
            let k = from + i * (to - from) / 4;
            *value =
                if k < to { self.speed_bounds[k].coefficients[0] } else { self.speed_bounds[to - 1].coefficients[4] };
        }
        new.speed_bounds.push(bound);
        let step = |id: usize| (from..to).map(|k| self.jerk_rows(k, Within::Start)[id].step).fold(0.0, f64::max);
        let steps: Vec<f64> = (0..self.jerk_rows_per_place).map(step).collect();
        for rows in [
            self.jerk_rows(from, Within::Start),
            self.jerk_rows(middle, Within::Start),
            self.jerk_rows(to - 1, Within::End),
        ] {
            new.jerk_rows.extend(rows.iter().zip(&steps).map(|(row, &step)| JerkRow { step, ..*row }));
        }
    }

    /// Grid points that stay, increasing.
    fn kept_points(&self, every: usize) -> Vec<usize> {
        let n = self.intervals();
        let mut kept = vec![0];
        let mut last_stop = 0;
        for stop in (1..=n).filter(|&i| i == n || self.x_max(i) == 0.0) {
            let mut i = last_stop;
            while i < stop {
                let apart = (i - last_stop).min(stop - i) / 2;
                i += apart.max(1).min(every);
                kept.push(i);
            }
            last_stop = stop;
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use crate::FeedProblem;
    use crate::constraint::{Feed, Stop, TangentialAcceleration, TangentialJerk, Within};

    /// Ends and stops stay, and points are dense next to them.
    #[test]
    fn a_thinned_problem_has_the_stops_and_all_points_beside_them() {
        let n = 400;
        let grid: Vec<f64> = (0..=n).map(f64::from).collect();
        let feeds = vec![1.0; n as usize];
        let feed = Feed::new(&feeds).expect("positive");
        let (acceleration, jerk) = (TangentialAcceleration::new(1.0), TangentialJerk::new(1.0));
        let (acceleration, jerk) = (acceleration.expect("positive"), jerk.expect("positive"));
        let stop = Stop { at: 250 };
        let problem = FeedProblem::between_points(&grid, &[&feed, &acceleration, &jerk, &stop]).expect("valid");
        let thin = problem.thinned(8);
        assert!(thin.intervals() < 100, "{}", thin.intervals());
        let at = |s: f64| thin.grid().iter().position(|&g| g == s);
        for s in [0.0, 1.0, 249.0, 250.0, 251.0, 399.0, 400.0] {
            assert!(at(s).is_some(), "{s}");
        }
        assert_eq!(thin.x_max(at(250.0).expect("kept")), 0.0);
        assert_eq!((0..thin.intervals()).filter(|&k| thin.x_max(k) == 0.0).count(), 1);
        assert_eq!(thin.jerk_rows(thin.intervals() - 1, Within::End).len(), 1);
    }
}
