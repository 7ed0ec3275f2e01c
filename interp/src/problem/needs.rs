//! The kinds of limits that a planner needs.

/// The rows that a planner needs; each kind includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RowsNeeded {
    /// Those at the grid points.
    Points,
    /// Those between the grid points.
    Between,
    /// Those on jerk.
    Jerk,
}
