//! Online generation: routes through way-points.

use crate::axes::ArcfeedMotionState;
use crate::generator::ArcfeedGenerator;
use crate::input::{finite, held, place, put, read, same_count, write_all};
use crate::route::ArcfeedRoute;
use crate::status::ArcfeedStatus::ArcfeedInvalid;
use crate::status::{ArcfeedStatus, guarded, refuse};

/// Gives the generator the memory that routes are planned in, some 0.1 MB for one axis and 0.6 MB for eight. Called once
/// before the first route; it allocates, and takes up to 0.8 MB of stack.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_reserve_way_points(generator: *mut ArcfeedGenerator) -> ArcfeedStatus {
    guarded(|| unsafe {
        place("generator", generator)?.inner.reserve_way_points();
        Ok(())
    })
}

/// Goes along a route from the present state of motion on, whatever the axes do. Plans it, in a time bounded by the number of
/// its points and with up to 0.54 MB of stack for eight axes. The limits of the route take the place of those of the generator.
/// A call that is refused changes nothing.
///
/// # Safety
/// Pointers, those of the route, too, are NULL or point to what their names say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_route(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    route: *const ArcfeedRoute,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &mut place("generator", generator)?.inner;
        same_count(axes, inner.axes())?;
        inner.set_route(&read("route", route)?)
    })
}

/// Number of sections of the route set last: one more than it has way-points, and one more for each corner that is rounded and for
/// a stop before a straight line that begins in motion; 0 before the first route.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_sections(
    generator: *const ArcfeedGenerator,
    count: *mut usize,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("count", count, held("generator", generator)?.inner.section_durations().len()) })
}

/// Durations of the sections of the route set last (s); `count` must be their number.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `seconds` has room for `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_section_durations(
    generator: *const ArcfeedGenerator,
    count: usize,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let durations = held("generator", generator)?.inner.section_durations();
        if count != durations.len() {
            let own = durations.len();
            return Err(refuse(ArcfeedInvalid, format_args!("count is {count}; this route has {own} sections")));
        }
        write_all("seconds", seconds, durations.iter().copied())
    })
}

/// The state of the motion along the route set last at time `t` (s) from its beginning, one entry of `states` for each
/// axis, without regard to cycles and other commands. Computes the section of `t` anew.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_route_at(
    generator: *const ArcfeedGenerator,
    t: f64,
    axes: usize,
    states: *mut ArcfeedMotionState,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let inner = &held("generator", generator)?.inner;
        same_count(axes, inner.axes())?;
        let all = inner.route_at(finite(&"t", "", t)?);
        write_all("states", states, all.into_iter().take(axes))
    })
}
