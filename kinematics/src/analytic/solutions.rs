//! The set of all inverse solutions, on the stack.

use crate::joint::Joints;

/// Solutions of the inverse kinematics of one target: up to [`Solutions::CAPACITY`], without heap.
///
/// Dereferences to a slice of joint vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solutions<const N: usize> {
    joints: [Joints<N>; 8],
    len: usize,
    wrist_singular: bool,
    shoulder_singular: bool,
    incomplete: bool,
}

impl<const N: usize> Solutions<N> {
    /// The most solutions a six-joint arm with a closed form has.
    pub const CAPACITY: usize = 8;

    pub(crate) fn new() -> Self {
        Self {
            joints: [Joints::zeros(); 8],
            len: 0,
            wrist_singular: false,
            shoulder_singular: false,
            incomplete: false,
        }
    }

    /// Adds a solution; beyond the capacity it is left out.
    pub(crate) fn push(&mut self, q: Joints<N>) {
        if let Some(place) = self.joints.get_mut(self.len) {
            *place = q;
            self.len += 1;
        }
    }

    /// Moves the first `by` solutions behind the others.
    pub(super) fn rotate_left(&mut self, by: usize) {
        self.joints[..self.len].rotate_left(by);
    }

    pub(crate) fn mark_wrist_singular(&mut self) {
        self.wrist_singular = true;
    }

    pub(crate) fn mark_shoulder_singular(&mut self) {
        self.shoulder_singular = true;
    }

    pub(crate) fn mark_incomplete(&mut self) {
        self.incomplete = true;
    }

    /// The same set for an arm of `M` joints, which is `N` by another name.
    pub(crate) fn for_joints<const M: usize>(&self) -> Solutions<M> {
        self.map(|q| Joints::from_fn(|i, _| q.get(i).copied().unwrap_or(0.0)))
    }

    /// The same set in other joints: every solution as `other` gives it.
    pub fn map<const M: usize>(&self, other: impl Fn(&Joints<N>) -> Joints<M>) -> Solutions<M> {
        Solutions {
            joints: self.joints.each_ref().map(other),
            len: self.len,
            wrist_singular: self.wrist_singular,
            shoulder_singular: self.shoulder_singular,
            incomplete: self.incomplete,
        }
    }

    /// Replaces every solution by `improve` of it, or drops it.
    pub(crate) fn retain_map(&mut self, mut improve: impl FnMut(&Joints<N>) -> Option<Joints<N>>) {
        let all = self.joints;
        let len = std::mem::take(&mut self.len);
        for q in all.iter().take(len).filter_map(&mut improve) {
            self.push(q);
        }
    }

    /// True if two wrist axes line up at the target in some branch: a whole circle of solutions exists there, and the
    /// list holds one representative of it (last joint at 0 or, if the arm does not reach that far, as near as it
    /// does). Seed-based inverse kinematics keeps the last joint where it was.
    ///
    /// The axes count as lined up within 1e-10 rad, and the orientation of the solutions is exact to that; those of any
    /// other target are exact to rounding (1e-12).
    pub fn wrist_singular(&self) -> bool {
        self.wrist_singular
    }

    /// True if the wrist stands on the first joint's axis, on an arm without shoulder offset: the first joint is free
    /// and the list holds its solutions for one value.
    pub fn shoulder_singular(&self) -> bool {
        self.shoulder_singular
    }

    /// True if these are all solutions there are, as a closed form finds them. A search finds some.
    pub fn is_complete(&self) -> bool {
        !self.incomplete
    }

    /// The solutions.
    pub fn as_slice(&self) -> &[Joints<N>] {
        &self.joints[..self.len]
    }
}

impl<const N: usize> std::ops::Deref for Solutions<N> {
    type Target = [Joints<N>];

    fn deref(&self) -> &[Joints<N>] {
        self.as_slice()
    }
}

impl<'a, const N: usize> IntoIterator for &'a Solutions<N> {
    type Item = &'a Joints<N>;
    type IntoIter = std::slice::Iter<'a, Joints<N>>;

    fn into_iter(self) -> Self::IntoIter {
        self.as_slice().iter()
    }
}
