//! Limits, warnings and files as every report shows them.

use std::fmt::{self, Formatter};
use std::path::PathBuf;

use crate::run::limit_line::{LimitLine, worst};
use crate::text::{WIDTH, clip, number, percent};

/// Lines that each kind of content may take, so that a report stays on one screen of 40 lines.
const MOST_LIMITS: usize = 15;
const MOST_JOINT_ROWS: usize = 5;

/// The last lines of a report: up to `most` warnings and files of each.
pub(crate) fn ending(f: &mut Formatter<'_>, warnings: &[String], files: &[PathBuf], most: [usize; 2]) -> fmt::Result {
    if !(warnings.is_empty() && files.is_empty()) {
        writeln!(f)?;
    }
    for warning in warnings.iter().take(most[0]) {
        writeln!(f, "  warning: {}", clip(warning, WIDTH - 11))?;
    }
    more(f, warnings.len(), most[0], "warnings")?;
    for file in files.iter().take(most[1]) {
        writeln!(f, "  wrote {}", clip(&file.display().to_string(), WIDTH - 8))?;
    }
    more(f, files.len(), most[1], "files")
}

/// The table of limits: each with its worst place, then what each joint uses of its own.
pub(crate) fn limit_table(f: &mut Formatter<'_>, limits: &[LimitLine]) -> fmt::Result {
    let groups = groups(limits);
    if !groups.is_empty() {
        writeln!(f)?;
        let place = if limits.iter().any(|l| l.at_s_m.is_some()) { "at s [mm]" } else { "" };
        let (when, wide) = if limits.iter().any(|l| l.lines.is_some()) { ("line", 13) } else { ("at t [s]", 10) };
        let head = format!(
            "  {:<24}{:<6}{:>12}{:>12}  {:<9}{:>8}{:>12}{when:>wide$}",
            "limit", "worst", "value", "limit", "", "used", place
        );
        writeln!(f, "{}", head.trim_end())?;
    }
    for (name, lines) in groups.iter().take(MOST_LIMITS) {
        let Some(worst) = worst(lines.iter().copied()) else { continue };
        let (factor, unit) = worst.unit.for_people();
        let joint = worst.joint.map(|j| format!("J{j}")).unwrap_or_default();
        writeln!(
            f,
            "{} {:<24}{joint:<6}{:>12}{:>12}  {unit:<9}{:>8}{:>12}{}",
            if worst.holds() { " " } else { "!" },
            clip(name, 23),
            number(worst.value * factor),
            number(worst.limit * factor),
            percent(worst.ratio),
            worst.at_s_m.map(|s| format!("{:.2}", s * 1e3)).unwrap_or_default(),
            worst.lines.map_or_else(|| format!("{:>10.3}", worst.at_t_s), |lines| format!("{:>13}", line_words(lines))),
        )?;
    }
    more(f, groups.len(), MOST_LIMITS, "limits")?;

    let jointed: Vec<_> = groups.iter().filter(|(_, l)| l.len() > 1 && l.iter().all(|l| l.joint.is_some())).collect();
    if let Some(most) = jointed.iter().flat_map(|(_, l)| l.iter().filter_map(|l| l.joint)).max() {
        let most = most.min(7);
        writeln!(f)?;
        write!(f, "  {:<24}", "used by joint")?;
        for j in 1..=most {
            write!(f, "{:>10}", format!("J{j}"))?;
        }
        writeln!(f)?;
        for (name, lines) in jointed.iter().take(MOST_JOINT_ROWS) {
            write!(f, "  {:<24}", clip(name, 23))?;
            for j in 1..=most {
                let cell = lines.iter().find(|l| l.joint == Some(j)).map(|l| percent(l.ratio));
                write!(f, "{:>10}", cell.unwrap_or_default())?;
            }
            writeln!(f)?;
        }
        more(f, jointed.len(), MOST_JOINT_ROWS, "kinds")?;
    }
    Ok(())
}

/// A line of a file, or the two whose corner is blended.
pub(crate) fn line_words([from, to]: [usize; 2]) -> String {
    if from == to { from.to_string() } else { format!("{from}-{to}") }
}

/// Names of the limits in their order, each with its lines.
fn groups(limits: &[LimitLine]) -> Vec<(&str, Vec<&LimitLine>)> {
    let mut groups: Vec<(&str, Vec<&LimitLine>)> = Vec::new();
    for line in limits {
        match groups.iter_mut().find(|(name, _)| *name == line.name) {
            Some((_, lines)) => lines.push(line),
            None => groups.push((&line.name, vec![line])),
        }
    }
    groups
}

/// A line for what a list has beyond the `shown` entries.
pub(crate) fn more(f: &mut Formatter<'_>, all: usize, shown: usize, what: &str) -> fmt::Result {
    if all > shown { writeln!(f, "  and {} more {what} (all in the JSON report)", all - shown) } else { Ok(()) }
}
