//! Paths that come with the program, so that the first run needs no file.

use std::path::Path;

use super::error::InputError;
use super::path_file::PathFile;

/// The paths that come with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplePath {
    /// The butterfly of the NURBS interpolation literature: cubic, 51 points, closed, 382.9 mm long.
    Butterfly,
    /// The six-point cubic of Liu et al. 2023, Table 1.
    SixPoint,
    /// The seven-point cubic of Actuators 2024, 13, 108, Table 1.
    SevenPoint,
    /// The fan of the same literature: cubic, 89 points, closed, 568.9 mm long.
    Fan,
}

impl SamplePath {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Butterfly, Self::SixPoint, Self::SevenPoint, Self::Fan];

    /// Its name, which is also the file name without the extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Butterfly => "butterfly",
            Self::SixPoint => "six_point",
            Self::SevenPoint => "seven_point",
            Self::Fan => "fan",
        }
    }

    /// The text of the path file.
    pub fn json(self) -> &'static str {
        match self {
            Self::Butterfly => include_str!("../../data/butterfly.json"),
            Self::SixPoint => include_str!("../../data/six_point.json"),
            Self::SevenPoint => include_str!("../../data/seven_point.json"),
            Self::Fan => include_str!("../../data/fan.json"),
        }
    }

    /// The path in metres.
    ///
    /// # Errors
    /// None with the files the program was built with; the type is that of any path file.
    pub fn load(self) -> Result<PathFile, InputError> {
        PathFile::from_bytes(self.json().as_bytes(), Path::new(&format!("{}.json", self.name())), None)
    }
}

/// The butterfly, in metres: the path of the first run.
///
/// ```
/// let butterfly = robot_cr7::butterfly()?;
/// assert!(butterfly.planar);
/// # Ok::<(), robot_cr7::InputError>(())
/// ```
///
/// # Errors
/// See [`SamplePath::load`].
pub fn butterfly() -> Result<PathFile, InputError> {
    SamplePath::Butterfly.load()
}
