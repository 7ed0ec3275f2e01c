//! `cr7 plan` on a program in parts: one trajectory, with pictures and report of all of them.

use std::time::Instant;

use crate::{
    ArmPoses, BoundReport, Cr7Error, Job, OnProgram, PartMotion, PathFile, ProgramMotion, ProgramPart, ProgramTask,
    ReportHead, Series, Staging, TrajectoryWriter, drawn_segments, few_enough,
};
use arcfeed_interp::PathArm;

use crate::cli::Failure;
use crate::cli::output::conclude;
use crate::cli::page_file::{Meshes, PageFile};
use crate::cli::path_places::{distance_of_places, places_of_program};
use crate::cli::plan_args::Args;
use crate::cli::plan_files::{COMPILED, Drawn, FILES, LEVERS, LINES, limit_at, pictures, write_lines};
use crate::cli::progress::Progress;
use crate::cli::ros::RosFiles;

pub fn run(
    args: &Args,
    (job, file): (&Job, &PathFile),
    (staging, progress): (Staging, Progress),
    meshes: Meshes,
) -> Result<(), Failure> {
    if args.stream.is_some() {
        return Err(Failure::BadInput(
            "--stream runs one path, and this program has dwells (G4) or rapid moves of the joints between its paths: leave \
             out --stream, or the dwells and feed.rapid = \"joints\""
                .to_owned(),
        ));
    }
    args.robot.load()?.on_program(job, file, PlanProgram { args, job, staging, progress, meshes })
}

/// Plans and samples the motion of a program, and writes all there is to write.
struct PlanProgram<'a> {
    args: &'a Args,
    job: &'a Job,
    staging: Staging,
    progress: Progress,
    meshes: Meshes,
}

impl OnProgram for PlanProgram<'_> {
    type Output = ();
    type Error = Failure;

    fn run<A: PathArm<N> + Clone, const N: usize>(
        self,
        task: ProgramTask<A, N>,
        warnings: Vec<String>,
    ) -> Result<(), Failure> {
        let Self { args, job, mut staging, progress, meshes } = self;
        few_enough(task.least_duration(), task.period(), LEVERS)?;
        let (mut motion, compiled) = match args.tolerance() {
            None => (task.plan()?, None),
            Some(tolerance) => {
                let (motion, compiled) = task.plan_compiled(tolerance)?;
                (motion, Some((tolerance, compiled)))
            }
        };
        motion.warn(warnings);
        few_enough(motion.duration(), motion.period(), LEVERS)?;
        let bound = if args.bound {
            progress.step("lower bound");
            Some(lower_bound(&motion)?)
        } else {
            None
        };

        progress.step("sampling and writing");
        let begin = Instant::now();
        let sampler = motion.samples().map_err(|e| Failure::Undoable(e.to_string()))?;
        let samples = sampler.len();
        let mut series = Series::new(3 + 3 * N, samples);
        let mut check = motion.check();
        let (robot, name) = (args.robot.load()?, FILES[0]);
        let (file, names) = (staging.create(name)?, robot.any().joint_names());
        let mut trajectory = TrajectoryWriter::new(file, names).map_err(|e| staging.failed(name, e))?;
        let pieces = compiled.as_ref().map(|(_, compiled)| &compiled.joints);
        let mut ros = RosFiles::new(args, job, &mut staging, pieces, motion.joint_limits())?;
        let torque = motion.parts().iter().find_map(|part| part.trajectory()?.limits().torque());
        let mut page = PageFile::new(args, &robot, motion.joint_limits(), torque, samples, meshes);
        let mut poses = ArmPoses::new(*robot.arm::<N>(job.tool).map_err(Cr7Error::from)?.chain(), samples);
        for sample in sampler {
            let sample = sample.map_err(|e| Failure::Undoable(e.to_string()))?;
            let row = sample.row;
            trajectory.write(&row).map_err(|e| staging.failed(name, e))?;
            ros.write(&row, &staging)?;
            page.push(&row, sample.s, sample.feed);
            poses.push(&row, sample.feed);
            check.see(&row);
            let rates = [row.qd, row.qdd, row.jerk];
            series.push([row.t, sample.s, sample.feed].into_iter().chain(rates.iter().flatten().copied()));
        }
        trajectory.finish().map_err(|e| staging.failed(name, e))?;
        ros.finish(&staging)?;
        series.cut();
        let sampling = begin.elapsed();
        let check = check.finish(job.feed.end_speeds[1] == 0.0);

        progress.step("drawing");
        let drawn = drawn(&motion, job, &series, poses, &mut page)?;
        let mut report = motion.report(&check, samples, sampling);
        for (name, svg) in pictures(&drawn, &series, &report.binding) {
            staging.write_picture(name, svg)?;
        }
        let file = staging.create(LINES)?;
        write_lines(file, &motion.line_times()).map_err(|source| staging.failed(LINES, source))?;
        if let Some((tolerance, compiled)) = &compiled {
            let names = std::array::from_fn(|k| names.get(k).cloned().unwrap_or_default());
            staging.write(COMPILED, &(compiled.joints.to_json(&names) + "\n"))?;
            report.compiled = Some(motion.compiled_report(*tolerance, compiled));
        }
        drop(progress);
        report.bound = bound;
        page.finish(&report, &drawn, &mut staging)?;
        let remedy = "lower the feed, or give the limits of the job more distance";
        conclude(&ReportHead::new("plan", &robot), report, staging, args.json, remedy)
    }
}

/// The bounds of all parts together.
fn lower_bound<const N: usize>(motion: &ProgramMotion<'_, N>) -> Result<BoundReport, Failure> {
    let moving = motion.parts().iter().filter_map(ProgramPart::trajectory);
    let bounds = moving.map(|trajectory| trajectory.lower_bound()).collect::<Result<Vec<_>, _>>();
    let bounds = bounds.map_err(|e| Failure::Undoable(format!("--bound, for planners that limit jerk: {e}")))?;
    let rests = motion.parts().iter().filter(|part| part.trajectory().is_none());
    Ok(BoundReport::of_parts(motion.duration(), rests.map(ProgramPart::duration).sum(), &bounds))
}

/// What the pictures show: the segments and limits of all paths, and no limit on the speed of the tool in joint moves.
fn drawn<'m, const N: usize>(
    motion: &'m ProgramMotion<'_, N>,
    job: &Job,
    series: &Series,
    poses: ArmPoses<N>,
    page: &mut PageFile<'_, N>,
) -> Result<Drawn<'m, N>, Failure> {
    let (mut segments, mut deviations, mut chord_tolerance) = (Vec::new(), Vec::new(), 0.0f64);
    let mut limit = Vec::new();
    // The limits of each part by its end.
    let mut limits: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
    for part in motion.parts() {
        let own = match part.motion() {
            PartMotion::Path(path) => {
                let plan = path.trajectory();
                segments.extend(drawn_segments(plan, &job.workpiece));
                deviations.extend(plan.segmentation().into_iter().flat_map(|s| s.deviations().iter().copied()));
                chord_tolerance = chord_tolerance.max(plan.chord_tolerance());
                let caps = plan.limit_curve().map_err(|e| Failure::Undoable(e.to_string()))?;
                page.see_limits(&caps, part.from());
                caps.iter().map(|point| (part.from() + point.s, point.speed)).collect()
            }
            PartMotion::Joints(_) => [part.from(), part.from() + part.length()].map(|s| (s, f64::INFINITY)).to_vec(),
            PartMotion::Dwell(_) => Vec::new(),
        };
        limit.extend_from_slice(&own);
        limits.push((part.end(), own));
    }
    let [t, s] = [0, 1].map(|column| series.column(column));
    let at = |(&t, &s): (&f64, &f64)| {
        let own = limits.get(limits.partition_point(|(end, _)| *end < t)).map_or(&[] as &[_], |(_, own)| own);
        let free = own.len() < 2 || own.iter().any(|(_, speed)| speed.is_infinite());
        (t, if free { f64::INFINITY } else { limit_at(own, s) })
    };
    let apart = distance_of_places(&segments, motion.length());
    let places = places_of_program(motion, &job.workpiece, apart);
    let places = places.map_err(|e| Failure::Undoable(e.to_string()))?;
    Ok(Drawn {
        name: motion.name(),
        segments,
        deviations,
        chord_tolerance,
        limit_by_time: t.iter().zip(s).map(at).collect(),
        limit,
        poses,
        workpiece: job.workpiece,
        places,
        joints: motion.joint_limits(),
    })
}
