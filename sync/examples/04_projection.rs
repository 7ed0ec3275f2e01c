//! Projection on the error: tables 5 and 7 of Liu et al. 2024, figures 9 and 13, with the limits kept.
use std::fmt::Write as _;
use std::time::Instant;

use arcfeed_sync::feedrate::AxisLimits;
use arcfeed_sync::nalgebra::{Isometry3, Quaternion, SVector, UnitQuaternion};
use arcfeed_sync::{
    JointState, PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, ProjectionSync, SyncError,
    symmetric_limits,
};

mod liu_2024;
use liu_2024 as paper;

type V6 = SVector<f64, 6>;
type Run = Vec<(f64, JointState<6>)>;

fn limits() -> Result<[AxisLimits; 6], SyncError> {
    let a = V6::from(paper::TABLE_7_ACCELERATION);
    symmetric_limits(V6::from(paper::TABLE_7_VELOCITY), a, paper::JERK_PER_ACCELERATION * a)
}

fn run(start: &JointState<6>, targets: &[(f64, [f64; 6])], limits: &[AxisLimits; 6]) -> Result<Run, SyncError> {
    let mut sync = ProjectionSync::new(start, V6::from(targets[0].1), limits)?;
    let mut run = vec![(0.0, *start)];
    let (mut cycle, mut next) = (0u32, 1);
    loop {
        let t = paper::PERIOD * f64::from(cycle);
        if next < targets.len() && t >= targets[next].0 - 0.5 * paper::PERIOD {
            sync.set_target(V6::from(targets[next].1))?;
            next += 1;
        }
        let step = sync.step(paper::PERIOD)?;
        cycle += 1;
        let t = t + paper::PERIOD;
        if let ProjectionStatus::Reached { unused } = step.status
            && next == targets.len()
        {
            run.push((t - unused, step.state));
            return Ok(run);
        }
        run.push((t, step.state));
    }
}

/// The largest use of the three limits, and the last time at which one was exceeded.
fn use_of_limits(run: &Run, limits: &[AxisLimits; 6]) -> ([f64; 3], f64) {
    let (mut used, mut last) = ([0.0f64; 3], 0.0);
    for (t, s) in run {
        let bound = |of: fn(&AxisLimits) -> f64| V6::from_fn(|k, _| of(&limits[k]));
        let orders = [
            (&s.qd, bound(AxisLimits::v_max)),
            (&s.qdd, bound(AxisLimits::a_max)),
            (&s.qddd, bound(AxisLimits::j_max)),
        ];
        for (used, (x, bound)) in used.iter_mut().zip(orders) {
            let ratio = x.component_div(&bound).amax();
            *used = used.max(ratio);
            if ratio > 1.0 + 1e-9 {
                last = *t;
            }
        }
    }
    (used, last)
}

fn report(what: &str, run: &Run, limits: &[AxisLimits; 6]) {
    let ((t, end), (used, last)) = (run[run.len() - 1], use_of_limits(run, limits));
    println!("{what}: arrives at {t:.4} s, velocity {:.0e}, acceleration {:.0e}", end.qd.amax(), end.qdd.amax());
    println!("  most of velocity, acceleration, jerk limit: {:.3} {:.3} {:.3}", used[0], used[1], used[2]);
    if last > 0.0 {
        println!("  inside all limits from {last:.3} s on: the start is outside");
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let limits = limits()?;
    let rest = JointState::rest(V6::from(paper::TABLE_5_FROM));
    let five = run(&rest, &[(0.0, paper::TABLE_5_TO)], &limits)?;
    report("table 5, joints", &five, &limits);
    println!("  (the paper's scheme, corrected and with an ideal planner: 2.930 s, above the limits)");

    let [q, qd, qdd] = paper::TABLE_7_START.map(V6::from);
    let start = JointState { q, qd, qdd, qddd: V6::zeros() };
    let began = Instant::now();
    let seven = run(&start, &paper::TABLE_7_TARGETS, &limits)?;
    let each = began.elapsed().as_secs_f64() / seven.len() as f64;
    report("table 7, joints", &seven, &limits);
    println!("  {:.2} us a cycle (paper: under {} ms)", each * 1e6, paper::STATED_TIME * 1e3);
    println!("  acceleration at the end: 0 (paper: \"inability to reduce the acceleration to zero\")");

    pose()?;
    write("sync_04_projection_table_5.svg", "Table 5, figure 9a: six joints on a straight line", &five, &limits)?;
    write("sync_04_projection_table_7.svg", "Table 7, figure 13: targets changed at 0.5, 1 and 2 s", &seven, &limits)?;
    Ok(())
}

/// Table 5 in task space: how far the tool leaves the straight line and the one axis of rotation.
fn pose() -> Result<(), SyncError> {
    let read = |(p, [x, y, z, w]): ([f64; 3], [f64; 4])| {
        Isometry3::from_parts(SVector::from(p).into(), UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
    };
    let (from, to) = (read(paper::TABLE_5_POSE_FROM), read(paper::TABLE_5_POSE_TO));
    let limits = PoseLimits::new(paper::TOOL_LINEAR, paper::TOOL_ANGULAR)?;
    let mut sync = PoseProjectionSync::new(&PoseState::rest(from), to, &limits)?;
    let way = (to.translation.vector - from.translation.vector).normalize();
    let axis = (to.rotation * from.rotation.inverse()).scaled_axis();
    let (mut t, mut off, mut tilt) = (0.0, 0.0f64, 0.0f64);
    loop {
        let step = sync.step(paper::PERIOD)?;
        let moved = step.state.pose.translation.vector - from.translation.vector;
        let turned = (step.state.pose.rotation * from.rotation.inverse()).scaled_axis();
        off = off.max((moved - way * moved.dot(&way)).norm());
        tilt = tilt.max(turned.cross(&axis.normalize()).norm());
        t += paper::PERIOD;
        if let ProjectionStatus::Reached { unused } = step.status {
            println!("table 5, tool: arrives at {:.4} s after a turn of {:.4} rad", t - unused, axis.norm());
            println!("  off the straight line {off:.1e} m, off the axis {tilt:.1e} rad");
            return Ok(());
        }
    }
}

/// Three panels, one colour a joint, each quantity as a part of its limit, so that one pair of lines bounds all.
fn write(name: &str, title: &str, run: &Run, limits: &[AxisLimits; 6]) -> std::io::Result<()> {
    const COLOURS: [&str; 6] = ["#1f6fb2", "#d2691e", "#2e8b57", "#8e44ad", "#b8860b", "#c2185b"];
    let (width, height, left, top) = (960.0, 230.0, 80.0, 60.0);
    let (w, h) = (width - left - 30.0, height - 35.0);
    let end = run[run.len() - 1].0;
    type Quantity = fn(&JointState<6>, &[AxisLimits; 6], usize) -> f64;
    let panels: [(&str, Quantity, bool); 4] = [
        ("q rad", |s, _, k| s.q[k], false),
        ("qd / limit", |s, l, k| s.qd[k] / l[k].v_max(), true),
        ("qdd / limit", |s, l, k| s.qdd[k] / l[k].a_max(), true),
        ("qddd / limit", |s, l, k| s.qddd[k] / l[k].j_max(), true),
    ];
    let total = top + height * panels.len() as f64 + 20.0;
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{width}' height='{total}' font-family='sans-serif' font-size='12'>\
         <rect width='100%' height='100%' fill='white'/><text x='{left}' y='24' font-size='16'>{title}</text>"
    );
    for (k, colour) in COLOURS.iter().enumerate() {
        let x = left + 80.0 * k as f64;
        let _ = write!(svg, "<text x='{x}' y='46' fill='{colour}'>joint {}</text>", k + 1);
    }
    for (i, (label, value, bounded)) in panels.into_iter().enumerate() {
        let y0 = top + height * i as f64;
        let values = || run.iter().flat_map(|(_, s)| (0..6).map(move |k| value(s, limits, k)));
        let (lo, hi) = values().fold((0.0f64, 0.0f64), |(lo, hi), x| (lo.min(x), hi.max(x)));
        let (lo, hi) = if bounded { (lo.min(-1.1), hi.max(1.1)) } else { (lo - 0.5, hi + 0.5) };
        let (px, py) = (|t: f64| left + w * t / end, |y: f64| y0 + h * (hi - y) / (hi - lo));
        let _ = write!(svg, "<rect x='{left}' y='{y0}' width='{w}' height='{h}' fill='#fafafa' stroke='#bbb'/>");
        let _ = write!(svg, "<text x='6' y='{}'>{label}</text>", y0 + 0.5 * h);
        for level in if bounded { vec![-1.0, 0.0, 1.0] } else { vec![0.0] } {
            let dash = if level == 0.0 { "stroke='#ccc'" } else { "stroke='#c0392b' stroke-dasharray='5 4'" };
            let _ = write!(svg, "<line x1='{left}' x2='{}' y1='{1:.1}' y2='{1:.1}' {dash}/>", left + w, py(level));
        }
        for (k, colour) in COLOURS.iter().enumerate() {
            let _ = write!(svg, "<polyline fill='none' stroke='{colour}' stroke-width='1.4' points='");
            for (t, s) in run {
                let _ = write!(svg, "{:.2},{:.2} ", px(*t), py(value(s, limits, k)));
            }
            svg.push_str("'/>");
        }
    }
    let _ = write!(
        svg,
        "<text x='{}' y='{}' text-anchor='end'>time in s (0 .. {end:.3})</text></svg>",
        left + w,
        total - 6.0
    );
    std::fs::create_dir_all("target/pictures")?;
    let path = std::path::Path::new("target/pictures").join(name);
    std::fs::write(&path, svg)?;
    println!("wrote {}", path.display());
    Ok(())
}
