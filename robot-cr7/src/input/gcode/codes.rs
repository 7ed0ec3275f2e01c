//! Which codes are known, what they set, and why others are refused.

use super::fault::GcodeFault;

/// What a code sets. A block holds one code of each group, except of [`Group::NonModal`] (LinuxCNC, "Modal Groups").
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    NonModal,
    Motion,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterCompensation,
    ToolLength,
    ReturnMode,
    CoordinateSystem,
    PathControl,
    SpindleMode,
    LatheMode,
    Stop,
    ToolChange,
    Spindle,
    Overrides,
}

impl Group {
    /// The name of what the codes of the group set.
    pub(super) fn sets(self) -> &'static str {
        match self {
            Self::NonModal => "nothing",
            Self::Motion => "the motion",
            Self::Plane => "the plane",
            Self::Distance => "absolute or incremental coordinates",
            Self::ArcDistance => "absolute or incremental centres",
            Self::FeedMode => "the feed mode",
            Self::Units => "the unit",
            Self::CutterCompensation => "the cutter compensation",
            Self::ToolLength => "the tool length",
            Self::ReturnMode => "the return of canned cycles",
            Self::CoordinateSystem => "the coordinate system",
            Self::PathControl => "the path control",
            Self::SpindleMode => "the spindle mode",
            Self::LatheMode => "radius or diameter",
            Self::Stop => "a stop",
            Self::ToolChange => "the tool",
            Self::Spindle => "the spindle",
            Self::Overrides => "the overrides",
        }
    }
}

/// Group of the G code `tenths / 10`, or why it is refused.
pub(super) fn general(tenths: u16) -> Result<Group, GcodeFault> {
    Ok(match tenths {
        0 | 10 | 20 | 30 | 50 | 51 | 52 | 53 | 62 | 800 => Group::Motion,
        40 | 921 | 922 => Group::NonModal,
        170 | 180 | 190 => Group::Plane,
        900 | 910 => Group::Distance,
        901 | 911 => Group::ArcDistance,
        930 | 940 | 950 => Group::FeedMode,
        200 | 210 => Group::Units,
        400 => Group::CutterCompensation,
        430 | 490 => Group::ToolLength,
        980 | 990 => Group::ReturnMode,
        540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 => Group::CoordinateSystem,
        610 | 611 | 640 => Group::PathControl,
        960 | 970 => Group::SpindleMode,
        80 => Group::LatheMode,
        _ => return Err(refusal(tenths)),
    })
}

/// Why the G code `tenths / 10` is refused.
fn refusal(tenths: u16) -> GcodeFault {
    let (what, remedy) = match tenths {
        22 => ("G2.2 as the start of a NURBS block", "write G5.2, as LinuxCNC documents it"),
        70 => ("diameter programming", "write radii with G8"),
        100 => ("the change of offsets and tool data", "post-process with coordinates of the workpiece"),
        171 | 181 | 191 => ("a plane of the axes U V W", "use G17, G18 or G19"),
        280 | 281 | 300 | 301 => ("the return to a position of the machine", "write the position with G0"),
        330 | 331 => ("motion that follows the spindle", "post-process without threads"),
        380..=389 => ("probing", "remove the probing cycle"),
        410 | 411 | 420 | 421 => ("cutter compensation", "post-process with compensation in the CAM"),
        430..=432 => ("tool length compensation", "post-process for the tool point, without G43"),
        520 | 920 | 923 => ("the shift of the origin", "post-process with coordinates of the workpiece"),
        530 => ("motion in machine coordinates", "write the position in coordinates of the workpiece"),
        700..=722 => ("a lathe cycle", "post-process with single moves"),
        730 | 740 | 760 | 810..=890 => ("a canned cycle", "post-process with single moves"),
        _ => return GcodeFault::UnknownCode,
    };
    GcodeFault::Unsupported { what, remedy }
}

/// Refusal of G43 with a length from the tool table.
pub(super) fn tool_length() -> GcodeFault {
    refusal(430)
}

/// Group of an M code, or why it is refused.
pub(super) fn miscellaneous(code: u16) -> Result<Group, GcodeFault> {
    Ok(match code {
        0 | 1 | 2 | 30 | 60 => Group::Stop,
        6 => Group::ToolChange,
        3..=5 | 19 => Group::Spindle,
        48 | 49 => Group::Overrides,
        70..=73 => {
            let what = "saved modal state";
            return Err(GcodeFault::Unsupported { what, remedy: "write the modal codes" });
        }
        97..=99 => {
            let what = "the call of a subroutine";
            return Err(GcodeFault::Unsupported { what, remedy: "post-process without subroutines" });
        }
        0..=999 => Group::NonModal,
        _ => return Err(GcodeFault::UnknownCode),
    })
}

/// True where an M code is executed behind the motion of its block.
pub(super) fn is_stop(code: u16) -> bool {
    matches!(miscellaneous(code), Ok(Group::Stop))
}

/// True where the M code ends the program.
pub(super) fn is_end(code: u16) -> bool {
    matches!(code, 2 | 30)
}

/// Letters that an M code takes as its own words.
pub(super) fn letters_of_miscellaneous(code: u16) -> &'static str {
    match code {
        0..=9 | 30 | 48 | 49 | 60 => "",
        _ => "pqelr",
    }
}

/// Letters of `pqrl` that a G code takes. Two codes of a block must not take the same letter.
pub(super) fn letters_of_general(tenths: u16) -> &'static str {
    match tenths {
        20 | 30 => "pr",
        40 => "p",
        50 | 640 => "pq",
        52 => "pl",
        62 => "pqr",
        _ => "",
    }
}

/// The name of a G code.
pub(super) fn name(tenths: u16) -> String {
    match tenths % 10 {
        0 => format!("G{}", tenths / 10),
        tenth => format!("G{}.{tenth}", tenths / 10),
    }
}
