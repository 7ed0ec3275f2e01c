//! Huang, Wong, Cheng 2025, "Quaternion-Based Velocity Scheduling for Robotic Systems" (Electronics
//! 14, 3869).
//!
//! The paper's arm is not published; `data/qb_arm.json` says what stands in its place. Where
//! dynamics matter the rows are fitted, because the stand-in was made from the printed numbers.

pub mod completeness;
pub mod data;
pub mod experiment;
mod figures;
pub mod integration;
pub mod lagrange;
pub mod motion;
pub mod published;
pub mod scan;

use arcfeed_feedrate::FeedPlanner;
use arcfeed_interp::Method;
use arcfeed_kinematics::Joints;

use self::completeness::CompletenessRun;
use self::data::{Data, QbError};
use self::experiment::Experiment;
use self::integration::IntegrationRun;
use self::motion::{Case, FINE, PoseRun, pose_of, scan_difference};
use self::scan::ScanRun;
use super::{Reproduced, Reproduction};
use crate::output::paper_figure::PaperFigure;
use crate::run::stand_in::JERK;

/// The grid of the plans whose violations are shown; the paper does not state its own.
const COARSE: usize = 100;
/// Time between the samples that are judged, and between setpoints, s.
const SAMPLE: f64 = 1e-3;
const TABLE_1: &str = "Table 1: limits of the joints, as planned with";
const PURE: &str = "Table 2, figures 2 to 5: pure orientation (half angles where the paper has them, rad)";
const COMPOSITE: &str = "Table 3, figures 6 to 9: composite motion (arc length, m)";

/// Both motions of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct QbRun {
    /// Pure orientation under the limits of Table 1 without torque.
    pub pure: PoseRun,
    /// The same with torque.
    pub pure_torque: PoseRun,
    /// Composite motion with torque.
    pub composite: PoseRun,
    /// The same with a jerk limit.
    pub jerk: PoseRun,
    /// The published scan, written a second time: pure, composite, on 500 intervals.
    pub scans: [ScanRun; 2],
    /// The speeds of [`published::PublishedScan`] at the same points.
    pub speeds: [Vec<f64>; 2],
    /// The published scan on 100 intervals: pure, composite.
    pub published: [PoseRun; 2],
    /// Numerical integration on 500 intervals: pure, composite.
    pub integration: [IntegrationRun; 2],
    /// Theorem 3 with viscous friction.
    pub completeness: CompletenessRun,
    /// The experiment.
    pub experiment: Experiment,
    /// Limits: velocity, acceleration, torque.
    pub limits: [Joints<6>; 3],
    /// Time to plan the composite motion by the forward-backward scan, s.
    pub planning: f64,
    /// Figures that need the plans themselves.
    figures: Vec<PaperFigure>,
}

impl QbRun {
    /// Plans and samples both motions.
    ///
    /// # Errors
    /// [`QbError`] when the embedded data cannot be planned.
    pub fn measure() -> Result<Self, QbError> {
        let data = Data::load()?;
        let (arm, joints, torque) = data::arm()?;
        let kinematic = Case::new(&arm, &data.po, joints, None)?;
        let case_po = Case::new(&arm, &data.po, joints, Some(torque))?;
        let case_to = Case::new(&arm, &data.to, joints, Some(torque))?;
        let sampled = |case: &Case<'_>, way, method: Method| {
            let (problem, _, law) = case.plan(method, FINE)?;
            PoseRun::sampled(&arm, way, &problem, &law, SAMPLE)
        };
        let certified = Method::InterpolatedReachability;
        let scanned = |case: &Case<'_>| {
            let (_, rows, law) = case.published(FINE)?;
            let scan = ScanRun::measure(&rows);
            let speeds: Vec<f64> = scan.s.iter().map(|&s| law.at_position(s).v).collect();
            Ok::<_, QbError>((scan, speeds))
        };
        let published = |case: &Case<'_>, way| {
            let (problem, _, law) = case.published(COARSE)?;
            PoseRun::sampled(&arm, way, &problem, &law, SAMPLE)
        };
        let integrated = |case: &Case<'_>| {
            let (_, rows, _) = case.plan(Method::ForwardBackward, FINE)?;
            Ok::<_, QbError>(IntegrationRun::measure(&rows)?)
        };
        let composite = sampled(&case_to, &data.to, certified)?;
        let mut jerk = sampled(&case_to, &data.to, Method::JerkLimited)?;
        jerk.jerk = Some(JERK);
        let limits = [*joints.velocity(), *joints.acceleration(), torque];
        let (po_scan, po_speeds) = scanned(&case_po)?;
        let (to_scan, to_speeds) = scanned(&case_to)?;
        let mut figures = figures::of(&case_po, "pure orientation", [2, 3, 4, 5])?;
        figures.extend(figures::of(&case_to, "composite motion", [6, 7, 8, 9])?);
        Ok(Self {
            pure: sampled(&kinematic, &data.po, certified)?,
            pure_torque: sampled(&case_po, &data.po, certified)?,
            published: [published(&case_po, &data.po)?, published(&case_to, &data.to)?],
            integration: [integrated(&case_po)?, integrated(&case_to)?],
            completeness: CompletenessRun::measure()?,
            experiment: Experiment::run(&arm, &composite.q, composite.period, limits)?,
            composite,
            jerk,
            scans: [po_scan, to_scan],
            speeds: [po_speeds, to_speeds],
            limits,
            planning: planning_time(&case_to)?,
            figures,
        })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        let units = ["velocity, rad/s", "acceleration, rad/s^2", "torque, N m"];
        for (what, limits) in units.into_iter().zip(&self.limits) {
            let ours = limits.iter().map(|v| format!("{v}")).collect::<Vec<_>>().join(" ");
            r.information(TABLE_1, what, "as ours", ours);
        }
        self.judge_pure(r);
        self.judge_composite(r);
        self.completeness.judge(r);
        self.experiment.judge(r);
    }

    fn judge_pure(&self, r: &mut Reproduction) {
        self.pure.judge(r, PURE, "without torque");
        let binds = self.pure.velocity_binds(4);
        let (from, to) = binds.unwrap_or((f64::NAN, f64::NAN));
        for (what, printed, full) in [("from", "0.11", from), ("to", "0.54", to)] {
            r.print(PURE, format!("velocity of joint 5 binds {what}"), printed, 0.5 * full)
                .note(format!("{full:.3} rad as a full angle; the paper's s2 = acos(Qc . Qt) is half of it"));
        }
        let share = self.pure.acceleration_binds(4, (from, to));
        r.independent(
            PURE,
            "acceleration of joint 5 binds before and after",
            "yes",
            format!("{share:.3} of the samples"),
            share > 0.95,
        )
        .note("at least 99 % of the limit, from second differences");
        self.pure_torque.judge(r, PURE, "with torque");
        self.judge_scan(r, PURE, 0);
    }

    fn judge_composite(&self, r: &mut Reproduction) {
        let [start, goal] = self.composite.poses.map(|p| pose_of(&p));
        let tool = |q: &Joints<6>| self.composite.links.tool(q);
        let (first, last) = (&self.composite.q[0], &self.composite.q[self.composite.q.len() - 1]);
        let length = (tool(last).translation.vector - tool(first).translation.vector).norm();
        r.print(COMPOSITE, "length between the first and the last tool point, m", "0.86", length);
        let half = 0.5 * tool(first).rotation.angle_to(&tool(last).rotation);
        r.print(COMPOSITE, "half angle between the first and the last orientation, rad", "0.13", half)
            .note(format!("the full angle of the printed poses is {:.4} rad", start.rotation.angle_to(&goal.rotation)));
        self.composite.judge(r, COMPOSITE, "composite");
        self.jerk.judge(r, COMPOSITE, "composite with jerk");
        let clamps = self.scans[1].clamps();
        for (i, printed) in ["0.066 .. 0.32", "0.77 .. 0.84"].into_iter().enumerate() {
            let ours = clamps.get(i).map_or("none".to_owned(), |(a, b)| format!("{a:.3} .. {b:.3}"));
            r.information(COMPOSITE, format!("clamp {} by the initial velocity limit", i + 1), printed, ours)
                .fitted()
                .note("friction and inertia of the stand-in were chosen so that these come out");
        }
        let shares = self.composite.binding();
        for (what, share) in
            [("acceleration of joint 3", shares.0), ("torque of joint 1", shares.1), ("torque of joint 3", shares.2)]
        {
            r.information(
                COMPOSITE,
                format!("{what}, largest share of its limit"),
                "reaches it",
                format!("{share:.4}"),
            )
            .fitted();
        }
        self.judge_scan(r, COMPOSITE, 1);
        r.information(COMPOSITE, "time to plan, forward-backward, ms", "5.63", format!("{:.2}", self.planning * 1e3))
            .note(format!(
                "{COARSE} intervals (the paper states no grid), inverse kinematics and dynamics included; best \
                 of five"
            ));
    }

    fn judge_scan(&self, r: &mut Reproduction, place: &str, index: usize) {
        let off = scan_difference(&self.scans[index], &self.speeds[index]);
        r.independent(
            place,
            "Appendix A by a second program, difference of speed",
            "0",
            format!("{off:.1e}"),
            off < 1e-6,
        )
        .note("as a share of the highest speed, 500 intervals");
        let shares = self.published[index].shares(5);
        let (share, what) =
            [(shares.velocity, "velocity"), (shares.acceleration, "acceleration"), (shares.torque, "torque")]
                .into_iter()
                .fold((0.0, ""), |most, x| if x.0 > most.0 { x } else { most });
        r.information(
            place,
            format!("published scan, N = {COARSE}: largest share of a limit"),
            "at most 1",
            format!("{share:.4}"),
        )
        .note(format!("{what}, from differences of positions: the scan tests one end of each interval"));
        self.integration[index].judge(r, place);
    }

    /// Figures 2 to 9 and 11 to 14.
    pub fn figures(&self) -> Vec<PaperFigure> {
        let mut all = vec![
            figures::scan(2, "pure orientation", &self.scans[0], 0.5),
            figures::scan(6, "composite motion", &self.scans[1], 1.0),
        ];
        all.extend(self.figures.iter().cloned());
        all.push(figures::time_domain(&self.composite));
        all.extend(figures::experiment(&self.experiment));
        all.sort_by(|a, b| a.file.cmp(&b.file));
        all
    }
}

impl PoseRun {
    /// Largest shares: acceleration of joint 3, torque of joints 1 and 3.
    fn binding(&self) -> (f64, f64, f64) {
        let h = self.period;
        let of = |w: &[Joints<6>]| ((w[2][2] - 2.0 * w[1][2] + w[0][2]) / (h * h)).abs() / self.limits.1[2];
        let acceleration = self.q.windows(3).map(of).fold(0.0, f64::max);
        let limit = self.limits.2.unwrap_or_else(|| Joints::repeat(f64::INFINITY));
        let torque = |k: usize| self.torque.iter().map(|t| t[k].abs() / limit[k]).fold(0.0, f64::max);
        (acceleration, torque(0), torque(2))
    }
}

fn planning_time(case: &Case<'_>) -> Result<f64, QbError> {
    let coarse = case.planner.clone().with_intervals(COARSE)?;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let begin = std::time::Instant::now();
        let needs = Method::ForwardBackward.needs();
        Method::ForwardBackward.plan(&coarse.prepare(&case.path, needs)?.rows(needs)?)?;
        best = best.min(begin.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// Tables 1 to 3, and Figures 2 to 9 and 11 to 14.
pub fn huang_2025() -> Reproduced {
    let mut out = Reproduced::new(
        "Huang, Wong, Cheng, Quaternion-Based Velocity Scheduling for Robotic Systems, Electronics 2025, 14, 3869",
    );
    out.take("Tables 1 to 3", QbRun::measure(), QbRun::judge, QbRun::figures);
    out
}
