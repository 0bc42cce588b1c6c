//! Charts as SVG: curves over linear or logarithmic axes, maps, timelines and paths in space. Also
//! formats tables of text.
//!
//! The SVG files have no style sheet and no script, and do not depend on measured text widths. They
//! look the same in every browser and vector editor, and in print. The colours are the palette of
//! Okabe and Ito, which colour-blind readers can distinguish; curves also differ in mark and dash
//! pattern. The feature `paper` converts SVG to PNG and PDF.

mod axis;
mod chart;
mod clear;
mod curve;
mod gantt;
mod ground;
mod legibility;
mod map;
mod panel;
#[cfg(feature = "paper")]
pub mod paper;
mod scene;
mod sky;
mod svg;
mod table;
mod thin;

pub use axis::{Axis, Scale};
pub use chart::{Chart, Level, Span};
pub use curve::{Curve, Shape};
pub use gantt::Gantt;
pub use ground::{Ground, GroundTrack};
pub use map::Map;
pub use panel::{Picture, panel};
pub use scene::{Item, Scene};
pub use sky::{ConeAsks, DiscKind, Sky, SkyCone, SkyDisc, SkyMark, SkyRing, SkyTrack, SkyView, circle};
pub use svg::escape;
pub use table::table;
pub use thin::thinned;

/// The colours of curves, by index.
pub const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#7a5c00", "#555555"];

/// Returns the colour of the curve or body with this index. Colours repeat after the last one.
pub fn colour(index: usize) -> &'static str {
    COLOURS[index % COLOURS.len()]
}
