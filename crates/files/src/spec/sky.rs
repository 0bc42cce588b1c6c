//! Reading of `epoch` and `[orbit]`, and of named targets at which ends and cones are directed.
//!
//! When a spec is read, each target becomes a direction vector as a function of time, in GCRS axes.
//! The maneuver contains these functions, and a plan file contains their coefficients
//! (`at = "track"`), so that later commands need neither an orbit nor an ephemeris.

mod acting;
mod scenery;
mod target;

use super::orbit::{self, Around};
use super::{Section, short};
use crate::epoch::Epoch;
use crate::scenery::TargetShown;
pub(super) use acting::within;
use slewkit::maneuver::{Aim, AimRate, Roll};
use slewkit::{Direction, Vector3};
use slewkit_sky::{Condition, EarthRotation, Light, OrbitError, Sky, SkyError, Target};
use std::path::Path;
pub(super) use target::star;
use target::{axis, named, own_keys, station, track};

/// Time after the epoch until which targets are computed if the duration has no upper bound \[s\].
const HORIZON: f64 = 7_200.0;

/// Largest time after the epoch until which targets are computed \[s\]. Reading the vectors of a
/// day takes a second.
const MOST_AHEAD: f64 = 86_400.0;

/// Remedy for the error that the spec has no epoch.
const ADD_EPOCH: &str = "add epoch = \"2026-11-21T07:00:00 UTC\" at the top";

/// Time within which the next pass of the spacecraft over a ground station is searched for \[s\].
const PASSES: f64 = 86_400.0;

/// Returns the time after the epoch until which the targets of a sequence are computed \[s\].
/// `least` is the shortest possible duration of the sequence, and `open` is the end of its last
/// window, both in seconds.
pub(crate) fn ahead_of([least, open]: [f64; 2]) -> f64 {
    if least < MOST_AHEAD { (least.max(open) + HORIZON).min(MOST_AHEAD) } else { least }
}

/// A named target of a spec.
#[derive(Clone, Debug)]
pub struct Named {
    /// Item of the spec that uses the target: "end", or the name of a constraint.
    pub used_by: String,
    /// Name of the target, such as "sun".
    pub name: String,
    /// Position or direction of the target.
    pub target: Target,
}

/// Named targets of a spec, and the sky that determines their directions.
#[derive(Clone, Debug)]
pub struct Heavens {
    /// Orbit of the spacecraft and positions of celestial bodies.
    pub sky: Sky,
    /// Named targets, in the order in which they were read.
    pub targets: Vec<Named>,
}

/// Data on the sky and its targets, collected while a spec is read.
pub(crate) struct Reading {
    /// Epoch, folder and other data for reading orbits; `None` if the spec has no epoch.
    around: Option<Around>,
    /// True if the epoch is invalid. This error has been reported, so the epoch is not also
    /// reported as missing.
    epoch_is_wrong: bool,
    /// The sky; `None` if the spec has no epoch, or if an error was reported.
    sky: Option<Sky>,
    /// Time after the epoch until which targets are computed \[s\].
    ahead: f64,
    targets: Vec<Named>,
    /// Description of the target of the end for pictures; `None` if it has no name.
    goal: Option<TargetShown>,
}

impl Reading {
    /// Reads `[orbit]`. `duration` is the time until which targets are needed \[s\], if it is
    /// known. Relative paths refer to `folder`.
    pub fn new(root: &Section, epoch: Option<Epoch>, duration: Option<f64>, folder: &Path) -> Self {
        let section = root.section("orbit");
        let number = |name: &str| section.and_then(|section| section.number(name)).unwrap_or(0.0);
        let rotation = EarthRotation {
            ut1_minus_utc_s: number("ut1_minus_utc_s"),
            polar_motion_arcsec: [number("polar_motion_x_arcsec"), number("polar_motion_y_arcsec")],
        };
        let ahead = duration.unwrap_or(HORIZON);
        let epoch_is_wrong = epoch.is_none() && root.has("epoch");
        let around = epoch.map(|epoch| Around {
            epoch,
            clock: epoch.clock(),
            rotation,
            ahead: ahead.min(MOST_AHEAD),
            folder: folder.into(),
        });
        let orbit = match (section, &around) {
            (Some(_), None) if epoch_is_wrong => None,
            (Some(section), None) => {
                let reason = "[orbit] needs `epoch`: the position of a satellite depends on the date";
                section.error_here("E0075", reason, ADD_EPOCH);
                None
            }
            (Some(section), Some(around)) => orbit::orbit(section, "[orbit]", around),
            (None, _) => None,
        };
        let turns =
            root.section("environment").is_some_and(|environment| environment.has("orbital_rate_rad_s"));
        if let (Some(section), true) = (section, turns) {
            let reason = "[orbit] places the satellite in inertial space, and `orbital_rate_rad_s` in a frame \
             that turns";
            section.error_here("E0028", reason, "remove one of the two");
        }
        let light = Light {
            takes_time: root.word("light_time") == Some("one_way"),
            aberrates: root.word("aberration") == Some("satellite"),
        };
        if light != Light::default() && around.is_none() && !epoch_is_wrong {
            let key = if light.takes_time { "light_time" } else { "aberration" };
            let reason = format!("`{key}` needs `epoch`: apparent directions depend on the date");
            root.error("E0075", key, reason, format!("{ADD_EPOCH}, or remove the key"));
        }
        // An error of the orbit has already been reported.
        let sky = match &around {
            Some(around) if orbit.is_some() || section.is_none() => {
                Some(Sky::new(around.clock, orbit, rotation).with_light(light))
            }
            _ => None,
        };
        Self { around, epoch_is_wrong, sky, ahead, targets: Vec::new(), goal: None }
    }

    /// Returns the sky and the named targets, if the spec has any.
    pub fn heavens(self) -> Option<Heavens> {
        Some(Heavens { sky: self.sky.filter(|_| !self.targets.is_empty())?, targets: self.targets })
    }

    /// Reads the direction in a table; `used_by` is the name of the end or constraint that uses it.
    pub fn direction(&mut self, section: &Section, used_by: &str) -> Option<Direction> {
        if !section.has("at") {
            let star = star(section)?;
            // A direction given as a vector is used unchanged. The direction of a star, given by
            // angles, is corrected for aberration.
            return match &self.sky {
                Some(sky) if sky.light().aberrates && section.has("ra_deg") => {
                    self.known_ahead(section, "ra_deg")?;
                    let target = Target::Fixed(star);
                    let found = sky.direction(&target, 0.0, self.ahead);
                    let direction = self.told(section, "a star", found)?;
                    self.targets.push(Named { used_by: used_by.into(), name: "star".into(), target });
                    Some(direction)
                }
                _ => Some(Direction::Fixed(star)),
            };
        }
        let word = section.word("at")?;
        if let Some(given) = ["ra_deg", "dec_deg", "vector"].into_iter().find(|name| section.has(name)) {
            let reason = format!("the direction is given twice, by `at` and by `{given}`");
            return section.refuse("E0028", given, reason, "give only one of the two");
        }
        own_keys(section, word)?;
        let target = match word {
            "track" => return track(section),
            "turning" => return self.turning(section),
            "sun" => Target::Sun,
            "anti_sun" => Target::AntiSun,
            "moon" => Target::Moon,
            "nadir" | "earth" => Target::Nadir,
            "zenith" => Target::Zenith,
            "geodetic_nadir" => Target::GeodeticNadir,
            "velocity" => Target::Velocity { reversed: false },
            "anti_velocity" => Target::Velocity { reversed: true },
            "along_track" => Target::AlongTrack,
            "orbit_normal" => Target::OrbitNormal { reversed: false },
            "anti_orbit_normal" => Target::OrbitNormal { reversed: true },
            "ground" => station(section)?,
            "limb" => {
                if !section.has("azimuth_deg") {
                    let reason = "`at = \"limb\"` needs `azimuth_deg`: about nadir, from along the track";
                    return section.refuse_here("E0021", reason, "add azimuth_deg = 0");
                }
                let height_m = if section.has("height_m") { section.number("height_m")? } else { 0.0 };
                Target::Limb { azimuth_deg: section.number("azimuth_deg")?, height_m }
            }
            "satellite" => {
                let around = self.around(section, "at", || of_word(word), ADD_EPOCH)?;
                Target::Satellite(Box::new(orbit::orbit(section, "`at = \"satellite\"`", around)?))
            }
            _ if !section.has("orbit_vector") => {
                let reason = "`at = \"orbit_vector\"` needs `orbit_vector`: along the track, the orbit normal, outward";
                return section.refuse_here("E0021", reason, "add orbit_vector = [1, 0, 0]");
            }
            _ => Target::InOrbit(axis(section, "orbit_vector")?),
        };
        self.around(section, "at", || of_word(word), ADD_EPOCH)?;
        let sky = self.sky.as_ref()?;
        self.known_ahead(section, "at")?;
        let found = sky.direction(&target, 0.0, self.ahead);
        let direction = self.told(section, word, found)?;
        self.targets.push(Named { used_by: used_by.into(), name: named(word, section), target });
        Some(direction)
    }

    /// Reads a direction that is fixed in a rotating object, such as a tumbling satellite.
    fn turning(&self, section: &Section) -> Option<Direction> {
        for (key, sample) in [("turning_vector", "[0, 0, 1]"), ("turning_rate_deg_s", "[0, 0, 2]")] {
            if !section.has(key) {
                let reason = format!("`at = \"turning\"` needs `{key}`");
                return section.refuse_here("E0021", reason, format!("add {key} = {sample}"));
            }
        }
        self.known_ahead(section, "at")?;
        let vector = axis(section, "turning_vector")?;
        let rate = section.vector("turning_rate_deg_s")?.map(f64::to_radians);
        if rate == Vector3::zeros() {
            return Some(Direction::Fixed(vector));
        }
        let direction = Direction::turning(vector, rate, self.ahead);
        let remedy = "give a smaller rate, or a shorter maneuver";
        direction
            .map_err(|error| section.error("E0076", "turning_rate_deg_s", error.to_string(), remedy))
            .ok()
    }

    /// Reads the disc of the Earth, from whose limb the angle of a cone is measured.
    pub fn limb(&mut self, section: &Section, used_by: &str) -> Option<Direction> {
        self.around(section, "limb_of", || "the position of the Earth".into(), ADD_EPOCH)?;
        let sky = self.sky.as_ref()?;
        self.known_ahead(section, "limb_of")?;
        let found = sky.earth_disc(0.0, self.ahead);
        let direction = self.told(section, "the limb of the Earth", found)?;
        self.targets.push(Named { used_by: used_by.into(), name: "earth".into(), target: Target::Nadir });
        Some(direction)
    }

    /// Reports an error if the maneuver may last longer than the time for which targets are
    /// computed.
    fn known_ahead(&self, section: &Section, key: &str) -> Option<()> {
        if self.ahead <= MOST_AHEAD {
            return Some(());
        }
        let reason = format!(
            "targets are computed for {} s, and the maneuver may take {} s",
            short(MOST_AHEAD),
            short(self.ahead)
        );
        section.refuse("E0076", key, reason, "shorten the maneuver, or bound it by duration_at_most_s")
    }

    /// Returns the epoch of the spec and the data for reading orbits. If the spec has no epoch,
    /// reports that `what` depends on the date.
    fn around(
        &self,
        section: &Section,
        key: &str,
        what: impl FnOnce() -> String,
        remedy: &str,
    ) -> Option<&Around> {
        if self.around.is_none() && !self.epoch_is_wrong {
            let reason = format!("{} depends on the date, and the spec has no `epoch`", what());
            section.error("E0075", key, reason, remedy);
        }
        self.around.as_ref()
    }

    /// Returns the epoch of the spec, which converts the date under `key` to seconds. If the spec
    /// has no epoch, reports an error.
    pub fn epoch(&self, section: &Section, key: &str) -> Option<Epoch> {
        if self.around.is_none() && !self.epoch_is_wrong {
            let reason = format!("`{key}` is a date, and the spec has no `epoch` at which time begins");
            section.error("E0075", key, reason, format!("{ADD_EPOCH}, or give {key}_s in seconds"));
        }
        self.around.as_ref().map(|around| around.epoch)
    }

    fn told<T>(&self, section: &Section, what: &str, found: Result<T, SkyError>) -> Option<T> {
        let remedy = match &found {
            Ok(_) => "",
            Err(SkyError::NoOrbit) => "add [orbit] with tle, omm, oem, or the keys of a Keplerian orbit",
            Err(SkyError::BelowLimb(..)) => "give a smaller height_m",
            Err(SkyError::Orbit(OrbitError::Decays(_))) => "use newer elements, or a shorter maneuver",
            Err(_) => "check [orbit]",
        };
        let key = if section.has("at") { "at" } else { "limb_of" };
        found.map_err(|error| section.error("E0076", key, format!("\"{what}\": {error}"), remedy)).ok()
    }

    /// Reports an error for each key that requires the key `point`, if the spec lacks `point`.
    pub fn check_boundary(boundary: &Section) {
        for key in ["second", "rate", "roll_rate_deg_s"] {
            if boundary.has(key) && !boundary.has("point") {
                let reason = format!("`{key}` needs `point`, which [{}] does not have", boundary.path);
                let remedy = "add point = { boresight_body = [0, 0, 1], at = \"sun\" }, or remove the key";
                boundary.error("E0021", key, reason, remedy);
            }
        }
    }

    /// Reads a start or an end at which the body points at a target.
    pub fn aim(&mut self, boundary: &Section, duration: Option<f64>) -> Option<Aim> {
        let (point, end) = (boundary.section("point")?, &boundary.path);
        let boresight = axis(point, "boresight_body");
        let known = self.targets.len();
        let at = self.direction(point, end);
        if end == "end" && self.targets.len() > known {
            self.goal = at.as_ref().and_then(|at| self.shown(at));
        }
        if at.is_some()
            && let Some(time) = duration
        {
            self.above_the_horizon(point, time)?;
        }
        let mut aim = Aim::new(boresight?, at?);
        if let Some(second) = boundary.section("second") {
            let (axis, at) = (axis(second, "axis_body"), self.direction(second, end));
            let within = second.number("roll_within_deg").unwrap_or(0.0).to_radians();
            aim = aim.with_roll_towards(axis?, at?, within);
        }
        // A stop does not have an angular velocity in the spec.
        let is_still = boundary.knows("rate") && boundary.word("rate") == Some("zero");
        let aim = if is_still { Aim { rate: AimRate::Zero, ..aim } } else { aim };
        let spin = spin(boundary, &aim)?;
        Some(aim.spinning(spin))
    }

    /// Reports an error if a ground station is the target but is below the horizon at `time` \[s\].
    fn above_the_horizon(&self, section: &Section, time: f64) -> Option<()> {
        let Some(Named { target: Target::Ground { latitude_deg, longitude_deg, height_m }, .. }) =
            self.targets.last()
        else {
            return Some(());
        };
        if section.word("at") != Some("ground") {
            return Some(());
        }
        let sky = self.sky.as_ref()?;
        let (latitude, longitude, height) = (*latitude_deg, *longitude_deg, *height_m);
        let elevation = slewkit_sky::elevation(sky, latitude, longitude, height, time).ok()?.to_degrees();
        if elevation >= 0.0 {
            return Some(());
        }
        let above = Condition::Visible(Target::Ground {
            latitude_deg: latitude,
            longitude_deg: longitude,
            height_m: height,
        });
        let passes = above.windows(sky, time, time + PASSES);
        let next = passes.ok().and_then(|passes| passes.first().copied());
        let remedy = next.map_or_else(
            || "it is not visible within a day: check the orbit and the station".to_string(),
            |window| {
                format!(
                    "it rises {} s after the epoch and is visible for {} s",
                    short(window.from.round()),
                    short((window.to - window.from).round())
                )
            },
        );
        let reason = format!(
            "the station is {} deg below the horizon {} s after the epoch",
            short((-elevation * 1e3).round() / 1e3),
            short(time)
        );
        section.refuse("E0077", "at", reason, remedy)
    }
}

/// Returns the description of a target that is given by a word, for messages.
fn of_word(word: &str) -> String {
    format!("the position of \"{word}\"")
}

/// Largest component of an angular velocity perpendicular to the boresight, as a fraction of its
/// norm, that counts as round-off.
const ACROSS: f64 = 1e-6;

/// Reads the rate about the boresight \[rad/s\]. It is given by a separate key, or by an angular
/// velocity, which must be parallel to the boresight.
fn spin(boundary: &Section, aim: &Aim) -> Option<f64> {
    if boundary.has("roll_rate_deg_s") {
        return boundary.number("roll_rate_deg_s").map(f64::to_radians);
    }
    let Some(key) = boundary.rate_key() else { return Some(0.0) };
    let rate = boundary.rate()?;
    let spin = rate.dot(&aim.boresight);
    let second = match &aim.roll {
        Roll::Free => None,
        Roll::Towards { at, .. } => Some(at),
    };
    let moves = |at: &Direction| !matches!(at, Direction::Fixed(_));
    if aim.rate == AimRate::Matched && (moves(&aim.at) || second.is_some_and(moves)) {
        let reason = format!("`{key}` is given, but the target moves, and the body turns with it");
        let remedy = if spin == 0.0 {
            "remove the key; write rate = \"zero\" for rest".into()
        } else {
            format!("write roll_rate_deg_s = {}, the spin besides", short(spin.to_degrees()))
        };
        return boundary.refuse("E0028", key, reason, remedy);
    }
    let across = (rate - aim.boresight * spin).norm();
    if across > ACROSS * rate.norm() {
        let reason = format!(
            "`{key}` is {} deg from the axis that points, which then leaves its target",
            short(across.atan2(spin).to_degrees())
        );
        let remedy = "give a rate along boresight_body; or give an attitude in place of `point`";
        return boundary.refuse("E0028", key, reason, remedy);
    }
    Some(spin)
}
