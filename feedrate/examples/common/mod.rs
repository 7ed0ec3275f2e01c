//! A few lines of SVG: stacked panels that share one horizontal axis.
use std::fmt::Write as _;

/// One curve of a panel.
pub struct Curve {
    pub name: &'static str,
    pub colour: &'static str,
    pub points: Vec<(f64, f64)>,
}

/// A panel with its axis label, its curves and the levels of its limits.
pub struct Panel {
    pub label: &'static str,
    pub curves: Vec<Curve>,
    pub limits: Vec<f64>,
}

/// Draws the panels below each other and writes the picture into `target/pictures`.
pub fn write(name: &str, title: &str, x_label: &str, panels: &[Panel]) -> std::io::Result<()> {
    let (width, height, left, top) = (960.0, 190.0, 90.0, 50.0);
    let (w, h) = (width - left - 30.0, height - 35.0);
    let total = top + height * panels.len() as f64 + 30.0;
    let all = || panels.iter().flat_map(|p| p.curves.iter().flat_map(|c| c.points.iter()));
    let x_max = all().map(|p| p.0).fold(0.0, f64::max);
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{width}' height='{total}' font-family='sans-serif' font-size='12'>\
         <rect width='100%' height='100%' fill='white'/><text x='{left}' y='24' font-size='16'>{title}</text>"
    );
    for (i, panel) in panels.iter().enumerate() {
        let y0 = top + height * i as f64;
        let values =
            || panel.curves.iter().flat_map(|c| c.points.iter().map(|p| p.1)).chain(panel.limits.iter().copied());
        let (lo, hi) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        let pad = 0.06 * (hi - lo).max(1e-300);
        let (lo, hi) = (lo - if lo < 0.0 { pad } else { 0.0 }, hi + pad);
        let px = |x: f64| left + w * x / x_max;
        let py = |y: f64| y0 + h * (hi - y) / (hi - lo);
        let _ = write!(svg, "<rect x='{left}' y='{y0}' width='{w}' height='{h}' fill='#fafafa' stroke='#bbb'/>");
        let _ = write!(svg, "<text x='12' y='{}'>{}</text>", y0 + 0.5 * h, panel.label);
        for level in panel.limits.iter().copied().chain([0.0]) {
            let dash = if level == 0.0 { "stroke='#ccc'" } else { "stroke='#c0392b' stroke-dasharray='5 4'" };
            let y = py(level);
            let _ = write!(svg, "<line x1='{left}' x2='{}' y1='{y:.1}' y2='{y:.1}' {dash}/>", left + w);
            let _ =
                write!(svg, "<text x='{}' y='{:.1}' text-anchor='end' fill='#777'>{level}</text>", left - 5.0, y + 4.0);
        }
        for (k, curve) in panel.curves.iter().enumerate() {
            let _ = write!(svg, "<polyline fill='none' stroke='{}' stroke-width='1.6' points='", curve.colour);
            for (x, y) in &curve.points {
                let _ = write!(svg, "{:.2},{:.2} ", px(*x), py(*y));
            }
            svg.push_str("'/>");
            let _ = write!(
                svg,
                "<text x='{}' y='{}' text-anchor='end' fill='{}'>{}</text>",
                left + w - 6.0,
                y0 + 16.0 + 15.0 * k as f64,
                curve.colour,
                curve.name
            );
        }
    }
    let _ = write!(
        svg,
        "<text x='{}' y='{}' text-anchor='end'>{x_label} (0 .. {x_max:.4})</text></svg>",
        left + w,
        total - 14.0
    );
    let folder = std::path::Path::new("target/pictures");
    std::fs::create_dir_all(folder)?;
    let path = folder.join(name);
    std::fs::write(&path, svg)?;
    println!("wrote {}", path.display());
    Ok(())
}
