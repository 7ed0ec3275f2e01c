//! Liu et al. 2023, "A High-Precision Planar NURBS Interpolation System" (Appl. Sci. 13, 13210).

pub mod bezier_table;
pub mod competitors;
pub mod counts;
pub mod curves;
pub mod figures;
pub mod motion;
pub mod open_loop;
pub mod printed;

use arcfeed_geometry::SegmentationMethod;
use arcfeed_interp::Method;

use self::bezier_table::{BezierTable, PrintedBezier};
use self::counts::CountRun;
use self::curves::curve_of;
use self::motion::MotionRun;
use self::printed::PrintedRun;
use super::spline::Spline;
use super::{Reproduced, Reproduction};
use crate::input::job::Job;
use crate::input::sample_paths::SamplePath;
use crate::run::error::Cr7Error;
use crate::run::task::Task;

/// Table 1 as printed, x and y.
const PRINTED: [PrintedBezier; 3] = [
    [("5", "4"), ("6", "12"), ("8.5", "12"), ("9.25", "9.5")],
    [("9.25", "9.5"), ("10", "8"), ("9", "6"), ("9.5", "4.75")],
    [("9.5", "4.75"), ("10", "3.5"), ("12", "3"), ("11", "9")],
];
const TABLE_1: &str = "Table 1: Bezier control points of the six-point curve, mm";
const COUNTS: &str = "Segments for a chord tolerance (the last two curves: counts of Actuators 2024, 13, 108)";

/// Curve, tolerance (m) and the paper's count.
const CASES: [(&str, SamplePath, f64, &str); 5] = [
    ("six points, 0.001 mm", SamplePath::SixPoint, 1e-6, "143"),
    ("butterfly, 0.001 mm", SamplePath::Butterfly, 1e-6, "1579"),
    ("fan, 0.001 mm", SamplePath::Fan, 1e-6, "1454"),
    ("seven points, 0.1 mm", SamplePath::SevenPoint, 1e-4, "47"),
    ("butterfly, 0.05 mm", SamplePath::Butterfly, 5e-5, "193"),
];

/// Every curve cut by every method.
///
/// # Errors
/// [`Cr7Error::Curve`] when an embedded curve cannot be cut.
pub fn all_counts() -> Result<Vec<(CountRun, &'static str)>, Cr7Error> {
    let methods = [
        SegmentationMethod::CType,
        SegmentationMethod::Hull,
        SegmentationMethod::Greedy { across_knots: false },
        SegmentationMethod::Greedy { across_knots: true },
    ];
    let mut runs = Vec::new();
    for (name, path, tolerance, paper) in CASES {
        for method in methods {
            // The method of the paper is the one its count stands beside.
            let printed = if method == SegmentationMethod::CType { paper } else { "" };
            runs.push((CountRun::measure(name, path, method, tolerance)?, printed));
        }
    }
    Ok(runs)
}

/// Feed over path length of the scanned fan, mm/s and mm.
fn fan_feed() -> Result<Vec<(f64, f64)>, Cr7Error> {
    let job = Job { method: Method::ContinuousAcceleration, ..Job::default() };
    let task = Task::of_cr7(&job, &SamplePath::Fan.load()?)?;
    let motion = task.plan()?;
    let (law, length) = (motion.trajectory().law(), motion.trajectory().path().length());
    let at = |i: u32| length * f64::from(i) / 8000.0;
    Ok((0..=8000).map(|i| (at(i) * 1e3, law.at_position(at(i)).v * 1e3)).collect())
}

/// Tables 1 and 2, the counts, the motion of section 6, and Figures 1 to 4, 6, 10, 11 and 13.
///
/// # Errors
/// [`Cr7Error`] when an embedded path cannot be planned.
pub fn liu_2023() -> Result<Reproduced, Cr7Error> {
    let mut r = Reproduction::new(
        "X. Liu et al., A High-Precision Planar NURBS Interpolation System Based on Segmentation Method for \
         Industrial \
         Robot, Appl. Sci. 2023, 13, 13210",
    );
    let six = curve_of(SamplePath::SixPoint)?;
    let table = BezierTable::measure(&six);
    table.judge(&mut r, TABLE_1, &PRINTED);
    let counts = all_counts()?;
    counts.iter().for_each(|(run, printed)| run.judge(&mut r, COUNTS, printed));
    let (motion, table_2) = MotionRun::measure()?;
    table_2.judge(&mut r);
    motion.judge(&mut r);
    PrintedRun::measure(&Spline::new(&six), &counts[4].0.curve).judge(&mut r);
    let mut figures = figures::six_points(&table, &Spline::new(&six), &counts[0].0);
    figures.extend(figures::profiles());
    figures.extend(figures::butterfly(&counts[4].0, &motion));
    figures.extend(figures::compared(&table_2));
    figures.extend(figures::fan(&counts[8].0, &fan_feed()?));
    Ok(Reproduced { reproduction: r, figures })
}
