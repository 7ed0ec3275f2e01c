//! What was asked of an arm beside what it did.

use std::io;

use super::canvas::{PALETTE, Pen, page};
use super::panel::{Panel, range, widened};
use super::{LEFT, RIGHT, WIDTH};
use crate::controller::SendRow;

/// For each joint the setpoints and the actual positions, and beside them how far the arm was behind.
///
/// # Errors
/// Fails when the drawing library fails.
pub fn sent_picture<const N: usize>(name: &str, facts: &str, rows: &[SendRow<N>]) -> Result<String, io::Error> {
    let (top, pitch, height, gap) = (92.0, 148.0, 104.0, 84.0);
    let half = 0.5 * (RIGHT - LEFT - gap);
    let x = range(rows.iter().map(|row| row.t));
    page(WIDTH, (top + pitch * N as f64 + 24.0) as u32, |canvas| {
        let [sent, actual, error] = [PALETTE[0], PALETTE[1], PALETTE[2]].map(|colour| Pen::solid(colour, 1.5));
        canvas.tall_header(name, facts, &[("sent", sent), ("actual", actual), ("actual - sent", error)])?;
        for k in 0..N {
            let line = |value: fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
                rows.iter().map(|row| (row.t, value(row.sent[k], row.actual[k]).to_degrees())).collect()
            };
            let [asked, done, off] =
                [line(|sent, _| sent), line(|_, actual| actual), line(|sent, actual| actual - sent)];
            let at = top + pitch * k as f64;
            let frame = |left: f64, lines: &[&[(f64, f64)]]| {
                let y = widened(range(lines.iter().flat_map(|line| line.iter()).map(|p| p.1)), 0.08);
                Panel { left, right: left + half, top: at, bottom: at + height, x, y }
            };
            let label = (k + 1 == N).then_some("time t [s]");
            let panel = frame(LEFT, &[&asked, &done]);
            panel.axes(canvas, label, &format!("J{} [deg]", k + 1))?;
            panel.series(canvas, &asked, sent)?;
            panel.series(canvas, &done, actual)?;
            let panel = frame(LEFT + half + gap, &[&off]);
            panel.axes(canvas, label, "behind [deg]")?;
            panel.series(canvas, &off, error)?;
        }
        Ok(())
    })
}
