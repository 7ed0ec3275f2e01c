//! Columns of a trajectory that name their joint.

/// A column with the name of its joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedColumn {
    /// The column without the name of the joint, as `qd1_rad_s`.
    pub column: String,
    /// The joint, from 0.
    pub joint: usize,
    /// The name of the joint.
    pub name: String,
}

impl NamedColumn {
    /// The column of that name, where it is one of a joint: of positions, velocities, accelerations or of the jerks that the
    /// project's own files have.
    pub(super) fn of(name: &str) -> Option<Self> {
        let (column, joint) = name.split_once(':')?;
        let quantity = column.split_once('_')?.0;
        let group = quantity.trim_end_matches(|c: char| c.is_ascii_digit());
        let number: usize =
            quantity[group.len()..].parse().ok().filter(|_| ["q", "qd", "qdd", "jerk"].contains(&group))?;
        Some(Self { column: column.to_owned(), joint: number.checked_sub(1)?, name: joint.to_owned() })
    }
}
