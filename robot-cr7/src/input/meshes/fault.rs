//! What can be wrong with the mesh of a link.

use std::path::PathBuf;

use thiserror::Error;

/// What is wrong with a mesh that a URDF names, or with how it names it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// No URDF, or none of its links has a mesh.
    #[error("{0}: meshes are drawn for a robot whose .urdf file names them; leave --meshes out")]
    None(&'static str),
    /// The markup of a visual cannot be read.
    #[error("link \"{link}\": {what} of its <visual> is \"{value}\": give three finite numbers")]
    Visual {
        /// The link.
        link: String,
        /// The attribute.
        what: &'static str,
        /// Its value.
        value: String,
    },
    /// The markup is none.
    #[error("{0}")]
    Markup(#[from] roxmltree::Error),
    /// The name is of a place that is not looked at.
    #[error(
        "the mesh is named by a place outside of the folder of --meshes, which alone is read: name it package://PACKAGE/FILE or by a path below that folder"
    )]
    Outside,
    /// There is no such file.
    #[error("there is no such file below {}: give the folder that its path begins in", folder.display())]
    Missing {
        /// The folder of `--meshes`.
        folder: PathBuf,
    },
    /// Only STL is read.
    #[error("only STL is read: convert it, and put \"{stand_in}\" beside it, which is taken instead")]
    Kind {
        /// The name of the file that is taken instead.
        stand_in: String,
    },
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// More than is read.
    #[error("{count} {what}: at most {most} are read; make the mesh coarser")]
    Many {
        /// What there is too much of.
        what: &'static str,
        /// How much.
        count: u64,
        /// How much is read.
        most: u64,
    },
    /// A binary file that is not as long as it says.
    #[error(
        "it states {triangles} triangles, which need {needed} bytes, and it has {bytes}: it was cut off, or is no STL; export it again"
    )]
    Length {
        /// The number that it states.
        triangles: u32,
        /// Bytes that these need.
        needed: u64,
        /// Bytes there are.
        bytes: u64,
    },
    /// A triangle cannot be read.
    #[error("triangle {triangle}: {words}: export it again")]
    Triangle {
        /// The triangle, from 1.
        triangle: usize,
        /// What is wrong, in the words of the reader.
        words: String,
    },
    /// A corner of a triangle is no place on an arm.
    #[error(
        "triangle {triangle}: a corner is at {value} m: a corner is less than {most} m from the origin of its link; check the scale in the .urdf file, which is 0.001 for a mesh in mm"
    )]
    Corner {
        /// The triangle, from 1.
        triangle: usize,
        /// The coordinate that is furthest off, m.
        value: f64,
        /// The greatest one, m.
        most: f64,
    },
}
