//! Conversion of the SVG text of charts to PNG and PDF with `resvg` and `svg2pdf`. No other file
//! uses these crates.
//!
//! The font is the first family named in the SVG that the system has. Sizes in a PDF are absolute:
//! 13 px are 9.75 points. The size of a PNG in pixels depends on the scale.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use svg2pdf::{ConversionOptions, PageOptions};
use thiserror::Error;

/// The reason why a picture cannot be converted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PaperError {
    /// The system has no font. This is an error, because the labels of the picture would be
    /// missing.
    #[error("the system has no fonts")]
    NoFont,
    /// The picture is too large, or is not valid SVG.
    #[error("{0}")]
    Unreadable(String),
}

/// Font families of similar appearance, in order of preference. They are used if the system has
/// none of the families that the SVG names.
const FAMILIES: [&str; 6] =
    ["Helvetica", "Arial", "DejaVu Sans", "Liberation Sans", "Noto Sans", "Open Sans"];

/// The number of SVG pixels per inch.
const PIXELS_PER_INCH: f32 = 96.0;

/// Returns the picture as the bytes of a PNG file, with `scale` pixels for each SVG pixel.
///
/// # Errors
/// Returns [`PaperError`] if the system has no font, or if the picture is too large or is not valid
/// SVG.
pub fn png(svg: &str, scale: f32) -> Result<Vec<u8>, PaperError> {
    let tree = tree(svg)?;
    let unreadable = |reason: String| PaperError::Unreadable(reason);
    let size = tree.size().to_int_size().scale_by(scale);
    let pixels = size.and_then(|size| Pixmap::new(size.width(), size.height()));
    let mut pixels = pixels.ok_or_else(|| unreadable("the picture is too large".into()))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| unreadable(error.to_string()))
}

/// Returns the picture as a PDF file of one page. Text remains selectable.
///
/// # Errors
/// Returns [`PaperError`] if the system has no font, or if the picture is too large or is not valid
/// SVG.
pub fn pdf(svg: &str) -> Result<Vec<u8>, PaperError> {
    let page = PageOptions { dpi: PIXELS_PER_INCH };
    let made = svg2pdf::to_pdf(&tree(svg)?, ConversionOptions::default(), page);
    made.map_err(|error| PaperError::Unreadable(error.to_string()))
}

fn tree(svg: &str) -> Result<Tree, PaperError> {
    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_system_fonts();
    let has =
        |name: &&&str| fonts.faces().any(|face| face.families.iter().any(|(family, _)| family == **name));
    let first = || fonts.faces().next().and_then(|face| Some(face.families.first()?.0.clone()));
    let family = FAMILIES.iter().find(has).map(|name| name.to_string()).or_else(first);
    fonts.set_sans_serif_family(family.ok_or(PaperError::NoFont)?);
    Tree::from_str(svg, &options).map_err(|error| PaperError::Unreadable(error.to_string()))
}
