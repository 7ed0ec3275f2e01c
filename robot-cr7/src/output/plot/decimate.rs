//! Thinning of long series without hiding anything: every pixel column keeps its first, least, largest and last value.

/// Thins `points` to at most four a column of width `(x1 - x0) / columns`, in their order, and splits them where a
/// coordinate is not finite.
///
/// Peaks survive with their true height; series with at most four points a column come back as they are.
pub(crate) fn min_max(points: &[(f64, f64)], x0: f64, x1: f64, columns: usize) -> Vec<Vec<(f64, f64)>> {
    let width = (x1 - x0) / columns.max(1) as f64;
    let column = |x: f64| ((x - x0) / width).floor();
    let mut runs = Vec::new();
    for run in points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
        let mut out: Vec<(f64, f64)> = Vec::new();
        let mut rest = run;
        while let Some(first) = rest.first() {
            let n = rest.iter().take_while(|p| column(p.0) == column(first.0)).count().max(1);
            let (group, tail) = rest.split_at(n);
            rest = tail;
            if n <= 4 {
                out.extend_from_slice(group);
                continue;
            }
            let by = |better: fn(f64, f64) -> bool| {
                (1..n).fold(0, |best, i| if better(group[i].1, group[best].1) { i } else { best })
            };
            let mut keep = [0, by(|a, b| a < b), by(|a, b| a > b), n - 1];
            keep.sort_unstable();
            for (k, &i) in keep.iter().enumerate() {
                if k == 0 || keep[k - 1] != i {
                    out.push(group[i]);
                }
            }
        }
        if !out.is_empty() {
            runs.push(out);
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_peak_among_a_hundred_thousand_points_survives() {
        let mut points: Vec<_> = (0..100_000).map(|i| (i as f64 * 1e-5, (i as f64 * 1e-3).sin())).collect();
        points[54_321].1 = 7.0;
        points[12_345].1 = -9.0;
        let runs = min_max(&points, 0.0, 1.0, 800);
        assert_eq!(runs.len(), 1);
        assert!(runs[0].len() <= 4 * 801);
        assert!(runs[0].contains(&points[54_321]) && runs[0].contains(&points[12_345]));
        assert!(runs[0].windows(2).all(|w| w[0].0 < w[1].0));
        assert_eq!((runs[0][0], runs[0][runs[0].len() - 1]), (points[0], points[99_999]));
    }

    #[test]
    fn gaps_split_and_short_series_stay() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0), (4.0, f64::INFINITY)];
        assert_eq!(min_max(&points, 0.0, 4.0, 10), vec![vec![(0.0, 1.0)], vec![(2.0, 3.0), (3.0, 4.0)]]);
        // A range without width must neither loop nor lose the ends.
        assert_eq!(min_max(&points[2..4], 0.0, 0.0, 10)[0], vec![(2.0, 3.0), (3.0, 4.0)]);
        assert!(min_max(&[], 0.0, 1.0, 10).is_empty());
    }
}
