//! Panels: several pictures in one SVG file, in columns, marked (a), (b), …

use super::chart::Chart;
use super::gantt::Gantt;
use super::ground::Ground;
use super::map::Map;
use super::sky::Sky;
use super::svg::{Anchor, INK, SIZE, Svg};

/// A picture of any kind, which can be drawn as SVG.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// Curves over two axes.
    Chart(Chart),
    /// Tracks and cones on the sphere of directions.
    Sky(Sky),
    /// A value as a function of two quantities, as coloured cells.
    Map(Map),
    /// Ground tracks on a map of the Earth.
    Ground(Ground),
    /// Time intervals in which thrusters or other objects are on.
    Gantt(Gantt),
}

impl Picture {
    /// Returns the title of the picture.
    pub fn title(&self) -> &str {
        match self {
            Self::Chart(chart) => &chart.title,
            Self::Sky(sky) => &sky.title,
            Self::Map(map) => &map.title,
            Self::Ground(ground) => &ground.title,
            Self::Gantt(gantt) => &gantt.title,
        }
    }

    /// Returns the picture as the text of an SVG file.
    pub fn svg(&self) -> String {
        match self {
            Self::Chart(chart) => chart.svg(),
            Self::Sky(sky) => sky.svg(),
            Self::Map(map) => map.svg(),
            Self::Ground(ground) => ground.svg(),
            Self::Gantt(gantt) => gantt.svg(),
        }
    }

    fn draw(&self, svg: &mut Svg, id: &str) {
        match self {
            Self::Chart(chart) => chart.draw(svg, id),
            Self::Sky(sky) => sky.draw(svg, id),
            Self::Map(map) => map.draw(svg),
            Self::Ground(ground) => ground.draw(svg, id),
            Self::Gantt(gantt) => gantt.draw(svg),
        }
    }
}

/// Returns several pictures as the text of one SVG file. They are arranged in columns and marked
/// with letters. The font size does not change.
pub fn panel(pictures: &[&Picture], columns: usize) -> String {
    let columns = columns.clamp(1, pictures.len().max(1));
    let rows = pictures.len().div_ceil(columns).max(1);
    let mut svg = Svg::new(SIZE.0 * columns as f64, SIZE.1 * rows as f64);
    for (index, picture) in pictures.iter().enumerate() {
        let at = ((index % columns) as f64 * SIZE.0, (index / columns) as f64 * SIZE.1);
        svg.raw(&format!("<g transform=\"translate({} {})\">", at.0, at.1));
        picture.draw(&mut svg, &format!("plot{index}"));
        if pictures.len() > 1 {
            let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
            svg.text((22.0, 26.0), Anchor::Start, &bold, &letter(index));
        }
        svg.raw("</g>");
    }
    svg.end()
}

/// Returns the label of a picture in a panel: (a) … (z), then numbers.
fn letter(index: usize) -> String {
    match u8::try_from(index) {
        Ok(index @ 0..26) => format!("({})", char::from(b'a' + index)),
        _ => format!("({})", index + 1),
    }
}
