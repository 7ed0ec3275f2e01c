//! Speed along a path under limits that change while it runs: table 3 and figure 5 of Liu et al. 2024, and a live override.
use arcfeed_feedrate::{AxisLimits, AxisState, FeedError, FeedScheduler, FeedStatus, MotionState};

mod common;
mod liu_2024;
use common::{Curve, Panel};

/// Time and state of every cycle.
type Run = Vec<(f64, MotionState)>;

fn table_3() -> Result<Run, FeedError> {
    let (start, end) = (liu_2024::TABLE_3_START, liu_2024::TABLE_3_END);
    let rows = liu_2024::TABLE_3.map(|r| AxisLimits::forward(r.v.1, r.a, r.j).map(|limits| (r.from, limits)));
    let mut feed: Option<FeedScheduler> = None;
    let mut run: Run = Vec::new();
    let (mut t, period) = (0.0, liu_2024::PERIOD);
    let mut rows = rows.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().peekable();
    loop {
        if let Some((_, limits)) = rows.next_if(|row| row.0 <= t + 0.5 * period) {
            match &mut feed {
                Some(feed) => println!("t = {t:.3} s: limits changed, {:?}", feed.set_limits(&limits)?),
                None => feed = Some(FeedScheduler::new(&start, &end, &limits)?),
            }
        }
        let Some(feed) = &mut feed else { return Ok(run) };
        if run.is_empty() {
            run.push((0.0, feed.state()));
        }
        let step = feed.step(period)?;
        if let FeedStatus::Reached { unused } = step.status {
            run.push((t + period - unused, step.state));
            return Ok(run);
        }
        t += period;
        run.push((t, step.state));
    }
}

/// The same way with an operator at the knob: slower, hold, on.
fn live_override() -> Result<Run, FeedError> {
    let row = &liu_2024::TABLE_3[2];
    let full = AxisLimits::forward(row.v.1, row.a, row.j)?;
    let mut feed = FeedScheduler::new(&AxisState::rest(0.0), &liu_2024::TABLE_3_END, &full)?;
    let mut run: Run = Vec::new();
    for cycle in 0..20_000 {
        match cycle {
            2500 => drop(feed.set_limits(&full.with_v_max(0.4 * full.v_max())?)?),
            4500 => drop(feed.set_limits(&full.with_v_max(0.0)?)?),
            6000 => drop(feed.set_limits(&full)?),
            _ => {}
        }
        let step = feed.step(liu_2024::PERIOD)?;
        let unused = if let FeedStatus::Reached { unused } = step.status { unused } else { 0.0 };
        run.push((liu_2024::PERIOD * f64::from(cycle + 1) - unused, step.state));
        if let FeedStatus::Reached { .. } = step.status {
            break;
        }
    }
    Ok(run)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let run = table_3()?;
    let (t, last) = run[run.len() - 1];
    let end = liu_2024::TABLE_3_END;
    println!("{:<14} {:>10} {:>10}", "at the end", "asked for", "reached");
    for (what, asked, ours) in [("s mm", end.p, last.p), ("v mm/s", end.v, last.v), ("a mm/s2", end.a, last.a)] {
        println!("{what:<14} {asked:>10} {ours:>10}");
    }
    println!("arrives at {t:.4} s (the paper's scheme with its formulas corrected: 12.1 s, up to 0.040 mm off)");
    // Jerk as a controller would see it: from cycle to cycle.
    let mut worst = 0.0f64;
    for pair in run.windows(2) {
        let ((t0, a), (t1, b)) = (pair[0], pair[1]);
        let row = liu_2024::TABLE_3.iter().rev().find(|r| r.from <= t0 + 0.5e-3).unwrap_or(&liu_2024::TABLE_3[0]);
        let jerk = (b.a - a.a) / (t1 - t0);
        worst = worst.max(jerk / row.j.1).max(jerk / row.j.0);
    }
    println!("largest jerk in any cycle: {:.4} % of its limit", 100.0 * worst);

    let knob = live_override()?;
    println!("with slow-down, hold and resume: {:.4} s", knob[knob.len() - 1].0);
    let step = 10;
    let curve = |name, colour, run: &Run, f: fn(&MotionState) -> f64| Curve {
        name,
        colour,
        points: run.iter().step_by(step).chain(run.last()).map(|(t, s)| (*t, f(s))).collect(),
    };
    let panel = |label, f: fn(&MotionState) -> f64| Panel {
        label,
        curves: vec![
            curve("table 3", "#1f6fb2", &run, f),
            curve("live override: 100, 40, 0, 100 %", "#d2691e", &knob, f),
        ],
        limits: vec![],
    };
    common::write(
        "feedrate_06_online_feed_rate.svg",
        "Online feed rate: limits that change while the motion runs (Liu et al. 2024, table 3, figure 5)",
        "time in s",
        &[panel("s mm", |s| s.p), panel("v mm/s", |s| s.v), panel("a mm/s2", |s| s.a), panel("j mm/s3", |s| s.j)],
    )?;
    Ok(())
}
