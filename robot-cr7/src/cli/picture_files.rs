//! The pictures of `cr7 plan`: SVG, and PNG where that is asked for.

#[cfg(feature = "png")]
use std::io::{Error, Write};

use crate::Staging;
#[cfg(feature = "png")]
use crate::plot::PngPainter;

use crate::cli::Failure;
use crate::cli::formats::Format;
#[cfg(feature = "png")]
use crate::cli::plan_files::FILES;
use crate::cli::plan_files::Picture;

/// Writes pictures.
pub struct PictureFiles {
    #[cfg(feature = "png")]
    png: Option<PngPainter>,
}

impl PictureFiles {
    /// For these formats. Fonts for PNG are looked for at once, so that their lack is known before the work.
    pub fn new(formats: &[Format]) -> Result<Self, Failure> {
        #[cfg(feature = "png")]
        {
            let asked = formats.contains(&Format::Png).then(PngPainter::new).transpose();
            let png = asked.map_err(|error| Failure::Undoable(format!("--format png: {error}")))?;
            Ok(Self { png })
        }
        #[cfg(not(feature = "png"))]
        {
            let _ = formats;
            Ok(Self {})
        }
    }

    /// Writes them all.
    pub fn write(&self, pictures: Vec<Picture>, staging: &mut Staging) -> Result<(), Failure> {
        for (name, svg) in pictures {
            let svg = svg.map_err(|source| staging.failed(name, source))?;
            staging.write(name, &svg)?;
            #[cfg(feature = "png")]
            self.write_png(name, &svg, staging)?;
        }
        Ok(())
    }

    #[cfg(feature = "png")]
    fn write_png(&self, svg_name: &str, svg: &str, staging: &mut Staging) -> Result<(), Failure> {
        let (Some(painter), Some(name)) = (&self.png, png_of(svg_name)) else { return Ok(()) };
        let image = painter.paint(svg).map_err(|error| staging.failed(name, Error::other(error)))?;
        let mut file = staging.create(name)?;
        Ok(file.write_all(&image).map_err(|source| staging.failed(name, source))?)
    }
}

/// The PNG beside an SVG file.
#[cfg(feature = "png")]
fn png_of(svg: &str) -> Option<&'static str> {
    let stem = svg.strip_suffix(".svg")?;
    FILES.into_iter().find(|name| name.strip_suffix(".png") == Some(stem))
}

#[cfg(all(test, feature = "png"))]
mod tests {
    use super::*;

    #[test]
    fn every_picture_but_that_of_a_stream_has_a_png_of_its_name() {
        for svg in FILES.iter().filter(|name| name.ends_with(".svg") && **name != "stream.svg") {
            assert_eq!(png_of(svg), Some(svg.replace(".svg", ".png").as_str()));
        }
        assert_eq!(png_of("trajectory.csv"), None);
    }
}
