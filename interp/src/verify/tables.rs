//! Limits of joints by tables at one sample, in code of its own.

use arcfeed_kinematics::Joints;

use crate::limits::{JointTables, TableKind};

/// The limit of a table at an argument, straight between its points.
fn value(points: &[[f64; 2]], argument: f64) -> f64 {
    let mut before = points[0];
    for &point in points {
        if argument < point[0] {
            let part = (argument - before[0]) / (point[0] - before[0]);
            // Before the first point both are the same.
            return if point == before { point[1] } else { (1.0 - part) * before[1] + part * point[1] };
        }
        before = point;
    }
    before[1]
}

/// The least of a constant limit and of those that tables of `kinds` give joint `k` at position `q` and velocity `qd`.
pub(super) fn limit<const N: usize>(
    constant: f64,
    tables: Option<&JointTables<N>>,
    kinds: &[TableKind],
    k: usize,
    (q, qd): (&Joints<N>, &Joints<N>),
) -> f64 {
    let Some(tables) = tables else { return constant };
    kinds.iter().filter_map(|kind| Some((kind, tables.of(*kind, k)?))).fold(constant, |least, (kind, table)| {
        let argument = if kind.is_by_speed() { qd[k].abs() } else { q[k] };
        least.min(value(table.points(), argument))
    })
}

/// The highest limit that a mean between two samples of position and velocity may come to: that of each table where the motion between
/// them finds it highest.
pub(super) fn limit_of_mean<const N: usize>(
    constant: f64,
    tables: Option<&JointTables<N>>,
    kinds: &[TableKind],
    k: usize,
    samples: [(&Joints<N>, &Joints<N>); 2],
) -> f64 {
    let Some(tables) = tables else { return constant };
    kinds.iter().filter_map(|kind| Some((kind, tables.of(*kind, k)?))).fold(constant, |least, (kind, table)| {
        let ends = samples.map(|(q, qd)| if kind.is_by_speed() { qd[k].abs() } else { q[k] });
        let turns = kind.is_by_speed() && samples[0].1[k] * samples[1].1[k] < 0.0;
        let from = if turns { 0.0 } else { ends[0].min(ends[1]) };
        let to = ends[0].max(ends[1]);
        let inside = table.points().iter().filter(|point| from < point[0] && point[0] < to).map(|point| point[1]);
        let at_ends = value(table.points(), from).max(value(table.points(), to));
        least.min(inside.fold(at_ends, f64::max))
    })
}

/// The tables that limit acceleration, jerk and torque.
pub(super) const ACCELERATION: [TableKind; 2] = [TableKind::AccelerationBySpeed, TableKind::AccelerationByPosition];
pub(super) const JERK: [TableKind; 2] = [TableKind::JerkBySpeed, TableKind::JerkByPosition];
pub(super) const TORQUE: [TableKind; 1] = [TableKind::TorqueBySpeed];

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panic")]
mod tests {
    use super::{JERK, limit_of_mean, value};
    use crate::limits::{JointTables, LimitTable, TableKind};
    use arcfeed_kinematics::Joints;

    #[test]
    fn a_table_is_straight_between_its_points_and_constant_outside() {
        let points = [[1.0, 8.0], [3.0, 4.0], [4.0, 5.0]];
        let at = |x| value(&points, x);
        assert_eq!([at(-1.0), at(1.0), at(2.0), at(3.0), at(3.5), at(9.0)], [8.0, 8.0, 6.0, 4.0, 4.5, 5.0]);
    }

    #[test]
    fn the_limit_of_a_mean_is_the_highest_between_its_samples() {
        let table = |points: &[[f64; 2]]| LimitTable::new(points).unwrap();
        let by_speed = table(&[[0.0, 10.0], [1.0, 5.0], [2.0, 8.0]]);
        let by_speed = JointTables::<1>::new().with(TableKind::JerkBySpeed, 0, by_speed).unwrap();
        let by_position = table(&[[-1.0, 3.0], [0.0, 9.0], [1.0, 4.0]]);
        let by_position = JointTables::<1>::new().with(TableKind::JerkByPosition, 0, by_position).unwrap();
        let most = |tables: &JointTables<1>, [from, to]: [[f64; 2]; 2]| {
            let [q, qd, q_to, qd_to] = [from[0], from[1], to[0], to[1]].map(Joints::<1>::repeat);
            limit_of_mean(100.0, Some(tables), &JERK, 0, [(&q, &qd), (&q_to, &qd_to)])
        };
        // Speeds of one sign: the limit at rest does not count.
        for sign in [1.0, -1.0] {
            assert!((most(&by_speed, [[0.0, sign * 1.2], [0.0, sign * 1.6]]) - 6.8).abs() < 1e-12);
            assert!((most(&by_speed, [[0.0, sign * 0.9], [0.0, sign * 0.5]]) - 7.5).abs() < 1e-12);
        }
        // Where the joint turns it rests in between.
        assert_eq!(most(&by_speed, [[0.0, -0.5], [0.0, 0.4]]), 10.0);
        // Positions: a turn of the joint is nothing to them, a point of the table between them is.
        assert_eq!(most(&by_position, [[0.5, 0.3], [0.75, -0.3]]), 6.5);
        assert_eq!(most(&by_position, [[-0.5, 0.3], [0.5, 0.3]]), 9.0);
        // The constant limit where it is lower, and where there is no table.
        let zero = Joints::<1>::zeros();
        assert_eq!(limit_of_mean(6.0, Some(&by_speed), &JERK, 0, [(&zero, &zero), (&zero, &zero)]), 6.0);
        assert_eq!(limit_of_mean(6.0, None::<&JointTables<1>>, &JERK, 0, [(&zero, &zero), (&zero, &zero)]), 6.0);
    }
}
