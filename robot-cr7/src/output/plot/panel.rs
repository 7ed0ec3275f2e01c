//! A panel of a page: axes, series, levels.

use std::io;

use plotters::prelude::RGBColor;

use super::canvas::{Anchor, Canvas, FRAME, GRID, INK, LIMIT, Pen};
use super::decimate::min_max;

/// A rectangle with axes: `x` and `y` are the ranges of the data, the other fields pixels.
#[derive(Clone, Copy)]
pub(crate) struct Panel {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub x: (f64, f64),
    pub y: (f64, f64),
}

impl Panel {
    /// Pixel of a data point, taken to the edge of the panel where it lies outside.
    pub fn place(&self, p: (f64, f64)) -> (f64, f64) {
        let fx = ((p.0 - self.x.0) / (self.x.1 - self.x.0)).max(0.0).min(1.0);
        let fy = ((p.1 - self.y.0) / (self.y.1 - self.y.0)).max(0.0).min(1.0);
        (self.left + fx * (self.right - self.left), self.bottom - fy * (self.bottom - self.top))
    }

    /// Grid, frame, tick labels and axis labels; without `x_label` the x axis has no numbers either.
    pub fn axes(&self, canvas: &Canvas<'_>, x_label: Option<&str>, y_label: &str) -> Result<(), io::Error> {
        let grid = Pen::solid(GRID, 1.0);
        let (xs, x_step) = ticks(self.x, ((self.right - self.left) / 110.0) as usize);
        for &x in &xs {
            let (px, _) = self.place((x, self.y.0));
            canvas.line(&[(px, self.top), (px, self.bottom)], grid)?;
            if x_label.is_some() {
                canvas.text(&tick_text(x, x_step), (px, self.bottom + 14.0), Anchor::Middle)?;
            }
        }
        let (ys, y_step) = ticks(self.y, ((self.bottom - self.top) / 44.0).max(4.0) as usize);
        for &y in &ys {
            let (_, py) = self.place((self.x.0, y));
            canvas.line(&[(self.left, py), (self.right, py)], grid)?;
            canvas.text(&tick_text(y, y_step), (self.left - 8.0, py), Anchor::Right)?;
        }
        let (l, r, t, b) = (self.left, self.right, self.top, self.bottom);
        canvas.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], Pen::solid(FRAME, 1.0))?;
        if let Some(label) = x_label {
            canvas.styled(label, (0.5 * (l + r), b + 34.0), 12.5, INK, Anchor::Middle, (false, false))?;
        }
        canvas.styled(y_label, (l - 58.0, 0.5 * (t + b)), 12.5, INK, Anchor::Middle, (false, true))
    }

    /// Grid over x, frame, tick labels and label of x alone, for panels whose rows have names.
    pub fn bare_axes(&self, canvas: &Canvas<'_>, x_label: &str) -> Result<(), io::Error> {
        let (xs, x_step) = ticks(self.x, ((self.right - self.left) / 110.0) as usize);
        for &x in &xs {
            let (px, _) = self.place((x, self.y.0));
            canvas.line(&[(px, self.top), (px, self.bottom)], Pen::solid(GRID, 1.0))?;
            canvas.text(&tick_text(x, x_step), (px, self.bottom + 14.0), Anchor::Middle)?;
        }
        let (l, r, t, b) = (self.left, self.right, self.top, self.bottom);
        canvas.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], Pen::solid(FRAME, 1.0))?;
        canvas.styled(x_label, (0.5 * (l + r), b + 34.0), 12.5, INK, Anchor::Middle, (false, false))
    }

    /// A series over x, thinned to the panel's pixels; it breaks where a value is not finite.
    pub fn series(&self, canvas: &Canvas<'_>, points: &[(f64, f64)], pen: Pen) -> Result<(), io::Error> {
        let columns = (self.right - self.left) as usize;
        for run in min_max(points, self.x.0, self.x.1, columns) {
            for inside in clipped(&run, self.y) {
                let placed: Vec<_> = inside.iter().map(|&p| self.place(p)).collect();
                canvas.line(&placed, pen)?;
            }
        }
        Ok(())
    }

    /// Tints what lies above the series, thinned as in [`Panel::series`].
    pub fn shade_above(&self, canvas: &Canvas<'_>, points: &[(f64, f64)], color: RGBColor) -> Result<(), io::Error> {
        for run in min_max(points, self.x.0, self.x.1, (self.right - self.left) as usize) {
            let mut outline: Vec<_> = run.iter().map(|&p| self.place(p)).collect();
            if let (Some(first), Some(last)) = (outline.first().copied(), outline.last().copied()) {
                outline.extend([(last.0, self.top), (first.0, self.top)]);
                canvas.fill(&outline, color, 0.10)?;
            }
        }
        Ok(())
    }

    /// A horizontal dashed line, left out where it lies outside the range.
    pub fn level(&self, canvas: &Canvas<'_>, y: f64) -> Result<(), io::Error> {
        if !(self.y.0..=self.y.1).contains(&y) {
            return Ok(());
        }
        canvas.line(&[self.place((self.x.0, y)), self.place((self.x.1, y))], Pen::dashed(LIMIT, 1.4))
    }
}

/// The parts of a line inside the band `y`, cut where it crosses an edge.
fn clipped(run: &[(f64, f64)], y: (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let inside = |p: &(f64, f64)| (y.0..=y.1).contains(&p.1);
    if run.iter().all(inside) {
        return vec![run.to_vec()];
    }
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut open: Vec<(f64, f64)> = Vec::new();
    for (i, p) in run.iter().enumerate() {
        if i > 0 {
            let a = run[i - 1];
            let cut = |edge: f64| (a.0 + (p.0 - a.0) * ((edge - a.1) / (p.1 - a.1)), edge);
            let edge = |v: f64| if v < y.0 { y.0 } else { y.1 };
            match (inside(&a), inside(p)) {
                (true, false) => {
                    open.push(cut(edge(p.1)));
                    parts.push(std::mem::take(&mut open));
                }
                (false, true) => open.push(cut(edge(a.1))),
                (false, false) if edge(a.1) != edge(p.1) => parts.push(vec![cut(edge(a.1)), cut(edge(p.1))]),
                _ => {}
            }
        }
        if inside(p) {
            open.push(*p);
        }
    }
    if !open.is_empty() {
        parts.push(open);
    }
    parts
}

/// Least and largest of the finite values, widened to an interval that can be drawn; (0, 1) without any value.
pub(crate) fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.into_iter().filter(|v| v.abs() < 1e100) {
        low = low.min(v);
        high = high.max(v);
    }
    if low > high {
        return (0.0, 1.0);
    }
    // Nothing narrower than the digits of a tick label can be shown.
    let least = 1e-9 * low.abs().max(high.abs());
    if high - low <= least {
        let half = if least > 0.0 { 0.1 * low.abs().max(high.abs()) } else { 1.0 };
        return (low - half, high + half);
    }
    (low, high)
}

/// The range with a margin of `share` of its width at both ends.
pub(crate) fn widened((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let margin = share * (high - low);
    (low - margin, high + margin)
}

/// Multiples of 1, 2, 2.5 or 5 times a power of ten inside the range, about `wanted` of them, and their step.
fn ticks((low, high): (f64, f64), wanted: usize) -> (Vec<f64>, f64) {
    let raw = (high - low) / wanted.max(2) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= raw * 0.999).unwrap_or(raw);
    let first = (low / step - 1e-9).ceil();
    let values = (0..50).map(|i| (first + f64::from(i)) * step).take_while(|&v| v <= high + 1e-9 * step).collect();
    (values, step)
}

fn tick_text(value: f64, step: f64) -> String {
    let value = if value.abs() < 1e-6 * step { 0.0 } else { value };
    if value != 0.0 && !(1e-4..1e7).contains(&step) {
        return format!("{value:e}").chars().take(12).collect();
    }
    let whole = |digits: &usize| {
        let scaled = step * 10f64.powi(*digits as i32);
        (scaled - scaled.round()).abs() < 1e-6
    };
    let digits = (0..6).find(whole).unwrap_or(6);
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        assert_eq!(ticks((0.0, 10.0), 5), (vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0], 2.0));
        let (values, step) = ticks((-0.37, 0.42), 4);
        assert_eq!(step, 0.2);
        let texts: Vec<_> = values.iter().map(|&v| tick_text(v, step)).collect();
        assert_eq!(texts, ["-0.2", "0.0", "0.2", "0.4"]);
        let (values, step) = ticks((-42.0, 42.0), 4);
        assert_eq!((values, step), (vec![-25.0, 0.0, 25.0], 25.0));
        assert_eq!((tick_text(2.5, 2.5), tick_text(0.25, 0.25)), ("2.5".to_owned(), "0.25".to_owned()));
    }

    #[test]
    fn ranges_can_always_be_drawn() {
        for values in [
            vec![],
            vec![f64::NAN, f64::INFINITY],
            vec![3.0],
            vec![0.0, 0.0],
            vec![1e99, 1e99],
            vec![-1e99, 1e99],
            vec![1e15, 1e15 + 0.125],
            vec![5e-324],
        ] {
            let (low, high) = range(values.iter().copied());
            assert!(low < high && (high - low).is_finite(), "{values:?}");
            let (at, step) = ticks((low, high), 5);
            assert!(at.len() <= 50 && at.iter().all(|&v| tick_text(v, step).len() <= 32), "{values:?}: {at:?}");
        }
    }

    #[test]
    fn a_line_is_cut_at_the_edges_of_its_band() {
        let run = [(0.0, 0.5), (1.0, 1.5), (2.0, 1.5), (3.0, 0.5), (4.0, -0.5), (5.0, 1.5)];
        assert_eq!(
            clipped(&run, (0.0, 1.0)),
            vec![
                vec![(0.0, 0.5), (0.5, 1.0)],
                vec![(2.5, 1.0), (3.0, 0.5), (3.5, 0.0)],
                vec![(4.25, 0.0), (4.75, 1.0)]
            ]
        );
    }
}
