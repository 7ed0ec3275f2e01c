//! The butterfly for the benchmarks (not a benchmark itself).

use arcfeed_geometry::{NurbsCurve, nalgebra::SVector};

/// A published plane curve of the test fixtures, in mm.
pub fn published(name: &str) -> NurbsCurve<2> {
    let file: serde_json::Value = serde_json::from_str(include_str!("../../tests/fixtures/curves.json")).unwrap();
    let c = file["curves"].as_array().unwrap().iter().find(|c| c["name"] == name).unwrap();
    let numbers = |v: &serde_json::Value| -> Vec<f64> { serde_json::from_value(v.clone()).unwrap() };
    let points = c["control_points"].as_array().unwrap().iter().map(|p| SVector::from_vec(numbers(p))).collect();
    let degree = usize::try_from(c["degree"].as_u64().unwrap()).unwrap();
    NurbsCurve::new(degree, points, numbers(&c["weights"]), numbers(&c["knots"])).unwrap()
}
