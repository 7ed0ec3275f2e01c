//! The search for frames of the workpiece in which an arm reaches a whole path.

use std::f64::consts::TAU;
use std::fmt;

use arcfeed_geometry::PosePath;
use arcfeed_kinematics::{
    AnalyticInverse, ForwardKinematics, InverseKinematics, JointRange, Joints, smallest_singular_value,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::Serialize;

use super::error::Cr7Error;
use super::placed_path::PlacedPath;
use crate::input::job::Job;
use crate::input::path_file::PathFile;
use crate::text::{WIDTH, clip};

/// Poses along the path by which most frames are sorted out, those that rank the others, and those that a frame which is
/// handed out was checked at.
const FEW: usize = 8;
const SOME: usize = 64;
const MANY: usize = 2000;
/// Distance of the frames of the first search, m.
const GRID: f64 = 0.1;
/// Steps of the first search each way: an arm or a tool that is longer has a coarser one.
const MOST_STEPS: f64 = 20.0;
/// Turns of the workpiece about its z axis in the first search.
const TURNS: i32 = 8;
/// Steps of the search around the best frames, m; with each goes a turn of so many radians for a metre.
const STEPS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
const TURN_PER_METRE: f64 = 5.0;
/// Frames that are handed out are at least this far apart, m.
const APART: f64 = 0.15;
/// Frames that the second search starts from, for each that is handed out.
const STARTS: usize = 3;
/// Largest step of a joint between two of the few poses, and between two of the others, rad.
const JUMPS: [f64; 2] = [2.5, 1.0];
/// Smallest singular value of a frame that is handed out: the arm's own bound is a tenth of it.
const LEAST_SINGULAR_VALUE: f64 = 0.01;
/// Distances by which a frame is moved to see how far it can be, m.
const MOVES: [f64; 9] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3];

/// What a search for frames may change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementSearch {
    /// Height of the workpiece frame in the base frame, m; `None` leaves it free, with the path above the plane z = 0 of the base.
    pub height: Option<f64>,
    /// Whether the workpiece may be turned about its own z axis.
    pub turn: bool,
    /// Largest number of frames.
    pub count: usize,
}

/// A frame of the workpiece in which the whole path is in reach.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Placement {
    /// Its origin in the base frame, m.
    pub position_m: [f64; 3],
    /// Its rotation in the base frame: roll, pitch, yaw in rad.
    pub rotation_rpy_rad: [f64; 3],
    /// The posture of the arm at the start, where its solutions have names.
    pub configuration: Option<String>,
    /// Least of the smallest singular values of the Jacobian along the path (m and rad).
    pub smallest_singular_value: f64,
    /// Least distance of a joint from the end of its range along the path, rad.
    pub range_left_rad: f64,
    /// Largest of some distances up to 0.3 m by which the frame can be moved along each axis either way, in the same configuration, m.
    pub movable_m: f64,
}

/// Frames of the workpiece for one path and one arm, the best first. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Placements {
    /// Name of the path.
    pub name: String,
    /// Length of the path, m.
    pub length_m: f64,
    /// Number of frames that were looked at.
    pub looked_at: usize,
    /// The frames.
    pub frames: Vec<Placement>,
    /// What was assumed about the path.
    pub warnings: Vec<String>,
}

/// How well an arm follows a path.
#[derive(Debug, Clone, Copy)]
struct Quality {
    singular_value: f64,
    /// rad.
    range_left: f64,
}

impl Quality {
    /// One number to rank by, as a path chooses its configuration.
    fn rank(&self) -> f64 {
        self.singular_value.min(0.1 * self.range_left)
    }
}

/// A frame under trial: position of the middle of the path, m, and turn of the workpiece about its z axis, rad.
#[derive(Debug, Clone, Copy)]
struct Trial {
    at: Vector3<f64>,
    turn: f64,
}

/// A path and an arm, and what all frames share.
struct Searcher<'a, A> {
    arm: &'a A,
    range: &'a JointRange<6>,
    path: PosePath,
    /// The frame that the path was placed in.
    placed: Isometry3<f64>,
    /// Middle of the box around the path in the workpiece frame, m.
    middle: Vector3<f64>,
    /// Height of the workpiece frame, m.
    height: Option<f64>,
    few: Vec<Isometry3<f64>>,
    some: Vec<Isometry3<f64>>,
    looked_at: usize,
}

impl Placements {
    /// Searches the reach of an arm of six joints, tool included, for frames of the path of `file`. `tell` hears of the share
    /// of the first search that is done.
    ///
    /// # Errors
    /// [`Cr7Error`] where the path cannot be made.
    pub fn search<A>(
        job: &Job,
        file: &PathFile,
        (arm, reach): (&A, f64),
        range: &JointRange<6>,
        search: &PlacementSearch,
        mut tell: impl FnMut(f64),
    ) -> Result<Self, Cr7Error>
    where
        A: ForwardKinematics<6> + InverseKinematics<6> + AnalyticInverse<6>,
    {
        let placed = PlacedPath::new(job, file)?;
        let warnings = [file.warnings.as_slice(), &job.warnings, placed.own_warnings()].concat();
        let mut searcher = Searcher::new(arm, range, placed.path, (job.workpiece, search.height));
        let found = searcher.grid(reach, search, &mut tell);
        let mut frames: Vec<(Trial, Placement)> = Vec::new();
        for (start, _) in found.iter().take(STARTS * search.count) {
            if frames.len() == search.count {
                break;
            }
            let trial = searcher.climb(*start, search);
            let near = |other: &Trial| (other.at - trial.at).norm() < APART;
            if frames.iter().any(|(other, _)| near(other)) {
                continue;
            }
            frames.extend(searcher.placement(&trial).map(|placement| (trial, placement)));
        }
        let mut frames: Vec<Placement> = frames.into_iter().map(|(_, placement)| placement).collect();
        frames.sort_by(|a, b| b.rank().total_cmp(&a.rank()));
        let (length_m, looked_at) = (searcher.path.length(), searcher.looked_at);
        Ok(Self { name: file.name.clone(), length_m, looked_at, frames, warnings })
    }
}

/// A value for people, in millionths of mm or degrees; none is minus zero.
fn tidy(v: f64) -> f64 {
    (v * 1e6).round() / 1e6 + 0.0
}

impl Placement {
    /// Its origin in mm, as jobs have it.
    fn position_mm(&self) -> [f64; 3] {
        self.position_m.map(|v| tidy(v * 1e3))
    }

    /// Roll, pitch, yaw in deg, as jobs have them.
    fn rotation_deg(&self) -> [f64; 3] {
        self.rotation_rpy_rad.map(|v| tidy(v.to_degrees()))
    }

    fn rank(&self) -> f64 {
        self.smallest_singular_value.min(0.1 * self.range_left_rad)
    }
}

impl<'a, A> Searcher<'a, A>
where
    A: ForwardKinematics<6> + InverseKinematics<6> + AnalyticInverse<6>,
{
    fn new(
        arm: &'a A,
        range: &'a JointRange<6>,
        path: PosePath,
        (placed, height): (Isometry3<f64>, Option<f64>),
    ) -> Self {
        let poses = |count: usize| -> Vec<Isometry3<f64>> { poses(&path, &placed, count).collect() };
        let (few, some) = (poses(FEW), poses(SOME));
        let corner = |pick: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| {
            some.iter().map(|pose| pose.translation.vector).reduce(|a, b| pick(&a, &b)).unwrap_or_default()
        };
        let middle = (corner(Vector3::inf) + corner(Vector3::sup)) / 2.0;
        Self { arm, range, path, placed, middle, height, few, some, looked_at: 0 }
    }

    /// The workpiece frame of a trial: the job's rotation, turned about its own z axis.
    fn frame(&self, trial: &Trial) -> Isometry3<f64> {
        let rotation = self.placed.rotation * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), trial.turn);
        let mut at = trial.at - rotation * self.middle;
        at.z = self.height.unwrap_or(at.z);
        Isometry3::from_parts(Translation3::from(at), rotation)
    }

    /// The frames on a grid over the reach of the arm in which the path is followed, the best first.
    fn grid(&mut self, reach: f64, search: &PlacementSearch, tell: &mut impl FnMut(f64)) -> Vec<(Trial, f64)> {
        let grid = GRID.max(reach / MOST_STEPS);
        let count = (reach / grid).ceil().min(MOST_STEPS) as i32;
        let levels = if self.height.is_some() { 0..=0 } else { -count..=count };
        let turns = if search.turn { TURNS } else { 1 };
        let mut found = Vec::new();
        for (done, x) in (-count..=count).enumerate() {
            tell(done as f64 / f64::from(2 * count + 1));
            for y in -count..=count {
                for z in levels.clone() {
                    let at = Vector3::from([x, y, z].map(|k| f64::from(k) * grid));
                    for turn in 0..turns {
                        let turn = f64::from(turn) * TAU / f64::from(TURNS);
                        let trial = Trial { at, turn };
                        found.extend(self.rank(&trial).map(|rank| (trial, rank)));
                    }
                }
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// How well a frame does on some poses; `None` where the path is not followed.
    fn rank(&mut self, trial: &Trial) -> Option<f64> {
        self.looked_at += 1;
        let frame = self.frame(trial);
        // A free height does not lead below the base.
        if self.height.is_none() && self.some.iter().any(|pose| (frame * pose).translation.vector.z < 0.0) {
            return None;
        }
        self.best(&frame, &self.few, JUMPS[0])?;
        self.best(&frame, &self.some, JUMPS[1]).map(|(quality, _)| quality.rank())
    }

    /// The best frame that small steps lead to.
    fn climb(&mut self, start: Trial, search: &PlacementSearch) -> Trial {
        let (mut best, mut rank) = (start, self.rank(&start).unwrap_or(0.0));
        for step in STEPS {
            let mut moved = true;
            while moved {
                moved = false;
                for trial in neighbours(&best, step, search) {
                    if let Some(other) = self.rank(&trial).filter(|other| *other > rank + 1e-6) {
                        (best, rank, moved) = (trial, other, true);
                    }
                }
            }
        }
        best
    }

    /// The frame of a trial in whole millimetres and degrees, checked at many places of the path.
    fn placement(&self, trial: &Trial) -> Option<Placement> {
        let frame = self.frame(&Trial { turn: trial.turn.to_degrees().round().to_radians(), ..*trial });
        let mut at = frame.translation.vector.map(|v| (v * 1e3).round() / 1e3 + 0.0);
        at.z = self.height.unwrap_or(at.z);
        let frame = Isometry3::from_parts(Translation3::from(at), frame.rotation);
        let many: Vec<_> = poses(&self.path, &self.placed, MANY).collect();
        let (quality, start) = self.best(&frame, &many, JUMPS[1])?;
        if quality.singular_value < LEAST_SINGULAR_VALUE {
            return None;
        }
        let posture = self.arm.posture(&start);
        let stays = |by: f64| {
            let ways = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| [axis * by, axis * -by]);
            ways.concat().iter().all(|way| {
                let moved = Isometry3::from_parts(Translation3::from(at + way), frame.rotation);
                let found = self.best_of(&moved, &self.some, JUMPS[1], |q| self.arm.posture(q) == posture);
                found.is_some_and(|(quality, _)| quality.singular_value > LEAST_SINGULAR_VALUE)
            })
        };
        let movable = MOVES.into_iter().take_while(|by| stays(*by)).last().unwrap_or(0.0);
        let (roll, pitch, yaw) = frame.rotation.euler_angles();
        Some(Placement {
            position_m: at.into(),
            rotation_rpy_rad: [roll, pitch, yaw].map(|v| tidy(v.to_degrees()).to_radians()),
            configuration: posture.map(|posture| posture.to_string()),
            smallest_singular_value: quality.singular_value,
            range_left_rad: quality.range_left,
            movable_m: movable,
        })
    }

    /// The best of all configurations at the first pose, with its joints there.
    fn best(&self, frame: &Isometry3<f64>, poses: &[Isometry3<f64>], jump: f64) -> Option<(Quality, Joints<6>)> {
        self.best_of(frame, poses, jump, |_| true)
    }

    /// The best of those configurations at the first pose that `keep` accepts.
    fn best_of(
        &self,
        frame: &Isometry3<f64>,
        poses: &[Isometry3<f64>],
        jump: f64,
        keep: impl Fn(&Joints<6>) -> bool,
    ) -> Option<(Quality, Joints<6>)> {
        let first = frame * poses.first()?;
        let starts = self.arm.inverse_all(&first).ok()?;
        let middle = (self.range.lower() + self.range.upper()) / 2.0;
        let near_middle = |q: &Joints<6>| q.zip_map(&middle, |q, m| q + ((m - q) / TAU).round() * TAU);
        let followed = starts.iter().filter(|q| keep(q)).filter_map(|q| {
            let start = near_middle(q);
            self.follow(frame, poses, &start, jump).map(|quality| (quality, start))
        });
        followed.max_by(|a, b| a.0.rank().total_cmp(&b.0.rank()))
    }

    /// How well the path is followed from `start`; `None` where it cannot be.
    fn follow(
        &self,
        frame: &Isometry3<f64>,
        poses: &[Isometry3<f64>],
        start: &Joints<6>,
        jump: f64,
    ) -> Option<Quality> {
        let mut quality = Quality { singular_value: f64::INFINITY, range_left: f64::INFINITY };
        let mut last = *start;
        for pose in poses {
            let q = self.arm.inverse(&(frame * pose), &last).ok()?;
            if (q - last).amax() > jump {
                return None;
            }
            let left = (q - self.range.lower()).zip_map(&(self.range.upper() - q), f64::min).min();
            quality.range_left = quality.range_left.min(left);
            quality.singular_value = quality.singular_value.min(smallest_singular_value(&self.arm.jacobian(&q)));
            last = q;
        }
        Some(quality)
    }
}

/// Poses of the path in the frame of the workpiece, evenly along it.
fn poses<'p>(path: &'p PosePath, placed: &Isometry3<f64>, count: usize) -> impl Iterator<Item = Isometry3<f64>> + 'p {
    let back = placed.inverse();
    (0..=count).map(move |i| back * path.jet(path.length() * i as f64 / count as f64).pose)
}

/// The frames one step away.
fn neighbours(trial: &Trial, step: f64, search: &PlacementSearch) -> Vec<Trial> {
    let axes: &[Vector3<f64>] = match search.height {
        Some(_) => &[Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)],
        None => &[Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)],
    };
    let mut all: Vec<Trial> = Vec::with_capacity(8);
    for sign in [step, -step] {
        all.extend(axes.iter().map(|axis| Trial { at: trial.at + axis * sign, ..*trial }));
        if search.turn {
            all.push(Trial { turn: trial.turn + sign * TURN_PER_METRE, ..*trial });
        }
    }
    all
}

impl fmt::Display for Placements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {:.2} mm, {} frames of the workpiece looked at",
            self.name,
            self.length_m * 1e3,
            self.looked_at
        )?;
        writeln!(
            f,
            "\n     {:>26}  {:>22}   can be moved   joint range   smallest",
            "position [mm]", "roll pitch yaw [deg]"
        )?;
        writeln!(f, "     {:>26}  {:>22}       by [mm]    left [deg]   sing. value", "", "")?;
        for (i, frame) in self.frames.iter().enumerate() {
            let list = |v: &[f64; 3]| v.map(|v| format!("{v}")).join(" ");
            writeln!(
                f,
                "  {}  {:>26}  {:>22}  {:>12}  {:>12.1}  {:>12.4}",
                i + 1,
                list(&frame.position_mm()),
                list(&frame.rotation_deg()),
                tidy(frame.movable_m * 1e3),
                frame.range_left_rad.to_degrees(),
                frame.smallest_singular_value
            )?;
        }
        let Some(best) = self.frames.first() else { return Ok(()) };
        writeln!(f, "\nThe first one, for the job:\n\n[workpiece]")?;
        writeln!(f, "position_mm = {:?}", best.position_mm())?;
        writeln!(f, "rotation_rpy_deg = {:?}", best.rotation_deg())?;
        if let Some(name) = &best.configuration {
            writeln!(f, "\n[start]\nconfiguration = \"{name}\"")?;
        }
        let mut warnings = self.warnings.iter();
        warnings.try_for_each(|warning| writeln!(f, "\nNote: {}", clip(warning, 2 * WIDTH)))
    }
}
