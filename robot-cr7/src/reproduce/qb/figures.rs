//! Figures 2 to 9 and 11 to 14 of Huang et al. 2025.

use arcfeed_feedrate::SpeedLaw;
use arcfeed_interp::{LimitPoint, Method, PathProblem, PlanError, Setpoint};
use arcfeed_kinematics::Joints;

use super::COARSE;
use super::data::QbError;
use super::experiment::Experiment;
use super::motion::{Case, FINE, PoseRun};
use super::scan::ScanRun;
use crate::output::paper_figure::{Drawing, FigureLine, PanelPlot, PaperFigure};
use crate::output::schedule_figure::{JointFigure, JointPanel, SpeedFigure, binding_bars};

/// Figures 2 and 6: the scan with its curves and clamp points.
pub(super) fn scan(number: u8, name: &str, run: &ScanRun, factor: f64) -> PaperFigure {
    let line =
        |of: &dyn Fn(usize) -> f64| (0..run.s.len()).map(|i| (run.s[i] * factor, of(i) * factor)).collect::<Vec<_>>();
    let top = 1.4 * (0..run.s.len()).map(|i| run.speed(i)).fold(0.0, f64::max);
    let capped = |v: f64| v.min(top);
    let mut marks = Vec::new();
    for (i, (from, to)) in run.clamps().into_iter().enumerate() {
        marks.push((from * factor, format!("p{}", 2 * i + 1)));
        marks.push((to * factor, format!("p{}", 2 * i + 2)));
    }
    let (across, label) = if factor < 1.0 {
        ("rotation s2, half angle [rad]", "speed [rad/s]")
    } else {
        ("arc length s1 [m]", "speed [m/s]")
    };
    let clamps =
        run.clamps().iter().map(|(a, b)| format!("{:.3} to {:.3}", a * factor, b * factor)).collect::<Vec<_>>();
    PaperFigure {
        file: format!("qb_figure_{number:02}_scan.svg"),
        title: format!("Figure {number}: {name}, the scan of the paper"),
        facts: format!("clamped by the initial velocity limit (red): {}", clamps.join(" and ")),
        caption:
            "The paper shows forward curves beta, the backward curve alpha and the clamp points. The scan is written \
                  from its Appendix A; the arm is a stand-in that was fitted, so the places differ where torque limits."
                .to_owned(),
        drawing: Drawing::Panels(vec![PanelPlot {
            across: across.to_owned(),
            label: label.to_owned(),
            lines: vec![
                FigureLine::new("final speed", line(&|i| run.speed(i))),
                FigureLine::new("β, forward", line(&|i| capped(run.forward[i]))),
                FigureLine::new("α, backward", line(&|i| capped(run.backward[i]))),
            ],
            limits: vec![FigureLine::new("", line(&|i| capped(run.initial[i])))],
            marks,
        }]),
    }
}

type Plan<'a> = (PathProblem<'a>, SpeedLaw);

/// The speed of our plan with what binds, and joint velocities, accelerations and torques.
pub(super) fn of(case: &Case<'_>, name: &str, numbers: [u8; 4]) -> Result<Vec<PaperFigure>, QbError> {
    let (problem, _, law) = case.plan(Method::InterpolatedReachability, FINE)?;
    let (published_problem, _, published) = case.published(COARSE)?;
    let planner = case.planner.clone().with_intervals(FINE)?;
    let check = planner.verify(&problem, &law, false)?;
    let factor = if case.path.motion().length() == 0.0 { 0.5 } else { 1.0 };
    let end = case.path.motion().end();
    let curve = |law: &SpeedLaw| {
        let at = |i: i32| end * f64::from(i) / 2000.0;
        (0..=2000).map(|i| (at(i) * factor, law.at_position(at(i)).v * factor)).collect::<Vec<_>>()
    };
    let scaled = |points: Vec<LimitPoint>| points.iter().map(|p| (p.s * factor, p.speed * factor)).collect::<Vec<_>>();
    let duration = arcfeed_feedrate::MotionLaw::duration;
    let title = format!("Figure {}: {name}, what binds", numbers[0]);
    let facts = format!(
        "interpolated-reachability {:.4} s; published scan (N = {COARSE}) {:.4} s, with limits exceeded",
        duration(&law),
        duration(&published)
    );
    let speed = SpeedFigure {
        file: String::new(),
        title: title.clone(),
        facts: facts.clone(),
        x_label: if factor < 1.0 { "rotation s2, half angle [rad]" } else { "arc length s1 [m]" }.to_owned(),
        y_label: if factor < 1.0 { "half angular speed [rad/s]" } else { "speed [m/s]" }.to_owned(),
        speeds: vec![
            ("interpolated-reachability".to_owned(), curve(&law)),
            ("published scan".to_owned(), curve(&published)),
        ],
        initial: scaled(problem.initial_velocity_limit()?),
        ceiling: scaled(problem.maximum_velocity_curve(&law)?),
        bindings: binding_bars(check.bindings(), factor),
    };
    let mut out = vec![PaperFigure {
        file: format!("qb_figure_{:02}_binding.svg", numbers[0]),
        title,
        facts,
        caption: "The paper does not show which limit binds where. The bars below the speeds show it for our plan."
            .to_owned(),
        drawing: Drawing::Speed(speed),
    }];
    let plans: [Plan<'_>; 2] = [(problem, law), (published_problem, published)];
    out.extend(joints(&plans, name, [numbers[1], numbers[2], numbers[3]])?);
    Ok(out)
}

fn joints(plans: &[Plan<'_>; 2], name: &str, numbers: [u8; 3]) -> Result<Vec<PaperFigure>, QbError> {
    let limits = plans[0].0.limits();
    let torque = limits.torque().map_or(Joints::repeat(f64::INFINITY), |torque| *torque.limits());
    let kinds: [(&str, &'static str, Joints<6>); 3] = [
        ("joint velocities", "rad/s", *limits.joints().velocity()),
        ("joint accelerations", "rad/s²", *limits.joints().acceleration()),
        ("joint torques", "N m", torque),
    ];
    let samples = |(problem, law): &Plan<'_>| -> Result<Vec<Setpoint>, QbError> {
        Ok(problem.setpoints(law, 1e-3)?.collect::<Result<Vec<_>, PlanError>>()?)
    };
    let both = [samples(&plans[0])?, samples(&plans[1])?];
    let figure = |kind: usize| {
        let (what, unit, limit) = &kinds[kind];
        let lines = |j: usize| -> Vec<Vec<(f64, f64)>> {
            let value = |p: &Setpoint, problem: &PathProblem<'_>| match kind {
                0 => p.qd[j],
                1 => p.qdd[j],
                _ => problem.torque_at(p).map_or(0.0, |torque| torque[j]),
            };
            both.iter()
                .zip(plans)
                .map(|(points, plan)| points.iter().map(|p| (p.t, value(p, &plan.0))).collect())
                .collect()
        };
        let title = format!("Figure {}: {what}, {name}", numbers[kind]);
        let facts = "setpoints every millisecond; above each panel the peak of our plan and the limit".to_owned();
        PaperFigure {
            file: format!("qb_figure_{:02}.svg", numbers[kind]),
            title: title.clone(),
            facts: facts.clone(),
            caption: format!(
                "The paper shows {what} inside their limits. The arm is a stand-in. The published scan exceeds \
                 limits \
                 between its grid points; our plan does not."
            ),
            drawing: Drawing::Joints(JointFigure {
                file: String::new(),
                title,
                facts,
                unit,
                names: vec!["interpolated-reachability".to_owned(), "published scan".to_owned()],
                joints: (0..6).map(|j| JointPanel { limit: limit[j], lines: lines(j) }).collect(),
            }),
        }
    };
    Ok((0..3).map(figure).collect())
}

/// Figure 11: speed and acceleration along the path over time.
pub(super) fn time_domain(run: &PoseRun) -> PaperFigure {
    let h = run.period;
    let t = |i: usize| h * i as f64;
    let speed = run.s.windows(2).enumerate().map(|(i, w)| (t(i) + 0.5 * h, (w[1] - w[0]) / h)).collect();
    let acceleration =
        run.s.windows(3).enumerate().map(|(i, w)| (t(i + 1), (w[2] - 2.0 * w[1] + w[0]) / (h * h))).collect();
    let panel = |label: &str, points| PanelPlot {
        across: "time t [s]".to_owned(),
        label: label.to_owned(),
        lines: vec![FigureLine::new("ours", points)],
        ..PanelPlot::default()
    };
    PaperFigure {
        file: "qb_figure_11.svg".to_owned(),
        title: "Figure 11: tangential speed and acceleration of the composite motion".to_owned(),
        facts: format!("{:.4} s; from differences of the path parameter", run.duration),
        caption: "The paper shows both in the time domain. The arm is a stand-in, so the duration \
         differs."
            .to_owned(),
        drawing: Drawing::Panels(vec![panel("speed [m/s]", speed), panel("acceleration [m/s²]", acceleration)]),
    }
}

/// Figures 12 to 14: the simulated experiment.
pub(super) fn experiment(run: &Experiment) -> Vec<PaperFigure> {
    let kinds: [(u8, &str, &'static str, &Vec<Joints<6>>); 3] = [
        (12, "joint velocities", "rad/s", &run.velocity),
        (13, "joint accelerations", "rad/s²", &run.acceleration),
        (14, "joint torques", "N m", &run.torque),
    ];
    let figure = |(kind, (number, what, unit, values)): (usize, (u8, &str, &'static str, &Vec<Joints<6>>))| {
        let line = |j: usize| values.iter().enumerate().map(|(i, x)| (run.period * i as f64, x[j])).collect();
        let title = format!("Figure {number}: measured {what}, simulated");
        let facts = "drives with a lag of 8 ms, encoder noise 2e-7 rad, torque noise 0.1 N m, seeded".to_owned();
        PaperFigure {
            file: format!("qb_figure_{number}.svg"),
            title: title.clone(),
            facts: facts.clone(),
            caption: format!(
                "The paper shows {what} measured on a Delta DRV70L. No arm was moved here: the setpoints run on \
                 a drive \
                 model with lag, and the sensors have seeded noise."
            ),
            drawing: Drawing::Joints(JointFigure {
                file: String::new(),
                title,
                facts,
                unit,
                names: vec!["measured".to_owned()],
                joints: (0..6).map(|j| JointPanel { limit: run.limits[kind][j], lines: vec![line(j)] }).collect(),
            }),
        }
    };
    kinds.into_iter().enumerate().map(figure).collect()
}
