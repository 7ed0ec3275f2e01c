//! Numbers and words for people, and JSON.

use serde::Serialize;

use crate::run::limit_line::TOLERANCE;

/// Columns of a terminal that a report fits into.
pub(crate) const WIDTH: usize = 100;

/// The whole value as one JSON object on one line. Numbers that are not finite become `null`.
pub(crate) fn json<T: Serialize>(value: &T) -> String {
    // Serialising plain fields and lists cannot fail; should it ever, the message is still one JSON object.
    serde_json::to_string(value).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
}

/// The text on one line, cut to `width` characters.
pub(crate) fn clip(text: &str, width: usize) -> String {
    let flat = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    if text.chars().count() <= width {
        return flat.collect();
    }
    flat.take(width.saturating_sub(3)).chain("...".chars()).collect()
}

/// A text of a file on one line, for a message; of a long one its beginning and its end, where readers say what they expect.
pub(crate) fn shortened(text: &str) -> String {
    const BEGINNING: usize = 300;
    const END: usize = 200;
    let length = text.chars().count();
    let flat = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    if length <= BEGINNING + END {
        return flat.collect();
    }
    let end = flat.clone().skip(length - END);
    flat.take(BEGINNING).chain(" ... ".chars()).chain(end).collect()
}

/// A number with about five significant digits and no exponent where it can be avoided.
pub(crate) fn number(v: f64) -> String {
    let a = v.abs();
    if !v.is_finite() {
        return v.to_string();
    }
    match a {
        0.0 => "0".to_owned(),
        _ if !(1e-4..1e8).contains(&a) => format!("{v:.3e}"),
        _ if a >= 1e4 => format!("{v:.0}"),
        _ => {
            let digits = (4 - a.log10().floor() as i32).clamp(0, 8) as usize;
            let text = format!("{v:.digits$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
    }
}

/// A share in percent, rounded so that what is above 100 % by more than rounding is never shown as 100 %.
pub(crate) fn percent(ratio: f64) -> String {
    let p = ratio * 100.0;
    if ratio > 1.0 + TOLERANCE && p < 100.01 {
        ">100 %".to_owned()
    } else if p < 1000.0 {
        format!("{p:.2} %")
    } else {
        format!("{p:.0} %")
    }
}

/// A time in the unit that suits it.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{} us", number((s * 1e7).round() / 10.0)),
        s if s < 1.0 => format!("{} ms", number((s * 1e5).round() / 100.0)),
        s => format!("{} s", number((s * 1e3).round() / 1e3)),
    }
}
