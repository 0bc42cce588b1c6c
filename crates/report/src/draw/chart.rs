//! Charts: curves over two axes with marks and bands, and a legend next to the plot.

use super::axis::{Axis, Laid, Tick};
use super::clear::crosses;
use super::curve::{Curve, Shape};
use super::legibility;
use super::svg::{Anchor, FAINT, FONT_SIZE, GRID, INK, SIZE, Svg, broken, shortened};
use super::{COLOURS, colour};

/// A chart: curves over two axes, with limits and shaded intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Title of the chart.
    pub title: String,
    /// Subtitle below the title, a single line that states the conditions of the data.
    pub subtitle: String,
    /// Horizontal axis of the plot.
    pub x: Axis,
    /// Vertical axis of the plot.
    pub y: Axis,
    /// Curves of the chart, of which the first is drawn on top.
    pub curves: Vec<Curve>,
    /// Horizontal lines across the plot, such as limits.
    pub levels: Vec<Level>,
    /// Shaded intervals of the horizontal axis.
    pub spans: Vec<Span>,
}

/// A horizontal line across the plot, such as a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The position on the vertical axis.
    pub value: f64,
    /// Label of the line; an empty text for a line without a label.
    pub label: String,
}

/// A shaded interval of the horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// The start of the interval, a value of the horizontal axis.
    pub from: f64,
    /// The end of the interval, a value of the horizontal axis.
    pub to: f64,
    /// Name of the state during the interval, such as "coast".
    pub label: String,
}

/// Left edge of the plot [px].
const LEFT: f64 = 92.0;
/// Right edge of the plot \[px\].
const RIGHT: f64 = 610.0;
/// Upper edge of the plot \[px\].
const TOP: f64 = 64.0;
/// Lower edge of the plot \[px\].
const BOTTOM: f64 = 418.0;

/// Colours of shaded intervals; intervals of the same name have the same colour.
const SHADES: [&str; 4] = ["#f4e7c4", "#d6e6f2", "#dfeed6", "#efdfee"];
/// Colour of the edges of a shaded interval.
const EDGE: &str = "#b9b29c";
/// Colour of the lines at limits.
const LIMIT: &str = "#a01818";

impl Chart {
    /// Creates a chart of curves, without horizontal lines and shaded intervals.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, curves: Vec<Curve>) -> Self {
        let (title, subtitle) = (title.into(), String::new());
        Self { title, subtitle, x, y, curves, levels: Vec::new(), spans: Vec::new() }
    }

    /// Returns the chart as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        self.draw(&mut svg, "plot");
        svg.end()
    }

    /// Returns the curves as they are drawn. A diverging curve is cut off, and its name states the
    /// abscissa at which this happens.
    pub fn legible_curves(&self) -> Vec<Curve> {
        legibility::cut(&self.curves, self.y.scale)
    }

    /// Draws the chart into `svg`. No other element of the document may use `id`.
    pub(super) fn draw(&self, svg: &mut Svg, id: &str) {
        let mut curves = self.legible_curves();
        let levels = self.levels.iter().map(|level| level.value);
        let points = || curves.iter().flat_map(|curve| curve.shape.points());
        let x = Laid::new(&self.x, points().map(|point| point.0), LEFT, RIGHT);
        let y = Laid::new(&self.y, points().map(|point| point.1).chain(levels), BOTTOM, TOP);
        legibility::name_hidden(&mut curves, |(a, b)| Some((x.place(a)?, y.place(b)?)));
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((LEFT, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((LEFT, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        let names = names(&self.spans);
        for span in &self.spans {
            let Some((from, to)) = x.place(span.from).zip(x.place(span.to)) else { continue };
            shade(svg, (from.clamp(LEFT, RIGHT), to.clamp(LEFT, RIGHT)), &names, &span.label);
        }
        axes(svg, self, &x, &y);
        let frame =
            format!("x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\"", RIGHT - LEFT, BOTTOM - TOP);
        svg.raw(&format!("<clipPath id=\"{id}\"><rect {frame}/></clipPath>"));
        svg.raw(&format!("<g clip-path=\"url(#{id})\">"));
        for level in self.levels.iter().filter_map(|level| y.place(level.value)) {
            svg.line((LEFT, level), (RIGHT, level), &format!("stroke=\"{LIMIT}\" stroke-dasharray=\"7 4\""));
        }
        for curve in curves.iter().rev() {
            draw(svg, curve, &x, &y);
        }
        let placed = |curve: &Curve| -> Vec<(f64, f64)> {
            curve.shape.points().into_iter().filter_map(|(a, b)| Some((x.place(a)?, y.place(b)?))).collect()
        };
        let lines: Vec<Vec<(f64, f64)>> = curves.iter().map(placed).collect();
        for level in self.levels.iter().filter(|level| !level.label.is_empty()) {
            if let Some(at) = y.place(level.value) {
                let style = format!("font-size=\"{NAME}\" fill=\"{LIMIT}\"");
                svg.text(beside(&level.label, at, &lines), Anchor::End, &style, &level.label);
            }
        }
        svg.raw("</g>");
        svg.raw(&format!("<rect {frame} fill=\"none\" stroke=\"{INK}\" stroke-width=\"1\"/>"));
        let y = legend(svg, &curves);
        shades(svg, &names, y);
    }
}

/// Font size of the name of a limit \[px\].
const NAME: f64 = 11.0;
/// Width of a character of the name of a limit, as a fraction of the font size.
const WIDE: f64 = 0.6;
/// Distance between the positions that are tried for the name of a limit \[px\].
const PLACES: f64 = 24.0;

/// Returns the position of the right end of the name of a limit \[px\]. The name is above or below
/// the line at the height `level`, and as far to the right as possible without crossing a curve.
fn beside(name: &str, level: f64, lines: &[Vec<(f64, f64)>]) -> (f64, f64) {
    let width = WIDE * NAME * name.chars().count() as f64;
    let sides: Vec<f64> = [level - 5.0, level + 15.0]
        .into_iter()
        .filter(|below| below - NAME - 2.0 >= TOP && below + 3.0 <= BOTTOM)
        .collect();
    let last = RIGHT - 6.0;
    let count = ((last - width - LEFT) / PLACES).max(0.0) as usize + 1;
    let ends = (0..count).map(|place| last - PLACES * place as f64);
    let mut places = ends.flat_map(|end| sides.iter().map(move |below| (end, *below)));
    let is_free = |(end, below): &(f64, f64)| {
        let frame = [end - width, below - NAME, *end, below + 2.0];
        lines.iter().all(|line| !crosses(line, frame))
    };
    places.find(is_free).unwrap_or((last, sides.first().copied().unwrap_or(level - 5.0)))
}

fn axes(svg: &mut Svg, chart: &Chart, x: &Laid, y: &Laid) {
    let grid = format!("stroke=\"{GRID}\" stroke-width=\"1\"");
    let tick = format!("stroke=\"{INK}\" stroke-width=\"1\"");
    let ink = format!("fill=\"{INK}\"");
    for Tick { at, label } in x.ticks() {
        let length = if label.is_some() { 6.0 } else { 3.0 };
        if let Some(label) = label {
            svg.line((at, TOP), (at, BOTTOM), &grid);
            svg.text((at, BOTTOM + 22.0), Anchor::Middle, &ink, &label);
        }
        svg.line((at, BOTTOM), (at, BOTTOM + length), &tick);
    }
    for Tick { at, label } in y.ticks() {
        let length = if label.is_some() { 6.0 } else { 3.0 };
        if let Some(label) = label {
            svg.line((LEFT, at), (RIGHT, at), &grid);
            svg.text((LEFT - 10.0, at + 0.35 * FONT_SIZE), Anchor::End, &ink, &label);
        }
        svg.line((LEFT - length, at), (LEFT, at), &tick);
    }
    svg.text((x.middle(), BOTTOM + 48.0), Anchor::Middle, &ink, &chart.x.label);
    let at = (22.0, y.middle());
    let turned = format!("fill=\"{INK}\" transform=\"rotate(-90 {} {})\"", at.0, at.1);
    svg.text(at, Anchor::Middle, &turned, &chart.y.label);
}

fn draw(svg: &mut Svg, curve: &Curve, x: &Laid, y: &Laid) {
    let colour = colour(curve.style);
    let place = |&(a, b): &(f64, f64)| Some((x.place(a)?, y.place(b)?));
    match &curve.shape {
        Shape::Line(points) => stretches(svg, points.iter().map(place), &stroke(curve.style, 1.8)),
        Shape::Marked(points) => {
            stretches(svg, points.iter().map(place), &stroke(curve.style, 1.8));
            for at in points.iter().filter_map(place) {
                mark(svg, at, curve.style);
            }
        }
        Shape::Band(points) => {
            let inside = |&(a, low, high): &(f64, f64, f64)| Some((place(&(a, low))?, place(&(a, high))?));
            let edges: Vec<_> = points.iter().filter_map(inside).collect();
            let upper = edges.iter().map(|edge| edge.1);
            let outline: Vec<_> = edges.iter().map(|edge| edge.0).chain(upper.rev()).collect();
            let style = format!(
                "fill=\"{colour}\" fill-opacity=\"0.75\" stroke=\"{colour}\" stroke-width=\"1.4\" \
                 stroke-linejoin=\"round\""
            );
            svg.path(&outline, true, &style);
        }
    }
}

/// Draws a polyline through points. `None` interrupts the line.
fn stretches(svg: &mut Svg, points: impl Iterator<Item = Option<(f64, f64)>>, style: &str) {
    let mut stretch = Vec::new();
    for point in points.chain([None]) {
        match point {
            Some(point) => stretch.push(point),
            None => {
                if stretch.len() > 1 {
                    svg.path(&stretch, false, style);
                }
                stretch.clear();
            }
        }
    }
}

fn stroke(style: usize, width: f64) -> String {
    const DASHES: [&str; 4] = ["", "9 4", "4 3", "11 3 2.5 3"];
    // The ninth curve has the colour of the first curve, but a different dash pattern.
    let dash = match DASHES[(style + style / COLOURS.len()) % DASHES.len()] {
        "" => String::new(),
        dash => format!(" stroke-dasharray=\"{dash}\""),
    };
    let colour = colour(style);
    format!(
        "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
         stroke-linecap=\"butt\"{dash}"
    )
}

/// Draws the mark of a curve: a circle, triangle, square or diamond, according to `style`.
fn mark(svg: &mut Svg, (x, y): (f64, f64), style: usize) {
    let fill = format!("fill=\"{}\" stroke=\"#ffffff\" stroke-width=\"0.8\"", colour(style));
    match style % 4 {
        0 => svg.circle((x, y), 4.6, &fill),
        1 => svg.path(&[(x, y - 5.8), (x + 5.2, y + 3.8), (x - 5.2, y + 3.8)], true, &fill),
        2 => {
            let s = 4.2;
            svg.path(&[(x - s, y - s), (x + s, y - s), (x + s, y + s), (x - s, y + s)], true, &fill);
        }
        _ => {
            let s = 5.8;
            svg.path(&[(x, y - s), (x + s, y), (x, y + s), (x - s, y)], true, &fill);
        }
    }
}

/// Largest number of characters in the first line of a legend entry.
const ROOM: usize = 22;
/// Largest number of characters in the smaller lines of a legend entry.
const ROOM_SMALL: usize = 27;

/// Draws the legend next to the plot. Returns the vertical position of the next entry \[px\].
fn legend(svg: &mut Svg, curves: &[Curve]) -> f64 {
    let x = RIGHT + 18.0;
    let mut y = TOP + 12.0;
    let named = |curve: &Curve| {
        let mut lines = curve.name.lines();
        let first = broken(lines.next().unwrap_or_default(), ROOM);
        (first, lines.flat_map(|line| broken(line, ROOM_SMALL)).collect::<Vec<_>>())
    };
    let names: Vec<(Vec<String>, Vec<String>)> = curves.iter().map(named).collect();
    let lines: usize = names.iter().map(|(first, more)| first.len() + more.len()).sum();
    // A legend with many entries has a smaller distance between them.
    let row =
        (28.0_f64).min((BOTTOM - TOP - 16.0 * (lines - curves.len()) as f64) / curves.len().max(1) as f64);
    for (curve, (first, more)) in curves.iter().zip(names) {
        match curve.shape {
            Shape::Band(_) => {
                let [left, top] = [x, y - 9.0];
                let fill = colour(curve.style);
                svg.raw(&format!(
                    "<rect x=\"{left}\" y=\"{top}\" width=\"28\" height=\"10\" fill=\"{fill}\" \
                     fill-opacity=\"0.75\" stroke=\"{fill}\"/>"
                ));
            }
            Shape::Line(_) | Shape::Marked(_) => {
                svg.line((x, y - 4.0), (x + 28.0, y - 4.0), &stroke(curve.style, 2.0));
                if matches!(curve.shape, Shape::Marked(_)) {
                    mark(svg, (x + 14.0, y - 4.0), curve.style);
                }
            }
        }
        for (index, line) in first.iter().enumerate() {
            y += if index > 0 { 16.0 } else { 0.0 };
            svg.text((x + 36.0, y), Anchor::Start, &format!("fill=\"{INK}\""), line);
        }
        for line in more {
            y += 16.0;
            let style = format!("font-size=\"11\" fill=\"{FAINT}\"");
            svg.text((x + 36.0, y), Anchor::Start, &style, &line);
        }
        y += row;
    }
    y
}

/// Returns the names of the spans without repetition, in the order of their colours.
fn names(spans: &[Span]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for span in spans {
        if !names.contains(&span.label.as_str()) {
            names.push(&span.label);
        }
    }
    names
}

/// Returns the colour of the spans with this name.
fn tint(names: &[&str], name: &str) -> &'static str {
    SHADES[names.iter().position(|other| *other == name).unwrap_or(0) % SHADES.len()]
}

/// Shades an interval between two pixels. If the chart has intervals with different names, the name
/// is written into the interval, provided that it fits.
fn shade(svg: &mut Svg, (from, to): (f64, f64), names: &[&str], name: &str) {
    /// The width of a character of the small font \[px\].
    const WIDTH: f64 = 6.5;
    let corners = [(from, TOP), (to, TOP), (to, BOTTOM), (from, BOTTOM)];
    svg.path(&corners, true, &format!("fill=\"{}\"", tint(names, name)));
    for edge in [from, to] {
        svg.line((edge, TOP), (edge, BOTTOM), &format!("stroke=\"{EDGE}\" stroke-width=\"0.6\""));
    }
    if names.len() > 1 && to - from > WIDTH * name.chars().count() as f64 {
        let style = format!("font-size=\"11\" fill=\"{FAINT}\"");
        svg.text((0.5 * (from + to), BOTTOM - 6.0), Anchor::Middle, &style, name);
    }
}

/// Draws the colour and the name of each kind of shaded interval below the legend.
fn shades(svg: &mut Svg, names: &[&str], mut y: f64) {
    for name in names.iter().filter(|name| !name.is_empty()) {
        if y > BOTTOM + 40.0 {
            return;
        }
        let x = RIGHT + 18.0;
        let rect = format!("x=\"{x}\" y=\"{}\" width=\"28\" height=\"12\"", y - 10.0);
        svg.raw(&format!(
            "<rect {rect} fill=\"{}\" stroke=\"{EDGE}\" stroke-width=\"0.6\"/>",
            tint(names, name)
        ));
        let style = format!("font-size=\"11\" fill=\"{INK}\"");
        svg.text((x + 36.0, y), Anchor::Start, &style, &shortened(name, 27));
        y += 16.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_limit_is_off_the_curves() {
        let level = 0.5 * (TOP + BOTTOM);
        assert_eq!(beside("limit", level, &[]), (RIGHT - 6.0, level - 5.0));
        // The first curve is above the line of the limit. The second one passes above and below the
        // right part of the line.
        let above = vec![(LEFT, level - 8.0), (RIGHT, level - 8.0)];
        let (x, y) = beside("limit", level, std::slice::from_ref(&above));
        assert_eq!((x, y), (RIGHT - 6.0, level + 15.0));
        let below = vec![(LEFT + 200.0, level + 8.0), (RIGHT, level + 8.0)];
        let (x, y) = beside("limit", level, &[above, below]);
        assert!(x < LEFT + 200.0 && y > level, "{x} {y}");
        // If the line is at the upper edge of the plot, the name is below the line.
        assert_eq!(beside("limit", TOP + 2.0, &[]).1, TOP + 17.0);
    }
}
