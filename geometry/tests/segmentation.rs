//! Segment counts on the published curves, and the one promise of every segmentation: no piece exceeds its tolerance.

mod common;

use arcfeed_geometry::{NurbsCurve, Segmentation, SegmentationMethod};
use common::{dense_deviation, published};

const WITHIN: SegmentationMethod = SegmentationMethod::Longest { across_knots: false };
const ACROSS: SegmentationMethod = SegmentationMethod::Longest { across_knots: true };
const METHODS: [SegmentationMethod; 4] = [SegmentationMethod::Hull, SegmentationMethod::CType, WITHIN, ACROSS];

/// Every piece, measured densely and independently, keeps the tolerance and the deviation it reports.
fn check<const D: usize>(curve: &NurbsCurve<D>, s: &Segmentation, samples: usize) {
    assert_eq!(s.breaks()[0], curve.knots().domain().0);
    assert_eq!(*s.breaks().last().unwrap(), curve.knots().domain().1);
    let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.amax()));
    let rounding = 1e-15 * size;
    for (u0, u1, reported) in s.pieces() {
        assert!(u0 < u1);
        let dense = dense_deviation(curve, u0, u1, samples);
        assert!(dense <= s.tolerance() + rounding, "[{u0}, {u1}] deviates by {dense}");
        assert!(dense <= reported + rounding, "[{u0}, {u1}] deviates by {dense}, reported {reported}");
        assert!(reported <= dense * (1.0 + 1e-5) + 10.0 * rounding, "[{u0}, {u1}]: {dense}, reported {reported}");
    }
}

#[test]
fn counts_on_published_curves() {
    for (name, tolerance, halving, within, across) in [
        ("seven_points", 0.1, [21, 18], 11, 10),
        ("butterfly", 0.05, [284, 248], 184, 156),
        ("six_points", 0.001, [170, 163], 114, 112),
        ("butterfly", 0.001, [1911, 1678], 1174, 1153),
        ("fan", 0.001, [2133, 1909], 1375, 1338),
    ] {
        let curve = published(name);
        let s = METHODS.map(|m| curve.segment(m, tolerance).unwrap());
        println!("{name} {tolerance}: {:?}", s.each_ref().map(|s| s.len()));
        s.iter().for_each(|s| check(&curve, s, 200));
        assert!(s[0].len() <= halving[0] && s[1].len() <= halving[1]);
        assert!(s[2].len() <= within, "{name}: {}", s[2].len());
        assert!(s[3].len() <= across, "{name}: {}", s[3].len());
    }
}
