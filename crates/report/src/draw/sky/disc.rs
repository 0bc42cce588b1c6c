//! Moving discs on the sphere of directions: Earth, Moon, Sun, and targets.

use super::super::svg::Svg;
use super::{SkyView, circle};
use slewkit::Vector3;

/// A moving disc, or a moving point.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyDisc {
    /// Name of the celestial body or target.
    pub name: String,
    /// Kind of the disc, which determines its colour.
    pub kind: DiscKind,
    /// Direction of the middle of the disc, as a unit vector, and its angular radius \[rad\], at
    /// equally spaced times from the start to the end. The list is never empty.
    pub way: Vec<(Vector3, f64)>,
}

/// The kind of a disc, which determines its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscKind {
    /// The Earth.
    Earth,
    /// The Moon.
    Moon,
    /// The Sun.
    Sun,
    /// A named target of the maneuver.
    Target,
}

/// Smallest radius with which a disc is drawn \[px\]. At its true size, the Sun would have half a
/// pixel.
const LEAST: f64 = 4.0;

impl DiscKind {
    /// Returns the name of this kind in the style sheet of pages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Earth => "earth",
            Self::Moon => "moon",
            Self::Sun => "sun",
            Self::Target => "target",
        }
    }

    fn colour(self) -> &'static str {
        match self {
            Self::Earth => "#2f6f9f",
            Self::Moon => "#777777",
            Self::Sun => "#d99a00",
            Self::Target => "#0b6b3a",
        }
    }
}

impl SkyDisc {
    /// Returns the direction and the angular radius \[rad\] of the disc at the start and at the
    /// end.
    pub fn ends(&self) -> [(Vector3, f64); 2] {
        let nothing = (Vector3::x(), 0.0);
        [self.way.first(), self.way.last()].map(|end| end.copied().unwrap_or(nothing))
    }

    /// Draws the disc at the end, its outline at the start, and the path of its middle. `scale` is
    /// the radius of the map \[px\]; `rim` is a closed curve around the map.
    pub(super) fn draw(
        &self,
        svg: &mut Svg,
        view: &SkyView,
        scale: f64,
        place: &dyn Fn(&Vector3) -> (f64, f64),
        rim: &[(f64, f64)],
    ) {
        let colour = self.kind.colour();
        let [start, end] = self.ends();
        for (index, (middle, radius)) in [start, end].into_iter().enumerate() {
            let line = if index == 0 { "stroke-dasharray=\"3 3\"" } else { "" };
            let stroke = format!("stroke=\"{colour}\" stroke-width=\"1.2\" {line}");
            let fill = if index == 0 { 0.0 } else { 0.25 };
            if scale * radius / view.reach < LEAST {
                let style = format!("fill=\"{colour}\" fill-opacity=\"{}\" {stroke}", 3.0 * fill);
                svg.circle(place(&middle), LEAST, &style);
                continue;
            }
            let edge: Vec<(f64, f64)> = circle(&middle, radius).iter().map(place).collect();
            // If the disc contains the antipode of the middle of the map, the area outside of its
            // edge is filled.
            let outside = middle.dot(&-view.middle) > radius.cos();
            if index == 1 {
                let curves = [Some(&edge[..]), outside.then_some(rim)];
                let style = format!("fill=\"{colour}\" fill-opacity=\"{fill}\" fill-rule=\"evenodd\"");
                svg.area(&curves.into_iter().flatten().collect::<Vec<_>>(), &style);
            }
            svg.path(&edge, true, &format!("fill=\"none\" {stroke}"));
        }
        let middles: Vec<Vector3> = self.way.iter().map(|(middle, _)| *middle).collect();
        for stretch in middles.chunk_by(|a, b| !view.tears(a, b)) {
            let points: Vec<(f64, f64)> = stretch.iter().map(place).collect();
            svg.path(&points, false, &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\""));
        }
    }
}
