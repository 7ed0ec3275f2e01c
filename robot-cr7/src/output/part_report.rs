//! The parts of a program, as its report states them.

use serde::Serialize;

use crate::run::program_part::{PartMotion, ProgramPart};
use crate::text::number;

/// One part of a program. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartReport {
    /// "path" for a path of the tool, "joints" for rapid moves as a motion of the joints, "dwell" where the tool waits.
    pub kind: &'static str,
    /// The first and the last line of the file that belong to it.
    pub lines: [usize; 2],
    /// Its start, s.
    pub begin_s: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// The way of the tool in it, m.
    pub length_m: f64,
    /// The joint move, where it is one.
    #[serde(flatten)]
    pub joints: Option<JointMoveReport>,
}

/// How far a joint move is from the lines of the program.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointMoveReport {
    /// Largest distance of the tool from the straight lines of the program, on dense samples, m.
    pub leaves_lines_m: f64,
    /// The line of the file where that is.
    pub leaves_lines_at: usize,
    /// How high the moves are above both of their ends along the z axis of the workpiece, or above their start where no path follows, m.
    pub lift_m: f64,
    /// Distance within which the tool passes the end of each move, m.
    pub passes_ends_m: f64,
    /// The arm changes its configuration.
    pub reconfigured: bool,
}

impl PartReport {
    /// The report of a part.
    pub fn new<const N: usize>(part: &ProgramPart<'_, N>) -> Self {
        let (kind, joints) = match part.motion() {
            PartMotion::Path(_) => ("path", None),
            PartMotion::Dwell(_) => ("dwell", None),
            PartMotion::Joints(motion) => {
                let report = JointMoveReport {
                    leaves_lines_m: motion.leaves().distance_m,
                    leaves_lines_at: motion.leaves().line,
                    lift_m: motion.lift_m(),
                    passes_ends_m: motion.passed().iter().map(|end| end.distance_m).fold(0.0, f64::max),
                    reconfigured: motion.reconfigured(),
                };
                ("joints", Some(report))
            }
        };
        let (begin_s, duration_s, length_m) = (part.begin(), part.duration(), part.length());
        Self { kind, lines: part.lines(), begin_s, duration_s, length_m, joints }
    }
}

/// All parts on one line: "3 paths 12.5 s, 2 joint moves 1.2 s, 1 dwell 0.5 s".
pub(crate) fn parts_line(parts: &[PartReport]) -> Option<String> {
    let words = |kind: &str, names: [&str; 2]| {
        let of = || parts.iter().filter(|part| part.kind == kind);
        let time = number(of().map(|part| part.duration_s).sum());
        match of().count() {
            0 => None,
            1 => Some(format!("1 {} {time} s", names[0])),
            count => Some(format!("{count} {} {time} s", names[1])),
        }
    };
    let all = [
        words("path", ["path", "paths"]),
        words("joints", ["joint move", "joint moves"]),
        words("dwell", ["dwell", "dwells"]),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// The joint move that leaves the lines most, or most of those that exceed their lift; and whether it does.
pub(crate) fn rapids_line(parts: &[PartReport]) -> Option<(String, bool)> {
    let moves = || parts.iter().filter_map(|part| part.joints.as_ref());
    let over = |one: &&JointMoveReport| one.leaves_lines_m > one.lift_m;
    let farthest = |a: &&JointMoveReport, b: &&JointMoveReport| a.leaves_lines_m.total_cmp(&b.leaves_lines_m);
    let exceeds = moves().any(|one| over(&one));
    let worst = moves().filter(|one| over(one) || !exceeds).max_by(farthest)?;
    let mm = |m: f64| number(m * 1e3);
    let (off, line, lift) = (mm(worst.leaves_lines_m), worst.leaves_lines_at, mm(worst.lift_m));
    let passed = mm(moves().map(|one| one.passes_ends_m).fold(0.0, f64::max));
    let lift = if exceeds { format!("above the lift of {lift} mm") } else { format!("lift {lift} mm") };
    Some((format!("{off} mm beside the lines at line {line}, {lift}; ends passed within {passed} mm"), exceeds))
}
