//! Paths of many pieces that meet in joints, and blends that round them.

mod allocation;
mod arcs;
mod blending;
mod builder;
mod certificate;
mod cusps;
mod orientation;
mod path;
mod shape;
mod spans;
mod standing;

pub use arcs::ArcTo;
pub use blending::{BlendedPath, Blending, JointOutcome, KeptJoint};
pub use builder::JoinedPathBuilder;
pub use path::{JoinedPath, Joint, PathPiece, PieceKind};

#[cfg(test)]
mod tests {
    use nalgebra::{Vector3, vector};

    use super::*;

    /// Looks at spans for each piece of a path of lines and arcs, for the blends and for both curves.
    fn looks_per_piece(n: usize) -> f64 {
        let mut builder = JoinedPathBuilder::new(Vector3::zeros(), 1e-6).unwrap();
        for i in 0..n / 2 {
            let p = builder.position();
            builder.line_to(p + vector![1.0, 0.2 * (1.3 * i as f64).sin(), 0.0], i).unwrap();
            let p = builder.position();
            let to = ArcTo::new(p + vector![0.5, 0.3, 0.0], Vector3::z_axis(), p + vector![1.0, 0.6, 0.0]);
            builder.arc(&to, i).unwrap();
        }
        let before = spans::LOOKS.get();
        let path = builder.build().unwrap();
        path.to_curve().unwrap();
        path.blended(&Blending::within(0.01)).unwrap().path.to_curve().unwrap();
        (spans::LOOKS.get() - before) as f64 / n as f64
    }

    #[test]
    fn the_effort_for_a_piece_does_not_depend_on_the_number_of_pieces() {
        let looks = [200, 2_000, 20_000].map(looks_per_piece);
        assert!(looks[0] > 10.0 && looks.iter().all(|l| (l - looks[1]).abs() < 0.05 * looks[1]), "{looks:?}");
    }
}
