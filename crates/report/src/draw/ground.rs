//! Maps of ground tracks, in azimuthal equidistant projection about the middle of the tracks, seen
//! from above, with north up.

use super::clear::crosses;
use super::colour;
use super::sky::SkyView;
use super::svg::{Anchor, FAINT, GRID, INK, SIZE, Svg, broken};
use slewkit::Vector3;
use std::f64::consts::PI;

/// A map of ground tracks and named places.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// Title of the map.
    pub title: String,
    /// The subtitle, one line below the title.
    pub subtitle: String,
    /// Ground tracks that the map shows.
    pub tracks: Vec<GroundTrack>,
    /// Named places, such as ground stations.
    pub places: Vec<(String, Place)>,
}

/// A place on the ground, given by its latitude and east longitude \[deg\].
pub type Place = [f64; 2];

/// The track on the ground of a spacecraft or of a line of sight.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundTrack {
    /// Name of the track in the legend.
    pub name: String,
    /// The index of the track's colour.
    pub style: usize,
    /// Connected parts of the track. A boresight track has several parts if its line of sight
    /// leaves the Earth and returns.
    pub stretches: Vec<Vec<Place>>,
}

/// Position of the middle of the map in the drawing \[px\].
const MIDDLE: (f64, f64) = (300.0, 264.0);
/// Radius of the map in the drawing \[px\].
const RADIUS: f64 = 196.0;
/// Possible distances between grid lines \[deg\]. The map uses the first of them for which at most
/// [`MOST_LINES`] grid lines lie between its middle and its rim.
const STEPS: [f64; 7] = [0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0];
/// Largest number of grid lines between the middle and the rim of the map.
const MOST_LINES: f64 = 3.5;
/// Distance between two points with which a grid line is drawn \[deg\].
const FINE: f64 = 2.0;
/// The length of one degree on the ground \[km\].
const KM_PER_DEG: f64 = 111.19;
/// The smallest angle from the middle to the rim of the map \[deg\].
const LEAST_REACH: f64 = 0.5;

impl Ground {
    /// Returns the map as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        self.draw(&mut svg, "plot");
        svg.end()
    }

    fn view(&self) -> SkyView {
        let tracks = self.tracks.iter().flat_map(|track| track.stretches.iter().flatten());
        let points: Vec<Vector3> =
            tracks.chain(self.places.iter().map(|(_, at)| at)).map(direction).collect();
        let middle = points.iter().sum::<Vector3>().try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let angle = |to: &Vector3| middle.cross(to).norm().atan2(middle.dot(to));
        let reach = points.iter().map(angle).fold(LEAST_REACH.to_radians(), f64::max);
        // East is to the right, as seen from above.
        let right = Vector3::z().cross(&middle).try_normalize(1e-6).unwrap_or_else(Vector3::y);
        SkyView { middle, right, up: middle.cross(&right), reach: (1.12 * reach).min(PI) }
    }

    /// Draws the map into `svg`. No other element of the document may use `id`.
    pub(super) fn draw(&self, svg: &mut Svg, id: &str) {
        let view = self.view();
        let place = |at: &Place| {
            let (x, y) = view.project(&direction(at));
            (MIDDLE.0 + RADIUS * x, MIDDLE.1 - RADIUS * y)
        };
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((92.0, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((92.0, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        let (x, y) = MIDDLE;
        svg.raw(&format!("<clipPath id=\"{id}\"><circle cx=\"{x}\" cy=\"{y}\" r=\"{RADIUS}\"/></clipPath>"));
        svg.raw(&format!("<g clip-path=\"url(#{id})\">"));
        let reach = view.reach.to_degrees();
        let step =
            STEPS.into_iter().find(|step| reach / step <= MOST_LINES).unwrap_or(STEPS[STEPS.len() - 1]);
        // Grid lines are cut off outside of the map, at most one point distance beyond the rim.
        // Points near the antipode of the middle are excluded, because the projection is
        // discontinuous there.
        let farthest = (reach + 1.5 * FINE).min(174.0).to_radians().cos();
        for line in grid(step) {
            let near = |at: &Place| direction(at).dot(&view.middle) > farthest;
            for stretch in line.split(|at| !near(at)).filter(|stretch| stretch.len() > 1) {
                let points: Vec<(f64, f64)> = stretch.iter().map(place).collect();
                svg.path(&points, false, &format!("fill=\"none\" stroke=\"{GRID}\""));
            }
        }
        for track in &self.tracks {
            let style = format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2\"", colour(track.style));
            for stretch in &track.stretches {
                svg.path(&stretch.iter().map(place).collect::<Vec<_>>(), false, &style);
            }
        }
        svg.raw("</g>");
        svg.circle(MIDDLE, RADIUS, &format!("fill=\"none\" stroke=\"{INK}\""));
        let small = format!("font-size=\"10\" fill=\"{FAINT}\"");
        let tracks = self.tracks.iter().flat_map(|track| &track.stretches);
        let tracks: Vec<Vec<(f64, f64)>> =
            tracks.map(|stretch| stretch.iter().map(place).collect()).collect();
        for (text, at) in labels(&view, step) {
            let ((x, y), width) = (place(&at), LETTER * text.chars().count() as f64);
            // A label is at the crossing of two grid lines, in a quadrant through which no track
            // passes.
            let [right, left, above, below] = [x + 2.0, x - 2.0 - width, y - 2.0, y + 10.0];
            let quarters = [(right, above), (right, below), (left, above), (left, below)];
            let is_free = |(x, y): &&(f64, f64)| {
                tracks.iter().all(|track| !crosses(track, [*x, y - 8.0, x + width, y + 2.0]))
            };
            let corner = quarters.iter().find(is_free).unwrap_or(&quarters[0]);
            svg.text(*corner, Anchor::Start, &small, &text);
        }
        for track in &self.tracks {
            let colour = colour(track.style);
            let first = track.stretches.first().and_then(|stretch| stretch.first());
            let last = track.stretches.last().and_then(|stretch| stretch.last());
            if let (Some(first), Some(last)) = (first, last) {
                svg.circle(
                    place(first),
                    4.5,
                    &format!("fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"2\""),
                );
                svg.circle(
                    place(last),
                    5.0,
                    &format!("fill=\"{colour}\" stroke=\"#ffffff\" stroke-width=\"1\""),
                );
            }
        }
        for (name, at) in &self.places {
            let (x, y) = place(at);
            let cross = format!("stroke=\"{INK}\" stroke-width=\"1.6\"");
            svg.line((x - 7.0, y), (x + 7.0, y), &cross);
            svg.line((x, y - 7.0), (x, y + 7.0), &cross);
            let style = format!("font-size=\"11\" fill=\"{INK}\"");
            svg.text((x + 9.0, y + 14.0), Anchor::Start, &style, name);
        }
        self.legend(svg, step, view.reach);
    }

    fn legend(&self, svg: &mut Svg, step: f64, reach: f64) {
        let (x, mut y) = (MIDDLE.0 + RADIUS + 56.0, 84.0);
        let ink = format!("fill=\"{INK}\"");
        for track in &self.tracks {
            let stroke = format!("stroke=\"{}\" stroke-width=\"2.4\"", colour(track.style));
            svg.line((x, y - 4.0), (x + 28.0, y - 4.0), &stroke);
            for line in broken(&track.name, 25) {
                svg.text((x + 36.0, y), Anchor::Start, &ink, &line);
                y += 16.0;
            }
            y += 8.0;
        }
        svg.circle((x + 6.0, y - 4.0), 4.5, &format!("fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"2\""));
        svg.text((x + 36.0, y), Anchor::Start, &ink, "start");
        svg.circle((x + 110.0, y - 4.0), 5.0, &format!("fill=\"{INK}\""));
        svg.text((x + 124.0, y), Anchor::Start, &ink, "end");
        let small = format!("font-size=\"11\" fill=\"{FAINT}\"");
        let across = (2.0 * reach.to_degrees() * KM_PER_DEG / 10.0).round() * 10.0;
        let remarks = [
            format!("grid every {step}°; {across} km across"),
            "distances from the middle are true;".into(),
            "north up".into(),
        ];
        for (row, remark) in remarks.iter().enumerate() {
            svg.text((x, 430.0 + 15.0 * row as f64), Anchor::Start, &small, remark);
        }
    }
}

/// The width of a digit on the map \[px\].
const LETTER: f64 = 6.0;

/// Returns the unit vector from the centre of the Earth to a place.
fn direction([latitude, longitude]: &Place) -> Vector3 {
    let ((sin, cos), (sl, cl)) = (latitude.to_radians().sin_cos(), longitude.to_radians().sin_cos());
    Vector3::new(cos * cl, cos * sl, sin)
}

/// Returns the parallels and meridians every `step` degrees.
fn grid(step: f64) -> Vec<Vec<Place>> {
    let parts = |whole: f64| (0..=(whole / FINE) as usize).map(move |k| FINE * k as f64);
    let count = (90.0 / step) as i32;
    let parallels = (1 - count..count)
        .map(|k| parts(360.0).map(|longitude| [step * f64::from(k), longitude - 180.0]).collect());
    let meridians = (0..(360.0 / step) as i32)
        .map(|k| parts(180.0).map(|latitude| [latitude - 90.0, step * f64::from(k)]).collect());
    parallels.chain(meridians).collect()
}

/// Returns the labels of the grid lines. They are placed along the parallel and the meridian that
/// are nearest to the middle of the map.
fn labels(view: &SkyView, step: f64) -> Vec<(String, Place)> {
    let latitude = view.middle.z.clamp(-1.0, 1.0).asin().to_degrees();
    let longitude = view.middle.y.atan2(view.middle.x).to_degrees();
    let near = |value: f64| (value / step).round() * step;
    let (row, column) = (near(latitude).clamp(-90.0 + step, 90.0 - step), near(longitude));
    let inside = |at: &Place| {
        let (x, y) = view.project(&direction(at));
        x.hypot(y) < 0.93
    };
    let signed = |value: f64, [plus, minus]: [&str; 2]| {
        let side = if value < 0.0 { minus } else { plus };
        format!("{}° {side}", value.abs())
    };
    let range = -6..=6;
    let rows = range.clone().map(|k| row + step * f64::from(k)).filter(|value| value.abs() < 90.0);
    let rows = rows.map(|value| (signed(value, ["N", "S"]), [value, column]));
    let columns = range.filter(|k| *k != 0).map(|k| column + step * f64::from(k));
    let columns = columns.map(|value| {
        let wrapped = value - 360.0 * (value / 360.0).round();
        (signed(wrapped, ["E", "W"]), [row, value])
    });
    rows.chain(columns).filter(|(_, at)| inside(at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn east_is_right_and_north_is_up_and_all_is_on_the_map() {
        let track =
            GroundTrack { name: "t".into(), style: 0, stretches: vec![vec![[10.0, 170.0], [20.0, -170.0]]] };
        let ground = Ground {
            title: String::new(),
            subtitle: String::new(),
            tracks: vec![track],
            places: vec![("station".into(), [14.0, 179.0])],
        };
        let view = ground.view();
        let [a, b] = [[10.0, 170.0], [20.0, -170.0]].map(|at| view.project(&direction(&at)));
        // The tracks may cross the date line.
        assert!(a.0 < 0.0 && b.0 > 0.0 && a.1 < b.1, "{a:?} {b:?}");
        assert!(a.0.hypot(a.1) < 1.0 && b.0.hypot(b.1) < 1.0);
        // An angle of latitude has its true size on the map.
        let apart = (view.project(&view.middle).1 - view.project(&(view.middle + 0.01 * view.up)).1).abs();
        assert!((apart * view.reach - 0.01_f64.atan()).abs() < 1e-12);
        assert!(ground.svg().contains("station") && !ground.svg().contains("NaN"));
    }
    /// If grid lines were not cut off at the rim, most of the file would consist of grid lines
    /// outside of the map.
    #[test]
    fn the_grid_of_a_small_map_is_that_of_the_map() {
        let map = |stretch: Vec<Place>| Ground {
            title: String::new(),
            subtitle: String::new(),
            tracks: vec![GroundTrack { name: "t".into(), style: 0, stretches: vec![stretch] }],
            places: Vec::new(),
        };
        let lines = |ground: &Ground| ground.svg().matches(GRID).count();
        let small = map(vec![[-1.0, -98.0], [-5.0, -95.0]]);
        assert!(small.svg().len() < 20_000, "{} bytes", small.svg().len());
        assert!((8..60).contains(&lines(&small)), "{} lines", lines(&small));
        // At a pole all meridians meet.
        let pole = map(vec![[89.0, 0.0], [88.0, 180.0]]);
        assert!(lines(&pole) >= 360, "{} lines", lines(&pole));
    }
}
