//! Checks of the order of the events before anything moves.

use arcfeed_feedrate::MAX_SECTIONS;

use super::{Action, Event, When};
use crate::input::error::InputError;
use crate::input::toml_check::Check;

/// The known state of the motion between two events.
#[derive(Debug, Default)]
struct Known {
    /// Number of the event that left the path, if it has not been told to return.
    away: Option<usize>,
    /// Number of the event that holds, if nothing went on after it.
    held: Option<usize>,
    /// True if there is anything to resume.
    resumable: bool,
    /// Number of the event that set the override to 0.
    zero: Option<usize>,
    stopped: bool,
    sections: usize,
    /// Time of the last event with one, s, and arc length of the last event with one, m.
    time: f64,
    length: f64,
}

/// Refuses events that cannot come in this order.
pub(super) fn check_order(check: &Check<'_>, events: &[Event], period: f64) -> Result<(), InputError> {
    let mut known = Known::default();
    for (i, event) in events.iter().enumerate() {
        if known.stopped {
            let rule = "after a stop the motion is over";
            return Err(check.wrong(
                &key(i, "do"),
                event.action.name(),
                rule,
                "remove the event, or hold in place of the stop",
            ));
        }
        when(check, i, event, &mut known, period)?;
        action(check, i, event, &mut known)?;
    }
    let open = [
        (known.away, "after it the path is left for good", "add a return (wait_s = 1.0), or a stop"),
        (known.held, "after it the motion stands for good", "add a resume (wait_s = 1.0), or a stop"),
        (known.zero, "an override of 0 holds, and nothing raises it again", "add another override, or a stop"),
    ];
    for (event, rule, remedy) in open {
        if let (Some(i), false) = (event, known.stopped) {
            return Err(check.wrong(&key(i, "do"), events[i].action.name(), rule, remedy));
        }
    }
    Ok(())
}

fn key(i: usize, name: &str) -> String {
    format!("event[{i}].{name}")
}

fn when(check: &Check<'_>, i: usize, event: &Event, known: &mut Known, period: f64) -> Result<(), InputError> {
    let in_order = |name: &str, value: f64, before: f64, unit: f64| {
        if value >= before {
            return Ok(value);
        }
        let value = format!("{} after {}", value * unit, before * unit);
        let rule = "events stand in the order in which they come";
        Err(check.wrong(&key(i, name), value, rule, "sort them"))
    };
    match event.when {
        When::Time(t) => known.time = in_order("at_s", t, known.time, 1.0)?,
        When::Cycle(cycle) => {
            // Compared as times, so that both kinds can be mixed; shown in cycles.
            let (t, unit) = (cycle as f64 * period, 1.0 / period);
            known.time = in_order("at_cycle", t, known.time - 1e-9 * period, unit)?.max(known.time);
        }
        When::Length(_) if known.away.is_some() => {
            let rule = "off the path no arc length is passed";
            return Err(check.wrong(&key(i, "at_mm"), "given", rule, "use wait_s or at_s, or return before"));
        }
        When::Length(s) => known.length = in_order("at_mm", s, known.length, 1e3)?,
        When::Stood(_) => {
            if known.away.is_none() && known.held.is_none() && known.zero.is_none() {
                let rule = "nothing before it lets the arm stand";
                return Err(check.wrong(
                    &key(i, "wait_s"),
                    "given",
                    rule,
                    "use at_s, or put it after a leave or a hold",
                ));
            }
        }
    }
    Ok(())
}

fn action(check: &Check<'_>, i: usize, event: &Event, known: &mut Known) -> Result<(), InputError> {
    let wrong = |rule, remedy| Err(check.wrong(&key(i, "do"), event.action.name(), rule, remedy));
    match &event.action {
        Action::Feed(_) => {}
        Action::Override(factor) => known.zero = (*factor == 0.0).then_some(i),
        Action::Section(_) => {
            known.sections += 1;
            if known.sections > MAX_SECTIONS {
                return wrong("at most 16 sections are set at a time", "clear sections before, or leave some out");
            }
        }
        Action::ClearSections => known.sections = 0,
        Action::Hold => (known.held, known.resumable) = (Some(i), true),
        Action::StepBackTo(_) | Action::StepBackBy(_) if known.away.is_some() => {
            return wrong("the tool is off its path, where nothing can be stepped back", "return before");
        }
        Action::StepBackTo(_) | Action::StepBackBy(_) => {
            (known.held, known.resumable, known.length) = (Some(i), true, 0.0);
        }
        Action::Resume if !known.resumable => {
            return wrong("no hold or step back comes before it", "remove it, or add a hold");
        }
        Action::Resume => (known.held, known.resumable) = (None, false),
        Action::Leave(..) => known.away = Some(i),
        Action::Return if known.away.is_none() => {
            return wrong("no event has left the path before it", "remove it, or add a leave");
        }
        // Going back goes on along the path, too.
        Action::Return => (known.away, known.held) = (None, None),
        Action::Stop => known.stopped = true,
    }
    Ok(())
}
