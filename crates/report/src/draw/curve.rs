//! The elements of a chart.

/// A curve. Points that are not finite, or not positive on a logarithmic axis, are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend; a second line after a line feed, smaller.
    pub name: String,
    /// Number of its colour, mark and dash.
    pub style: usize,
    /// The shape of the curve.
    pub shape: Shape,
}

/// The shape of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A line.
    Line(Vec<(f64, f64)>),
    /// A line with a mark at each point.
    Marked(Vec<(f64, f64)>),
    /// The area between a lowest and a highest value: x, low, high.
    Band(Vec<(f64, f64, f64)>),
}

impl Shape {
    /// Returns every point, of a band both edges.
    pub fn points(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Line(points) | Self::Marked(points) => points.clone(),
            Self::Band(points) => points.iter().flat_map(|&(x, a, b)| [(x, a), (x, b)]).collect(),
        }
    }
}
