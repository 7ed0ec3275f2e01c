//! Readers of files and packets, each fed arbitrary bytes.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

use arcfeed_geometry::Curve;
use arcfeed_interp::JointTrajectory;
use arcfeed_kinematics::ArmDescription;
use robot_cr7::{
    BatchItem, Job, OnlineScenario, PathFile, PathGeometry, RecordedRows, Scenario, ScheduleFile, ToolScenario,
    read_trajectory,
};

use super::verdict::Verdict;

/// The longest message, bytes: longer ones are no help.
const LONGEST_MESSAGE: usize = 6_000;

/// What a reader gave: an error has to say something, and not too much.
pub(super) fn verdict<T, E: Display>(read: Result<T, E>, broken: impl FnOnce(&T) -> Option<String>) -> Verdict {
    match read {
        Ok(value) => broken(&value).map_or(Verdict::Accepted, Verdict::Broken),
        Err(error) => match error.to_string() {
            text if text.is_empty() => Verdict::Broken("an error without words".to_owned()),
            text if text.len() > LONGEST_MESSAGE => Verdict::Broken(format!("an error of {} bytes", text.len())),
            _ => Verdict::Refused,
        },
    }
}

/// Text for readers that take no bytes, without a byte order mark as files are read.
pub(super) fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok().map(|text| text.strip_prefix('\u{feff}').unwrap_or(text))
}

fn path_file(bytes: &[u8], name: &str) -> Verdict {
    verdict(PathFile::from_bytes(bytes, Path::new(name), None), |file| match &file.geometry {
        PathGeometry::Curve(curve) => {
            let (a, b) = curve.domain();
            let finite = [a, 0.5 * (a + b), b].iter().all(|u| curve.point(*u).iter().all(|c| c.is_finite()));
            (!finite).then(|| "a curve with a point that is not finite".to_owned())
        }
        PathGeometry::Points { points, .. } => {
            let finite = points.iter().all(|p| p.iter().all(|c| c.is_finite()));
            (!finite).then(|| "a point that is not finite".to_owned())
        }
        PathGeometry::Program(program) => {
            let ends = program.moves.iter().map(|m| m.end());
            let finite = std::iter::once(program.start).chain(ends).all(|place| place.iter().all(|c| c.is_finite()));
            (!finite).then(|| "a move to a place that is not finite".to_owned())
        }
    })
}

pub(super) fn json_path(bytes: &[u8]) -> Verdict {
    path_file(bytes, "a.json")
}

pub(super) fn csv_points(bytes: &[u8]) -> Verdict {
    path_file(bytes, "a.csv")
}

pub(super) fn gcode(bytes: &[u8]) -> Verdict {
    path_file(bytes, "a.ngc")
}

pub(super) fn dxf(bytes: &[u8]) -> Verdict {
    path_file(bytes, "a.dxf")
}

pub(super) fn svg(bytes: &[u8]) -> Verdict {
    path_file(bytes, "a.svg")
}

pub(super) fn job(bytes: &[u8]) -> Verdict {
    verdict(Job::from_bytes(bytes, Path::new("a.toml")), |job| {
        let feed = job.feed.feed;
        (!(feed.is_finite() && feed > 0.0)).then(|| format!("a feed of {feed}"))
    })
}

/// All three kinds of scenarios see the same text.
pub(super) fn scenario(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    let file = Path::new("a.toml");
    let all = [
        verdict(Scenario::parse(text, file), |_| None),
        verdict(OnlineScenario::parse(text, file), |_| None),
        verdict(ToolScenario::parse(text, file), |_| None),
    ];
    Verdict::worst(all)
}

pub(super) fn schedule(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    verdict(ScheduleFile::parse(text, Path::new("a.toml")), |_| None)
}

/// What an arm that was read does at a place.
fn arm(read: Result<ArmDescription, arcfeed_kinematics::KinematicsError>) -> Verdict {
    verdict(read.and_then(|arm| arm.build_any()), |arm| {
        let pose = arm.forward(&vec![0.1; arm.joints()]);
        let finite = pose.is_ok_and(|pose| pose.translation.vector.iter().all(|v| v.is_finite()));
        (!finite).then(|| "an arm without a pose".to_owned())
    })
}

pub(super) fn urdf(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    arm(ArmDescription::from_urdf(text, None, None))
}

pub(super) fn arm_json(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    arm(ArmDescription::from_json(text))
}

/// Trajectories of our own form, and of any.
pub(super) fn trajectory_csv(bytes: &[u8]) -> Verdict {
    let file = Path::new("a.csv");
    let own = verdict(read_trajectory::<_, 6>(bytes, file), |rows| {
        let finite = rows.iter().all(|row| row.t.is_finite() && row.q.iter().all(|q| q.is_finite()));
        (!finite).then(|| "a row that is not finite".to_owned())
    });
    let recorded = RecordedRows::<_, 6>::new(Cursor::new(bytes), file).and_then(|rows| {
        let mut last = f64::NEG_INFINITY;
        let mut ordered = true;
        for row in rows {
            let row = row?;
            ordered &= row.t > last && row.q.iter().all(|q| q.is_finite());
            last = row.t;
        }
        Ok(ordered)
    });
    let foreign = verdict(recorded, |ordered| (!ordered).then(|| "rows out of order or not finite".to_owned()));
    Verdict::worst([own, foreign])
}

pub(super) fn compiled_json(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    verdict(JointTrajectory::<2>::from_json(text), |(motion, _)| {
        let end = motion.at(motion.duration());
        let finite = motion.duration().is_finite() && end.q.iter().all(|q| q.is_finite());
        (!finite).then(|| "a motion that is not finite".to_owned())
    })
}

pub(super) fn batch_line(bytes: &[u8]) -> Verdict {
    let Some(text) = text(bytes) else { return Verdict::Refused };
    let item = BatchItem::from_line(text, 1, Path::new("jobs.jsonl"));
    let id = BatchItem::id_of(text, 1);
    if id != item.id {
        // Two jobs of one name would write the same file.
        return Verdict::Broken(format!("is job {:?}, and is named {id:?}", item.id));
    }
    if id == "1" { Verdict::Refused } else { Verdict::Accepted }
}

/// Replies and packets of a controller, in pieces of any length.
#[cfg(feature = "controller")]
pub(super) fn controller(bytes: &[u8]) -> Verdict {
    use robot_cr7::controller::{Dialect, FEEDBACK_BYTES, FeedbackReader, ReplyReader, decode_feedback};

    let (mut replies, mut packets) = (ReplyReader::default(), FeedbackReader::default());
    let mut seen = 0;
    let mut rest = bytes;
    while let Some((length, tail)) = rest.split_first() {
        let (piece, later) = tail.split_at((usize::from(*length) * 8).min(tail.len()));
        rest = later;
        if replies.push(piece).is_ok() {
            while let Ok(Some(_)) = replies.next_reply() {
                seen += 1;
            }
        }
        let mut left = piece;
        loop {
            left = packets.push(left);
            let Some(packet) = packets.next_packet() else { break };
            for dialect in [Dialect::V3, Dialect::V4] {
                if let Ok(state) = decode_feedback(&packet, dialect) {
                    seen += 1;
                    if !state.q.iter().chain(&state.qd).all(|v| v.is_finite()) {
                        return Verdict::Broken("a state that is not finite".to_owned());
                    }
                }
            }
        }
        if !left.is_empty() && left.len() >= FEEDBACK_BYTES {
            return Verdict::Broken("bytes that are never taken".to_owned());
        }
    }
    if seen > 0 { Verdict::Accepted } else { Verdict::Refused }
}

/// Streams of replies and of a packet as a controller sends it, behind lengths.
#[cfg(feature = "controller")]
pub(super) fn streams() -> Vec<Vec<u8>> {
    let replies = b"0,{},EnableRobot();0,{[[],[],[],[],[],[],[]]},GetErrorID();-1,{},ServoJ(1,2,3,4,5,6);0,{1},Stop();";
    let mut packet = vec![0u8; robot_cr7::controller::FEEDBACK_BYTES];
    packet[..2].copy_from_slice(&1440u16.to_le_bytes());
    packet[48..56].copy_from_slice(&0x0123_4567_89AB_CDEF_u64.to_le_bytes());
    let framed = |bytes: &[u8]| {
        let pieces = bytes.chunks(255 * 8);
        pieces.flat_map(|piece| std::iter::once((piece.len().div_ceil(8)) as u8).chain(piece.iter().copied())).collect()
    };
    let both = [&replies[..], &packet, &packet].concat();
    vec![framed(replies), framed(&packet), framed(&both)]
}
