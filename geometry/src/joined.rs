//! Paths of many pieces that meet in joints, and blends that round them.

mod allocation;
mod arcs;
mod blending;
mod builder;
mod certificate;
mod orientation;
mod path;
mod shape;
mod spans;

pub use arcs::ArcTo;
pub use blending::{BlendedPath, Blending, JointOutcome, KeptJoint};
pub use builder::JoinedPathBuilder;
pub use path::{JoinedPath, Joint, PathPiece, PieceKind};
