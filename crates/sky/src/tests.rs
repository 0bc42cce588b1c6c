use crate::bodies;
use crate::frames::{self, EarthRotation, Theory};
use crate::{Clock, Condition, Elements, Light, Model, Orbit, Sky, Target, elevation};
use serde_json::Value;
use slewkit::{Matrix3, Vector3};

fn reference() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/sky.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> Vector3 {
    Vector3::from_fn(|row, _| number(&value[row]))
}

fn matrix(value: &Value) -> Matrix3 {
    Matrix3::from_fn(|row, column| number(&value[3 * row + column]))
}

fn clock(epoch: &Value) -> Clock {
    let text = epoch["utc"].as_str().unwrap();
    let parts: Vec<f64> = text.split(['-', 'T', ':']).map(|part| part.parse().unwrap()).collect();
    let date = [0, 1, 2].map(|part| parts[part] as i32);
    let nanoseconds = (parts[5].fract() * 1e9).round() as u32;
    Clock::of_utc(date, parts[3] as u8, parts[4] as u8, parts[5] as u8, nanoseconds).unwrap()
}

fn rotation(epoch: &Value) -> EarthRotation {
    let pole = &epoch["polar_motion_arcsec"];
    EarthRotation {
        ut1_minus_utc_s: number(&epoch["ut1_minus_utc_s"]),
        polar_motion_arcsec: [number(&pole[0]), number(&pole[1])],
    }
}

fn lines(value: &Value) -> [&str; 2] {
    [0, 1].map(|row| value[row].as_str().unwrap())
}

fn apart(a: &Vector3, b: &Vector3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Compares frames, Sun and Moon with ERFA and DE421. The tolerance for frames is 0.063″ = 3.1e-7
/// with the truncated nutation series, and the accuracy of the constants with the full theory. It
/// is 4″ for the Sun and 10″ for the Moon.
#[test]
fn frames_sun_and_moon_are_those_of_the_standards() {
    for epoch in reference()["epochs"].as_array().unwrap() {
        let (clock, rotation) = (clock(epoch), rotation(epoch));
        for (theory, within) in [(Theory::Series, 3.1e-7), (Theory::Full, 1e-9)] {
            let off = |found: Matrix3, wanted: &Value| (found - matrix(wanted)).amax();
            let earth = frames::to_earth(&clock, 0.0, &rotation, theory);
            let teme = frames::from_teme(&clock, 0.0, theory);
            let found = [off(earth, &epoch["gcrs_to_itrf"]), off(teme, &epoch["teme_to_gcrs"])];
            println!("{} {theory:?} {found:?}", epoch["utc"]);
            assert!(found.iter().all(|off| *off < within), "{} {theory:?} {found:?}", epoch["utc"]);
        }
        let sun = vector(&epoch["sun_gcrs_km"]);
        let moon = vector(&epoch["moon_gcrs_km"]);
        let arcseconds = [
            apart(&bodies::sun(&clock, 0.0), &sun),
            apart(&bodies::sun_by_vsop(&clock, 0.0).unwrap(), &sun),
            apart(&bodies::moon(&clock, 0.0), &moon),
        ]
        .map(|angle| angle / frames::ARCSECOND);
        println!(
            "{} Sun {:.2} {:.3}, Moon {:.2} arcsec",
            epoch["utc"], arcseconds[0], arcseconds[1], arcseconds[2]
        );
        assert!(arcseconds[0] < 4.0 && arcseconds[1] < 0.05 && arcseconds[2] < 10.0, "{arcseconds:?}");
        assert!((bodies::sun(&clock, 0.0).norm() / (sun.norm() * 1e3) - 1.0).abs() < 3e-5);
        assert!((bodies::moon(&clock, 0.0).norm() / (moon.norm() * 1e3) - 1.0).abs() < 1e-4);
    }
}

/// Compares satellite positions with the verification vectors of SGP4, and target directions and
/// their rates with reference values for 48 satellites.
#[test]
fn satellites_and_what_they_see_are_where_they_were_computed() {
    let reference = reference();
    let epochs = reference["epochs"].as_array().unwrap();
    for case in reference["cases"].as_array().unwrap() {
        let epoch = &epochs[case["epoch"].as_u64().unwrap() as usize];
        let (clock, rotation) = (clock(epoch), rotation(epoch));
        let wanted = vector(&case["r_gcrs_km"]) * 1e3;
        let (orbit, within) = if case["tle"].is_array() {
            let orbit = Orbit::of_two_lines(lines(&case["tle"]), clock).unwrap();
            assert!((orbit.age() / 60.0 - number(&case["minutes_since_epoch"])).abs() < 1e-6);
            (orbit, 1e-9)
        } else {
            let given = &case["elements"];
            let elements = Elements {
                semi_major_axis_m: number(&given["semi_major_axis_m"]),
                eccentricity: number(&given["eccentricity"]),
                inclination_deg: number(&given["inclination_deg"]),
                raan_deg: number(&given["raan_deg"]),
                argument_of_perigee_deg: number(&given["argument_of_perigee_deg"]),
                true_anomaly_deg: number(&given["true_anomaly_deg"]),
            };
            let before = number(&given["epoch_seconds_before"]);
            let of = |model| Orbit::of_elements(&elements, model, clock.later(-before), clock).unwrap();
            let kepler = of(Model::TwoBody).position(0.0).unwrap();
            let wanted = vector(&case["two_body_r_gcrs_km"]) * 1e3;
            assert!((kepler - wanted).norm() < 1e-3, "{}", (kepler - wanted).norm());
            // The error of the pole in the truncated series is 0.06″, which changes the effect of
            // the oblateness by some centimetres per hour.
            (of(Model::J2), 1e-8)
        };
        let full = orbit.position_by(0.0, Theory::Full).unwrap();
        let off = (full - wanted).norm() / wanted.norm();
        assert!(off < within, "{} {off:.1e}", case["orbit"]);
        let sky = Sky::new(clock, Some(orbit), rotation);
        let ground = &case["ground_target"];
        let station = Target::Ground {
            latitude_deg: number(&ground["latitude_deg"]),
            longitude_deg: number(&ground["longitude_deg"]),
            height_m: number(&ground["height_m"]),
        };
        let elevation = elevation(
            &sky,
            number(&ground["latitude_deg"]),
            number(&ground["longitude_deg"]),
            number(&ground["height_m"]),
            0.0,
        );
        assert!((elevation.unwrap() - number(&case["ground_elevation_rad"])).abs() < 2e-5);
        let told = case["eclipse"].as_str().unwrap();
        for (condition, other) in [(Condition::Sunlit, "umbra"), (Condition::Eclipsed, "sunlit")] {
            assert_eq!(condition.holds(&sky, 0.0).unwrap(), told != other, "{condition:?}: {told}");
        }
        let disc = sky.earth_disc(0.0, 10.0).unwrap().angular_radius(0.0);
        assert!((disc - number(&case["earth_angular_radius"])).abs() < 1e-6);
        let zero = Vector3::zeros();
        let targets = [
            ("sun", Target::Sun, 2e-5),
            ("moon", Target::Moon, 5e-5),
            ("nadir", Target::Nadir, 1e-6),
            ("ground", station, 2e-6),
        ];
        for (name, target, within) in targets {
            let planned = sky.direction(&target, -100.0, 200.0).unwrap().in_space(0.0, &zero);
            let wanted = vector(&case[name]);
            let off = apart(&planned.direction, &wanted);
            assert!(off < within, "{name}: {off:.1e}");
            let rate = vector(&case[format!("{name}_rate")]);
            // The tolerance allows for the error of the series for Sun and Moon, and for the
            // nutation terms that the truncated series omits.
            let rates = if name == "moon" || name == "sun" { 1e-4 } else { 2e-6 };
            let rate_off = (planned.rate - rate).norm();
            assert!(rate_off < rates * rate.norm() + 1e-11, "{name}: {rate_off:.1e} of {}", rate.norm());
            let witness = sky.seen(&target, 0.0).unwrap();
            assert!(apart(&witness, &planned.direction) < 2.0 * within);
        }
    }
}

/// The effects of light have the size that follows from the velocities. Both theories give equal
/// effects, so that the difference between their directions does not change.
#[test]
fn light_moves_what_is_seen() {
    let clock = Clock::of_utc([2026, 11, 21], 7, 0, 0, 0).unwrap();
    let (r, v) = (Vector3::new(7.0e6, 0.0, 0.0), Vector3::new(0.0, 7.5e3, 0.0));
    let orbit = Orbit::of_state(r, v, Model::TwoBody, clock, clock).unwrap();
    let geometric = Sky::new(clock, Some(orbit), EarthRotation::default());
    let apparent = geometric.clone().with_light(Light::APPARENT);
    let aberrated = geometric.clone().with_light(Light { takes_time: false, aberrates: true });
    let old = geometric.clone().with_light(Light { takes_time: true, aberrates: false });
    let station = Target::Ground { latitude_deg: 0.0, longitude_deg: 0.0, height_m: 0.0 };
    let zenith = Target::Fixed(Vector3::x());
    let zero = Vector3::zeros();
    for target in [&Target::Sun, &Target::Moon, &station, &zenith] {
        let planned = |sky: &Sky| sky.direction(target, 0.0, 60.0).unwrap().at(30.0, &zero);
        let full = |sky: &Sky| sky.seen(target, 30.0).unwrap();
        // The two theories are compared by the changes of direction that light causes.
        let [by_series, by_full] =
            [planned(&apparent) - planned(&geometric), full(&apparent) - full(&geometric)];
        let off = (by_series - by_full).norm();
        // The series theory assumes that the Sun is at rest, although it moves about the barycentre
        // with up to 16 m/s. The resulting error is 5e-8 rad for the Sun and stars.
        let within = if matches!(target, Target::Sun | Target::Fixed(_)) { 6e-8 } else { 2e-8 };
        assert!(off < within, "{target:?} {off:.1e}");
        let told = geometric.moved_by_light(target, 30.0).unwrap();
        assert!((told - by_full.norm()).abs() < within, "{target:?} {told} {}", by_full.norm());
    }
    // A star at the zenith is shifted by the transverse component of the sum of the velocities of
    // the Earth, 30 km/s, and of the satellite, 7.5 km/s.
    let shift = aberrated.seen(&zenith, 0.0).unwrap() - Vector3::x();
    let earth = bodies::earth_by_vsop(&clock, 0.0).unwrap() + v;
    let across = (earth - Vector3::x() * earth.x) / crate::light::C;
    assert!((shift - across).norm() < 2e-8, "{:e}", (shift - across).norm());
    // A station moves by ω × x while its light travels.
    let shift = old.seen(&station, 0.0).unwrap() - geometric.seen(&station, 0.0).unwrap();
    let earth = geometric.earth_axes(0.0).transpose();
    let place = earth * frames::station(0.0, 0.0, 0.0);
    let turning = earth * Vector3::z() * frames::EARTH_RATE_RAD_S;
    let to = place - r;
    let d = to.normalize();
    let moved = -turning.cross(&place) / crate::light::C;
    let wanted = moved - d * d.dot(&moved);
    assert!((shift - wanted).norm() < 1e-10, "{:e}", (shift - wanted).norm());
    // The Moon moves with 1 km/s, and its light takes 1.3 s. Directions that are not observed by
    // light do not change.
    let shift = old.seen(&Target::Moon, 0.0).unwrap() - geometric.seen(&Target::Moon, 0.0).unwrap();
    assert!((2.5e-6..4e-6).contains(&shift.norm()), "{:e}", shift.norm());
    for target in [Target::Nadir, Target::Velocity { reversed: false }] {
        assert_eq!(apparent.seen(&target, 5.0), geometric.seen(&target, 5.0));
    }
    let opposite = apparent.seen(&Target::AntiSun, 0.0).unwrap() + apparent.seen(&Target::Sun, 0.0).unwrap();
    assert!(opposite.norm() < 1e-15);
}

/// A line of sight to a point of the ellipsoid meets the ellipsoid at this point. A line that
/// misses the ellipsoid has no such point.
#[test]
fn a_line_of_sight_meets_the_ground() {
    let place = frames::station(47.0, 11.0, 6e5);
    for (latitude, longitude) in [(47.0, 11.0), (52.0, 3.0), (41.5, 20.0)] {
        let there = frames::station(latitude, longitude, 0.0);
        let met = frames::meets_ground(&place, &((there - place) * 1e-3)).unwrap();
        assert!((met - there).norm() < 1e-6, "{}", (met - there).norm());
        let [lat, lon] = frames::geodetic(&met);
        assert!((lat - latitude).abs() < 1e-9 && (lon - longitude).abs() < 1e-9, "{lat} {lon}");
    }
    assert_eq!(frames::meets_ground(&place, &place), None);
    assert_eq!(frames::meets_ground(&place, &place.cross(&Vector3::z())), None);
}

/// Checks the documented accuracy of the pole for the nutation series with seven arguments, every
/// ten days from 1990 to 2050.
#[test]
fn the_pole_of_seven_arguments_is_that_of_iau_2006_within_63_milliarcseconds() {
    let start = Clock::of_utc([1990, 1, 1], 0, 0, 0, 0).unwrap();
    let mut largest = 0.0_f64;
    for tens in 0..2190 {
        let time = 864_000.0 * f64::from(tens);
        let [series, full] = [Theory::Series, Theory::Full]
            .map(|theory| frames::intermediate(&start, time, theory).row(2).transpose());
        largest = largest.max(apart(&series, &full) / frames::ARCSECOND);
    }
    assert!(largest < 0.063, "{largest}″");
}
