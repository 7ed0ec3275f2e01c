//! Where limits bind, as lines of a report.

use arcfeed_interp::Binding;
use serde::Serialize;

/// The intervals in which one limit binds: 99.9 % of it or more is used.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BindingLine {
    /// Which limit, in words: "torque of joint 3".
    pub limit: String,
    /// From where to where, by the parameter of the motion (m or rad), increasing.
    pub intervals: Vec<[f64; 2]>,
}

impl BindingLine {
    /// The lines of `bindings` on a path that begins at `from` of the whole way.
    pub(crate) fn of(bindings: &[Binding], from: f64) -> Vec<Self> {
        let line = |binding: &Binding| Self {
            limit: binding.id.to_string(),
            intervals: binding.intervals.iter().map(|&(a, b)| [from + a, from + b]).collect(),
        };
        bindings.iter().map(line).collect()
    }

    /// Adds the lines of a later part of the way; those on one limit become one.
    pub(crate) fn append(all: &mut Vec<Self>, lines: Vec<Self>) {
        for line in lines {
            match all.iter_mut().find(|other| other.limit == line.limit) {
                Some(other) => other.intervals.extend(line.intervals),
                None => all.push(line),
            }
        }
    }

    /// Length of all its intervals.
    pub fn length(&self) -> f64 {
        self.intervals.iter().map(|[from, to]| to - from).sum()
    }
}

/// What limits the motion most of its way, in words: "jerk of joint 3 on 41 % of the path, feed on 12 %"; none where nothing binds on
/// 1 % of it.
pub(crate) fn limited_by(lines: &[BindingLine], length: f64) -> Option<String> {
    let mut shares: Vec<(f64, &str)> =
        lines.iter().map(|line| (100.0 * line.length() / length, line.limit.as_str())).collect();
    shares.retain(|(share, _)| *share >= 1.0);
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut words = shares.iter().enumerate().map(|(i, (share, limit))| match i {
        0 => format!("{limit} on {share:.0} % of the path"),
        _ => format!("{limit} on {share:.0} %"),
    });
    let first = words.next()?;
    Some(words.take(2).fold(first, |all, next| all + ", " + &next))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(limit: &str, intervals: &[[f64; 2]]) -> BindingLine {
        BindingLine { limit: limit.to_owned(), intervals: intervals.to_vec() }
    }

    #[test]
    fn the_limit_that_binds_on_most_of_the_path_comes_first() {
        let mut lines = vec![line("feed", &[[0.0, 0.1]]), line("jerk of joint 3", &[[0.2, 0.3]])];
        BindingLine::append(
            &mut lines,
            vec![line("jerk of joint 3", &[[0.7, 1.01]]), line("torque of joint 1", &[[1.0, 1.0]])],
        );
        assert_eq!(lines.len(), 3);
        let words = limited_by(&lines, 1.0).expect("two bind");
        assert_eq!(words, "jerk of joint 3 on 41 % of the path, feed on 10 %");
        assert_eq!(limited_by(&lines[2..], 1.0), None);
        assert_eq!(limited_by(&[], 1.0), None);
    }
}
