//! Specs that aim at the sky: their meaning, exact reading of written specs, and plan files that
//! are complete without other files.

use slewkit::maneuver::constraint::angle_between;
use slewkit::maneuver::{Rule, Settings};
use slewkit::{Direction, Silent, Status, Vector3, plan, verify};
use slewkit_files::epoch::Epoch;
use slewkit_files::spec::{self, Format, Loaded, SpecDocument};
use std::path::PathBuf;

fn shipped(name: &str) -> Loaded {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../problems/{name}.toml"));
    match spec::load(&path, Format::Toml, &[]).unwrap() {
        spec::Spec::Maneuver(loaded) => *loaded,
        _ => panic!("{name} is a maneuver"),
    }
}

/// The directions of the targets by the full theories, which the planner does not use.
#[test]
fn targets_are_where_the_full_theories_see_them() {
    let loaded = shipped("ground_pass");
    let heavens = loaded.heavens.as_ref().unwrap();
    let none = Vector3::zeros();
    let seen = |name: &str, time: f64| {
        let named = heavens.targets.iter().find(|named| named.name.starts_with(name)).unwrap();
        heavens.sky.seen(&named.target, time).unwrap()
    };
    let aim = loaded.problem.aim().unwrap();
    for time in [0.0, 40.0, 75.0] {
        assert!(angle_between(&aim.at.at(time, &none), &seen("ground", time)) < 2e-6);
    }
    // The start: nadir exactly, x forward, turning once a revolution.
    let start = &loaded.problem.start;
    assert!(angle_between(&(start.attitude * Vector3::z()), &seen("nadir", 0.0)) < 2e-6);
    assert!(angle_between(&(start.attitude * Vector3::x()), &seen("along", 0.0)) < 1e-4);
    let period = heavens.sky.orbit().unwrap().period().unwrap();
    assert!((start.angular_velocity.norm() * period / std::f64::consts::TAU - 1.0).abs() < 2e-3);
    let cones: Vec<_> = loaded.problem.constraints.iter().map(|constraint| &constraint.rule).collect();
    let [Rule::Pointing(sun), Rule::Pointing(earth)] = cones[..] else { panic!("two cones") };
    assert!(angle_between(&sun.directions[0].at(30.0, &none), &seen("sun", 30.0)) < 2e-5);
    assert!(matches!(earth.directions[0], Direction::Disc { .. }));
    // The Earth, seen from a height of 777 km, is 63 degrees from its middle to its limb.
    assert!((earth.directions[0].angular_radius(0.0).to_degrees() - 63.06).abs() < 0.1);
}

/// The boresight of the flown plan is on the target by the full theories, with the rate of the
/// target, and the file reads back.
#[test]
fn a_plan_to_a_station_points_at_it_and_stands_without_its_orbit() {
    let loaded = shipped("ground_pass");
    let found = plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved);
    let rows = &found.solution.trajectory;
    let attitude = slewkit::lie::rotation_from_quaternion(rows.quaternion.last().unwrap());
    let heavens = loaded.heavens.as_ref().unwrap();
    let station = &heavens.targets.iter().find(|named| named.name.starts_with("ground")).unwrap().target;
    let seen = |time: f64| heavens.sky.seen(station, time).unwrap();
    assert!(angle_between(&(attitude * Vector3::z()), &seen(75.0)) < 2e-6);
    let moved = (seen(75.5) - seen(74.5)).cross(&seen(75.0)) * -1.0;
    let rate = attitude * rows.angular_velocity.last().unwrap();
    assert!((rate - moved).norm() < 2e-6, "{rate} {moved}");

    let written = SpecDocument::new(&loaded.problem, &Settings::default()).unwrap();
    let read = written.read("plan", &[]).unwrap();
    assert_eq!(read.problem.end_condition, loaded.problem.end_condition);
    assert_eq!(read.problem.constraints, loaded.problem.constraints);
    assert_eq!(read.problem.start, loaded.problem.start);
    assert!(read.heavens.is_none());
    let again = found.solution.on_grid(&read.problem);
    assert!(verify(&again, rows, 1e-12, None).passed());
}

/// Returns the result of a spec of the sky, with files in its folder.
fn written(
    files: &[(&str, String)],
    orbit: &str,
    end: &str,
    duration: f64,
) -> Result<Loaded, spec::Diagnostics> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let text = format!(
        "format = 1\nepoch = \"{EPOCH} UTC\"\n[orbit]\n{orbit}\n[body]\ninertia_kg_m2 = [120, 100, 80]\n\
         [start]\npoint = {{ boresight_body = [0, 0, 1], at = \"nadir\" }}\n\
         second = {{ axis_body = [1, 0, 0], at = \"velocity\" }}\n\
         [end]\npoint = {{ boresight_body = [0, 0, 1], {end} }}\n[maneuver]\nduration_s = {duration}\n"
    );
    let path = folder.path().join("spec.toml");
    std::fs::write(&path, text).unwrap();
    spec::read(&path, &[])
}

const EPOCH: &str = "2024-01-01T00:00:00";
/// The orbit of these tests: semi-major axis \[m\], inclination.
const CIRCLE: (f64, f64) = (7e6, 1.2);

fn mean_motion() -> f64 {
    (3.986_004_418e14 / CIRCLE.0.powi(3)).sqrt()
}

/// Returns the closed form of a circular orbit: position at `angle` from the node, at longitude 0.
fn on_circle(angle: f64) -> Vector3 {
    let (sin, cos) = angle.sin_cos();
    Vector3::new(cos, sin * CIRCLE.1.cos(), sin * CIRCLE.1.sin()) * CIRCLE.0
}

fn forward(angle: f64) -> Vector3 {
    on_circle(angle + std::f64::consts::FRAC_PI_2).normalize()
}

/// Returns an OEM whose rows are `step` \[s\] apart, from the epoch on, with the velocities of the
/// formula.
fn oem(frame: &str, step: f64, count: usize, position: impl Fn(f64) -> Vector3) -> String {
    let epoch = Epoch::parse(&format!("{EPOCH} UTC")).unwrap();
    let moment = |row: usize| epoch.after(step * row as f64).calendar_text();
    let mut text = format!(
        "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = {EPOCH}\nORIGINATOR = TEST\nMETA_START\nOBJECT_NAME = A\n\
         OBJECT_ID = 2024-001A\nCENTER_NAME = EARTH\nREF_FRAME = {frame}\nTIME_SYSTEM = UTC\n\
         START_TIME = {}\nSTOP_TIME = {}\nMETA_STOP\n",
        moment(0),
        moment(count - 1)
    );
    for row in 0..count {
        let time = step * row as f64;
        let [x, y, z] = (position(time) / 1e3).into();
        // Differences of fourth order.
        let [far, near] = [2.0, 1.0].map(|h| position(time + h) - position(time - h));
        let [u, v, w] = ((near * 8.0 - far) / 12e3).into();
        text.push_str(&format!("{} {x:.9} {y:.9} {z:.9} {u:.12} {v:.12} {w:.12}\n", moment(row)));
    }
    text
}

/// Returns the zenith at the epoch of a maneuver of 30 s that begins `from` \[s\] after the epoch
/// of the file, and the warnings.
fn zenith(file: &str, from: f64) -> Result<(Vector3, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("orbit.oem"), file).unwrap();
    let epoch = Epoch::parse(&format!("{EPOCH} UTC")).unwrap().after(from);
    let text = format!(
        "format = 1\nepoch = \"{epoch}\"\n[orbit]\noem = \"orbit.oem\"\n[body]\ninertia_kg_m2 = [120, 100, 80]\n\
         [start]\nattitude = {{ axis = [0, 0, 1], angle_deg = 0 }}\n\
         [end]\npoint = {{ boresight_body = [0, 0, 1], at = \"zenith\" }}\n[maneuver]\nduration_s = 30\n"
    );
    let path = folder.path().join("spec.toml");
    std::fs::write(&path, text).unwrap();
    let loaded = spec::read(&path, &[]).map_err(|errors| errors.0[0].reason.clone())?;
    let sky = &loaded.heavens.as_ref().unwrap().sky;
    let seen = sky.seen(&slewkit_sky::Target::Zenith, 0.0).unwrap();
    Ok((seen, loaded.warnings.iter().map(|found| format!("{}: {}", found.code, found.reason)).collect()))
}

/// The declared polynomial interpolates between rows: Hermite's of degree 7 through four rows, and
/// through quarters of an hour, for which Lagrange's has a reported error of kilometres.
#[test]
fn an_ephemeris_message_is_followed_by_what_it_declares() {
    let n = mean_motion();
    let of = |step: f64, count: usize, how: &str| {
        oem("ICRF", step, count, |time| on_circle(n * time)).replace("META_STOP", &format!("{how}META_STOP"))
    };
    let hermite = "INTERPOLATION = HERMITE\nINTERPOLATION_DEGREE = 7\n";
    let (seen, warnings) = zenith(&of(60.0, 4, hermite), 75.0).unwrap();
    assert!(angle_between(&seen, &on_circle(n * 75.0)) < 1e-10 && warnings.is_empty(), "{warnings:?}");
    let (seen, warnings) = zenith(&of(900.0, 9, hermite), 3150.0).unwrap();
    assert!(angle_between(&seen, &on_circle(n * 3150.0)) < 2e-5 && warnings.is_empty(), "{warnings:?}");
    let (seen, warnings) = zenith(&of(900.0, 9, ""), 3150.0).unwrap();
    assert!(angle_between(&seen, &on_circle(n * 3150.0)) < 2e-5 && warnings.is_empty(), "{warnings:?}");
    let lagrange = "INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 7\n";
    // Half way between the first two of twelve rows the polynomial of degree 7 is 55 km off.
    let edge = zenith(&of(900.0, 12, lagrange), 450.0);
    assert!(edge.is_err_and(|reason| reason.contains("rows 900.0 s apart are not enough for this orbit")));
    let far = zenith(&of(3600.0, 12, ""), 16_200.0);
    assert!(far.is_err_and(|reason| reason.contains("rows 3600 s apart are not enough for this orbit")));
}

#[test]
fn rows_of_an_ephemeris_that_contradict_one_another_are_told() {
    let n = mean_motion();
    let good = oem("ICRF", 60.0, 15, |time| on_circle(n * time));
    let (_, none) = zenith(&good, 300.0).unwrap();
    assert!(none.is_empty(), "{none:?}");
    // A row that is 50 km off the position that its neighbours imply.
    let line = good.lines().nth(12 + 6).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    let wrong: f64 = words[2].parse::<f64>().unwrap() + 50.0;
    let typed = good.replace(words[2], &format!("{wrong:.9}"));
    let (_, told) = zenith(&typed, 390.0).unwrap();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].starts_with("W0077") && told[0].contains("line 19: this row contradicts its neighbours"),
        "{told:?}"
    );
    // A burn from one row to the next.
    let burn = oem("ICRF", 60.0, 15, |time| {
        on_circle(n * time) + Vector3::x() * if time > 350.0 { 20e3 } else { 0.0 }
    });
    let (_, told) = zenith(&burn, 320.0).unwrap();
    assert!(told.len() == 1 && told[0].contains("the orbit jumps by 20"), "{told:?}");
    // Metres where kilometres are meant.
    let metres = oem("ICRF", 60.0, 15, |time| on_circle(n * time) * 1e3);
    assert!(zenith(&metres, 300.0).is_err_and(|reason| reason.contains("escapes from the Earth")));
    // Velocities of another frame, or none.
    let still: String = good
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            [date, x, y, z, _, _, _] => format!("{date} {x} {y} {z} 0 0 0\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    assert!(zenith(&still, 300.0).is_err_and(|reason| reason.contains("do not fit the positions")));
}

/// Two segments may share a moment; two orbits at one time are refused.
#[test]
fn segments_of_one_time_must_be_of_one_orbit() {
    let n = mean_motion();
    let first = oem("ICRF", 60.0, 15, |time| on_circle(n * time));
    let segment = |text: &str| format!("META_START{}", text.split_once("META_START").unwrap().1);
    let same = format!("{first}{}", segment(&first));
    assert!(zenith(&same, 300.0).is_ok());
    let other = oem("ICRF", 60.0, 15, |time| on_circle(n * time + 1e-3));
    let both = format!("{first}{}", segment(&other));
    assert!(
        zenith(&both, 300.0).is_err_and(|reason| reason.contains("both cover the maneuver, 7.00 km apart"))
    );
    let useable = segment(&other).replace("META_STOP", "USEABLE_START_TIME = 2024-01-01T00:10:00\nMETA_STOP");
    assert!(zenith(&format!("{first}{useable}"), 300.0).is_ok());
}

/// Elements by an OMM equal elements by two lines with equal numbers.
#[test]
fn a_mean_elements_message_is_the_orbit_of_the_two_lines() {
    let json = "{\"OBJECT_NAME\":\"SAMPLE\",\"EPOCH\":\"2023-12-31T12:00:00.000000\",\"MEAN_MOTION\":14.9,\
        \"ECCENTRICITY\":\"0.0012\",\"INCLINATION\":97.8,\"RA_OF_ASC_NODE\":200.1,\"ARG_OF_PERICENTER\":90.2,\
        \"MEAN_ANOMALY\":270.1,\"NORAD_CAT_ID\":799999999,\"BSTAR\":0.00002}";
    let lines = "tle = [\"SAMPLE\", \"1 99991U 20001A   23365.50000000  .00000000  00000-0  20000-4 0  9990\", \
                 \"2 99991  97.8000 200.1000 0012000  90.2000 270.1000 14.90000000    15\"]";
    let files = [("orbit.json", json.to_string())];
    let of = |orbit: &str| {
        let loaded =
            written(&files, orbit, "at = \"nadir\"", 60.0).unwrap_or_else(|errors| panic!("{errors}"));
        loaded.heavens.unwrap().sky.orbit().unwrap().position(0.0).unwrap()
    };
    assert_eq!(of("omm = \"orbit.json\""), of(lines));
}

/// Requires agreement with the closed form along the path of the end, and of the start with its
/// rate: rows a minute apart, read to a micrometre.
#[test]
fn an_ephemeris_message_is_the_orbit_that_it_was_sampled_from() {
    let n = mean_motion();
    // The maneuver takes all of the file: at its ends velocities are differences to one side.
    let file = oem("ICRF", 60.0, 11, |time| on_circle(n * time));
    let loaded = written(&[("orbit.oem", file)], "oem = \"orbit.oem\"", "at = \"nadir\"", 600.0).unwrap();
    let at = &loaded.problem.aim().unwrap().at;
    let none = Vector3::zeros();
    for time in [0.0, 33.0, 290.7, 600.0] {
        let seen = at.in_space(time, &none);
        assert!(angle_between(&seen.direction, &-on_circle(n * time)) < 1e-11);
        assert!((seen.rate + forward(n * time) * n).norm() < 1e-9);
    }
    let start = &loaded.problem.start;
    assert!(angle_between(&(start.attitude * Vector3::x()), &forward(0.0)) < 1e-10);
    let turning = start.attitude * start.angular_velocity;
    let normal = on_circle(0.0).cross(&forward(0.0)).normalize();
    assert!((turning - normal * n).norm() < 1e-8, "{turning} {n}");
}

/// A stationary satellite stands above a station in ITRF; TEME is turned by the matrix of another
/// program.
#[test]
fn positions_of_ephemeris_messages_are_turned_from_their_frames() {
    let longitude = 0.7_f64;
    let stationary = Vector3::new(longitude.cos(), longitude.sin(), 0.0) * 4.2164e7;
    let file = oem("ITRF2014", 300.0, 9, |_| stationary);
    let end = format!("at = \"ground\", latitude_deg = 0, longitude_deg = {}", longitude.to_degrees());
    let loaded = written(&[("orbit.oem", file)], "oem = \"orbit.oem\"", &end, 1200.0).unwrap();
    let heavens = loaded.heavens.as_ref().unwrap();
    let aim = loaded.problem.aim().unwrap();
    for time in [0.0, 700.0, 1200.0] {
        let station = aim.at.at(time, &Vector3::zeros());
        let nadir = heavens.sky.seen(&slewkit_sky::Target::Nadir, time).unwrap();
        assert!(angle_between(&station, &nadir) < 1e-9);
    }
    let matrix = &evidence::reference("sky")["epochs"][0]["teme_to_gcrs"];
    let column = |column: usize| Vector3::from_fn(|row, _| evidence::number(&matrix[3 * row + column]));
    let n = mean_motion();
    let file = oem("TEME", 60.0, 11, |time| {
        let (sin, cos) = (n * time).sin_cos();
        Vector3::new(cos, sin, 0.0) * CIRCLE.0
    });
    let loaded = written(&[("orbit.oem", file)], "oem = \"orbit.oem\"", "at = \"velocity\"", 300.0).unwrap();
    let start = &loaded.problem.start;
    // The pole of seven arguments is within 0.063″.
    assert!(angle_between(&(start.attitude * Vector3::z()), &-column(0)) < 4e-7);
    assert!(angle_between(&(start.attitude * Vector3::x()), &column(1)) < 4e-7);
}

/// A neighbour 0.1 rad ahead is given in three equivalent ways.
#[test]
fn another_satellite_is_told_as_the_own_one_is() {
    let (n, ahead) = (mean_motion(), 0.1_f64);
    let (axis, inclination) = (CIRCLE.0, CIRCLE.1.to_degrees());
    let own = format!("semi_major_axis_m = {axis}\ninclination_deg = {inclination}\nmodel = \"two_body\"");
    let velocity = forward(ahead) * (n * axis);
    let list = |vector: Vector3| format!("[{}, {}, {}]", vector.x, vector.y, vector.z);
    let ways = [
        format!(
            "semi_major_axis_m = {axis}, inclination_deg = {inclination}, true_anomaly_deg = {}, model = \"two_body\"",
            ahead.to_degrees()
        ),
        format!(
            "position_m = {}, velocity_m_s = {}, model = \"two_body\"",
            list(on_circle(ahead)),
            list(velocity)
        ),
        "oem = \"other.oem\"".into(),
    ];
    let file = oem("GCRF", 60.0, 11, |time| on_circle(n * time + ahead));
    for way in ways {
        let end = format!("at = \"satellite\", {way}");
        let loaded = written(&[("other.oem", file.clone())], &own, &end, 400.0).unwrap();
        let at = &loaded.problem.aim().unwrap().at;
        for time in [0.0, 123.4, 400.0] {
            let wanted = on_circle(n * time + ahead) - on_circle(n * time);
            let off = angle_between(&at.at(time, &Vector3::zeros()), &wanted);
            assert!(off < 1e-10, "{way}: {off:.1e}");
        }
    }
}

/// The limb, seen from a circular orbit, is asin(R/r) from nadir, in the plane of the orbit at
/// azimuth 0, and opposite to its normal at 90.
#[test]
fn the_limb_is_where_a_line_of_sight_touches() {
    let n = mean_motion();
    let own = format!(
        "semi_major_axis_m = {}\ninclination_deg = {}\nmodel = \"two_body\"",
        CIRCLE.0,
        CIRCLE.1.to_degrees()
    );
    let height = 3e4;
    let sine = (6_378_137.0 + height) / CIRCLE.0;
    for (azimuth, side) in [(0.0, 0.0), (90.0, -1.0), (180.0, 0.0), (-90.0, 1.0)] {
        let end = format!("at = \"limb\", azimuth_deg = {azimuth}, height_m = {height}");
        let loaded = written(&[], &own, &end, 300.0).unwrap();
        let at = &loaded.problem.aim().unwrap().at;
        for time in [0.0, 77.0, 300.0] {
            let (direction, here) = (at.at(time, &Vector3::zeros()), on_circle(n * time));
            // The foot of the perpendicular from the centre of the Earth.
            let foot = here - direction * here.dot(&direction);
            assert!((foot.norm() / (sine * CIRCLE.0) - 1.0).abs() < 1e-9 && here.dot(&direction) < 0.0);
            let normal = here.cross(&forward(n * time)).normalize();
            assert!((direction.dot(&normal) - side * sine).abs() < 1e-7, "{azimuth}: {direction}");
            let along = f64::from(azimuth == 0.0) - f64::from(azimuth == 180.0);
            assert!(
                (direction.dot(&forward(n * time)) - along * sine).abs() < 1e-7,
                "{azimuth}: {direction}"
            );
        }
    }
}

/// The rate about the axis that points is read, and reads back.
#[test]
fn a_spin_about_the_axis_that_points_is_told() {
    let text = "format = 1\n[body]\ninertia_kg_m2 = [120, 100, 80]\n[start]\nattitude = { axis = [0, 0, 1], \
        angle_deg = 0 }\n\
                [end]\npoint = { boresight_body = [0, 0, 1], vector = [1, 0, 0] }\nroll_rate_deg_s = 2\n\
                [maneuver]\nduration_s = 60\n";
    let loaded = super::good(text, &[]);
    assert!((loaded.problem.aim().unwrap().roll_rate - 2_f64.to_radians()).abs() < 1e-16);
    let written = SpecDocument::new(&loaded.problem, &Settings::default()).unwrap();
    assert_eq!(written.read("plan", &[]).unwrap().problem.end_condition, loaded.problem.end_condition);
    // An angular velocity along the axis is the same spin.
    for same in ["angular_velocity_deg_s = [0, 0, 2]", "angular_velocity_rad_s = [0, 0, 0.03490658503988659]"]
    {
        let spun = super::good(&text.replace("roll_rate_deg_s = 2", same), &[]).problem;
        assert_eq!(spun.end_condition, loaded.problem.end_condition, "{same}");
        assert_eq!((spun.end, spun.steps), (loaded.problem.end, loaded.problem.steps), "{same}");
    }
    let alone = text.replace(
        "point = { boresight_body = [0, 0, 1], vector = [1, 0, 0] }",
        "attitude = { axis = [1, 0, 0], angle_deg = 9 }",
    );
    let found = super::bad(&alone, &[]);
    assert!(found.0.iter().any(|one| one.reason.contains("`roll_rate_deg_s` needs `point`")), "{found}");
}
