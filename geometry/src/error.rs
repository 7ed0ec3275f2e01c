//! Errors in a curve, each with its remedy.

use thiserror::Error;

/// Everything that can go wrong in this crate.
///
/// Each variant names the place (index or parameter), the value, the rule it breaks and the way out, so that a program
/// can react to the fields and a person to the text.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// The degree is zero.
    #[error("degree is 0, but a curve needs degree 1 (a polyline) or more")]
    DegreeZero,
    /// The degree is higher than any curve that can be evaluated.
    #[error(
        "degree {degree} is more than {limit}: binomial coefficients beyond it leave the range of f64; lower the degree"
    )]
    DegreeTooHigh {
        /// The degree given.
        degree: usize,
        /// The highest degree.
        limit: usize,
    },
    /// An orientation key is not a rotation.
    #[error("orientation key {index} has {value} in its quaternion; give four finite numbers x y z w of a rotation")]
    QuaternionNotFinite {
        /// Which key, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// Fewer control points than degree + 1.
    #[error("{points} control points are too few for degree {degree}: at least {} are needed; lower the degree or add points", degree + 1)]
    TooFewPoints {
        /// Number of control points given.
        points: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// The number of weights differs from the number of control points.
    #[error(
        "{weights} weights for {points} control points: give one weight per control point (1 where the curve is not rational)"
    )]
    WeightCount {
        /// Number of weights given.
        weights: usize,
        /// Number of control points given.
        points: usize,
    },
    /// The number of knots is not points + degree + 1.
    #[error("{knots} knots for {points} control points of degree {degree}: the knot vector needs exactly {} entries (points + degree + 1)", points + degree + 1)]
    KnotCount {
        /// Number of knots given.
        knots: usize,
        /// Number of control points given.
        points: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// A coordinate of a point is NaN or infinite.
    #[error("{what} {index} has coordinate {axis} = {value}, which is not a finite number of magnitude below 1e100")]
    PointNotFinite {
        /// The kind of point: "control point", "data point", ...
        what: &'static str,
        /// Index of the point, from 0.
        index: usize,
        /// Which coordinate: 0 = x, 1 = y, 2 = z.
        axis: usize,
        /// The value found.
        value: f64,
    },
    /// A weight is not finite or not above zero.
    #[error(
        "weight {index} is {value}: weights must be finite and above 0 (with a weight of 0 or below the curve leaves the hull of its control points)"
    )]
    Weight {
        /// Index of the weight, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// Weights so far apart that the curve cannot be evaluated in double precision.
    #[error(
        "weights range from {smallest} to {largest}, more than a factor of 1e12 apart: the small ones have no effect in double precision; remove those points or scale their weights"
    )]
    WeightRange {
        /// Smallest weight.
        smallest: f64,
        /// Largest weight.
        largest: f64,
    },
    /// A knot is NaN or infinite.
    #[error("knot {index} is {value}, which is not a finite number")]
    KnotNotFinite {
        /// Index of the knot, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// The knot vector decreases.
    #[error("knot {index} is {value}, below knot {} = {previous}: knots must not decrease", index - 1)]
    KnotsDecrease {
        /// Index of the offending knot, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// The value before it.
        previous: f64,
    },
    /// A knot is repeated more often than degree + 1 times.
    #[error("knot value {value} stands {multiplicity} times from index {index} on: at most degree + 1 = {} is meaningful", degree + 1)]
    Multiplicity {
        /// Index of the first of them.
        index: usize,
        /// The knot value.
        value: f64,
        /// The number of times it stands there.
        multiplicity: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// A span is too narrow for double precision, and its ends cannot count as one knot.
    #[error(
        "knots {index} and {} at {value} lie {width:e} apart, and at least {least:e} is needed where so many stand together: give them the same value and remove the points between, or spread them",
        index + 1
    )]
    KnotsTooClose {
        /// Index of the first of the two, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Distance between the two.
        width: f64,
        /// Least distance.
        least: f64,
    },
    /// All knots of the domain coincide.
    #[error("the domain [{start}, {end}] is empty: the knots from index degree to index points must span an interval")]
    EmptyDomain {
        /// First knot of the domain.
        start: f64,
        /// Last knot of the domain.
        end: f64,
    },
    /// An interior knot of multiplicity degree + 1 tears the curve apart.
    #[error(
        "the curve jumps by {gap} at knot {value} (multiplicity degree + 1): a tool cannot follow that; make the two points equal or split it into two curves"
    )]
    Jump {
        /// The knot value.
        value: f64,
        /// Distance between the two ends, in the curve's unit.
        gap: f64,
    },
    /// A parameter lies outside the curve's domain.
    #[error("parameter {value} lies outside the domain [{start}, {end}] of the curve")]
    OutsideDomain {
        /// The parameter given.
        value: f64,
        /// Start of the domain.
        start: f64,
        /// End of the domain.
        end: f64,
    },
    /// A knot to insert would stand there too often.
    #[error(
        "knot {value} stands {present} times already, and {times} more would exceed degree = {degree} times: the curve gains nothing by it, insert fewer"
    )]
    KnotFull {
        /// The knot value.
        value: f64,
        /// The number of times it stands there already.
        present: usize,
        /// The number of times it was to be inserted.
        times: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// An angle that an arc cannot sweep.
    #[error("{what} is {value} rad: it must be finite, and the sweep between -2 pi and 2 pi and not 0")]
    ArcAngle {
        /// Which angle.
        what: &'static str,
        /// The value given, in rad.
        value: f64,
    },
    /// A tolerance or a step that has to be positive is not.
    #[error("{what} is {value}, but has to be a finite number above 0")]
    NotPositive {
        /// Which argument.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A tolerance lost in the rounding of the coordinates.
    #[error(
        "the tolerance {tolerance} is below {smallest}, where the rounding of the curve's coordinates begins: raise the tolerance, or move the curve nearer to the origin"
    )]
    ToleranceTooSmall {
        /// The tolerance given.
        tolerance: f64,
        /// The smallest meaningful one for this curve.
        smallest: f64,
    },
    /// A tolerance that asks for more pieces than fit in memory.
    #[error(
        "with the tolerance {tolerance} the curve needs about {estimate:.2e} segments, and the limit is {limit}: raise the tolerance (check its unit: the curve's), or split the curve"
    )]
    TooManySegments {
        /// The tolerance given.
        tolerance: f64,
        /// Estimated number of segments.
        estimate: f64,
        /// Largest number allowed.
        limit: usize,
    },
    /// The parameter has no numbers left between the ends of a piece that is still too long.
    #[error(
        "near u = {u} the curve moves by more than the tolerance {tolerance} between neighbouring parameter values: spread its knots over a wider range, or raise the tolerance"
    )]
    ParameterTooCoarse {
        /// Parameter of the place.
        u: f64,
        /// The tolerance given.
        tolerance: f64,
    },
    /// The curve has no length.
    #[error("the curve has length {length}: all its points coincide, there is nothing to follow")]
    ZeroLength {
        /// The measured length.
        length: f64,
    },
    /// The speed |C'(u)| vanishes: a cusp or coincident control points.
    #[error(
        "the curve stands still near u = {u} (|C'| = {speed} of a mean of {mean}): there is a cusp or control points coincide; remove repeated control points or split the curve there"
    )]
    StandsStill {
        /// Parameter where the derivative vanishes.
        u: f64,
        /// |C'(u)| there.
        speed: f64,
        /// Mean of |C'| over the curve.
        mean: f64,
    },
    /// Too few points to lay a curve through.
    #[error("{points} data points are too few: at least {needed} are needed; lower the degree or add points")]
    TooFewDataPoints {
        /// Number of points given.
        points: usize,
        /// Number needed.
        needed: usize,
    },
    /// Two consecutive points that have to differ coincide.
    #[error("data points {index} and {} coincide (distance {distance}): remove one of them", index + 1)]
    DuplicatePoints {
        /// Index of the first of the two.
        index: usize,
        /// Distance between them.
        distance: f64,
    },
    /// A degree too high for fitting.
    #[error("degree {degree} is too high for a fit, at most {limit} keeps its digits: 3 to 5 is usual")]
    FitDegree {
        /// The degree given.
        degree: usize,
        /// The highest allowed.
        limit: usize,
    },
    /// The requested tolerance is not reached.
    #[error(
        "the best fit with {control_points} control points deviates by {reached}, above the tolerance {tolerance}: raise the tolerance, or check the points for outliers"
    )]
    FitTolerance {
        /// Deviation reached.
        reached: f64,
        /// Tolerance asked for.
        tolerance: f64,
        /// Number of control points used.
        control_points: usize,
    },
    /// A linear system of a fit is singular.
    #[error("the fitting equations are singular: {reason}")]
    SingularFit {
        /// Why, in words.
        reason: &'static str,
    },
    /// Keys of an orientation profile are not usable.
    #[error("orientation key {index} stands at {value}: keys must increase strictly and lie in [{start}, {end}]")]
    OrientationKey {
        /// Index of the key.
        index: usize,
        /// Its position along the path.
        value: f64,
        /// Start of the allowed range.
        start: f64,
        /// End of the allowed range.
        end: f64,
    },
    /// The tangent is parallel to the axis about which the tool turns, so that it has no heading.
    #[error(
        "at s = {s} the path runs along the tool axis, where \"follow the tangent\" has no direction: use another orientation mode, or another axis"
    )]
    NoHeading {
        /// Arc length of the place.
        s: f64,
    },
    /// The direction of the path jumps, so that a tool following the tangent would have to turn at once.
    #[error(
        "at s = {s} the path has a corner of {angle} rad, where \"follow the tangent\" would have to turn at once: round the corner, or use another orientation mode"
    )]
    HeadingJump {
        /// Arc length of the place.
        s: f64,
        /// Angle of the corner, rad.
        angle: f64,
    },
    /// A pose is not one.
    #[error(
        "the {what} pose has a sum of coordinates of {place} and a quaternion of norm {norm}: coordinates have to be finite and quaternions of unit length"
    )]
    PoseNotFinite {
        /// Which pose.
        what: &'static str,
        /// Sum of its coordinates, m.
        place: f64,
        /// Norm of its quaternion.
        norm: f64,
    },
    /// A motion goes nowhere.
    #[error(
        "start and goal are the same pose (they differ by {distance:e} m and {angle:e} rad, at least 1e-9 of one is needed): drop the motion, or move the goal"
    )]
    SamePose {
        /// Distance of the tool points, m.
        distance: f64,
        /// Angle between the orientations, rad.
        angle: f64,
    },
    /// A path without pieces.
    #[error("the path has no pieces: append a line, an arc, a helix or a curve before it is built")]
    EmptyPath,
    /// A piece of a path has no length.
    #[error(
        "the piece from input line {line} has length {length:e}, and at least {least:e} is needed, where the rounding of its coordinates ends: drop it, or move the path nearer to the origin"
    )]
    PieceTooShort {
        /// Line of the input the piece comes from.
        line: usize,
        /// Its length.
        length: f64,
        /// Least length.
        least: f64,
    },
    /// An arc has no radius.
    #[error("the arc from input line {line} has radius {radius:e}: its centre has to lie off its start")]
    ArcRadius {
        /// Line of the input the arc comes from.
        line: usize,
        /// Distance of its start from its axis.
        radius: f64,
    },
    /// The normal of the plane of an arc is not a direction.
    #[error("the arc from input line {line} has a normal of length {norm}: give three finite numbers of length 1")]
    ArcNormal {
        /// Line of the input the arc comes from.
        line: usize,
        /// Length of the normal.
        norm: f64,
    },
    /// The end of an arc is not on its circle.
    #[error(
        "the arc from input line {line} has an end that is off its circle: a circle through both ends deviates by {deviation:e}, above the tolerance {tolerance:e}; correct the centre or the end, or raise the tolerance"
    )]
    ArcEnd {
        /// Line of the input the arc comes from.
        line: usize,
        /// Deviation of a circle through both ends from the one that is programmed.
        deviation: f64,
        /// Tolerance of the path.
        tolerance: f64,
    },
    /// An arc or a helix has too many turns.
    #[error("the arc from input line {line} has {turns} full turns, and the limit is {limit}: divide it into several")]
    TooManyTurns {
        /// Line of the input the arc comes from.
        line: usize,
        /// Full turns given.
        turns: u32,
        /// Most full turns.
        limit: u32,
    },
    /// A curve starts away from the end of the path so far.
    #[error(
        "the curve from input line {line} starts {gap:e} away from the end of the path, above the tolerance {tolerance:e}: join them by a line, or raise the tolerance"
    )]
    CurveStart {
        /// Line of the input the curve comes from.
        line: usize,
        /// Distance between the end of the path and the start of the curve.
        gap: f64,
        /// Tolerance of the path.
        tolerance: f64,
    },
    /// A setting of a blend is not usable.
    #[error("at joint {joint} the {what} of the blend is {value}: it has to be {rule}")]
    Blending {
        /// Index of the joint, from 0.
        joint: usize,
        /// Which setting.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What it has to be.
        rule: &'static str,
    },
    /// The number of orientations does not fit the path.
    #[error(
        "{keys} orientations for a path of {pieces} programmed pieces: give one for the start and one for the end of each piece, {} in all",
        pieces + 1
    )]
    OrientationCount {
        /// Number of orientations given.
        keys: usize,
        /// Number of calls of the builder that appended a piece.
        pieces: usize,
    },
    /// A curve is not the one of the path.
    #[error(
        "the curve has the domain [{start}, {end}], and that of the path ends at {expected}: make the curve with `to_curve` of the same path"
    )]
    OtherCurve {
        /// First parameter of the curve.
        start: f64,
        /// Last parameter of the curve.
        end: f64,
        /// Last parameter of the path.
        expected: f64,
    },
}
