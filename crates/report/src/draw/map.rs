//! Maps of a value as a function of two quantities, drawn as coloured cells. Cells without a value
//! are marked.

use super::svg::{Anchor, FAINT, FONT_SIZE, INK, SIZE, Svg, shortened};
use slewkit::numerics::figures::short;

/// A map of a value as a function of two quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Title of the map.
    pub title: String,
    /// The subtitle, one line below the title.
    pub subtitle: String,
    /// Name and values of the quantity on the horizontal axis.
    pub x: (String, Vec<String>),
    /// Name and values of the quantity on the vertical axis.
    pub y: (String, Vec<String>),
    /// The name of the quantity that the colours show.
    pub value: String,
    /// The meaning of cells without a value, as text for the legend.
    pub none: String,
    /// Values of the cells, row by row from the lowest row upwards. A cell without a value is
    /// `None`.
    pub cells: Vec<Option<f64>>,
}

/// Left edge of the cells \[px\].
const LEFT: f64 = 110.0;
/// Right edge of the cells \[px\].
const RIGHT: f64 = 610.0;
/// Upper edge of the cells \[px\].
const TOP: f64 = 64.0;
/// Lower edge of the cells \[px\].
const BOTTOM: f64 = 410.0;
/// The largest number of labels along each axis.
const MOST_LABELS: usize = 10;
/// Five equidistant colours of the colour map Viridis (van der Walt, Smith 2015). Its lightness
/// increases, so that it can also be read in print and by colour-blind readers.
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
/// Ratio of the largest to the smallest value above which the colour scale is logarithmic.
const WIDE: f64 = 30.0;

impl Map {
    /// Returns the map as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        self.draw(&mut svg);
        svg.end()
    }

    pub(super) fn draw(&self, svg: &mut Svg) {
        let (columns, rows) = (self.x.1.len().max(1), self.y.1.len().max(1));
        let (width, height) = ((RIGHT - LEFT) / columns as f64, (BOTTOM - TOP) / rows as f64);
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((LEFT, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((LEFT, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        let values = || self.cells.iter().flatten().copied().filter(|value| value.is_finite());
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let logarithmic = low > 0.0 && high > WIDE * low;
        let place = |value: f64| if logarithmic { value.ln() } else { value };
        let part = |value: f64| {
            if high > low { (place(value) - place(low)) / (place(high) - place(low)) } else { 0.5 }
        };
        for (index, cell) in self.cells.iter().enumerate().take(columns * rows) {
            let (column, row) = ((index % columns) as f64, (index / columns) as f64);
            let (x, y) = (LEFT + column * width, BOTTOM - (row + 1.0) * height);
            let corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)];
            match cell {
                // The outline of a cell has the colour of the cell and closes the gaps to its
                // neighbours.
                Some(value) => {
                    let fill = colour(part(*value));
                    svg.path(
                        &corners,
                        true,
                        &format!("fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.4\""),
                    );
                }
                None => {
                    svg.path(&corners, true, "fill=\"#f3f3f3\" stroke=\"#dddddd\" stroke-width=\"0.4\"");
                    let cross = "stroke=\"#a01818\" stroke-width=\"1\"";
                    let (u, v) = (0.3 * width.min(18.0), 0.3 * height.min(18.0));
                    let (x, y) = (x + 0.5 * width, y + 0.5 * height);
                    svg.line((x - u, y - v), (x + u, y + v), cross);
                    svg.line((x - u, y + v), (x + u, y - v), cross);
                }
            }
        }
        let frame = [(LEFT, TOP), (RIGHT, TOP), (RIGHT, BOTTOM), (LEFT, BOTTOM)];
        svg.path(&frame, true, &format!("fill=\"none\" stroke=\"{INK}\""));
        self.labels(svg, width, height);
        self.legend(svg, (low, high), logarithmic);
    }

    fn labels(&self, svg: &mut Svg, width: f64, height: f64) {
        let ink = format!("fill=\"{INK}\"");
        let shown = |count: usize| (0..count).step_by(count.div_ceil(MOST_LABELS).max(1));
        for index in shown(self.x.1.len()) {
            let at = (LEFT + (index as f64 + 0.5) * width, BOTTOM + 20.0);
            svg.text(at, Anchor::Middle, &ink, &shortened(&self.x.1[index], 8));
        }
        for index in shown(self.y.1.len()) {
            let at = (LEFT - 8.0, BOTTOM - (index as f64 + 0.5) * height + 0.35 * FONT_SIZE);
            svg.text(at, Anchor::End, &ink, &shortened(&self.y.1[index], 9));
        }
        svg.text((0.5 * (LEFT + RIGHT), BOTTOM + 48.0), Anchor::Middle, &ink, &self.x.0);
        let at = (22.0, 0.5 * (TOP + BOTTOM));
        let turned = format!("fill=\"{INK}\" transform=\"rotate(-90 {} {})\"", at.0, at.1);
        svg.text(at, Anchor::Middle, &turned, &self.y.0);
    }

    /// Draws the colour scale next to the cells, with its values.
    fn legend(&self, svg: &mut Svg, (low, high): (f64, f64), logarithmic: bool) {
        const STRIPES: usize = 64;
        let (x, top, bottom) = (RIGHT + 24.0, TOP + 28.0, BOTTOM - 60.0);
        let ink = format!("fill=\"{INK}\"");
        svg.text((x, TOP + 12.0), Anchor::Start, &ink, &shortened(&self.value, 24));
        if low <= high {
            let step = (bottom - top) / STRIPES as f64;
            for stripe in 0..STRIPES {
                let fill = colour((stripe as f64 + 0.5) / STRIPES as f64);
                let y = bottom - (stripe + 1) as f64 * step;
                let corners = [(x, y), (x + 22.0, y), (x + 22.0, y + step), (x, y + step)];
                svg.path(&corners, true, &format!("fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.4\""));
            }
            let middle = if logarithmic { (low * high).sqrt() } else { 0.5 * (low + high) };
            for (value, part) in [(low, 0.0), (middle, 0.5), (high, 1.0)] {
                let at = (x + 30.0, bottom - part * (bottom - top) + 0.35 * FONT_SIZE);
                svg.text(at, Anchor::Start, &ink, &short(value));
            }
        }
        if self.cells.iter().any(Option::is_none) {
            svg.text((x, BOTTOM - 20.0), Anchor::Start, "fill=\"#a01818\"", &format!("× {}", self.none));
        }
    }
}

/// Returns the colour of a value, which is given as a fraction of the range from 0 to 1.
fn colour(part: f64) -> String {
    let place = part.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let below = (place.floor() as usize).min(COLOURS.len() - 2);
    let between = place - below as f64;
    let channel = |index: usize| {
        (COLOURS[below][index] * (1.0 - between) + COLOURS[below + 1][index] * between).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2))
}
