//! Liu et al. 2024: motion from state to state, online feed rate, projection on the error, and both spaces together.

use std::time::Instant;

use arcfeed_feedrate::{
    AxisLimits, AxisState, FeedError, FeedScheduler, FeedStatus, MotionLaw, MotionState, StateToState,
};
use arcfeed_sync::nalgebra::{Isometry3, Quaternion, SVector, UnitQuaternion};
use arcfeed_sync::{
    JointState, MotionOptions, PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, ProjectionSync, SyncError,
    Synchronisation, Trajectory, symmetric_limits,
};

use super::hs_live::{table_6, table_8};
use super::{Figure, FigureLine, Reproduction};

type V6 = SVector<f64, 6>;
type JointRun = Vec<(f64, JointState<6>)>;

/// Round-off allowed in what a guarantee says, relative.
const SLACK: f64 = 1e-9;

/// The paper's controller samples every 2 ms.
const PERIOD: f64 = 2e-3;

/// Tables 3 to 8 of Liu et al. 2024, "online trajectory generation in task and joint spaces" (Actuators 13, 108), beside ours, and
/// the figures that belong to them (5, 7, 9, 11 to 14; those that are more than lines come from `liu_2024_pictures`).
pub fn liu_2024() -> (Reproduction, Vec<Figure>) {
    let mut r = Reproduction {
        paper:
            "Liu et al. 2024, online trajectory generation for robots in task and joint spaces, Actuators 2024, 13, 108"
                .to_owned(),
        claims: Vec::new(),
    };
    let mut figures = Vec::new();
    // What cannot be run at all is a broken guarantee, too.
    let outcomes = [
        ("Table 3", table_3(&mut r, &mut figures).map_err(|e| e.to_string())),
        ("Table 4", table_4(&mut r, &mut figures).map_err(|e| e.to_string())),
        ("Table 5", table_5(&mut r, &mut figures).map_err(|e| e.to_string())),
        ("Table 6", table_6(&mut r, &mut figures).map_err(|e| e.to_string())),
        ("Table 7", table_7(&mut r, &mut figures).map_err(|e| e.to_string())),
        ("Table 8", table_8(&mut r, &mut figures).map_err(|e| e.to_string())),
    ];
    for (place, outcome) in outcomes {
        if let Err(message) = outcome {
            r.add(place, "could not be run", "", message).guaranteed(false);
        }
    }
    (r, figures)
}

/// Lower and upper.
type Bounds = (f64, f64);

/// What a figure shows of a state.
type Quantity = fn(&MotionState) -> f64;

/// Limits from a time on: speed, acceleration, jerk in mm and s.
const TABLE_3: [(f64, f64, Bounds, Bounds); 3] = [
    (0.0, 5.0, (-12.0, 10.0), (-25.0, 20.0)),
    (3.0, 15.0, (-15.0, 12.0), (-100.0, 90.0)),
    (6.0, 30.0, (-20.0, 30.0), (-80.0, 70.0)),
];

fn table_3(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), FeedError> {
    const PLACE: &str = "Table 3, figure 5: online feed rate, limits changed at 3 and 6 s (mm, s)";
    let end = AxisState::new(200.0, 5.0, 6.0);
    let rows = TABLE_3.map(|(_, v, a, j)| AxisLimits::forward(v, a, j));
    let mut row = 0;
    let mut limits = rows[0]?;
    let mut feed = FeedScheduler::new(&AxisState::new(0.0, -1.0, -10.0), &end, &limits)?;
    let mut run = vec![(0.0, feed.state())];
    // Largest use of acceleration and jerk, the latter as the change of acceleration over a cycle.
    let (mut used_v, mut used_a, mut used_j) = (0.0f64, 0.0f64, 0.0f64);
    let mut cycle = 0u32;
    loop {
        let t = PERIOD * f64::from(cycle);
        if row + 1 < rows.len() && t >= TABLE_3[row + 1].0 - 0.5 * PERIOD {
            row += 1;
            limits = rows[row]?;
            feed.set_limits(&limits)?;
        }
        let before = feed.state();
        let step = feed.step(PERIOD)?;
        let s = step.state;
        let lasted = if let FeedStatus::Reached { unused } = step.status { PERIOD - unused } else { PERIOD };
        let jerk = (s.a - before.a) / lasted;
        used_v = used_v.max(s.v / limits.v_max());
        used_a = used_a.max(s.a / limits.a_max()).max(s.a / limits.a_min());
        used_j = used_j.max(jerk / limits.j_max()).max(jerk / limits.j_min());
        run.push((t + lasted, s));
        cycle += 1;
        if let FeedStatus::Reached { .. } = step.status {
            break;
        }
    }
    let (t, last) = run[run.len() - 1];
    for (what, asked, ours) in
        [("s at the end", end.p, last.p), ("v at the end", end.v, last.v), ("a at the end", end.a, last.a)]
    {
        r.add(PLACE, what, asked.to_string(), ours.to_string()).guaranteed(ours == asked);
    }
    r.add(PLACE, "arrival, s", "", format!("{t:.4}"))
        .note("as printed the scheme runs away; corrected it takes 12.1 s and ends up to 0.040 mm beside S");
    for (what, used) in [("speed", used_v), ("acceleration", used_a), ("jerk, cycle by cycle", used_j)] {
        r.add(PLACE, format!("largest part of the limit on {what}"), "", format!("{used:.9}"))
            .guaranteed(used <= 1.0 + SLACK);
    }
    let quantities: [(&str, &str, &str, Quantity); 4] = [
        ("figure_5_position.svg", "Figure 5: position", "s [mm]", |s| s.p),
        ("figure_5_feed.svg", "Figure 5: feed rate", "v [mm/s]", |s| s.v),
        ("figure_5_acceleration.svg", "Figure 5: acceleration", "a [mm/s²]", |s| s.a),
        ("figure_5_jerk.svg", "Figure 5: jerk", "j [mm/s³]", |s| s.j),
    ];
    for (file, title, label, value) in quantities {
        figures.push(Figure {
            file,
            title,
            facts: format!(
                "limits change at 3 and 6 s; ends exactly at s = {}, v = {}, a = {}",
                last.p, last.v, last.a
            ),
            across: "time t [s]",
            label,
            lines: vec![FigureLine { name: "ours".into(), points: run.iter().map(|(t, s)| (*t, value(s))).collect() }],
        });
    }
    Ok(())
}

/// Position, velocity, acceleration.
type State = (f64, f64, f64);

/// Start and end (position, velocity, acceleration) of each joint, and the printed duration.
const TABLE_4: [(State, State, &str); 6] = [
    ((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), "0.6000"),
    ((-2.0, -4.0, 1.0), (-6.0, 6.0, 2.0), "0.6519"),
    ((3.0, 3.0, -2.0), (10.0, 7.0, -3.0), "0.7756"),
    ((-4.0, -2.0, 3.0), (2.0, -5.0, -1.0), "0.9145"),
    ((5.0, 0.0, 5.0), (0.0, -6.0, 4.0), "0.6290"),
    ((1.0, 3.0, -2.0), (-5.0, -8.0, 0.0), "0.7559"),
];

fn table_4(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), SyncError> {
    const PLACE: &str = "Table 4, figure 7: shortest durations from state to state, s";
    let axes = symmetric_limits(V6::repeat(10.0), V6::repeat(100.0), V6::repeat(1000.0))?;
    let state = |s: State| AxisState::new(s.0, s.1, s.2);
    let (start, end) = (TABLE_4.map(|joint| state(joint.0)), TABLE_4.map(|joint| state(joint.1)));
    let mut alone = Vec::new();
    for (axis, (_, _, printed)) in TABLE_4.into_iter().enumerate() {
        let motion = StateToState::new(&start[axis], &end[axis], &axes[axis])
            .map_err(|source| SyncError::State { axis, source })?;
        let holds = format!("{:.4}", motion.duration()) == printed;
        r.add(PLACE, format!("joint {}", axis + 1), printed, format!("{:.6}", motion.duration())).guaranteed(holds);
        alone.push(motion);
    }
    let together = Trajectory::new(&start, &end, &axes, &MotionOptions::new(Synchronisation::Time))?;
    let longest = alone.iter().map(MotionLaw::duration).fold(0.0, f64::max);
    let common = together.duration();
    r.add(PLACE, "all joints together", "0.9145", format!("{common:.6}"))
        .guaranteed((common - longest).abs() <= SLACK * longest);
    let reached = together.at(common);
    let missed = (0..6).fold(0.0f64, |worst, k| {
        let off = (reached.q[k] - end[k].p).abs().max((reached.qd[k] - end[k].v).abs());
        worst.max(off).max((reached.qdd[k] - end[k].a).abs())
    });
    r.add(PLACE, "largest error of the end state, synchronised", "", format!("{missed:.1e}")).guaranteed(missed == 0.0);

    let velocity = |sample: &dyn Fn(usize, f64) -> f64, end: &dyn Fn(usize) -> f64| {
        (0..6)
            .map(|k| FigureLine {
                name: format!("joint {}", k + 1),
                points: (0..=500).map(|i| end(k) * f64::from(i) / 500.0).map(|t| (t, sample(k, t))).collect(),
            })
            .collect()
    };
    figures.push(Figure {
        file: "figure_7a_velocity.svg",
        title: "Figure 7a: each joint as fast as it can",
        facts: "table 4, limits 10 rad/s, 100 rad/s², 1000 rad/s³".into(),
        across: "time t [s]",
        label: "velocity [rad/s]",
        lines: velocity(&|k, t| alone[k].at(t).v, &|k| alone[k].duration()),
    });
    figures.push(Figure {
        file: "figure_7b_velocity.svg",
        title: "Figure 7b: all joints arrive together",
        facts: format!("table 4, {common:.6} s"),
        across: "time t [s]",
        label: "velocity [rad/s]",
        lines: velocity(&|k, t| together.at(t).qd[k], &|_| common),
    });
    Ok(())
}

/// The limits of table 7. No jerk is printed: ten times the acceleration is taken.
fn joint_limits() -> Result<[AxisLimits; 6], SyncError> {
    let acceleration = V6::from([10.0, 12.0, 14.0, 16.0, 18.0, 20.0]);
    symmetric_limits(V6::from([6.0, 3.0, 4.0, 5.0, 6.0, 7.0]), acceleration, 10.0 * acceleration)
}

/// One motion of the joints under targets that change at given times, and what it used of the limits.
struct Projected {
    run: JointRun,
    /// Largest part of each limit after the first moment at which all can be kept.
    used: [f64; 3],
    /// Time of one cycle, s.
    cycle: f64,
}

fn project(
    start: &JointState<6>,
    targets: &[(f64, [f64; 6])],
    limits: &[AxisLimits; 6],
    kept_from: f64,
) -> Result<Projected, SyncError> {
    let began = Instant::now();
    let mut sync = ProjectionSync::new(start, V6::from(targets[0].1), limits)?;
    let mut run = vec![(0.0, *start)];
    let (mut cycle, mut next) = (0u32, 1);
    loop {
        let t = PERIOD * f64::from(cycle);
        if next < targets.len() && t >= targets[next].0 - 0.5 * PERIOD {
            sync.set_target(V6::from(targets[next].1))?;
            next += 1;
        }
        let step = sync.step(PERIOD)?;
        cycle += 1;
        let reached = if let ProjectionStatus::Reached { unused } = step.status { Some(unused) } else { None };
        run.push((t + PERIOD - reached.unwrap_or(0.0), step.state));
        if reached.is_some() && next == targets.len() {
            break;
        }
    }
    let cycle = began.elapsed().as_secs_f64() / run.len() as f64;
    let mut used = [0.0f64; 3];
    for (_, s) in run.iter().filter(|(t, _)| *t >= kept_from) {
        let bound = |of: fn(&AxisLimits) -> f64| V6::from_fn(|k, _| of(&limits[k]));
        let orders = [
            (&s.qd, bound(AxisLimits::v_max)),
            (&s.qdd, bound(AxisLimits::a_max)),
            (&s.qddd, bound(AxisLimits::j_max)),
        ];
        for (used, (x, bound)) in used.iter_mut().zip(orders) {
            *used = used.max(x.component_div(&bound).amax());
        }
    }
    Ok(Projected { run, used, cycle })
}

fn claims(r: &mut Reproduction, place: &str, motion: &Projected, target: &[f64; 6]) {
    let (t, end) = motion.run[motion.run.len() - 1];
    r.add(place, "arrival, s", "", format!("{t:.4}"));
    r.add(place, "error, velocity, acceleration at the end", "", {
        let off = (end.q - V6::from(*target)).amax();
        format!("{off:.0e}, {:.0e}, {:.0e}", end.qd.amax(), end.qdd.amax())
    })
    .guaranteed(end == JointState::rest(V6::from(*target)));
    for (what, used) in ["velocity", "acceleration", "jerk"].into_iter().zip(motion.used) {
        r.add(place, format!("largest part of the limits on {what}"), "", format!("{used:.9}"))
            .guaranteed(used <= 1.0 + SLACK);
    }
    r.add(place, "time of one cycle, ms", "under 1", format!("{:.5}", motion.cycle * 1e3))
        .guaranteed(motion.cycle < 1e-3);
}

fn joint_figure(
    file: &'static str,
    title: &'static str,
    label: &'static str,
    run: &JointRun,
    q: fn(&JointState<6>) -> &V6,
) -> Figure {
    let lines = (0..6).map(|k| FigureLine {
        name: format!("joint {}", k + 1),
        points: run.iter().map(|(t, s)| (*t, q(s)[k])).collect(),
    });
    let facts = format!("projection on the error, {:.4} s", run[run.len() - 1].0);
    Figure { file, title, facts, across: "time t [s]", label, lines: lines.collect() }
}

fn table_5(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), SyncError> {
    const PLACE: &str = "Table 5, figure 9: projection on the error, from rest, joints and tool";
    const FROM: [f64; 6] = [0.0, -5.0, 3.0, -2.0, 6.0, 0.0];
    const TO: [f64; 6] = [-3.0, 3.0, -5.0, 6.0, 5.0, -6.0];
    let motion = project(&JointState::rest(V6::from(FROM)), &[(0.0, TO)], &joint_limits()?, 0.0)?;
    claims(r, PLACE, &motion, &TO);
    r.add(PLACE, "limits", "none printed", "those of table 7")
        .note("the paper's scheme as printed does not move; corrected it takes 2.930 s and breaks the limits");
    figures.push(joint_figure(
        "figure_9a_position.svg",
        "Figure 9a: joint positions",
        "position [rad]",
        &motion.run,
        |s| &s.q,
    ));
    figures.push(joint_figure(
        "figure_9a_velocity.svg",
        "Figure 9a: joint velocities",
        "velocity [rad/s]",
        &motion.run,
        |s| &s.qd,
    ));

    let pose = |p: [f64; 3], [x, y, z, w]: [f64; 4]| {
        Isometry3::from_parts(SVector::from(p).into(), UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
    };
    let from = pose([0.1463, -0.4679, -0.0066], [1.0, 0.0, 0.0, 0.0]);
    let to = pose([-0.35, -0.35, 0.1], [0.4711, 0.7322, 0.4668, -0.1551]);
    // No limits are printed for the tool.
    let limits = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0])?;
    let mut sync = PoseProjectionSync::new(&PoseState::rest(from), to, &limits)?;
    let way = (to.translation.vector - from.translation.vector).normalize();
    let axis = (to.rotation * from.rotation.inverse()).scaled_axis().normalize();
    let (mut t, mut off, mut tilt) = (0.0, 0.0f64, 0.0f64);
    let mut lines: Vec<FigureLine> =
        ["x", "y", "z"].map(|name| FigureLine { name: name.into(), points: Vec::new() }).into();
    loop {
        let step = sync.step(PERIOD)?;
        let at = step.state.pose;
        let moved = at.translation.vector - from.translation.vector;
        off = off.max((moved - way * moved.dot(&way)).norm());
        tilt = tilt.max((at.rotation * from.rotation.inverse()).scaled_axis().cross(&axis).norm());
        t += PERIOD;
        for (k, line) in lines.iter_mut().enumerate() {
            line.points.push((t, at.translation.vector[k]));
        }
        if let ProjectionStatus::Reached { .. } = step.status {
            r.add(PLACE, "tool at the end", "the target", if at == to { "the target" } else { "beside it" })
                .guaranteed(at == to);
            break;
        }
    }
    r.add(PLACE, "tool off the straight line, m", "", format!("{off:.1e}")).guaranteed(off < 1e-12);
    r.add(PLACE, "tool off one axis of rotation, rad", "", format!("{tilt:.1e}")).guaranteed(tilt < 1e-12);
    figures.push(Figure {
        file: "figure_9b_position.svg",
        title: "Figure 9b: tool position",
        facts: "a straight line, one axis of rotation; limits 0.5 m/s, 1.5 rad/s".into(),
        across: "time t [s]",
        label: "position [m]",
        lines,
    });
    Ok(())
}

fn table_7(r: &mut Reproduction, figures: &mut Vec<Figure>) -> Result<(), SyncError> {
    const PLACE: &str = "Table 7, figure 13: targets changed at 0.5, 1 and 2 s, from a state of motion";
    const TARGETS: [(f64, [f64; 6]); 4] = [
        (0.0, [-3.0, 3.0, -5.0, 6.0, 6.0, -6.0]),
        (0.5, [6.0, 3.0, 2.0, 6.0, -10.0, -6.0]),
        (1.0, [6.0, -5.0, 2.0, 20.0, -10.0, -1.0]),
        (2.0, [5.0, 10.0, -5.0, 3.0, -6.0, 0.0]),
    ];
    let start = JointState {
        q: V6::from([0.0, -5.0, 3.0, -2.0, 6.0, 0.0]),
        qd: V6::from([1.0, 2.0, 0.0, 3.0, -4.0, 0.0]),
        qdd: V6::from([10.0, -15.0, 5.0, 0.0, 1.0, 0.0]),
        qddd: V6::zeros(),
    };
    // Joint 2 starts at -15 rad/s² with a limit of 12 and a jerk of 120.
    let kept_from = 3.0 / 120.0;
    let motion = project(&start, &TARGETS, &joint_limits()?, kept_from)?;
    claims(r, PLACE, &motion, &TARGETS[3].1);
    r.add(PLACE, "limits kept from, s", "", format!("{kept_from}"))
        .note("joint 2 starts beyond its acceleration limit: no motion conforms sooner; jerk is ten times the acceleration (none printed)");
    figures.push(joint_figure(
        "figure_13_position.svg",
        "Figure 13: joint positions",
        "position [rad]",
        &motion.run,
        |s| &s.q,
    ));
    figures.push(joint_figure(
        "figure_13_velocity.svg",
        "Figure 13: joint velocities",
        "velocity [rad/s]",
        &motion.run,
        |s| &s.qd,
    ));
    figures.push(joint_figure(
        "figure_13_acceleration.svg",
        "Figure 13: joint accelerations",
        "acceleration [rad/s²]",
        &motion.run,
        |s| &s.qdd,
    ));
    Ok(())
}
