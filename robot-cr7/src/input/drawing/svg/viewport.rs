//! The page: from user units to metres.

use svgtypes::{Align, AspectRatio, Length, LengthUnit as SvgUnit};

use super::length::{Element, pixels};
use crate::input::drawing::map::Map;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;
use crate::input::unit::LengthUnit;

/// Metres of a pixel of CSS.
const PIXEL: f64 = 0.0254 / 96.0;

/// A length of the page in pixels, and whether it has a unit of its own.
#[derive(Debug, Clone, Copy)]
struct Extent {
    pixels: f64,
    stated: bool,
}

/// The map from user units to metres, with y up. The origin is the lower left corner of the page; where the file states no height, the
/// origin of the drawing.
pub(super) fn page_map(root: &Element, unit: Option<LengthUnit>, sink: &mut Sink) -> Result<Map, InputError> {
    let width = extent(root, "width", sink)?;
    let height = extent(root, "height", sink)?;
    let view = view_box(root, sink)?;
    let stated = [width, height].iter().flatten().any(|extent| extent.stated);
    if !stated && unit.is_none() {
        sink.warnings.push(
            "the drawing names no unit: a pixel is 1/96 in; give width and height of the page a unit, or set \
             path.csv_unit in the job"
                .to_owned(),
        );
    }
    // The unit that was asked for is that of the numbers in the file.
    if let (false, Some(unit)) = (stated, unit) {
        let size = view.map_or([width, height].map(|e| e.map(|e| e.pixels)), |[_, _, w, h]| [Some(w), Some(h)]);
        let shift = view.map_or([0.0; 2], |[x, y, _, _]| [-x, -y]);
        return Ok(upright(unit.to_metres(1.0), size[1]).after(&Map::plane([1.0, 0.0, 0.0, 1.0, shift[0], shift[1]])));
    }
    let Some([x, y, w, h]) = view else {
        return Ok(upright(PIXEL, height.map(|e| e.pixels)));
    };
    let (width, height) = match (width.map(|e| e.pixels), height.map(|e| e.pixels)) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, width * h / w),
        (None, Some(height)) => (height * w / h, height),
        (None, None) => (w, h),
    };
    let [a, d, e, f] = fitted(root, [w, h], [width, height], sink)?;
    let view = Map::plane([a, 0.0, 0.0, d, e - a * x, f - d * y]);
    Ok(upright(PIXEL, Some(height)).after(&view))
}

/// From units with y down to metres with y up.
fn upright(metres: f64, height: Option<f64>) -> Map {
    Map::plane([metres, 0.0, 0.0, -metres, 0.0, height.unwrap_or(0.0) * metres])
}

/// Scales and offsets that put the view box into the page, as `preserveAspectRatio` says.
fn fitted(root: &Element, view: [f64; 2], page: [f64; 2], sink: &Sink) -> Result<[f64; 4], InputError> {
    let text = root.node.attribute("preserveAspectRatio").unwrap_or("xMidYMid meet");
    let Ok(ratio) = text.parse::<AspectRatio>() else {
        let why = ("it has to be a value of SVG", "correct it, or remove it");
        return Err(root.wrong(sink, "preserveAspectRatio", text, why));
    };
    let [sx, sy] = [page[0] / view[0], page[1] / view[1]];
    let scale = if ratio.slice { sx.max(sy) } else { sx.min(sy) };
    let (x, y) = match ratio.align {
        Align::None => return Ok([sx, sy, 0.0, 0.0]),
        Align::XMinYMin => (0.0, 0.0),
        Align::XMidYMin => (0.5, 0.0),
        Align::XMaxYMin => (1.0, 0.0),
        Align::XMinYMid => (0.0, 0.5),
        Align::XMidYMid => (0.5, 0.5),
        Align::XMaxYMid => (1.0, 0.5),
        Align::XMinYMax => (0.0, 1.0),
        Align::XMidYMax => (0.5, 1.0),
        Align::XMaxYMax => (1.0, 1.0),
    };
    Ok([scale, scale, x * (page[0] - scale * view[0]), y * (page[1] - scale * view[1])])
}

fn extent(root: &Element, attribute: &str, sink: &Sink) -> Result<Option<Extent>, InputError> {
    let Some(text) = root.node.attribute(attribute) else { return Ok(None) };
    let wrong = || {
        let why = ("it has to be a length above 0 in mm, cm, in, pt, pc or px", "correct it, or remove it");
        root.wrong(sink, attribute, text, why)
    };
    let length = text.trim().parse::<Length>().map_err(|_| wrong())?;
    if length.unit == SvgUnit::Percent {
        return Ok(None);
    }
    let pixels = pixels(&length).filter(|v| *v > 0.0 && v.is_finite()).ok_or_else(wrong)?;
    Ok(Some(Extent { pixels, stated: length.unit != SvgUnit::None && length.unit != SvgUnit::Px }))
}

fn view_box(root: &Element, sink: &Sink) -> Result<Option<[f64; 4]>, InputError> {
    let Some(text) = root.node.attribute("viewBox") else { return Ok(None) };
    let numbers = root.numbers("viewBox", sink)?;
    match numbers.as_slice() {
        &[x, y, w, h] if w > 0.0 && h > 0.0 => Ok(Some([x, y, w, h])),
        _ => {
            let why = ("it has to be x, y, width and height, the last two above 0", "correct it, or remove it");
            Err(root.wrong(sink, "viewBox", text, why))
        }
    }
}
