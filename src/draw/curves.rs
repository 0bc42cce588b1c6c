//! Curves over two axes, with marks, bands and a legend beside the plot.

use super::axis::{Axis, Laid, Tick};
use super::colour;
use super::svg::{Anchor, FAINT, FONT_SIZE, GRID, INK, Svg};

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Under which circumstances, one line below the title.
    pub subtitle: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// What is drawn, the first one on top.
    pub curves: Vec<Curve>,
}

/// A curve. Points that are not finite, or not positive on a logarithmic axis, are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend; a second line after a line feed, smaller.
    pub name: String,
    /// Number of its colour, mark and dash.
    pub style: usize,
    /// How it is drawn.
    pub shape: Shape,
}

/// How a curve is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A line.
    Line(Vec<(f64, f64)>),
    /// A line with a mark at each point.
    Marked(Vec<(f64, f64)>),
    /// The area between a lowest and a highest value: x, low, high.
    Band(Vec<(f64, f64, f64)>),
}

/// The drawing [px]: its size, and the edges of the plot.
const SIZE: (f64, f64) = (800.0, 480.0);
const LEFT: f64 = 92.0;
const RIGHT: f64 = 610.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 418.0;

impl Shape {
    fn points(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Line(points) | Self::Marked(points) => points.clone(),
            Self::Band(points) => points.iter().flat_map(|&(x, a, b)| [(x, a), (x, b)]).collect(),
        }
    }
}

impl Chart {
    /// The chart as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        let points = || self.curves.iter().flat_map(|curve| curve.shape.points());
        let x = Laid::new(&self.x, points().map(|point| point.0), LEFT, RIGHT);
        let y = Laid::new(&self.y, points().map(|point| point.1), BOTTOM, TOP);
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((LEFT, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((LEFT, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        axes(&mut svg, self, &x, &y);
        let frame =
            format!("x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\"", RIGHT - LEFT, BOTTOM - TOP);
        svg.raw(&format!("<clipPath id=\"plot\"><rect {frame}/></clipPath>"));
        svg.raw("<g clip-path=\"url(#plot)\">");
        for curve in self.curves.iter().rev() {
            draw(&mut svg, curve, &x, &y);
        }
        svg.raw("</g>");
        svg.raw(&format!("<rect {frame} fill=\"none\" stroke=\"{INK}\" stroke-width=\"1\"/>"));
        legend(&mut svg, &self.curves);
        svg.end()
    }
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

/// Polylines between the gaps.
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
    let dash = match DASHES[style % DASHES.len()] {
        "" => String::new(),
        dash => format!(" stroke-dasharray=\"{dash}\""),
    };
    let colour = colour(style);
    format!(
        "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
         stroke-linecap=\"butt\"{dash}"
    )
}

/// Circle, triangle, square, diamond.
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

fn legend(svg: &mut Svg, curves: &[Curve]) {
    let x = RIGHT + 18.0;
    let mut y = TOP + 12.0;
    for curve in curves {
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
        let mut lines = curve.name.lines();
        let first = lines.next().unwrap_or_default();
        svg.text((x + 36.0, y), Anchor::Start, &format!("fill=\"{INK}\""), first);
        for line in lines {
            y += 16.0;
            svg.text((x + 36.0, y), Anchor::Start, &format!("font-size=\"11\" fill=\"{FAINT}\""), line);
        }
        y += 28.0;
    }
}
