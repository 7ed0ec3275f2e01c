//! The arm that moves along its path: a picture that a browser plays.

use std::fmt::Write;

use nalgebra::Vector3;

use super::path::{colour_of, level_of};
use crate::output::arm_poses::Pose;
use crate::text::number;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 480.0;
/// Space around the drawing, and above it for the title.
const MARGIN: f64 = 30.0;
const TITLE: f64 = 44.0;
/// Poses that are drawn, at the most; between two of them each joint runs on a straight line.
const MOST_FRAMES: usize = 160;
/// The eye looks down by this angle, and stands this far beside the direction of the path, rad.
const DOWN: f64 = 0.5;
const ASIDE: f64 = 0.8;

/// The plane onto which all is drawn: to the right and up, in the frame of the base.
struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    scale: f64,
    /// What is drawn at the upper left corner, m.
    corner: [f64; 2],
}

impl View {
    /// For an arm at these poses: the eye stands on the side of the path.
    fn of(poses: &[&Pose]) -> Self {
        let tips = poses.iter().filter_map(|pose| pose.places().next_back());
        let middle = tips.fold(Vector3::zeros(), |sum, tip| sum + tip);
        let angle = middle.y.atan2(middle.x) + ASIDE;
        let right = Vector3::new(-angle.sin(), angle.cos(), 0.0);
        let up = Vector3::new(-angle.cos() * DOWN.sin(), -angle.sin() * DOWN.sin(), DOWN.cos());
        let mut view = Self { right, up, scale: 1.0, corner: [0.0; 2] };
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for place in poses.iter().flat_map(|pose| pose.places()) {
            for point in [place, Vector3::new(place.x, place.y, 0.0)] {
                for (bound, value) in bounds.iter_mut().zip(view.place(&point)) {
                    *bound = [bound[0].min(value), bound[1].max(value)];
                }
            }
        }
        let [wide, high] = bounds.map(|[least, most]| (most - least).max(1e-3));
        view.scale = ((WIDTH - 2.0 * MARGIN) / wide).min((HEIGHT - TITLE - 2.0 * MARGIN) / high);
        let spare = [WIDTH - view.scale * wide, HEIGHT + TITLE - view.scale * high].map(|v| 0.5 * v);
        view.corner = [bounds[0][0] - spare[0] / view.scale, bounds[1][0] - spare[1] / view.scale];
        view
    }

    fn place(&self, point: &Vector3<f64>) -> [f64; 2] {
        let on_plane = [point.dot(&self.right), -point.dot(&self.up)];
        [0, 1].map(|i| (on_plane[i] - self.corner[i]) * self.scale)
    }

    fn line(&self, points: impl Iterator<Item = Vector3<f64>>) -> String {
        let mut text = String::new();
        for point in points {
            let [x, y] = self.place(&point);
            let _ = write!(text, "{x:.1},{y:.1} ");
        }
        text.truncate(text.trim_end().len());
        text
    }
}

/// The arm at `poses` along its motion of `duration` (s), over and over, with its path coloured by the speed of the tool.
///
/// Any program that shows SVG shows the arm at its start; a browser plays the motion.
pub fn motion_picture(name: &str, poses: &[Pose], duration: f64) -> String {
    let finite = |pose: &&Pose| pose.feed.is_finite() && pose.points.iter().all(|v| v.is_finite());
    let poses: Vec<&Pose> = poses.iter().filter(finite).collect();
    let every = poses.len().div_ceil(MOST_FRAMES).max(1);
    let last = poses.len().saturating_sub(1);
    let frames: Vec<&Pose> = poses
        .iter()
        .enumerate()
        .filter(|(i, _)| i.is_multiple_of(every) || *i == last)
        .map(|(_, pose)| *pose)
        .collect();
    let view = View::of(&poses);
    let mut svg = String::new();
    let title = name.replace('&', "&amp;").replace('<', "&lt;");
    let _ = write!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"28\" font-size=\"16\" fill=\"#222222\">{title}</text>\n\
         <text x=\"{}\" y=\"28\" font-size=\"12\" fill=\"#666666\" text-anchor=\"end\">{} s in real time, the path coloured by the \
         speed of the tool</text>\n<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n",
        WIDTH - MARGIN,
        number(duration)
    );
    let thick = 0.022 * WIDTH;
    // The shadow on the plane of the base, the path, the arm over it.
    let shadow = |pose: &Pose| view.line(pose.places().map(|p| Vector3::new(p.x, p.y, 0.0)));
    moving(&mut svg, "#e3e6ea", thick, &frames, duration, &shadow);
    moving(&mut svg, "#8aa4b8", thick, &frames, duration, &|pose| view.line(pose.places()));
    moving(&mut svg, "#5d7890", 0.35 * thick, &frames, duration, &|pose| view.line(pose.places()));
    path(&mut svg, &view, &poses);
    svg.push_str("</g>\n</svg>\n");
    svg
}

/// A line that moves from frame to frame.
fn moving(svg: &mut String, colour: &str, width: f64, frames: &[&Pose], duration: f64, line: &dyn Fn(&Pose) -> String) {
    let Some(first) = frames.first() else { return };
    let lines: Vec<String> = frames.iter().map(|pose| line(pose)).collect();
    let times: Vec<String> = frames.iter().map(|pose| format!("{:.4}", (pose.t / duration).clamp(0.0, 1.0))).collect();
    let _ = write!(svg, "<polyline stroke=\"{colour}\" stroke-width=\"{width:.1}\" points=\"{}\">", line(first));
    if duration > 0.0 && frames.len() > 1 {
        let _ = write!(
            svg,
            "<animate attributeName=\"points\" dur=\"{duration:.3}s\" repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{}\"/>",
            times.join(";"),
            lines.join(";")
        );
    }
    svg.push_str("</polyline>\n");
}

/// The path of the tip, a line for each run of places of one colour.
fn path(svg: &mut String, view: &View, poses: &[&Pose]) {
    let highest = poses.iter().fold(0.0f64, |most, pose| most.max(pose.feed));
    let level = |pose: &Pose| level_of(pose.feed, highest);
    let mut from = 0;
    while from + 1 < poses.len() {
        let own = level(poses[from]);
        let to = (from + 1..poses.len()).find(|&i| level(poses[i]) != own).unwrap_or(poses.len() - 1);
        let tips = poses[from..=to].iter().filter_map(|pose| pose.places().next_back());
        let colour = colour_of(own);
        let _ = writeln!(
            svg,
            "<polyline stroke=\"#{:02x}{:02x}{:02x}\" stroke-width=\"3\" points=\"{}\"/>",
            colour.0,
            colour.1,
            colour.2,
            view.line(tips)
        );
        from = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(count: usize) -> Vec<Pose> {
        let pose = |i: usize| {
            let t = i as f64 * 0.01;
            Pose {
                t,
                points: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.4 + 0.1 * t, 0.1 * t.sin(), 0.2],
                joints: Vec::new(),
                feed: 0.05 + 0.01 * t,
            }
        };
        (0..count).map(pose).collect()
    }

    #[test]
    fn each_frame_has_its_time_and_all_stand_in_the_picture() {
        let mut poses = poses(500);
        poses[7].points[3] = f64::NAN;
        let svg = motion_picture("a <b> & c", &poses, 4.99);
        assert!(svg.contains("a &lt;b> &amp; c") && !svg.contains("NaN"));
        assert_eq!(svg.matches("<animate").count(), 3);
        let list = |name: &str| {
            let (_, rest) = svg.split_once(&format!("{name}=\"")).expect("a list");
            let (list, _) = rest.split_once('"').expect("its end");
            list.split(';').map(str::to_owned).collect::<Vec<_>>()
        };
        let (times, values) = (list("keyTimes"), list("values"));
        assert_eq!(times.len(), values.len());
        assert!(times.len() > 100 && times.len() <= MOST_FRAMES + 1, "{}", times.len());
        assert_eq!((times[0].as_str(), times[times.len() - 1].as_str()), ("0.0000", "1.0000"));
        let inside = |pair: &str| {
            let (x, y) = pair.split_once(',').expect("a pair");
            let [x, y] = [x, y].map(|v| v.parse::<f64>().expect("a number"));
            (0.0..=WIDTH).contains(&x) && (TITLE..=HEIGHT).contains(&y)
        };
        assert!(values.iter().flat_map(|line| line.split(' ')).all(inside));
    }

    #[test]
    fn a_motion_without_poses_or_duration_stands_still() {
        for (count, duration) in [(0, 0.0), (1, 0.0), (3, 0.0)] {
            let svg = motion_picture("still", &poses(count), duration);
            assert!(!svg.contains("<animate") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
