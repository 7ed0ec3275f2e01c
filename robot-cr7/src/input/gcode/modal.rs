//! What stays in force from block to block: units, planes, modes and feed.

use nalgebra::Vector3;

use super::arc::Plane;
use super::block::Block;
use super::codes::{self, Group};
use super::fault::{GcodeFault, Located};
use super::program::{MoveKind, PathControl};
use crate::input::unit::LengthUnit;

/// Seconds per minute.
const MINUTE: f64 = 60.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FeedMode {
    /// G93.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

/// The modes in force.
#[derive(Debug)]
pub(super) struct Modal {
    pub(super) unit: LengthUnit,
    /// True once the program has named its unit.
    pub(super) unit_named: bool,
    pub(super) plane: Plane,
    /// True after G91.
    pub(super) incremental: bool,
    /// True after G90.1.
    pub(super) absolute_centres: bool,
    pub(super) control: Option<PathControl>,
    /// G code in tenths of the motion that a block without one continues.
    pub(super) motion: Option<u16>,
    /// G code in tenths of the coordinate system, where the program has named one.
    pub(super) system: Option<u16>,
    feed_mode: FeedMode,
    /// F as it stands, and in metres.
    feed: Option<(f64, f64)>,
    /// S in rev/min.
    spindle_speed: f64,
    /// True after G96.
    surface_speed: bool,
}

impl Modal {
    pub(super) fn new(unit: LengthUnit) -> Self {
        Self {
            unit,
            unit_named: false,
            plane: Plane::Xy,
            incremental: false,
            absolute_centres: false,
            control: None,
            motion: None,
            system: None,
            feed_mode: FeedMode::PerMinute,
            feed: None,
            spindle_speed: 0.0,
            surface_speed: false,
        }
    }

    /// Applies the modal codes of a block and its F and S. `moved` is true once the program had a motion.
    pub(super) fn apply(&mut self, block: &mut Block, moved: bool) -> Result<(), Located> {
        if let Some(code) = block.code_of(Group::Units) {
            self.unit = if code.code == 200 { LengthUnit::Inch } else { LengthUnit::Millimetre };
            self.unit_named = true;
        }
        if let Some(code) = block.code_of(Group::FeedMode) {
            let mode = match code.code {
                930 => FeedMode::InverseTime,
                940 => FeedMode::PerMinute,
                _ => FeedMode::PerRevolution,
            };
            if mode != self.feed_mode {
                self.feed_mode = mode;
                self.feed = None;
            }
        }
        match block.code_of(Group::SpindleMode).map(|c| c.code) {
            Some(960) => {
                self.surface_speed = true;
                block.take(b'd');
            }
            Some(_) => self.surface_speed = false,
            None => {}
        }
        self.feed_and_speed(block)?;
        if let Some(code) = block.code_of(Group::Plane) {
            self.plane = match code.code {
                170 => Plane::Xy,
                180 => Plane::Zx,
                _ => Plane::Yz,
            };
        }
        if let Some(code) = block.code_of(Group::Distance) {
            self.incremental = code.code == 910;
        }
        if let Some(code) = block.code_of(Group::ArcDistance) {
            self.absolute_centres = code.code == 901;
        }
        if block.has_code(430) && block.take(b'h').is_none_or(|h| h.value != 0.0) {
            return Err(block.code_fault(430, codes::tool_length()));
        }
        self.coordinate_system(block, moved)?;
        self.path_control(block)
    }

    fn feed_and_speed(&mut self, block: &mut Block) -> Result<(), Located> {
        if let Some(word) = block.take(b'f') {
            if word.value < 0.0 {
                return Err(word.refuse("the feed is not below 0", "correct F"));
            }
            self.feed = Some((word.value, self.unit.to_metres(word.value)));
        }
        if let Some(word) = block.word(b's') {
            if word.value < 0.0 {
                return Err(word.refuse("the spindle speed is not below 0", "correct S; M4 turns backward"));
            }
            self.spindle_speed = word.value;
        }
        Ok(())
    }

    /// The first coordinate system of a program is the workpiece frame.
    fn coordinate_system(&mut self, block: &Block, moved: bool) -> Result<(), Located> {
        let Some(code) = block.code_of(Group::CoordinateSystem) else { return Ok(()) };
        let present = self.system.or(moved.then_some(540));
        if moved && present != Some(code.code) {
            let what = "the change of the coordinate system after the first move";
            let remedy = "post-process in one coordinate system";
            return Err(block.code_fault(code.code, GcodeFault::Unsupported { what, remedy }));
        }
        self.system = Some(code.code);
        Ok(())
    }

    fn path_control(&mut self, block: &mut Block) -> Result<(), Located> {
        let Some(code) = block.code_of(Group::PathControl) else { return Ok(()) };
        self.control = Some(match code.code {
            610 => PathControl::ExactPath,
            611 => PathControl::ExactStop,
            _ => {
                let mut length = |letter| match block.take(letter) {
                    Some(word) if word.value < 0.0 => Err(word.refuse("tolerances are not below 0", "correct it")),
                    word => Ok(word.map(|w| self.unit.to_metres(w.value))),
                };
                let (tolerance, naive) = (length(b'p')?, length(b'q')?);
                PathControl::Blend { tolerance, naive: naive.or(tolerance).unwrap_or(0.0) }
            }
        });
        Ok(())
    }

    /// How fast the feed move of `block` is. `turns_only` is true where the tool point rests.
    pub(super) fn feed_kind(&self, block: &Block, turns_only: bool) -> Result<MoveKind, Located> {
        let missing = |needs, remedy| Err(block.fault(GcodeFault::Missing { needs, remedy }));
        let Some((number, metres)) = self.feed.filter(|f| f.0 > 0.0) else {
            return missing("a feed move needs a feed above 0", "write F in this block or before it");
        };
        let per_second = match self.feed_mode {
            FeedMode::InverseTime => {
                if block.word(b'f').is_none() {
                    return missing("each feed move after G93 has its own F", "write F: 1 / F is the time in min");
                }
                return Ok(MoveKind::InverseTime { seconds: MINUTE / number });
            }
            FeedMode::PerMinute => 1.0 / MINUTE,
            FeedMode::PerRevolution => {
                if self.surface_speed {
                    let needs = "the feed per revolution (G95) needs a constant spindle speed, not G96";
                    return missing(needs, "write G97 and S in rev/min, or G94");
                }
                if self.spindle_speed == 0.0 {
                    return missing("the feed per revolution (G95) needs a spindle speed", "write S, or G94");
                }
                self.spindle_speed / MINUTE
            }
        };
        Ok(if turns_only {
            MoveKind::RotaryFeed { speed: number.to_radians() * per_second }
        } else {
            MoveKind::Feed { speed: metres * per_second }
        })
    }

    /// The place that the words of three axes lead to from `position`; `scale` gives SI units.
    pub(super) fn target(
        &self,
        block: &mut Block,
        letters: &[u8; 3],
        position: Vector3<f64>,
        scale: impl Fn(f64) -> f64,
    ) -> Vector3<f64> {
        let mut to = position;
        for (axis, &letter) in letters.iter().enumerate() {
            if let Some(word) = block.take(letter) {
                to[axis] = if self.incremental { position[axis] } else { 0.0 } + scale(word.value);
            }
        }
        to
    }
}
