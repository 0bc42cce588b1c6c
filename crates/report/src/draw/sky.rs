//! Maps of the sphere of directions: boresight tracks, keep-out cones and keep-in cones.
//!
//! The projection is azimuthal equidistant about the middle of the tracks and cones. A direction at
//! the angle θ from the middle is drawn at a distance proportional to θ, in its true azimuth. A
//! track is interrupted only at the antipode of the middle, and a cone is always a single closed
//! curve.

mod disc;
mod names;

pub use disc::{DiscKind, SkyDisc};
use names::Names;

use super::colour;
use super::svg::{Anchor, FAINT, GRID, INK, SIZE, Svg, broken, shortened};
use slewkit::Vector3;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};

/// A map of the sphere of directions, with tracks and cones.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// Title of the map.
    pub title: String,
    /// The subtitle, one line below the title.
    pub subtitle: String,
    /// True to show the whole sphere; false to show only the part with tracks and cones.
    pub whole: bool,
    /// Cones that the map shows.
    pub cones: Vec<SkyCone>,
    /// The moving discs, such as Earth, Moon and Sun.
    pub discs: Vec<SkyDisc>,
    /// Tracks of directions over the sphere that the map shows.
    pub tracks: Vec<SkyTrack>,
    /// Closed curves around points of the tracks, such as covariance ellipses.
    pub rings: Vec<SkyRing>,
    /// Single directions that are marked on the map.
    pub marks: Vec<SkyMark>,
    /// The names of the azimuth about z and of the elevation above the x-y plane, such as right
    /// ascension and declination.
    pub angles: [String; 2],
}

/// A pointing constraint as a cone on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyCone {
    /// Name of the pointing constraint.
    pub name: String,
    /// Axis of the cone at the start, as a unit vector.
    pub axis: Vector3,
    /// Half angle of the cone at the start \[rad\].
    pub half_angle: f64,
    /// Condition on boresights: they must stay outside, inside or on the surface of the cone.
    pub asks: ConeAsks,
    /// Time intervals in which the cone is active, as fractions of the duration from 0 to 1; `None`
    /// if the cone is always active.
    pub acts: Option<Vec<[f64; 2]>>,
    /// Time intervals in which the cone is active as text, such as "from 0 to 40 s"; empty if the
    /// cone is always active.
    pub when: String,
    /// Axis and half angle \[rad\] of the cone at equally spaced times from the start to the end;
    /// empty if the cone does not move.
    pub way: Vec<(Vector3, f64)>,
}

/// The condition that a cone imposes on boresights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConeAsks {
    /// Boresights must stay outside of the cone.
    KeepOut,
    /// Boresights must stay inside the cone.
    KeepIn,
    /// Boresights must stay on the surface of the cone.
    HoldOn,
}

impl ConeAsks {
    /// Returns the name of the condition for pages.
    pub fn word(self) -> &'static str {
        match self {
            Self::KeepOut => "keep out",
            Self::KeepIn => "keep in",
            Self::HoldOn => "hold on",
        }
    }
}

/// The track of a direction over the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyTrack {
    /// Name of the direction, such as a boresight.
    pub name: String,
    /// Index of the colour of the track.
    pub style: usize,
    /// The unit vectors along the track.
    pub points: Vec<Vector3>,
}

/// A closed curve on the sphere, such as the covariance ellipse of a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyRing {
    /// Index of the colour of the curve.
    pub style: usize,
    /// True if the inside is shaded, false if only the outline is drawn.
    pub filled: bool,
    /// The unit vectors along the closed curve.
    pub points: Vec<Vector3>,
}

/// A marked direction with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMark {
    /// Name of the marked direction.
    pub name: String,
    /// Direction of the mark, as a unit vector.
    pub at: Vector3,
}

/// The projection of a map: its middle, orientation and angular radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyView {
    /// Direction at the middle of the map, as a unit vector.
    pub middle: Vector3,
    /// Unit vector that points to the right at the middle of the map.
    pub right: Vector3,
    /// Unit vector that points upwards at the middle of the map.
    pub up: Vector3,
    /// The angle from the middle to the rim \[rad\], at most π.
    pub reach: f64,
}

/// Position of the middle of the map in the drawing \[px\].
const MIDDLE: (f64, f64) = (320.0, 264.0);
/// Radius of the map in the drawing \[px\].
const RADIUS: f64 = 196.0;

/// Font size of names on the map \[px\].
const NAME: f64 = 11.0;
/// Largest number of characters of a name on the map.
const LONGEST_NAME: usize = 30;

/// Upper edge of the area in which names are placed \[px\].
const TOP: f64 = 56.0;
/// Smallest distance of names from the ends of tracks \[px\].
const END: f64 = 6.0;

/// Half the size of the cross at a mark \[px\].
const CROSS: f64 = 5.0;

/// Number of points with which the edge of a cone is drawn.
const AROUND: usize = 180;

/// Colour of the areas that constraints forbid.
const FORBIDDEN: &str = "#a01818";

impl SkyView {
    /// Projects a direction onto the map. The coordinates are in units of the radius of the map.
    pub fn project(&self, direction: &Vector3) -> (f64, f64) {
        let part =
            Vector3::new(direction.dot(&self.right), direction.dot(&self.up), direction.dot(&self.middle));
        let across = part.x.hypot(part.y);
        let angle = across.atan2(part.z) / self.reach;
        if across == 0.0 { (angle, 0.0) } else { (angle * part.x / across, angle * part.y / across) }
    }

    /// Returns whether a track is interrupted between two neighbouring points. This is the case if
    /// both points lie in the hemisphere opposite to the middle of the map, and their azimuths on
    /// the map differ by more than an eighth of a turn.
    fn tears(&self, a: &Vector3, b: &Vector3) -> bool {
        let behind = [a, b].iter().all(|point| point.dot(&self.middle) < 0.0);
        let ((ax, ay), (bx, by)) = (self.project(a), self.project(b));
        behind && ax * bx + ay * by < FRAC_1_SQRT_2 * ax.hypot(ay) * bx.hypot(by)
    }
}

impl Sky {
    /// Returns the projection about the mean direction of tracks, marks and cones. The map contains
    /// all of them, and north is up.
    pub fn view(&self) -> SkyView {
        let tracks = || self.tracks.iter().flat_map(|track| &track.points);
        let shown = || tracks().copied().chain(self.marks.iter().map(|mark| mark.at));
        let rings = || self.rings.iter().flat_map(|ring| &ring.points);
        let sum = shown().chain(self.cones.iter().map(|cone| cone.axis)).sum::<Vector3>();
        let middle = sum.try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let angle = |to: &Vector3| middle.cross(to).norm().atan2(middle.dot(to));
        let forbidden = self.cones.iter().map(|cone| angle(&cone.axis) + cone.half_angle);
        let reach =
            shown().chain(rings().copied()).map(|point| angle(&point)).chain(forbidden).fold(0.0, f64::max);
        // East is to the right, because the sphere is seen from outside, like the body at its
        // centre.
        let right = Vector3::z().cross(&middle).try_normalize(1e-6).unwrap_or_else(Vector3::y);
        SkyView {
            middle,
            right,
            up: middle.cross(&right),
            reach: if self.whole { PI } else { (1.08 * reach).clamp(0.2, PI) },
        }
    }

    /// Returns the map as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1);
        self.draw(&mut svg, "plot");
        svg.end()
    }

    /// Draws the map into `svg`. No other element of the document may use `id`.
    pub(super) fn draw(&self, svg: &mut Svg, id: &str) {
        let view = self.view();
        let place = |direction: &Vector3| {
            let (x, y) = view.project(direction);
            (MIDDLE.0 + RADIUS * x, MIDDLE.1 - RADIUS * y)
        };
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        svg.text((92.0, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((92.0, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        svg.raw(&format!(
            "<clipPath id=\"{id}\"><circle cx=\"{}\" cy=\"{}\" r=\"{RADIUS}\"/></clipPath>",
            MIDDLE.0, MIDDLE.1
        ));
        svg.raw(&format!("<g clip-path=\"url(#{id})\">"));
        let grid = format!("fill=\"none\" stroke=\"{GRID}\"");
        for line in graticule() {
            for stretch in near(&line, &view) {
                svg.path(&stretch.iter().map(place).collect::<Vec<_>>(), false, &grid);
            }
        }
        let rim: Vec<(f64, f64)> = (0..AROUND)
            .map(|k| (TAU * k as f64 / AROUND as f64).sin_cos())
            .map(|(sin, cos)| (MIDDLE.0 + 1.01 * RADIUS * cos, MIDDLE.1 + 1.01 * RADIUS * sin))
            .collect();
        for disc in &self.discs {
            disc.draw(svg, &view, RADIUS, &place, &rim);
        }
        for cone in &self.cones {
            if let Some((axis, half_angle)) = cone.way.last() {
                let edge: Vec<(f64, f64)> = circle(axis, *half_angle).iter().map(place).collect();
                let style = format!("fill=\"none\" stroke=\"{FORBIDDEN}\" stroke-dasharray=\"4 3\"");
                svg.path(&edge, true, &style);
            }
            let edge: Vec<(f64, f64)> = circle(&cone.axis, cone.half_angle).iter().map(place).collect();
            // On the map, the inside of a closed curve is the part that does not contain the
            // antipode of the middle.
            let opposite = cone.axis.dot(&-view.middle).clamp(-1.0, 1.0).acos() < cone.half_angle;
            if cone.asks != ConeAsks::HoldOn {
                let outer = (opposite == (cone.asks == ConeAsks::KeepOut)).then_some(&rim[..]);
                let fill = format!("fill=\"{FORBIDDEN}\" fill-opacity=\"0.13\" fill-rule=\"evenodd\"");
                svg.area(&[Some(&edge[..]), outer].into_iter().flatten().collect::<Vec<_>>(), &fill);
            }
            svg.path(&edge, true, &format!("fill=\"none\" stroke=\"{FORBIDDEN}\" stroke-width=\"1.4\""));
        }
        for ring in &self.rings {
            let whole = ring.points.iter().chain(ring.points.first());
            if whole.clone().zip(whole.skip(1)).any(|(a, b)| view.tears(a, b)) {
                continue;
            }
            let edge: Vec<(f64, f64)> = ring.points.iter().map(place).collect();
            let (colour, fill) = (colour(ring.style), if ring.filled { 0.35 } else { 0.0 });
            let style = format!(
                "fill=\"{colour}\" fill-opacity=\"{fill}\" stroke=\"{colour}\" stroke-width=\"0.9\" \
                 stroke-opacity=\"0.75\""
            );
            svg.path(&edge, true, &style);
        }
        let stretches = |track: &SkyTrack| -> Vec<Vec<(f64, f64)>> {
            let stretches = track.points.chunk_by(|a, b| !view.tears(a, b));
            stretches.map(|stretch| stretch.iter().map(place).collect()).collect()
        };
        for track in self.tracks.iter().rev() {
            let colour = colour(track.style);
            for points in stretches(track) {
                svg.path(&points, false, &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\""));
            }
        }
        svg.raw("</g>");
        let rim = format!("fill=\"none\" stroke=\"{INK}\"");
        svg.circle(MIDDLE, RADIUS, &rim);
        let tracks = self.tracks.iter().flat_map(stretches).collect();
        let mut names = Names::within([0.0, TOP, MIDDLE.0 + RADIUS + 48.0, SIZE.1], tracks);
        for track in &self.tracks {
            for end in [track.points.first(), track.points.last()].into_iter().flatten() {
                names.keep_clear(place(end), END);
            }
        }
        for mark in &self.marks {
            names.keep_clear(place(&mark.at), CROSS);
        }
        let style = format!("font-size=\"{NAME}\" fill=\"{INK}\"");
        let discs = self.discs.iter().map(|disc| (disc.ends()[1].0, &disc.name));
        let marks = self.marks.iter().map(|mark| (mark.at, &mark.name));
        // Points beyond the rim of the map are not drawn.
        let shown = |at: &Vector3| {
            let (x, y) = view.project(at);
            x.hypot(y) <= 1.0
        };
        for (at, name) in marks.chain(discs).filter(|(at, name)| !name.is_empty() && shown(at)) {
            let name = shortened(name, LONGEST_NAME);
            svg.text(names.beside(place(&at), &name, NAME), Anchor::Start, &style, &name);
        }
        for (label, at) in self.labels(&view) {
            let (x, y) = place(&at);
            if names.if_free((x + 2.0, y - 2.0), &label, 10.0) {
                let style = format!("font-size=\"10\" fill=\"{FAINT}\"");
                svg.text((x + 2.0, y - 2.0), Anchor::Start, &style, &label);
            }
        }
        for track in &self.tracks {
            if let [first, .., last] = &track.points[..] {
                ends(svg, place(first), place(last), colour(track.style));
            }
        }
        for mark in &self.marks {
            let (x, y) = place(&mark.at);
            let cross = format!("stroke=\"{INK}\" stroke-width=\"1.6\"");
            svg.line((x - CROSS, y), (x + CROSS, y), &cross);
            svg.line((x, y - CROSS), (x, y + CROSS), &cross);
        }
        self.legend(svg);
    }

    /// Returns the labels of the grid lines through the middle of the map, with the directions at
    /// which they are placed.
    pub fn labels(&self, view: &SkyView) -> Vec<(String, Vector3)> {
        let inside = |at: &Vector3| {
            let (x, y) = view.project(at);
            x.hypot(y) < 0.93
        };
        let middle = (view.middle.y.atan2(view.middle.x) / (PI / 6.0)).round() * 30.0;
        let tilt = (view.middle.z.asin() / (PI / 6.0)).round().clamp(-2.0, 2.0) * 30.0;
        let tilts = (-2..=2).map(|k| (f64::from(30 * k), middle));
        let abouts = (-5..=6).map(|k| (tilt, f64::from(30 * k)));
        let both = tilts.map(|at| (0, at)).chain(abouts.map(|at| (1, at)));
        let label = |(kind, (tilt, about)): (usize, (f64, f64))| {
            let at = sphere(tilt.to_radians(), about.to_radians());
            let about = (about + 360.0) % 360.0;
            let text = if kind == 0 { format!("{tilt}°") } else { format!("{about}°") }.replace('-', "−");
            // At this crossing, two labels would overlap.
            let twice = kind == 1 && ((about - middle) % 360.0).abs() < 1.0;
            (!twice && inside(&at)).then_some((text, at))
        };
        both.filter_map(label).collect()
    }

    fn legend(&self, svg: &mut Svg) {
        let (x, mut y) = (MIDDLE.0 + RADIUS + 56.0, 84.0);
        let ink = format!("fill=\"{INK}\"");
        let small = format!("font-size=\"11\" fill=\"{FAINT}\"");
        for track in &self.tracks {
            let stroke = format!("stroke=\"{}\" stroke-width=\"2.4\"", colour(track.style));
            svg.line((x, y - 4.0), (x + 28.0, y - 4.0), &stroke);
            for line in broken(&track.name, 25) {
                svg.text((x + 36.0, y), Anchor::Start, &ink, &line);
                y += 16.0;
            }
            y += 8.0;
        }
        ends(svg, (x + 6.0, y - 4.0), (x + 110.0, y - 4.0), INK);
        svg.text((x + 36.0, y), Anchor::Start, &ink, "start");
        svg.text((x + 124.0, y), Anchor::Start, &ink, "end");
        y += 26.0;
        for cone in &self.cones {
            let style = format!("fill=\"{FORBIDDEN}\" fill-opacity=\"0.2\" stroke=\"{FORBIDDEN}\"");
            svg.circle((x + 14.0, y - 4.0), 8.0, &style);
            for line in broken(&cone.name, 25) {
                svg.text((x + 36.0, y), Anchor::Start, &ink, &line);
                y += 16.0;
            }
            let angle = slewkit::numerics::figures::rounded(cone.half_angle.to_degrees(), 4);
            svg.text((x + 36.0, y), Anchor::Start, &small, &format!("{}, {angle}°", cone.asks.word()));
            if !cone.when.is_empty() {
                y += 14.0;
                for line in broken(&cone.when, 28) {
                    svg.text((x + 36.0, y), Anchor::Start, &small, &line);
                    y += 14.0;
                }
                y -= 14.0;
            }
            y += 24.0;
        }
        let [about, tilt] = &self.angles;
        let remarks = [
            &format!("{about}, {tilt}: every 30°"),
            "angles from the middle are true;",
            "z up, seen from outside",
        ];
        for (row, remark) in remarks.iter().enumerate() {
            svg.text((x, BOTTOM_LINE + 15.0 * row as f64), Anchor::Start, &small, remark);
        }
    }
}

/// Vertical position of the remarks below the legend \[px\].
const BOTTOM_LINE: f64 = 430.0;

/// Draws a ring at the start of a track and a filled disc at its end.
fn ends(svg: &mut Svg, start: (f64, f64), end: (f64, f64), colour: &str) {
    svg.circle(start, 4.5, &format!("fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"2\""));
    svg.circle(end, 5.0, &format!("fill=\"{colour}\" stroke=\"#ffffff\" stroke-width=\"1\""));
}

fn sphere(tilt: f64, about: f64) -> Vector3 {
    Vector3::new(tilt.cos() * about.cos(), tilt.cos() * about.sin(), tilt.sin())
}

/// Returns directions on the circle at the angle `angle` \[rad\] from the axis `axis`.
pub fn circle(axis: &Vector3, angle: f64) -> Vec<Vector3> {
    let other = if axis.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let u = axis.cross(&other).normalize();
    let v = axis.cross(&u);
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
        angle.cos() * axis + angle.sin() * (cos * u + sin * v)
    };
    (0..AROUND).map(at).collect()
}

/// Returns meridians and parallels with a spacing of 30°.
fn graticule() -> Vec<Vec<Vector3>> {
    const PARTS: i32 = 90;
    let along = |k: i32, length: f64| length * f64::from(k) / f64::from(PARTS);
    let parallel =
        |tilt: i32| (0..=PARTS).map(|k| sphere(f64::from(30 * tilt).to_radians(), along(k, TAU))).collect();
    let meridian = |about: i32| {
        (0..=PARTS).map(|k| sphere(along(k, PI) - FRAC_PI_2, f64::from(30 * about).to_radians())).collect()
    };
    (-2..=2).map(parallel).chain((0..12).map(meridian)).collect()
}

/// Returns the parts of a line that are not near the antipode of the middle, where the projection
/// is discontinuous.
fn near(line: &[Vector3], view: &SkyView) -> Vec<Vec<Vector3>> {
    let is_near = |point: &Vector3| point.dot(&view.middle) > -0.995;
    line.split(|point| !is_near(point)).filter(|stretch| stretch.len() > 1).map(<[Vector3]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_the_middle_are_true_and_east_is_right() {
        let mark = |at: Vector3| SkyMark { name: String::new(), at };
        let mut sky = Sky {
            title: String::new(),
            subtitle: String::new(),
            cones: vec![],
            tracks: vec![],
            rings: vec![],
            whole: false,
            discs: vec![],
            marks: vec![mark(Vector3::x())],
            angles: ["longitude", "latitude"].map(String::from),
        };
        let view = SkyView { reach: PI, ..sky.view() };
        let (x, y) = view.project(&sphere(0.0, 0.3));
        assert!((x - 0.3 / PI).abs() < 1e-15 && y.abs() < 1e-15, "{x} {y}");
        let (x, y) = view.project(&sphere(1.2, 0.0));
        assert!(x.abs() < 1e-15 && (y - 1.2 / PI).abs() < 1e-15, "{x} {y}");
        // The map contains all points.
        sky.marks.push(mark(sphere(0.4, 2.5)));
        let view = sky.view();
        for mark in &sky.marks {
            let (x, y) = view.project(&mark.at);
            assert!(x.hypot(y) < 1.0);
        }
    }

    /// One track goes around the sphere and passes near the antipode of the middle. The other track
    /// remains in the hemisphere about the middle.
    #[test]
    fn a_track_is_torn_where_it_passes_behind_the_middle_and_nowhere_else() {
        let view = SkyView { middle: Vector3::x(), right: Vector3::y(), up: Vector3::z(), reach: PI };
        let around = |tilt: f64| -> Vec<Vector3> {
            (0..=72).map(|k| sphere(tilt.to_radians(), (5.0 * f64::from(k) + 2.5).to_radians())).collect()
        };
        let torn = |track: &[Vector3]| track.windows(2).filter(|pair| view.tears(&pair[0], &pair[1])).count();
        assert_eq!(torn(&around(0.5)), 1);
        // A track that passes the antipode at a distance of 40° is curved on the map but not
        // interrupted.
        assert_eq!(torn(&around(40.0)), 0);
        assert_eq!(torn(&circle(&Vector3::x(), 1.5)), 0);
    }

    #[test]
    fn the_edge_of_a_cone_is_at_its_half_angle() {
        for axis in [Vector3::z(), Vector3::new(0.6, -0.48, 0.64)] {
            for point in circle(&axis, 0.7) {
                assert!(
                    (point.dot(&axis) - 0.7_f64.cos()).abs() < 1e-14 && (point.norm() - 1.0).abs() < 1e-14
                );
            }
        }
    }
}
