//! Pictures as PNG.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Family, Query};
use resvg::usvg::{Options, Tree};
use thiserror::Error;

/// Pixels of the image for one of the picture: text stays sharp on dense screens and on paper.
const SCALE: f32 = 2.0;

/// Draws pictures as PNG, with the fonts of the system.
///
/// ```
/// use robot_cr7::plot::{PngError, PngPainter};
/// let svg = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30"><rect width="10" height="10"/></svg>"#;
/// match PngPainter::new() {
///     Ok(painter) => assert_eq!(&painter.paint(svg)?[1..4], b"PNG"),
///     Err(error) => assert_eq!(error, PngError::NoFont),
/// }
/// # Ok::<(), PngError>(())
/// ```
#[derive(Debug)]
pub struct PngPainter {
    options: Options<'static>,
}

impl PngPainter {
    /// Looks for the fonts of the system.
    ///
    /// # Errors
    /// [`PngError::NoFont`].
    pub fn new() -> Result<Self, PngError> {
        let mut fonts = Database::new();
        fonts.load_system_fonts();
        Self::with_fonts(fonts)
    }

    fn with_fonts(mut fonts: Database) -> Result<Self, PngError> {
        let plain = Query { families: &[Family::SansSerif], ..Query::default() };
        if fonts.query(&plain).is_none() {
            // The system names no font of this kind: one of those that are there stands in.
            let families = || fonts.faces().filter_map(|face| face.families.first()).map(|(name, _)| name);
            let family = families().find(|name| name.contains("Sans")).or_else(|| families().next());
            let family = family.cloned().ok_or(PngError::NoFont)?;
            fonts.set_sans_serif_family(family);
        }
        let mut options = Options::default();
        *options.fontdb_mut() = fonts;
        Ok(Self { options })
    }

    /// An SVG picture as a PNG file, two pixels for one of the picture.
    ///
    /// # Errors
    /// [`PngError::Picture`] for what is no SVG or has no size.
    pub fn paint(&self, svg: &str) -> Result<Vec<u8>, PngError> {
        let tree = Tree::from_str(svg, &self.options).map_err(|e| PngError::Picture(e.to_string()))?;
        let [width, height] = [tree.size().width(), tree.size().height()].map(|pixels| (pixels * SCALE).round() as u32);
        let image = Pixmap::new(width, height);
        let mut image = image.ok_or_else(|| PngError::Picture(format!("{width} x {height} pixels are too many")))?;
        resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut image.as_mut());
        image.encode_png().map_err(|e| PngError::Picture(e.to_string()))
    }
}

/// Why there is no PNG of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PngError {
    /// The system has no font, so that no text could be read.
    #[error(
        "no font is found: install one (such as DejaVu, in the package fonts-dejavu-core of Debian), or take the SVG"
    )]
    NoFont,
    /// The picture cannot be drawn.
    #[error("the picture cannot be drawn as PNG: {0}")]
    Picture(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_any_font_the_error_says_what_to_install() {
        let error = PngPainter::with_fonts(Database::new()).expect_err("no font");
        assert!(error == PngError::NoFont && error.to_string().contains("install one"), "{error}");
    }

    #[test]
    fn a_font_stands_in_where_the_system_names_none() {
        let mut fonts = Database::new();
        fonts.load_system_fonts();
        if fonts.is_empty() {
            return;
        }
        fonts.set_sans_serif_family("there is no such font");
        assert!(PngPainter::with_fonts(fonts).is_ok());
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let mut fonts = Database::new();
        fonts.load_system_fonts();
        let Ok(painter) = PngPainter::with_fonts(fonts) else { return };
        for text in ["", "<svg", "<p/>"] {
            assert!(matches!(painter.paint(text), Err(PngError::Picture(_))), "{text}");
        }
    }
}
