//! Rounding the corners of a path.

use nalgebra::Vector3;

use super::allocation::allocate;
use super::arcs::rounding;
use super::certificate::{Rail, deviation};
use super::path::{JoinedPath, Joint, PathPiece, PieceKind, SAME_DIRECTION, SAME_PLACE};
use super::shape::{Blend, between, fullness, leads_on, of_lines, symmetric_deviation};
use super::spans::{Place, Spans, homogeneous, length};
use crate::error::GeometryError;

/// Tries to find the largest blend of curved pieces that is within its tolerance.
const MOST_TRIES: usize = 10;
/// Tries to make a blend smaller until it is within its tolerance.
const MOST_SHRINKS: usize = 24;
/// Part of the tolerance that a try aims at.
const AIM: f64 = 0.96;
/// A blend of curved pieces is large enough from this part of its tolerance on.
const ENOUGH: f64 = 0.85;
/// A blend over the length `l` of a jump of curvature `k` deviates by about this part of `k l^2`.
const JUMP_DEVIATION: f64 = 0.003;
/// A blend takes no more of a piece than would turn by this angle (rad) with the curvature at the joint.
const MOST_TURN: f64 = 1.0;
/// A jump of curvature that turns by less over its pieces (rad) is rounding.
const NO_TURN: f64 = 1e-9;

/// How joints are replaced by blends.
///
/// ```
/// use arcfeed_geometry::Blending;
///
/// let blending = Blending { radius: 2.0, ..Blending::within(0.05) };
/// assert_eq!((blending.tolerance, blending.radius), (0.05, 2.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blending {
    /// Largest distance of a point of the blend from the programmed path, in the unit of the path; 0 keeps the joint
    /// as it is, for an exact stop. The corner may be farther from the blend: of two lines at the angle `a` by the
    /// factor `1 / cos(a / 2)`, which is 1.4 at 90 degrees and 11.5 at 170.
    pub tolerance: f64,
    /// Largest length taken from each neighbour, in the unit of the path; infinite by default.
    pub radius: f64,
    /// A joint stays as it is where its angle is within this of a reversal, rad; 0.02 by default.
    pub reversal: f64,
    /// A smooth joint stays as it is where the curvature jumps by no more than this part of the larger one; 0.01 by
    /// default.
    pub curvature_jump: f64,
}

impl Blending {
    /// Blends within `tolerance` of the programmed path, and defaults for the rest.
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance, radius: f64::INFINITY, reversal: 0.02, curvature_jump: 0.01 }
    }

    fn check(&self, joint: usize) -> Result<(), GeometryError> {
        let error = |what, value, rule| Err(GeometryError::Blending { joint, what, value, rule });
        if !(self.tolerance >= 0.0 && self.tolerance < 1e100) {
            error("tolerance", self.tolerance, "a number from 0 (exact stop) to 1e100")
        } else if self.radius.is_nan() || self.radius <= 0.0 {
            error("radius", self.radius, "above 0, or infinite for no limit")
        } else if !(0.0..=std::f64::consts::PI).contains(&self.reversal) {
            error("angle of a reversal", self.reversal, "between 0 and pi rad")
        } else if self.curvature_jump.is_nan() || self.curvature_jump < 0.0 {
            error("jump of curvature", self.curvature_jump, "0 or more")
        } else {
            Ok(())
        }
    }
}

/// Why a joint stayed as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeptJoint {
    /// Neither the direction nor, by more than the threshold, the curvature jumps there.
    Smooth,
    /// Its tolerance is 0.
    ExactStop,
    /// The path turns back there.
    Reversal,
    /// No blend of any size could be shown to stay within the tolerance.
    NotCertified,
}

/// What became of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointOutcome {
    /// A blend replaces it.
    Blended {
        /// Upper bound on the distance of the blend from the programmed path.
        deviation: f64,
        /// Lengths taken from the pieces before and after the joint.
        taken: [f64; 2],
        /// Index of the blend among the pieces of the new path.
        piece: usize,
    },
    /// It stayed as it is.
    Kept(KeptJoint),
}

/// A path with blends in place of its joints, and what became of each joint.
#[derive(Debug, Clone, PartialEq)]
pub struct BlendedPath {
    /// The new path.
    pub path: JoinedPath,
    /// The joints of the programmed path, in order, each with its outcome.
    pub joints: Vec<(Joint, JointOutcome)>,
}

impl BlendedPath {
    /// Largest certified distance of a blend from the programmed path.
    pub fn deviation(&self) -> f64 {
        let of = |(_, outcome): &(Joint, JointOutcome)| match outcome {
            JointOutcome::Blended { deviation, .. } => *deviation,
            JointOutcome::Kept(_) => 0.0,
        };
        self.joints.iter().map(of).fold(0.0, f64::max)
    }
}

impl JoinedPath {
    /// The path with its corners and its jumps of curvature replaced by blends, with the same setting at every joint.
    ///
    /// A blend has continuous tangent and curvature at both ends, and it is certain to stay within the tolerance of
    /// the two pieces it joins. Its shape depends on the angle, and on whether the tolerance or the pieces bound its
    /// length, so that the motion over it takes nearly the least time. Where blends compete for a short piece, each
    /// takes what the other does not need, and half of it where both want it.
    ///
    /// ```
    /// use arcfeed_geometry::{ArcLengthCurve, Blending, JoinedPathBuilder, JointOutcome, nalgebra::vector};
    ///
    /// // A square of 100 mm, within 1 mm.
    /// let mut square = JoinedPathBuilder::new(vector![0.0, 0.0, 0.0], 1e-3)?;
    /// square.line_to(vector![100.0, 0.0, 0.0], 1)?.line_to(vector![100.0, 100.0, 0.0], 2)?;
    /// square.line_to(vector![0.0, 100.0, 0.0], 3)?.line_to(vector![0.0, 0.0, 0.0], 4)?;
    /// let blended = square.build()?.blended(&Blending::within(1.0))?;
    ///
    /// for (joint, outcome) in &blended.joints {
    ///     let JointOutcome::Blended { deviation, taken, piece } = outcome else { panic!("{joint:?}") };
    ///     assert!(*deviation <= 1.0 && *deviation > 0.999);
    ///     assert!(taken[0] == taken[1] && taken[0] < 7.5);
    ///     assert_eq!(blended.path.pieces()[*piece].sources, joint.sources);
    /// }
    /// // Four lines and three blends; the path starts and ends in the fourth corner.
    /// assert_eq!(blended.path.pieces().len(), 7);
    /// let curve = ArcLengthCurve::new(blended.path.to_curve()?, 1e-9)?;
    /// assert!(curve.corners(1e-6).is_empty());
    /// assert!(curve.length() < 400.0 && curve.length() > 390.0);
    /// # Ok::<(), arcfeed_geometry::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Fails when a setting is not usable.
    pub fn blended(&self, blending: &Blending) -> Result<BlendedPath, GeometryError> {
        self.blended_by(|_| *blending)
    }

    /// As [`JoinedPath::blended`], with a setting for each joint.
    ///
    /// # Errors
    /// Fails when a setting is not usable.
    pub fn blended_by(&self, setting: impl Fn(&Joint) -> Blending) -> Result<BlendedPath, GeometryError> {
        let joints = self.joints();
        let settings: Vec<Blending> = joints.iter().map(setting).collect();
        for (i, setting) in settings.iter().enumerate() {
            setting.check(i)?;
        }
        let wanted: Vec<Result<Blend, KeptJoint>> =
            joints.iter().zip(&settings).map(|(joint, setting)| self.largest_blend(joint, setting)).collect();
        let wishes: Vec<f64> = wanted.iter().map(|w| w.as_ref().map_or(0.0, |blend| blend.taken[0])).collect();
        let lengths: Vec<f64> = self.pieces.iter().map(|p| p.length).collect();
        let mut blends = Vec::with_capacity(joints.len());
        for (i, taken) in allocate(&lengths, &wishes).into_iter().enumerate() {
            let blend = wanted[i].and_then(|wanted| {
                if wanted.taken == taken {
                    return Ok(wanted);
                }
                self.blend_at_most(&joints[i], &settings[i], taken)
            });
            blends.push(blend);
        }
        Ok(self.assembled(&joints, &blends))
    }

    /// The largest blend that a joint would take if it had both of its pieces for itself.
    fn largest_blend(&self, joint: &Joint, setting: &Blending) -> Result<Blend, KeptJoint> {
        let larger = joint.curvature[0].max(joint.curvature[1]);
        let [before, after] = [0, 1].map(|side| self.pieces[joint.piece + side].length);
        let bends = joint.curvature_jump > setting.curvature_jump * larger
            && joint.curvature_jump * before.min(after) > NO_TURN;
        if joint.angle <= SAME_DIRECTION && !bends {
            return Err(KeptJoint::Smooth);
        } else if setting.tolerance == 0.0 {
            return Err(KeptJoint::ExactStop);
        } else if joint.angle >= std::f64::consts::PI - setting.reversal {
            return Err(KeptJoint::Reversal);
        }
        let most = setting.radius.min(before).min(after).min(MOST_TURN / larger);
        let aim = self.aim(joint, setting);
        if aim < 0.0 {
            return Err(KeptJoint::NotCertified);
        }
        let joins_lines = self.joins_lines(joint);
        let corner = aim / symmetric_deviation(joint.angle, if joins_lines { 0.0 } else { 1.0 });
        if joins_lines {
            let taken = if corner.is_finite() { most.min(corner) } else { most };
            return self.blend_at_most(joint, setting, [taken; 2]);
        }
        let jump = (AIM * setting.tolerance / (4.0 * JUMP_DEVIATION * joint.curvature_jump)).sqrt();
        // How the deviation grows with the length.
        let power = if corner < jump { 1.0 } else { 2.0 };
        self.search(joint, setting, most.min(corner).min(jump), (most, power))
    }

    /// The largest blend of curved pieces within the tolerance, nearly, tried first with the length `taken`.
    fn search(
        &self,
        joint: &Joint,
        setting: &Blending,
        mut taken: f64,
        (mut most, power): (f64, f64),
    ) -> Result<Blend, KeptJoint> {
        let mut best: Option<Blend> = None;
        for _ in 0..MOST_TRIES {
            let tried = self.blend(joint, setting, [taken; 2]);
            let factor = |d: f64| (AIM * setting.tolerance / d).powf(1.0 / power);
            let next = match tried {
                Some(blend) if blend.deviation <= setting.tolerance => {
                    best = Some(blend);
                    if blend.deviation >= ENOUGH * setting.tolerance || taken >= 0.99 * most {
                        break;
                    }
                    taken * factor(blend.deviation).max(1.1).min(3.0)
                }
                Some(blend) => {
                    most = taken;
                    taken * factor(blend.deviation).max(0.1).min(0.9)
                }
                None => {
                    most = taken;
                    taken * 0.6
                }
            };
            let least = best.map_or(0.0, |b| b.taken[0]);
            taken = if next <= least || next >= most { 0.5 * (least + most) } else { next };
        }
        best.map_or_else(|| self.blend_at_most(joint, setting, [taken; 2]), Ok)
    }

    /// A blend that takes these lengths, or less by the same factor where that is not certain to be within the
    /// tolerance.
    fn blend_at_most(&self, joint: &Joint, setting: &Blending, mut taken: [f64; 2]) -> Result<Blend, KeptJoint> {
        for _ in 0..MOST_SHRINKS {
            if let Some(blend) = self.blend(joint, setting, taken).filter(|b| b.deviation <= setting.tolerance) {
                return Ok(blend);
            }
            taken = taken.map(|t| 0.75 * t);
        }
        Err(KeptJoint::NotCertified)
    }

    /// The deviation that a blend of two lines aims at; below 0 where rounding exceeds the tolerance.
    fn aim(&self, joint: &Joint, setting: &Blending) -> f64 {
        let size = 8.0 * rounding(&[&self.jet(self.last_place(joint.piece)).point]);
        (1.0 - 1e-9) * (setting.tolerance - size)
    }

    fn joins_lines(&self, joint: &Joint) -> bool {
        self.pieces[joint.piece..joint.piece + 2].iter().all(|p| p.kind == PieceKind::Line)
    }

    /// The blend at a joint that takes these lengths, if it is regular; its deviation may exceed the tolerance.
    fn blend(&self, joint: &Joint, setting: &Blending, taken: [f64; 2]) -> Option<Blend> {
        let (before, after) = (joint.piece, joint.piece + 1);
        if !(taken[0] > 0.0 && taken[1] > 0.0) {
            return None;
        }
        let (corner, cuts) = (self.jet(self.last_place(before)), self.cuts(joint, taken));
        if self.joins_lines(joint) {
            let along = [corner.tangent(), self.jet(self.first_place(after)).tangent()];
            let full = fullness(joint.angle, taken[0].max(taken[1]), self.aim(joint, setting));
            let mut blend = of_lines(&corner.point, &along, (joint.angle, full), taken);
            // The ends are where the lines are cut, to the last digit.
            (blend.points[0], blend.points[5]) = (self.jet(cuts[0]).point, self.jet(cuts[1]).point);
            return Some(blend);
        }
        let rails = [
            Rail::new(self.spans.part(cuts[0], self.last_place(before))),
            Rail::new(self.spans.part(self.first_place(after), cuts[1])),
        ];
        let replaced = [rails[0].length(), rails[1].length()];
        if replaced.iter().any(|&length| !(length > 0.0 && length <= setting.radius * (1.0 + 1e-9))) {
            return None;
        }
        let jump = joint.curvature_jump * replaced[0].max(replaced[1]);
        let points = between(&cuts.map(|cut| self.jet(cut)), replaced, joint.angle / (joint.angle + jump));
        if !leads_on(&points) {
            return None;
        }
        let deviation =
            deviation(&points.map(|p| homogeneous(&p)), &rails) + rounding(&[&points[0], &points[5], &corner.point]);
        Some(Blend { points, deviation, taken, replaced })
    }

    /// Where the lengths taken from both pieces end.
    fn cuts(&self, joint: &Joint, taken: [f64; 2]) -> [Place; 2] {
        [self.place(joint.piece, self.pieces[joint.piece].length - taken[0]), self.place(joint.piece + 1, taken[1])]
    }

    /// The pieces between the blends, and the blends.
    fn assembled(&self, joints: &[Joint], blends: &[Result<Blend, KeptJoint>]) -> BlendedPath {
        let (mut spans, mut pieces) = (Spans::default(), Vec::with_capacity(self.pieces.len() + blends.len()));
        let mut outcomes = Vec::with_capacity(joints.len());
        for (i, piece) in self.pieces.iter().enumerate() {
            let before = i.checked_sub(1).and_then(|j| blends[j].as_ref().ok());
            let after = blends.get(i).and_then(|b| b.as_ref().ok());
            let (x0, x1) = (before.map_or(0.0, |b| b.taken[1]), piece.length - after.map_or(0.0, |b| b.taken[0]));
            let from = before.map_or(self.first_place(i), |_| self.place(i, x0));
            let to = after.map_or(self.last_place(i), |_| self.place(i, x1));
            if x1 - x0 > SAME_PLACE * piece.length {
                let mut part = self.spans.part(from, to);
                before.iter().for_each(|b| part.set_end(false, &b.points[5]));
                after.iter().for_each(|b| part.set_end(true, &b.points[0]));
                if part.len() > 0 {
                    push_piece(
                        &mut spans,
                        &mut pieces,
                        &part,
                        piece,
                        [
                            piece.programmed[0] + before.map_or(0.0, |b| b.replaced[1]),
                            piece.programmed[1],
                            piece.programmed[2] - after.map_or(0.0, |b| b.replaced[0]),
                        ],
                    );
                }
            }
            let (Some(joint), Some(blend)) = (joints.get(i), blends.get(i)) else { continue };
            outcomes.push((
                *joint,
                match blend {
                    Ok(blend) => {
                        let at = piece.programmed[2];
                        let programmed = [at - blend.replaced[0], at, at + blend.replaced[1]];
                        let (kind, sources, deviation) = (PieceKind::Blend, joint.sources, blend.deviation);
                        let shape = PathPiece { kind, sources, deviation, ..piece.clone() };
                        push_piece(&mut spans, &mut pieces, &blend_spans(&blend.points), &shape, programmed);
                        JointOutcome::Blended {
                            deviation: blend.deviation,
                            taken: blend.replaced,
                            piece: pieces.len() - 1,
                        }
                    }
                    Err(reason) => JointOutcome::Kept(*reason),
                },
            ));
        }
        let path = JoinedPath::from_parts(spans, pieces, self.calls.clone());
        BlendedPath { path, joints: outcomes }
    }
}

fn push_piece(spans: &mut Spans, pieces: &mut Vec<PathPiece>, part: &Spans, like: &PathPiece, programmed: [f64; 3]) {
    let first = spans.len();
    spans.append(part);
    pieces.push(PathPiece { spans: first..spans.len(), programmed, ..like.clone() });
}

fn blend_spans(points: &[Vector3<f64>; 6]) -> Spans {
    let points = points.map(|p| homogeneous(&p));
    let mut spans = Spans::default();
    spans.push(&points, length(&points, 0.0, 1.0));
    spans
}
