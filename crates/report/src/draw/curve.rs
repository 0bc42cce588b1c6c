//! The curves of a chart.

/// A curve of a chart. Points that are not finite are omitted, and so are points that are not
/// positive on a logarithmic axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name of the curve in the legend. Text after a line feed is written in a second, smaller
    /// line.
    pub name: String,
    /// The index of the curve's colour, mark and dash pattern.
    pub style: usize,
    /// Shape of the curve, with its points.
    pub shape: Shape,
}

/// Shape of a curve: a line, a line with marks, or a band.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A line through these points.
    Line(Vec<(f64, f64)>),
    /// A line with a mark at each point.
    Marked(Vec<(f64, f64)>),
    /// The area between a lower and an upper value, as points (x, low, high).
    Band(Vec<(f64, f64, f64)>),
}

impl Shape {
    /// Returns all points of the curve; for a band, the points of both edges.
    pub fn points(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Line(points) | Self::Marked(points) => points.clone(),
            Self::Band(points) => points.iter().flat_map(|&(x, a, b)| [(x, a), (x, b)]).collect(),
        }
    }
}
