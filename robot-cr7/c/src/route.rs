//! Routes through way-points.

use std::fmt::Display;

use arcfeed_sync::{MOST_WAY_POINTS, Route, SyncError, WayPoint};

use crate::axes::{self, ArcfeedAxisLimits, ArcfeedAxisState, of_axes};
use crate::input::{ARCFEED_MAX_AXES, finite, held, not_negative, read_all};
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{Outcome, of_sync, refuse};

/// The most way-points of a route.
pub const ARCFEED_MAX_WAY_POINTS: usize = 64;

const _: () = assert!(ARCFEED_MAX_WAY_POINTS == MOST_WAY_POINTS);

/// A position that all axes pass at the same time, and what holds on the section that ends there. Entries past the number
/// of axes are not read. Only the position must be given: a field left at 0 sets nothing.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedWayPoint {
    /// The position of each axis (rad or m).
    pub position: [f64; ARCFEED_MAX_AXES],
    /// The velocity of each axis whose bit is in `has_velocity` (rad/s or m/s).
    pub velocity: [f64; ARCFEED_MAX_AXES],
    /// Bit k: axis k passes with `velocity[k]`. The others pass as is best.
    pub has_velocity: u32,
    /// Limits of the section that ends here, one entry for each axis; NULL for those of the route.
    pub limits: *const ArcfeedAxisLimits,
    /// Least duration of the section that ends here (s); 0 for the shortest.
    pub least_duration: f64,
    /// Between two straight sections the point is passed within this distance (root of the sum of the squares of all axes, rad
    /// or m), or the axes rest where that is faster; with 0 they rest.
    pub blend: f64,
    /// 0 or 1; with 1 all axes move on a straight line to the point.
    pub straight: u8,
}

/// Way-points, the target after them, and limits. Points and blends together are at most `ARCFEED_MAX_WAY_POINTS`. A call copies
/// what it points to.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedRoute {
    /// Number of way-points, from 0 to `ARCFEED_MAX_WAY_POINTS`.
    pub count: usize,
    /// The way-points; may be NULL if there are none.
    pub points: *const ArcfeedWayPoint,
    /// The state of each axis at the end.
    pub target: *const ArcfeedAxisState,
    /// The limits of each axis.
    pub limits: *const ArcfeedAxisLimits,
    /// Limits of the section that ends in the target, one entry for each axis; NULL for those of the route.
    pub last_limits: *const ArcfeedAxisLimits,
    /// Least duration of the section that ends in the target (s); 0 for the shortest.
    pub last_least_duration: f64,
    /// 0 or 1; with 1 all axes move on a straight line to the target.
    pub last_straight: u8,
}

/// Runs a call with a route for `N` axes.
///
/// # Safety
/// Pointers of the route are NULL, not aligned, or point to what their names say.
pub unsafe fn with_route<T, const N: usize>(
    c: &ArcfeedRoute,
    call: impl FnOnce(&Route<'_, N>) -> Result<T, SyncError>,
) -> Outcome<T> {
    if c.count > ARCFEED_MAX_WAY_POINTS {
        let count = c.count;
        return Err(refuse(
            ArcfeedInvalid,
            format_args!("route.count is {count}; it must be at most {ARCFEED_MAX_WAY_POINTS}: send the others later"),
        ));
    }
    let mut points = [WayPoint::new([0.0; N]); ARCFEED_MAX_WAY_POINTS];
    if c.count > 0 {
        unsafe { held("route.points", c.points) }?;
    }
    for (index, point) in points[..c.count].iter_mut().enumerate() {
        // SAFETY: checked above, and promised by the caller.
        *point = unsafe { way_point(index, &*c.points.add(index)) }?;
    }
    let target = unsafe { read_all("route.target", c.target, N, axes::state) }?;
    let limits = unsafe { read_all("route.limits", c.limits, N, axes::limits) }?;
    let least = not_negative(&"route", ".last_least_duration", c.last_least_duration)?;
    let mut route = Route::new(&points[..c.count], of_axes(&target), of_axes(&limits)).with_least_duration(least);
    if !c.last_limits.is_null() {
        let limits = unsafe { read_all("route.last_limits", c.last_limits, N, axes::limits) }?;
        route = route.with_limits(of_axes(&limits));
    }
    if yes(&"route", ".last_straight", c.last_straight)? {
        route = route.with_straight_section();
    }
    call(&route).map_err(|error| match error {
        SyncError::TooManyWayPoints { count, most } => refuse(
            ArcfeedInvalid,
            format_args!(
                "route.count is {}, with blends {count}; together they must be at most {most}: send the others later",
                c.count
            ),
        ),
        error => of_sync(error),
    })
}

/// A number that says yes or no.
fn yes(place: &dyn Display, field: &str, value: u8) -> Outcome<bool> {
    match value {
        0 | 1 => Ok(value == 1),
        _ => Err(refuse(ArcfeedInvalid, format_args!("{place}{field} is {value}; it must be 0 or 1"))),
    }
}

/// A way-point of a route.
///
/// # Safety
/// The limits are NULL, not aligned, or point to an entry for each axis.
unsafe fn way_point<const N: usize>(index: usize, c: &ArcfeedWayPoint) -> Outcome<WayPoint<N>> {
    let here = format_args!("route.points[{index}]");
    let position = unsafe { read_all(format_args!("{here}.position"), c.position.as_ptr(), N, axes::number) }?;
    let mut point = WayPoint::new(of_axes(&position));
    let bits = c.has_velocity;
    if bits >> N != 0 {
        return Err(refuse(
            ArcfeedInvalid,
            format_args!("{here}.has_velocity is {bits:#b}; it must have bits of the {N} axes only"),
        ));
    }
    for axis in (0..N).filter(|axis| bits >> axis & 1 == 1) {
        let value = finite(&format_args!("{here}.velocity[{axis}]"), "", c.velocity[axis])?;
        point = point.with_velocity(axis, value);
    }
    if !c.limits.is_null() {
        let limits = unsafe { read_all(format_args!("{here}.limits"), c.limits, N, axes::limits) }?;
        point = point.with_limits(of_axes(&limits));
    }
    if yes(&here, ".straight", c.straight)? {
        point = point.with_straight_section();
    }
    if not_negative(&here, ".blend", c.blend)? > 0.0 {
        point = point.with_blend(c.blend);
    }
    Ok(point.with_least_duration(not_negative(&here, ".least_duration", c.least_duration)?))
}
