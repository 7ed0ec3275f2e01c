//! What can be wrong with the mesh of a link.

use std::path::PathBuf;

use arcfeed_kinematics::KinematicsError;
use thiserror::Error;

/// What is wrong with a mesh that a URDF names, or with how it names it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// No URDF, or none of its links has a mesh.
    #[error("{0}: meshes are drawn for a robot whose .urdf file names them; leave --meshes out")]
    None(&'static str),
    /// The scale of a mesh cannot be read.
    #[error("link \"{link}\": scale of its <mesh> is \"{value}\": give three finite numbers")]
    Scale {
        /// The link.
        link: String,
        /// The scale.
        value: String,
    },
    /// The origin of a visual, or of a joint, cannot be read.
    #[error("link \"{link}\": {error}")]
    Origin {
        /// The link.
        link: String,
        /// What is wrong with it.
        error: Box<KinematicsError>,
    },
    /// The markup is none.
    #[error("{0}")]
    Markup(#[from] roxmltree::Error),
    /// The name is of a place that is not looked at.
    #[error(
        "the mesh is named by a place outside of the folder of --meshes, which alone is read: name it package://PACKAGE/FILE, model://PACKAGE/FILE or by a path below that folder"
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
    #[error("{count} {what}: at most {most} are read; make meshes coarser, or fewer in the .urdf file")]
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
    /// A text goes on behind its end in a way that is none of STL.
    #[error("line {line} is \"{found}\", but only \"solid\" begins what follows \"endsolid\": export it again")]
    Behind {
        /// The line, from 1.
        line: usize,
        /// Its beginning.
        found: String,
    },
    /// It has no triangles.
    #[error("it has no triangles: export it again, or take its <visual> out of the .urdf file")]
    Nothing,
    /// It is too small to be seen.
    #[error(
        "it is {size:.1e} m large, which nobody sees: at least {least} m is drawn; check the scale in the .urdf file, which is 0.001 for a mesh in mm and 1 for one in m"
    )]
    Small {
        /// Its greatest extent along an axis, m.
        size: f64,
        /// The least one that is drawn, m.
        least: f64,
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
