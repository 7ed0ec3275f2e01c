//! Inputs of Liu et al. 2024 (Actuators 13, 108), section 4.2 and 5.2, as printed: rad, m and s.

/// Table 5, joint space.
pub const TABLE_5_FROM: [f64; 6] = [0.0, -5.0, 3.0, -2.0, 6.0, 0.0];
pub const TABLE_5_TO: [f64; 6] = [-3.0, 3.0, -5.0, 6.0, 5.0, -6.0];

/// Table 5, task space: position, then quaternion x y z w.
pub const TABLE_5_POSE_FROM: ([f64; 3], [f64; 4]) = ([0.1463, -0.4679, -0.0066], [1.0, 0.0, 0.0, 0.0]);
pub const TABLE_5_POSE_TO: ([f64; 3], [f64; 4]) = ([-0.35, -0.35, 0.1], [0.4711, 0.7322, 0.4668, -0.1551]);

/// Table 7: position, velocity and acceleration at the start.
pub const TABLE_7_START: [[f64; 6]; 3] =
    [[0.0, -5.0, 3.0, -2.0, 6.0, 0.0], [1.0, 2.0, 0.0, 3.0, -4.0, 0.0], [10.0, -15.0, 5.0, 0.0, 1.0, 0.0]];

/// Table 7: targets from a time on.
pub const TABLE_7_TARGETS: [(f64, [f64; 6]); 4] = [
    (0.0, [-3.0, 3.0, -5.0, 6.0, 6.0, -6.0]),
    (0.5, [6.0, 3.0, 2.0, 6.0, -10.0, -6.0]),
    (1.0, [6.0, -5.0, 2.0, 20.0, -10.0, -1.0]),
    (2.0, [5.0, 10.0, -5.0, 3.0, -6.0, 0.0]),
];

/// Table 7: limits.
pub const TABLE_7_VELOCITY: [f64; 6] = [6.0, 3.0, 4.0, 5.0, 6.0, 7.0];
pub const TABLE_7_ACCELERATION: [f64; 6] = [10.0, 12.0, 14.0, 16.0, 18.0, 20.0];

/// No jerk limit is printed: ten times the acceleration is taken.
pub const JERK_PER_ACCELERATION: f64 = 10.0;

/// No limits are printed for the tool.
pub const TOOL_LINEAR: [f64; 3] = [0.5, 3.0, 40.0];
pub const TOOL_ANGULAR: [f64; 3] = [1.5, 8.0, 100.0];

/// The paper's controller samples every 2 ms.
pub const PERIOD: f64 = 2e-3;

/// Time of one calculation the paper states (s).
pub const STATED_TIME: f64 = 1e-3;
