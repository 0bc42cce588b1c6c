//! Drawings of paths and bodies in space, in parallel projection. Near items hide far items.

use super::axis::{Axis, Laid};
use super::colour;
use super::svg::{Anchor, FAINT, FONT_SIZE, GRID, INK, Svg};
use slewkit::Vector3;

/// A three-dimensional drawing in parallel projection.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Title of the drawing.
    pub title: String,
    /// The subtitle, one line below the title.
    pub subtitle: String,
    /// Unit of the three axes, such as "m".
    pub unit: String,
    /// The names of the bodies in the legend, in the order of their colours.
    pub names: Vec<String>,
    /// Items that are drawn: paths, rods and balls.
    pub items: Vec<Item>,
}

/// An item of the drawing: a path, a rod or a ball.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A path through points in space.
    Path {
        /// Points of the path \[m\].
        points: Vec<Vector3>,
        /// Index of the colour of the path.
        style: usize,
        /// True if the path is drawn thin and pale.
        faint: bool,
    },
    /// A straight rod between two points.
    Rod {
        /// Ends of the rod \[m\].
        ends: [Vector3; 2],
        /// Index of the colour of the rod.
        style: usize,
    },
    /// A ball with a center and a radius.
    Ball {
        /// Center of the ball \[m\].
        center: Vector3,
        /// Radius of the ball \[m\]. A small ball is drawn large enough to be visible.
        radius: f64,
        /// Index of the colour of the ball.
        style: usize,
    },
}

/// The width and height of the drawing [px].
const SIZE: (f64, f64) = (800.0, 620.0);
const TOP: f64 = 70.0;
const MARGIN: f64 = 62.0;

/// Azimuth of the direction of view \[deg\].
const AZIMUTH: f64 = -62.0;
/// Elevation of the direction of view above the x-y plane \[deg\].
const ELEVATION: f64 = 34.0;

/// The number of parts in which a rod is drawn.
const PARTS: usize = 10;

/// A parallel projection onto the drawing.
struct View {
    right: Vector3,
    up: Vector3,
    /// The unit vector towards the viewer.
    near: Vector3,
    scale: f64,
    shift: (f64, f64),
}

/// A piece of an item. Pieces are drawn in the order of decreasing distance from the viewer.
struct Piece {
    depth: f64,
    draw: Draw,
}

enum Draw {
    Line { ends: [(f64, f64); 2], style: String },
    Ball { center: (f64, f64), radius: f64, style: usize },
}

impl View {
    /// Builds the projection in which the box between two opposite corners fills the drawing.
    fn of(low: &Vector3, high: &Vector3) -> Self {
        let (azimuth, elevation) = (AZIMUTH.to_radians(), ELEVATION.to_radians());
        let near =
            Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
        let right = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
        let up = near.cross(&right);
        let corners = corners(low, high);
        let extent = |axis: &Vector3| {
            let along = corners.map(|corner| corner.dot(axis));
            (
                along.into_iter().fold(f64::INFINITY, f64::min),
                along.into_iter().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        let ((left, right_end), (bottom, top)) = (extent(&right), extent(&up));
        let room = (SIZE.0 - 2.0 * MARGIN, SIZE.1 - TOP - MARGIN);
        let scale = (room.0 / (right_end - left)).min(room.1 / (top - bottom));
        let shift = (
            0.5 * SIZE.0 - scale * 0.5 * (left + right_end),
            TOP + 0.5 * room.1 + scale * 0.5 * (bottom + top),
        );
        Self { right, up, near, scale, shift }
    }

    fn place(&self, point: &Vector3) -> (f64, f64) {
        (self.shift.0 + self.scale * point.dot(&self.right), self.shift.1 - self.scale * point.dot(&self.up))
    }

    fn depth(&self, point: &Vector3) -> f64 {
        point.dot(&self.near)
    }
}

fn corners(low: &Vector3, high: &Vector3) -> [Vector3; 8] {
    std::array::from_fn(|index| {
        Vector3::from_fn(|axis, _| if index >> axis & 1 == 0 { low[axis] } else { high[axis] })
    })
}

impl Scene {
    /// Returns the scene as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((MARGIN, 28.0), Anchor::Start, &bold, &self.title);
        svg.text((MARGIN, 49.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        let (low, high) = self.bounds();
        let view = View::of(&low, &high);
        for index in 0..self.names.len() {
            let (light, dark) = (mix(colour(index), 0.65), colour(index));
            svg.raw(&format!(
                "<radialGradient id=\"ball{index}\" cx=\"0.36\" cy=\"0.32\" r=\"0.75\">\
                 <stop offset=\"0\" stop-color=\"{light}\"/><stop offset=\"1\" stop-color=\"{dark}\"/>\
                 </radialGradient>"
            ));
        }
        self.floor(&mut svg, &view, &low, &high);
        let mut pieces = self.pieces(&view);
        pieces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        for piece in &pieces {
            match &piece.draw {
                Draw::Line { ends, style } => svg.line(ends[0], ends[1], style),
                Draw::Ball { center, radius, style } => {
                    let style = format!(
                        "fill=\"url(#ball{style})\" stroke=\"{}\" stroke-width=\"0.6\"",
                        mix(colour(*style), -0.35)
                    );
                    svg.circle(*center, *radius, &style);
                }
            }
        }
        let mut x = SIZE.0 - MARGIN - 118.0 * self.names.len() as f64;
        for (index, name) in self.names.iter().enumerate() {
            svg.circle((x, SIZE.1 - 22.0), 6.0, &format!("fill=\"url(#ball{index})\""));
            svg.text((x + 13.0, SIZE.1 - 17.5), Anchor::Start, &format!("fill=\"{INK}\""), name);
            x += 118.0;
        }
        svg.end()
    }

    /// Returns two opposite corners of a box that contains all items, with a margin. Their
    /// coordinates are not rounded to ticks.
    fn bounds(&self) -> (Vector3, Vector3) {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let mut see = |point: &Vector3, radius: f64| {
            for axis in 0..3 {
                // `f64::min` and `f64::max` ignore a NaN.
                if point[axis].is_finite() {
                    low[axis] = low[axis].min(point[axis] - radius);
                    high[axis] = high[axis].max(point[axis] + radius);
                }
            }
        };
        for item in &self.items {
            match item {
                Item::Path { points, .. } => points.iter().for_each(|point| see(point, 0.0)),
                Item::Rod { ends, .. } => ends.iter().for_each(|point| see(point, 0.0)),
                Item::Ball { center, radius, .. } => see(center, *radius),
            }
        }
        let size = (high - low).amax();
        if !(size.is_finite() && size > 0.0) {
            return (Vector3::repeat(-1.0), Vector3::repeat(1.0));
        }
        // A box of zero height has no floor.
        let middle = 0.5 * (low + high);
        let half = (0.5 * (high - low)).map(|half| (1.04 * half).max(0.08 * size));
        (middle - half, middle + half)
    }

    fn pieces(&self, view: &View) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut line = |a: &Vector3, b: &Vector3, style: String| {
            let ends = [view.place(a), view.place(b)];
            if ends.iter().all(|end| end.0.is_finite() && end.1.is_finite()) {
                pieces.push(Piece { depth: view.depth(&(0.5 * (a + b))), draw: Draw::Line { ends, style } });
            }
        };
        for item in &self.items {
            match item {
                Item::Path { points, style, faint } => {
                    let (width, opacity) = if *faint { (1.0, 0.35) } else { (1.9, 1.0) };
                    let style = format!(
                        "stroke=\"{}\" stroke-width=\"{width}\" stroke-opacity=\"{opacity}\" \
                         stroke-linecap=\"round\"",
                        colour(*style)
                    );
                    for pair in points.windows(2) {
                        line(&pair[0], &pair[1], style.clone());
                    }
                }
                Item::Rod { ends, style } => {
                    let colour = mix(colour(*style), -0.35);
                    let style = format!("stroke=\"{colour}\" stroke-width=\"2.4\" stroke-linecap=\"round\"");
                    // The path is drawn in parts, so that some parts can be in front of other items
                    // and other parts behind them.
                    let at = |part: usize| ends[0] + (ends[1] - ends[0]) * (part as f64 / PARTS as f64);
                    for part in 0..PARTS {
                        line(&at(part), &at(part + 1), style.clone());
                    }
                }
                Item::Ball { .. } => {}
            }
        }
        for item in &self.items {
            let Item::Ball { center, radius, style } = item else { continue };
            let at = view.place(center);
            if at.0.is_finite() && at.1.is_finite() {
                let radius = (view.scale * radius).clamp(3.0, 400.0);
                pieces.push(Piece {
                    depth: view.depth(center),
                    draw: Draw::Ball { center: at, radius, style: *style },
                });
            }
        }
        pieces
    }

    /// Draws the floor of the box with a grid, the height axis at one corner, and labels along the
    /// edges near the viewer.
    fn floor(&self, svg: &mut Svg, view: &View, low: &Vector3, high: &Vector3) {
        let grid = format!("stroke=\"{GRID}\" stroke-width=\"1\"");
        let edge = format!("stroke=\"{FAINT}\" stroke-width=\"1\"");
        let ink = format!("fill=\"{INK}\"");
        let at = |x: f64, y: f64, z: f64| view.place(&Vector3::new(x, y, z));
        let outline = [
            at(low.x, low.y, low.z),
            at(high.x, low.y, low.z),
            at(high.x, high.y, low.z),
            at(low.x, high.y, low.z),
        ];
        svg.path(&outline, true, "fill=\"#f6f7f9\" stroke=\"none\"");
        let ticks = |axis: usize| -> Vec<(f64, Option<String>)> {
            let round = Axis { limits: Some((low[axis], high[axis])), ..Axis::linear("") };
            // The ticks are computed for an axis that is about as long as this edge in the drawing,
            // so that labels do not overlap. They are then converted back to values.
            let length = 0.8 * view.scale * (high[axis] - low[axis]);
            let laid = Laid::new(&round, std::iter::empty(), 0.0, length);
            let value = |at: f64| low[axis] + at / length * (high[axis] - low[axis]);
            laid.ticks().into_iter().map(|tick| (value(tick.at), tick.label)).collect()
        };
        // In this view, the corner nearest to the viewer is (high x, low y).
        for (value, label) in ticks(0) {
            svg.line(at(value, low.y, low.z), at(value, high.y, low.z), &grid);
            let (x, y) = at(value, low.y, low.z);
            svg.text((x - 6.0, y + 1.5 * FONT_SIZE), Anchor::Middle, &ink, &label.unwrap_or_default());
        }
        for (value, label) in ticks(1) {
            svg.line(at(low.x, value, low.z), at(high.x, value, low.z), &grid);
            let (x, y) = at(high.x, value, low.z);
            svg.text((x + 10.0, y + 0.9 * FONT_SIZE), Anchor::Start, &ink, &label.unwrap_or_default());
        }
        svg.path(&outline, true, &format!("fill=\"none\" {edge}"));
        // The height axis is at the left corner, (low x, low y).
        svg.line(at(low.x, low.y, low.z), at(low.x, low.y, high.z), &edge);
        for (value, label) in ticks(2) {
            let (x, y) = at(low.x, low.y, value);
            svg.line((x - 5.0, y), (x, y), &edge);
            svg.text((x - 9.0, y + 0.35 * FONT_SIZE), Anchor::End, &ink, &label.unwrap_or_default());
        }
        let name = |name: &str| format!("{name}, {}", self.unit);
        let (x, y) = at(0.5 * (low.x + high.x), low.y, low.z);
        svg.text((x - 14.0, y + 3.3 * FONT_SIZE), Anchor::Middle, &ink, &name("x"));
        let (x, y) = at(high.x, 0.5 * (low.y + high.y), low.z);
        svg.text((x + 40.0, y + 2.2 * FONT_SIZE), Anchor::Start, &ink, &name("y"));
        let (x, y) = at(low.x, low.y, high.z);
        svg.text((x - 9.0, y - 1.0 * FONT_SIZE), Anchor::Middle, &ink, &name("z"));
    }
}

/// Mixes a colour with white or, if `part` is negative, with black.
fn mix(colour: &str, part: f64) -> String {
    let channel = |at: usize| {
        let value = u8::from_str_radix(&colour[at..at + 2], 16).map_or(0.0, f64::from);
        let target = if part > 0.0 { 255.0 } else { 0.0 };
        (value + part.abs() * (target - value)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(1), channel(3), channel(5))
}
