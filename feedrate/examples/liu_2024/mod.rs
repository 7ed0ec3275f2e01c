//! Inputs of Liu et al. 2024 (Actuators 13, 108), section 3, as printed: mm and s.
use arcfeed_feedrate::AxisState;

/// Limits from a time on.
pub struct Row {
    pub from: f64,
    /// Lowest and highest speed. The lowest only matters to the start, which runs backwards for a moment and stays above it.
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

/// Table 3.
pub const TABLE_3: [Row; 3] = [
    Row { from: 0.0, v: (-6.0, 5.0), a: (-12.0, 10.0), j: (-25.0, 20.0) },
    Row { from: 3.0, v: (-13.0, 15.0), a: (-15.0, 12.0), j: (-100.0, 90.0) },
    Row { from: 6.0, v: (-50.0, 30.0), a: (-20.0, 30.0), j: (-80.0, 70.0) },
];

/// `S(0)`, `vs`, `as`.
pub const TABLE_3_START: AxisState = AxisState::new(0.0, -1.0, -10.0);

/// `S`, `ve`, `ae`.
pub const TABLE_3_END: AxisState = AxisState::new(200.0, 5.0, 6.0);

/// Not printed; the paper's controller samples every 1 or 2 ms.
pub const PERIOD: f64 = 1e-3;
