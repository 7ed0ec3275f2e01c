//! Samples of a motion for pictures, in bounded memory however long the motion is.

/// Rows that are kept at the most, far more than a picture has columns of pixels.
const MOST_ROWS: usize = 40_000;

/// Columns of numbers, sample by sample.
///
/// A short series keeps every sample. A long one keeps two rows of each run of samples, with the least and with the greatest
/// value of every column: no peak is lost, and a column that increases, such as time, keeps the first and the last.
/// A value that is not a number makes both rows of its run so.
#[derive(Debug, Clone)]
pub struct Series {
    columns: Vec<Vec<f64>>,
    /// Samples in a run.
    run: usize,
    /// Samples in the present run, with their least and greatest values.
    seen: usize,
    least: Vec<f64>,
    greatest: Vec<f64>,
}

impl Series {
    /// For `columns` numbers a sample, and about `samples` of them.
    pub fn new(columns: usize, samples: usize) -> Self {
        Self::with_rows(columns, samples, MOST_ROWS)
    }

    /// The same with at most about `most` rows, which are two or more.
    pub(crate) fn with_rows(columns: usize, samples: usize, most: usize) -> Self {
        let run = if samples <= most { 1 } else { samples.div_ceil(most / 2) };
        let rows = samples.min(most);
        Self {
            columns: (0..columns).map(|_| Vec::with_capacity(rows)).collect(),
            run,
            seen: 0,
            least: vec![0.0; columns],
            greatest: vec![0.0; columns],
        }
    }

    /// The next sample, one value a column.
    pub fn push(&mut self, values: impl IntoIterator<Item = f64>) {
        let first = self.seen == 0;
        for ((least, greatest), value) in self.least.iter_mut().zip(&mut self.greatest).zip(values) {
            if first || value.is_nan() {
                (*least, *greatest) = (value, value);
            } else if !least.is_nan() {
                (*least, *greatest) = (least.min(value), greatest.max(value));
            }
        }
        self.seen += 1;
        if self.seen == self.run {
            self.cut();
        }
    }

    /// Ends a run early: what follows, such as samples under other limits, shares no row with what came before.
    pub fn cut(&mut self) {
        let rows: &[&Vec<f64>] = match self.seen {
            0 => &[],
            1 => &[&self.least],
            _ => &[&self.least, &self.greatest],
        };
        for row in rows {
            for (column, value) in self.columns.iter_mut().zip(row.iter()) {
                column.push(*value);
            }
        }
        self.seen = 0;
    }

    /// The values of one column, as many in each. A run that has not ended is not among them: see [`Series::cut`].
    pub fn column(&self, index: usize) -> &[f64] {
        self.columns.get(index).map_or(&[], Vec::as_slice)
    }

    /// The points of column `y` over column `x`.
    pub fn pairs(&self, x: usize, y: usize) -> Vec<(f64, f64)> {
        self.column(x).iter().copied().zip(self.column(y).iter().copied()).collect()
    }

    /// Number of rows kept.
    pub fn len(&self) -> usize {
        self.column(0).len()
    }

    /// True if no row is kept.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_series_keeps_every_sample() {
        let mut series = Series::new(2, 3);
        for i in 0..3 {
            series.push([f64::from(i), -f64::from(i)]);
        }
        series.cut();
        assert_eq!((series.column(0), series.column(1)), ([0.0, 1.0, 2.0].as_slice(), [0.0, -1.0, -2.0].as_slice()));
    }

    #[test]
    fn a_long_series_is_bounded_and_loses_no_peak_and_no_gap() {
        let samples = 3_000_001;
        let mut series = Series::new(3, samples);
        for i in 0..samples {
            let peak = if i == 1_234_567 { 9.0 } else { (i as f64 * 1e-3).sin() };
            series.push([i as f64, peak, if i == 2_000_000 { f64::NAN } else { 0.0 }]);
        }
        series.cut();
        assert!(series.len() <= MOST_ROWS + 2, "{}", series.len());
        let (t, v) = (series.column(0), series.column(1));
        assert_eq!((t[0], t[t.len() - 1]), (0.0, (samples - 1) as f64));
        assert!(t.windows(2).all(|w| w[0] <= w[1]));
        let at = v.iter().position(|v| *v == 9.0).expect("the peak is there");
        assert!((t[at] - 1_234_567.0).abs() < 200.0, "{}", t[at]);
        assert!((v.iter().fold(0.0, |a: f64, v| a.min(*v)) + 1.0).abs() < 1e-6);
        assert_eq!(series.column(2).iter().filter(|v| v.is_nan()).count(), 2);
    }
}
