//! Joints that are known from another grid over the same path.

use super::jet::JointJet;

/// Joints at the points of a grid and in the middles of its intervals, to be asked for at increasing places.
#[derive(Debug)]
pub(crate) struct KnownJoints<'k, const N: usize> {
    before: &'k [JointJet<N>],
    after: &'k [JointJet<N>],
    middles: &'k [Option<JointJet<N>>],
    /// The last grid point that is not beyond the place asked for last.
    point: usize,
}

impl<'k, const N: usize> KnownJoints<'k, N> {
    /// Nothing is known.
    pub fn none() -> Self {
        Self { before: &[], after: &[], middles: &[], point: 0 }
    }

    /// Those before and after every point of a grid, and in the `middles` of its intervals where they are known.
    pub fn of([before, after]: [&'k [JointJet<N>]; 2], middles: &'k [Option<JointJet<N>>]) -> Self {
        Self { before, after, middles, point: 0 }
    }

    /// Values before and after `s`, which is no less than in the call before; none unless exactly that place is known.
    pub fn at(&mut self, s: f64) -> Option<[JointJet<N>; 2]> {
        while self.after.get(self.point + 1).is_some_and(|next| next.s <= s) {
            self.point += 1;
        }
        let (before, after) = (self.before.get(self.point)?, self.after.get(self.point)?);
        if after.s == s {
            return Some([*before, *after]);
        }
        // A knot of the path is a grid point: in the middle both sides are the same.
        let middle = self.middles.get(self.point).copied().flatten();
        middle.filter(|middle| middle.s == s).map(|middle| [middle; 2])
    }
}
