//! Online generation: the calls of a control cycle.

use crate::axes::{self, ArcfeedMotionState};
use crate::generator::{ArcfeedEvents, ArcfeedGenerator};
use crate::input::{finite, held, place, put, read_all, same_count, write_all};
use crate::status::{ArcfeedStatus, guarded, of_sync};

/// Moves on by one cycle. `states` gets what to command at its end, one entry for each axis; `events`, if it is not NULL,
/// what happened.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_step(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    states: *mut ArcfeedMotionState,
    events: *mut ArcfeedEvents,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let generator = place("generator", generator)?;
        same_count(axes, generator.inner.axes())?;
        place("states", states)?;
        // All before the step, so that a call that fails has moved nothing.
        let wanted = if events.is_null() { None } else { Some(place("events", events)?) };
        let (all, what) = generator.inner.step();
        write_all("states", states, all.into_iter().take(axes))?;
        if let Some(events) = wanted {
            *events = what;
        }
        Ok(())
    })
}

/// Brings every axis to rest in the shortest way of its own, and gives up the targets.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_stop(generator: *mut ArcfeedGenerator) -> ArcfeedStatus {
    guarded(|| unsafe { place("generator", generator)?.inner.stop().map_err(of_sync) })
}

/// Brings all axes to rest together on the curve of their plan, and gives up the targets.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_stop_on_path(generator: *mut ArcfeedGenerator) -> ArcfeedStatus {
    guarded(|| unsafe {
        place("generator", generator)?.inner.stop_on_path();
        Ok(())
    })
}

/// Moves the axes at `velocity`, one entry for each, until `timeout` (s) is over; then they stop. Another call renews the
/// time.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_jog(
    generator: *mut ArcfeedGenerator,
    axes: usize,
    velocity: *const f64,
    timeout: f64,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let generator = place("generator", generator)?;
        same_count(axes, generator.inner.axes())?;
        let velocity = read_all("velocity", velocity, axes, axes::number)?;
        generator.inner.jog(&velocity, finite(&"timeout", "", timeout)?).map_err(of_sync)
    })
}

/// Sets the scale of time, from 0 to 1.5: 0.5 plays every plan at half its velocity, on the same curve.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_set_scale(generator: *mut ArcfeedGenerator, scale: f64) -> ArcfeedStatus {
    guarded(|| unsafe { place("generator", generator)?.inner.set_scale(scale).map_err(of_sync) })
}

/// Brings the scale of time to 0: the axes rest on their curve until `arcfeed_generator_resume`.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_hold(generator: *mut ArcfeedGenerator) -> ArcfeedStatus {
    guarded(|| unsafe {
        place("generator", generator)?.inner.hold();
        Ok(())
    })
}

/// Ends a hold.
///
/// # Safety
/// The generator is NULL or one that is in use nowhere else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_resume(generator: *mut ArcfeedGenerator) -> ArcfeedStatus {
    guarded(|| unsafe {
        place("generator", generator)?.inner.resume();
        Ok(())
    })
}

/// Whether an axis has still to reach its target.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_is_underway(
    generator: *const ArcfeedGenerator,
    is_underway: *mut bool,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("is_underway", is_underway, held("generator", generator)?.inner.is_underway()) })
}

/// Time until the last axis has reached its target (s), at scale 1.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_time_left(
    generator: *const ArcfeedGenerator,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe { put("seconds", seconds, held("generator", generator)?.inner.time_left()) })
}

/// The scale of time at the end of the last cycle.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_generator_scale(generator: *const ArcfeedGenerator, scale: *mut f64) -> ArcfeedStatus {
    guarded(|| unsafe { put("scale", scale, held("generator", generator)?.inner.scale()) })
}
