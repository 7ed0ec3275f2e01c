//! A recording of a motion in the MCAP format, profile ros2: the trajectory, the states of the joints, the frames of the links.

use std::collections::BTreeMap;
use std::io;

use arcfeed_kinematics::Chain;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use nalgebra::Isometry3;

use super::cdr::{Cdr, Message};
use super::joint_trajectory::RosTrajectory;
use crate::run::robot::Robot;
use crate::run::trajectory_row::TrajectoryRow;

/// Frames of the links are written at most this often, s.
const FRAMES_EVERY: f64 = 0.01;

const STAMP: &str = "int32 sec\nuint32 nanosec\n";
const HEADER: &str = "builtin_interfaces/Time stamp\nstring frame_id\n";
const TRAJECTORY: &str =
    "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n";
const POINT: &str = "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n\
                     builtin_interfaces/Duration time_from_start\n";
const STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n";
const FRAMES: &str = "geometry_msgs/TransformStamped[] transforms\n";
const STAMPED: &str = "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n";
const TRANSFORM: &str = "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n";
const VECTOR: &str = "float64 x\nfloat64 y\nfloat64 z\n";
const QUATERNION: &str = "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

/// The definition of a message with those of its parts.
fn definition(own: &str, parts: &[(&str, &str)]) -> String {
    let part = |(name, text): &(&str, &str)| format!("{}\nMSG: {name}\n{text}", "=".repeat(80));
    own.to_owned() + &parts.iter().map(part).collect::<String>()
}

/// Writes a recording. Message times count from 0.
pub struct RosRecording<W: io::Write + io::Seek, const N: usize = 6> {
    writer: Writer<W>,
    states: u16,
    frames: u16,
    chain: Chain<N>,
    /// Of each joint the name and the link that it moves.
    joint_names: Vec<String>,
    links: Vec<String>,
    /// Base, flange and tool.
    own_frames: [String; 3],
    sequence: u32,
    next_frames: f64,
}

/// The name, or one with marks behind it, so that no link of the arm has it.
fn free_name(name: &str, links: &[String]) -> String {
    let mut free = name.to_owned();
    while links.contains(&free) {
        free.push('_');
    }
    free
}

/// A header with a time since the start, s.
fn header(cdr: &mut Cdr, t: f64, frame: &str) {
    let nanoseconds = nanoseconds(t);
    cdr.i32(i32::try_from(nanoseconds / 1_000_000_000).unwrap_or(i32::MAX));
    cdr.u32((nanoseconds % 1_000_000_000) as u32);
    cdr.string(frame);
}

fn nanoseconds(t: f64) -> u64 {
    (t * 1e9).round() as u64
}

struct State<'a> {
    t: f64,
    names: &'a [String],
    position: &'a [f64],
    velocity: &'a [f64],
}

impl Message for State<'_> {
    fn write(&self, cdr: &mut Cdr) {
        header(cdr, self.t, "");
        cdr.strings(self.names);
        cdr.numbers(self.position);
        cdr.numbers(self.velocity);
        cdr.numbers(&[]);
    }
}

/// The frame of each link in that of the one before.
struct Frames<'a> {
    t: f64,
    links: Vec<(&'a str, &'a str, Isometry3<f64>)>,
}

impl Message for Frames<'_> {
    fn write(&self, cdr: &mut Cdr) {
        cdr.count(self.links.len());
        for (parent, child, pose) in &self.links {
            header(cdr, self.t, parent);
            cdr.string(child);
            let (place, turn) = (pose.translation.vector, pose.rotation.quaternion());
            for value in [place.x, place.y, place.z, turn.i, turn.j, turn.k, turn.w] {
                cdr.f64(value);
            }
        }
    }
}

impl<W: io::Write + io::Seek, const N: usize> RosRecording<W, N> {
    /// Begins a recording with the trajectory that a controller gets. `chain` is that of the robot, with its tool.
    ///
    /// # Errors
    /// What writing fails with.
    pub fn new(to: W, trajectory: &RosTrajectory, robot: &Robot, chain: &Chain<N>) -> io::Result<Self> {
        let options = WriteOptions::new().profile("ros2").library("arcfeed").compression(None);
        let mut writer = options.create(to).map_err(io::Error::other)?;
        let stamp = ("builtin_interfaces/Time", STAMP);
        let shared = [("std_msgs/Header", HEADER), stamp];
        let duration = ("builtin_interfaces/Duration", STAMP);
        let mut channel = |topic: &str, kind: &str, own: &str, parts: &[(&str, &str)]| {
            let parts: Vec<_> = shared.iter().chain(parts).copied().collect();
            let text = definition(own, &parts);
            let schema = writer.add_schema(kind, "ros2msg", text.as_bytes()).map_err(io::Error::other)?;
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).map_err(io::Error::other)
        };
        let point = ("trajectory_msgs/JointTrajectoryPoint", POINT);
        let planned =
            channel("/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", TRAJECTORY, &[point, duration])?;
        let states = channel("/joint_states", "sensor_msgs/msg/JointState", STATE, &[])?;
        let parts = [
            ("geometry_msgs/TransformStamped", STAMPED),
            ("geometry_msgs/Transform", TRANSFORM),
            ("geometry_msgs/Vector3", VECTOR),
            ("geometry_msgs/Quaternion", QUATERNION),
        ];
        let frames = channel("/tf", "tf2_msgs/msg/TFMessage", FRAMES, &parts)?;
        let joints = &robot.description().joints;
        let joint_names = joints.iter().map(|joint| joint.name.clone()).collect();
        let links: Vec<String> = joints.iter().map(|joint| joint.link.clone()).collect();
        let own_frames = ["base", "flange", "tool"].map(|name| free_name(name, &links));
        let chain = *chain;
        let mut recording =
            Self { writer, states, frames, chain, joint_names, links, own_frames, sequence: 0, next_frames: 0.0 };
        recording.add(planned, 0.0, &trajectory.to_cdr())?;
        Ok(recording)
    }

    fn add(&mut self, channel_id: u16, t: f64, data: &[u8]) -> io::Result<()> {
        let (log_time, sequence) = (nanoseconds(t), self.sequence);
        self.sequence = self.sequence.wrapping_add(1);
        let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, data).map_err(io::Error::other)
    }

    /// Adds a sample.
    ///
    /// # Errors
    /// What writing fails with.
    pub fn write(&mut self, row: &TrajectoryRow<N>) -> io::Result<()> {
        let state = State { t: row.t, names: &self.joint_names, position: &row.q, velocity: &row.qd };
        let data = state.to_cdr();
        self.add(self.states, row.t, &data)?;
        if row.t < self.next_frames {
            return Ok(());
        }
        self.next_frames = row.t + FRAMES_EVERY;
        let data = Frames { t: row.t, links: self.links(&row.q) }.to_cdr();
        self.add(self.frames, row.t, &data)
    }

    /// Parent, link and pose of all links at the joints `q`, flange and tool included.
    fn links(&self, q: &[f64; N]) -> Vec<(&str, &str, Isometry3<f64>)> {
        let [base, flange, tool] = &self.own_frames;
        let mut parent = base.as_str();
        let mut before = *self.chain.base();
        let mut links = Vec::with_capacity(N + 2);
        for ((joint, link), &value) in self.chain.joints().iter().zip(&self.links).zip(q) {
            links.push((parent, link.as_str(), before * joint.origin() * joint.motion(value)));
            (parent, before) = (link, Isometry3::identity());
        }
        links.push((parent, flange, *self.chain.flange()));
        links.push((flange, tool, *self.chain.tool()));
        links
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// What writing fails with.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.finish().map(|_| ()).map_err(io::Error::other)
    }
}
