//! `cr7 plan`: from a path file to trajectory, pictures and report.

use std::path::Path;
use std::time::Instant;

use crate::plot::speed_picture;
use crate::{
    ArmPoses, BindingLine, BoundReport, CompiledReport, Cr7Error, Job, Motion, OnToolPath, ProgramReport, ProgramTask,
    ReportHead, Series, Staging, Task, TrajectoryRow, TrajectoryWriter, drawn_segments, few_enough, line_times,
};
use arcfeed_interp::PathArm;

use crate::cli::Failure;
use crate::cli::formats::{self, Format};
use crate::cli::output::conclude;
use crate::cli::page_file::{Meshes, PageFile};
use crate::cli::path_places::{distance_of_places, places_of_path};
use crate::cli::picture_files::Painter;
use crate::cli::plan_args::Args;
use crate::cli::plan_files::{
    COMPILED, Drawn, FILES, LEVERS, LINES, Picture, limit_at, pictures, stream_figure, write_lines,
};
use crate::cli::plan_program;
use crate::cli::progress::Progress;
use crate::cli::ros::RosFiles;
use crate::cli::tool_path::{read_job, read_path};

pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(value) = args.compile_rad.filter(|value| !(value.is_finite() && *value > 0.0)) {
        return Err(Failure::BadInput(format!("--compile-rad {value}: give a number above 0, such as 1e-6")));
    }
    formats::check(&args.format)?;
    let meshes = Meshes::read(args)?;
    let painter = Painter::new(args.format.contains(&Format::Png))?;
    let inputs: Vec<&Path> = [&args.path, &args.job].into_iter().filter_map(|file| file.as_deref()).collect();
    let mut staging = Staging::new(&args.out, &FILES, &inputs)?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let job = read_job(args.job.as_deref())?;
    if args.stream.is_some() && job.whole_cycles {
        let words = "--stream: a motion whose segments arrive on the way does not know its duration: remove sampling.whole_cycles";
        return Err(Failure::BadInput(words.to_owned()));
    }
    if let Some(path) = &job.path_file {
        staging.reads(path)?;
    }
    let file = read_path(args.path.as_deref().or(job.path_file.as_deref()), args.unit.as_deref(), &job)?;

    staging.clear()?;
    let progress = Progress::new("planning");
    if ProgramTask::is_needed(&job, &file) {
        return plan_program::run(args, (&job, &file), (staging, progress), meshes);
    }
    args.robot.load()?.on_tool_path(&job, &file, Plan { args, job: &job, staging, progress, meshes })
}

/// Plans and samples the motion, and writes all there is to write.
struct Plan<'a> {
    args: &'a Args,
    job: &'a Job,
    staging: Staging,
    progress: Progress,
    meshes: Meshes,
}

impl OnToolPath for Plan<'_> {
    type Output = ();
    type Error = Failure;

    fn run<A: PathArm<N>, const N: usize>(self, task: Task<A, N>, warnings: Vec<String>) -> Result<(), Failure> {
        let Self { args, job, mut staging, progress, meshes } = self;
        // A lower bound of the duration, before the work.
        few_enough(task.least_duration(), task.period(), LEVERS)?;
        let path;
        let (mut motion, compiled) = match (args.stream, args.tolerance()) {
            (Some(ahead), _) => {
                path = task.tool_path()?;
                (task.plan_streamed(&path, ahead as usize, args.stream_gap_ms * 1e-3)?, None)
            }
            (None, Some(tolerance)) => {
                let (motion, pieces, certificate) = task.plan_compiled(tolerance)?;
                (motion, Some((tolerance, pieces, certificate)))
            }
            (None, None) => (task.plan()?, None),
        };
        motion.warn(warnings);
        few_enough(motion.trajectory().duration(), motion.trajectory().period(), LEVERS)?;
        let bound = if args.bound {
            progress.step("lower bound");
            Some(lower_bound(&motion)?)
        } else {
            None
        };

        progress.step("sampling and writing");
        let begin = Instant::now();
        let sampler = motion.setpoints().map_err(|e| Failure::Undoable(e.to_string()))?;
        let samples = sampler.samples();
        let mut series = Series::new(3 + 3 * N, samples);
        let (robot, name) = (args.robot.load()?, FILES[0]);
        let (file, names) = (staging.create(name)?, robot.any().joint_names());
        let mut trajectory = TrajectoryWriter::new(file, names).map_err(|e| staging.failed(name, e))?;
        let pieces = compiled.as_ref().map(|(_, pieces, _)| pieces);
        let limits = motion.trajectory().limits();
        let mut ros = RosFiles::new(args, job, &mut staging, pieces, limits.joints())?;
        let mut page = PageFile::new(args, &robot, limits.joints(), limits.torque(), samples, meshes);
        let mut poses = ArmPoses::new(*robot.arm::<N>(job.tool).map_err(Cr7Error::from)?.chain(), samples);
        for setpoint in sampler {
            let p = setpoint.map_err(|e| Failure::Undoable(e.to_string()))?;
            let row = TrajectoryRow::from(&p);
            trajectory.write(&row).map_err(|e| staging.failed(name, e))?;
            ros.write(&row, &staging)?;
            page.push(&row, p.s, p.feed);
            poses.push(&row, p.feed);
            series.push([p.t, p.s, p.feed].into_iter().chain([p.qd, p.qdd, p.jerk].iter().flatten().copied()));
        }
        trajectory.finish().map_err(|e| staging.failed(name, e))?;
        ros.finish(&staging)?;
        series.cut();
        let sampling = begin.elapsed();

        progress.step("drawing");
        let drawn = drawn(&motion, job, &series, poses, &mut page)?;
        let mut report = motion.report(samples, sampling);
        for (name, svg) in path_pictures(&motion, &drawn, &series, &report.binding) {
            staging.write_picture(name, svg)?;
        }
        let compiled = match compiled {
            Some((tolerance, pieces, certificate)) => {
                let names = std::array::from_fn(|k| names.get(k).cloned().unwrap_or_default());
                staging.write(COMPILED, &(pieces.to_json(&names) + "\n"))?;
                Some(CompiledReport::new(tolerance, &pieces, &certificate))
            }
            None => None,
        };
        drop(progress);
        let program = motion.outline().map(|outline| {
            let (t, s) = (series.column(0), series.column(1));
            (line_times(outline, t, s), ProgramReport::new(outline, t, s))
        });
        if let Some((lines, _)) = &program {
            let file = staging.create(LINES)?;
            write_lines(file, lines).map_err(|source| staging.failed(LINES, source))?;
        }
        let remedy = "lower the feed, or give the limits of the job more distance";
        (report.compiled, report.bound, report.program) = (compiled, bound, program.map(|(_, report)| report));
        page.finish(&report, &drawn, &mut staging)?;
        conclude(&ReportHead::new("plan", &robot), report, staging, args.json, remedy)
    }
}

/// How much shorter any motion can be.
fn lower_bound<const N: usize>(motion: &Motion<'_, N>) -> Result<BoundReport, Failure> {
    let bound = motion.trajectory().lower_bound();
    let bound = bound.map_err(|e| Failure::Undoable(format!("--bound, for planners that limit jerk: {e}")))?;
    Ok(BoundReport::new(motion.trajectory().duration(), &bound))
}

/// What the pictures show: path, limits and places.
fn drawn<'m, const N: usize>(
    motion: &'m Motion<'_, N>,
    job: &Job,
    series: &Series,
    poses: ArmPoses<N>,
    page: &mut PageFile<'_, N>,
) -> Result<Drawn<'m, N>, Failure> {
    let plan = motion.trajectory();
    let caps = plan.limit_curve().map_err(|e| Failure::Undoable(e.to_string()))?;
    let limit: Vec<(f64, f64)> = caps.iter().map(|point| (point.s, point.speed)).collect();
    let [t, s] = [0, 1].map(|column| series.column(column));
    page.see_limits(&caps, 0.0);
    let segments = drawn_segments(plan, &job.workpiece);
    let apart = distance_of_places(&segments, plan.path().length());
    Ok(Drawn {
        name: motion.name(),
        segments,
        deviations: plan.segmentation().map_or_else(Vec::new, |segmentation| segmentation.deviations().to_vec()),
        chord_tolerance: plan.chord_tolerance(),
        limit_by_time: t.iter().zip(s).map(|(&t, &s)| (t, limit_at(&limit, s))).collect(),
        places: places_of_path(plan, &job.workpiece, 0.0, apart),
        joints: plan.limits().joints(),
        limit,
        poses,
        workpiece: job.workpiece,
    })
}

/// Pictures of a motion whose time, place, feed and joint rates are the columns of `series`.
fn path_pictures<const N: usize>(
    motion: &Motion<'_, N>,
    drawn: &Drawn<'_, N>,
    series: &Series,
    binding: &[BindingLine],
) -> Vec<Picture> {
    let mut all = pictures(drawn, series, binding);
    if let Some(stream) = motion.stream() {
        let figure = stream_figure(motion.name(), stream, &series.pairs(1, 2), &drawn.limit);
        all.push(("stream.svg", speed_picture(&figure)));
    }
    all
}
