//! The place for a route in a generator.

use super::trajectory::WayPointTrajectory;

/// A place for the motion along a route in an [`OnlineGenerator`](crate::OnlineGenerator): `()` for
/// none, or a [`WayPointTrajectory`].
pub trait RouteMemory<const N: usize>: sealed::Sealed {
    /// The motion along the route set last.
    #[doc(hidden)]
    fn motion(&self) -> Option<&WayPointTrajectory<N>>;
}

impl<const N: usize> RouteMemory<N> for () {
    fn motion(&self) -> Option<&WayPointTrajectory<N>> {
        None
    }
}

impl<const N: usize> RouteMemory<N> for WayPointTrajectory<N> {
    fn motion(&self) -> Option<&WayPointTrajectory<N>> {
        Some(self)
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for () {}
    impl<const N: usize> Sealed for super::WayPointTrajectory<N> {}
}
