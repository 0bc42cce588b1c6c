//! Files of other programs: the written directions and orders, reading back, and refusals.
//! `tests/exchange` has the other programs read them.

use super::{BASE, WHEELS, bad, good};
use slewkit::maneuver::Trajectory;
use slewkit::{Vector3, lie};
use slewkit_files::epoch::Epoch;
use slewkit_files::exchange::{AemVersion, Attitudes, Format, Lacking, Record, Tables, read_attitudes};
use slewkit_files::export::{ExportError, write_csv};
use slewkit_files::identity::Identity;
use slewkit_files::spec::{self, Loaded, SpecDocument};
use std::borrow::Cow;

const NAMED: &str = "names={ object = \"SAT\", spice_id = -42, reference_frame = \"ICRF\" }";
const EPOCH: &str = "epoch=\"2026-11-21T07:00:00.5 UTC\"";

fn loaded() -> Loaded {
    good(BASE, &["maneuver.steps=4", NAMED, EPOCH])
}

/// Returns the motion of a body that turns about an axis at one rate, in closed form.
fn turning(axis: Vector3, rate: f64, steps: usize, step: f64) -> Trajectory {
    let time: Vec<f64> = (0..=steps).map(|k| k as f64 * step).collect();
    let half = |t: &f64| 0.5 * rate * t;
    let quaternion = |t: &f64| {
        let v = half(t).sin() * axis;
        [half(t).cos(), v.x, v.y, v.z]
    };
    let mut trajectory = Trajectory::default();
    trajectory.quaternion = time.iter().map(quaternion).collect();
    trajectory.angular_velocity = vec![rate * axis; steps + 1];
    trajectory.input = vec![0.0; 3 * (steps + 1)];
    trajectory.input_count = 3;
    trajectory.torque = vec![Vector3::zeros(); steps + 1];
    trajectory.costates = vec![0.0; 6 * (steps + 1)];
    trajectory.time = time;
    trajectory
}

fn written(
    format: Format,
    loaded: &Loaded,
    trajectory: &Trajectory,
    tick: Option<f64>,
) -> Result<Vec<u8>, ExportError> {
    let mut bytes = Vec::new();
    let record = Record { tables: Tables { tick, margins: false }, ..record(loaded, trajectory) };
    format.write(&record, &mut bytes).map(|()| bytes)
}

fn record<'a>(loaded: &'a Loaded, trajectory: &'a Trajectory) -> Record<'a> {
    Record {
        problem: &loaded.problem,
        identity: Cow::Borrowed(&loaded.identity),
        trajectory,
        switches: vec![],
        created: Epoch::of_unix(1_700_000_000),
        tables: Tables::default(),
        notes: vec!["a note".into()],
        gains: None,
    }
}

fn text(format: Format, loaded: &Loaded, trajectory: &Trajectory) -> String {
    String::from_utf8(written(format, loaded, trajectory, None).unwrap()).unwrap()
}

fn numbers(line: &str) -> Vec<f64> {
    line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 2e-15, "{found:?} {expected:?}");
    }
}

/// A body that has turned by 30 degrees about z at 10 deg/s, in the words of every program.
#[test]
fn thirty_degrees_about_z() {
    let (loaded, path) = (loaded(), turning(Vector3::z(), 10_f64.to_radians(), 3, 1.0));
    let (sin, cos) = 15_f64.to_radians().sin_cos();
    let last = |text: &str, from_end: usize| numbers(text.lines().rev().nth(from_end).unwrap());
    let aem = text(Format::Aem(AemVersion::Two), &loaded, &path);
    assert_close(&last(&aem, 1), &[0.0, 0.0, sin, cos, 0.0, 0.0, 10.0]);
    for line in [
        "CCSDS_AEM_VERS = 2.0",
        "REF_FRAME_A = ICRF",
        "REF_FRAME_B = SC_BODY_1",
        "OBJECT_NAME = SAT",
        "START_TIME = 2026-11-21T07:00:00.500",
        "STOP_TIME = 2026-11-21T07:00:03.500",
        "CREATION_DATE = 2023-11-14T22:13:20.000",
    ] {
        assert!(aem.lines().any(|found| found == line), "{line}: {aem}");
    }
    let half = 5_f64.to_radians();
    let one = text(Format::Aem(AemVersion::One), &loaded, &path);
    assert_close(&last(&one, 1), &[0.0, 0.0, sin, cos, 0.0, 0.0, half * cos, -half * sin]);
    assert!(one.contains("ATTITUDE_DIR = A2B\n") && one.contains("QUATERNION_TYPE = LAST\n"));
    assert_close(&last(&text(Format::Stk, &loaded, &path), 1), &[3.0, 0.0, 0.0, sin, cos, 0.0, 0.0, 10.0]);
    assert!(text(Format::Stk, &loaded, &path).contains("ScenarioEpoch 21 Nov 2026 07:00:00.500\n"));
    let rate = 10_f64.to_radians();
    assert_close(
        &last(&text(Format::FortyTwo, &loaded, &path), 0),
        &[3.0, 0.0, 0.0, sin, cos, 0.0, 0.0, rate],
    );
    let sigma = 7.5_f64.to_radians().tan();
    let row = last(&text(Format::Basilisk, &loaded, &path), 0);
    assert_close(&row, &[3.0, 0.0, 0.0, sigma, 0.0, 0.0, rate, 0.0, 0.0, 0.0]);
}

/// The record structure of a C-kernel of NAIF, byte by byte where it matters.
#[test]
fn c_kernel_is_an_array_file_with_conjugate_quaternions() {
    let (loaded, path) = (loaded(), turning(Vector3::z(), 10_f64.to_radians(), 250, 0.012));
    let bytes = written(Format::Ck, &loaded, &path, None).unwrap();
    assert_eq!(bytes.len() % 1024, 0);
    let word = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let double = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert_eq!((&bytes[..8], word(8), word(12), &bytes[88..96]), (&b"DAF/CK  "[..], 2, 6, &b"LTL-IEEE"[..]));
    let summary = (word(76) as usize - 1) * 1024;
    // Next, previous, count; first and last tick; structure, frame, type, rates, first and last
    // word.
    assert_eq!([double(summary), double(summary + 8), double(summary + 16)], [0.0, 0.0, 1.0]);
    assert_eq!((double(summary + 24), double(summary + 32)), (0.0, 250.0 * 0.012 * 1e6));
    let integers: Vec<i32> = (0..6).map(|index| word(summary + 40 + 4 * index)).collect();
    assert_eq!(integers[..4], [-42_000, 1, 3, 1]);
    let (begin, end) = (integers[4] as usize, integers[5] as usize);
    // 251 rows of 7 and 1, two entries of the directory, one start, two counts.
    assert_eq!((end + 1 - begin, word(84) as usize), (251 * 8 + 2 + 1 + 2, end + 1));
    let row = |k: usize| (0..7).map(|part| double((begin - 1 + 7 * k + part) * 8)).collect::<Vec<_>>();
    let (sin, cos) = 15_f64.to_radians().sin_cos();
    assert_close(&row(250), &[cos, 0.0, 0.0, -sin, 0.0, 0.0, 10_f64.to_radians()]);
    assert_eq!((double((end - 2) * 8), double((end - 1) * 8)), (1.0, 251.0));
    assert!(bytes.windows(28).any(|part| part == b"FTPSTR:\r:\n:\r\n:\r\0:\x81:\x10\xce:ENDFTP"));
}

/// A C-kernel can be read back: attitudes, rates, and the moments of its clock.
#[test]
fn c_kernels_of_ours_are_read_back() {
    let (loaded, path) = (loaded(), turning(Vector3::new(0.6, 0.0, 0.8), 0.1, 250, 0.012));
    let bytes = written(Format::Ck, &loaded, &path, None).unwrap();
    let found = read_attitudes(&bytes[..], "plan.bc").unwrap();
    assert_eq!(found.time.len(), 251);
    for (k, time) in path.time.iter().enumerate() {
        assert!((found.time[k] - time).abs() < 1e-12);
        assert_close(&found.quaternion[k], &path.quaternion[k]);
        assert!((found.rate[k] - path.angular_velocity[k]).amax() < 1e-15);
    }
    assert!(found.epoch.unwrap().since(&loaded.identity.epoch.unwrap()).abs() < 1e-9);
    assert_eq!(found.reference_frame.as_deref(), Some("J2000"));
    // Frames have the names in the file that they have in the spec, but for the bias of ICRF.
    for (name, theirs) in [("ICRF", "J2000"), ("B1950", "B1950"), ("ECLIPJ2000", "ECLIPJ2000")] {
        let names = NAMED.replace("\"ICRF\"", &format!("\"{name}\""));
        let named = good(BASE, &["maneuver.steps=4", &names, EPOCH]);
        let bytes = written(Format::Ck, &named, &path, None).unwrap();
        let found = read_attitudes(&bytes[..], "plan.bc").unwrap();
        assert_eq!(found.reference_frame.as_deref(), Some(theirs));
    }
    // A truncated or changed file is either refused or read.
    for end in (0..bytes.len()).step_by(97) {
        let _ = read_attitudes(&bytes[..end], "cut");
    }
    for at in (0..4096).step_by(3) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x5a;
        let _ = read_attitudes(&changed[..], "changed");
    }
}

fn read(text: &str) -> Attitudes {
    read_attitudes(text.as_bytes(), "test").unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

#[test]
fn what_is_written_reads_back() {
    let loaded = loaded();
    let path = turning(Vector3::new(2.0, -1.0, 2.0) / 3.0, 0.7, 40, 0.3);
    let csv = {
        let mut bytes = Vec::new();
        write_csv(&path, &loaded.problem, &Identity::default(), false, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    };
    let formats = [Format::Aem(AemVersion::Two), Format::Aem(AemVersion::One), Format::AemXml];
    let texts = formats.map(|format| text(format, &loaded, &path));
    for text in texts.iter().chain([&csv]) {
        let found = read(text);
        assert_eq!(found.quaternion, path.quaternion, "to the last bit");
        for (k, rate) in found.rate.iter().enumerate() {
            assert!((rate - path.angular_velocity[k]).amax() < 1e-15, "{rate} {k}");
            assert!((found.time[k] - path.time[k]).abs() < 1e-12);
        }
        assert_eq!(found.rate.len(), 41);
    }
    let found = read(&texts[0]);
    assert_eq!(found.epoch, loaded.identity.epoch);
    assert_eq!(found.reference_frame.as_deref(), Some("ICRF"));
    assert_eq!(found.evenly().len(), 41);
}

/// Neighbours share a node, which a reader uses once.
#[test]
fn an_ephemeris_has_a_block_for_each_piece_between_switches() {
    let loaded = loaded();
    let path = turning(Vector3::new(2.0, -1.0, 2.0) / 3.0, 0.7, 40, 0.3);
    let date = |k: usize| loaded.identity.epoch.unwrap().after(path.time[k]).calendar_text();
    for format in [Format::Aem(AemVersion::Two), Format::Aem(AemVersion::One), Format::AemXml] {
        let mut bytes = Vec::new();
        let record = Record { switches: vec![1, 15], ..record(&loaded, &path) };
        format.write(&record, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let starts: Vec<&str> = (text.lines().filter(|line| line.contains("START_TIME")))
            .map(|line| line.trim_matches(|c: char| !c.is_ascii_digit()))
            .collect();
        assert_eq!(starts, [date(0), date(1), date(15)], "{text}");
        for (k, times) in [(0, 2), (1, 3 + 1), (15, 3 + 1), (40, 2)] {
            // A date occurs in the metadata of one block or of two, and in as many rows.
            assert_eq!(text.matches(&date(k)).count(), times, "node {k}");
        }
        let found = read(&text);
        assert_eq!((found.time.len(), found.quaternion), (41, path.quaternion.clone()));
        // Not within a block.
        let (head, rest) = text.rsplit_once(&date(20)).unwrap();
        let twice = format!("{head}{}{rest}", date(19));
        let refused = read_attitudes(twice.as_bytes(), "test").unwrap_err().to_string();
        assert!(refused.contains("or at the same time"), "{refused}");
    }
}

#[test]
fn a_block_that_begins_elsewhere_than_the_one_above_ends_is_refused() {
    let loaded = loaded();
    let one = text(Format::Aem(AemVersion::Two), &loaded, &turning(Vector3::z(), 0.1, 3, 1.0));
    let after = |first: &str, second: &str| {
        let block = second[second.find("META_START").unwrap()..].to_string();
        // The second block begins when the first ends.
        let shifted = (0..4).rev().fold(block, |block, k| {
            block.replace(&format!("07:00:0{k}.500"), &format!("07:00:0{}.500", k + 3))
        });
        format!("{first}\n{shifted}")
    };
    // It begins in the attitude at which the first began.
    let both = after(&one, &one);
    let refused = read_attitudes(both.as_bytes(), "test").unwrap_err().to_string();
    assert!(refused.contains("the block above ends at the same time in another attitude"), "{refused}");
    let row = |line: &str| line.starts_with("2026-11-21T07:00:03.500 ");
    let line = both.lines().count() - both.lines().rev().position(row).unwrap();
    assert!(refused.contains(&format!("test:{line}:1")), "{refused}");
}

/// The body turns about z at 10 deg/s, and x with it.
#[test]
fn tables_tell_margins_and_angles_where_they_are_asked_for() {
    let text = format!(
        "{BASE}\n[actuators]\ntorque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ntorque_limit_n_m = 0.5\n{}",
        r#"
        [[constraint]]
        kind = "keep_out"
        name = "tracker, off the Sun"
        boresight_body = [[1, 0, 0], [0, 0, 1]]
        direction_inertial = { vector = [0, -1, 0] }
        half_angle_deg = 20
        margin_deg = 1
        [[constraint]]
        kind = "keep_in"
        name = "antenna"
        boresight_body = [1, 0, 0]
        direction_inertial = { vector = [1, 0, 0] }
        half_angle_deg = 170
        [[constraint]]
        kind = "rate_limit"
        name = "rate"
        angular_velocity_limit_deg_s = 12
        "#
    );
    let loaded = good(&text, &["maneuver.steps=4", "names={ inputs = [\"a\", \"b\", \"c, d\"] }"]);
    let mut path = turning(Vector3::z(), 10_f64.to_radians(), 4, 1.0);
    path.input[5] = -0.125;
    let table = |margins: bool| {
        let mut bytes = Vec::new();
        write_csv(&path, &loaded.problem, &loaded.identity, margins, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    };
    let (bare, full) = (table(false), table(true));
    let head = "time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z,angular_velocity_x_rad_s,\
        angular_velocity_y_rad_s,angular_velocity_z_rad_s,torque_x_n_m,torque_y_n_m,torque_z_n_m,\
        input_a_n_m,input_b_n_m,input_c_ d_n_m,costate_attitude_x_cost_per_rad,costate_attitude_y_cost_per_rad,\
        costate_attitude_z_cost_per_rad,costate_momentum_x_cost_per_n_m_s,costate_momentum_y_cost_per_n_m_s,\
        costate_momentum_z_cost_per_n_m_s";
    assert_eq!(bare.lines().next(), Some(head));
    let more = ",margin_torque_limit_n_m,margin_tracker__off_the_Sun_deg,margin_antenna_deg,margin_rate_deg_s,\
        angle_tracker__off_the_Sun_1_1_deg,angle_tracker__off_the_Sun_2_1_deg,angle_antenna_deg";
    assert_eq!(full.lines().next(), Some(&*format!("{head}{more}")));
    for (k, (bare, full)) in bare.lines().zip(full.lines()).skip(1).enumerate() {
        let turned = 10.0 * k as f64;
        let torque = if k == 1 { 0.375 } else { 0.5 };
        // z stays at 90° from −y, and x moves away from it.
        let expected = [torque, 90.0 - 21.0, 170.0 - turned, 2.0, 90.0 + turned, 90.0, turned];
        let found = numbers(full.strip_prefix(bare).unwrap());
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected} at {k}");
        }
    }
}

/// A1 to B1, body named first or second, version 1.0 with each direction and order: one attitude.
#[test]
fn directions_and_orders_of_others_come_to_ours() {
    let (loaded, path) = (loaded(), turning(Vector3::z(), 10_f64.to_radians(), 3, 1.0));
    let ours = read(&text(Format::Aem(AemVersion::One), &loaded, &path));
    let one = text(Format::Aem(AemVersion::One), &loaded, &path);
    let conjugated = |text: &str| -> String {
        let row = |line: &str| {
            let Some((date, rest)) = line.split_once(' ').filter(|(date, _)| date.starts_with("2026")) else {
                return line.to_string();
            };
            let q = numbers(rest);
            format!(
                "{date} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
                -q[0], -q[1], -q[2], q[3], -q[4], -q[5], -q[6], q[7]
            )
        };
        text.lines().map(row).collect::<Vec<_>>().join("\n")
    };
    let close = |found: &Attitudes, what: &str| {
        for k in 0..4 {
            assert_close(&found.quaternion[k], &ours.quaternion[k]);
            assert!((found.rate[k] - ours.rate[k]).amax() < 1e-15, "{what}");
        }
    };
    close(&read(&conjugated(&one).replace("A2B", "B2A")), "B2A");
    let exchanged = one
        .replace("REF_FRAME_A = ICRF", "REF_FRAME_A = SC_BODY_1")
        .replace("REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = ICRF");
    close(&read(&conjugated(&exchanged)), "body first");
    close(&read(&exchanged.replace("A2B", "B2A")), "body first, and B2A");
    let first = |text: &str| -> String {
        let row = |line: &str| match line.split_once(' ').filter(|(date, _)| date.starts_with("2026")) {
            None => line.to_string(),
            Some((date, rest)) => {
                let q = numbers(rest);
                format!(
                    "{date} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
                    q[3], q[0], q[1], q[2], q[7], q[4], q[5], q[6]
                )
            }
        };
        text.lines().map(row).collect::<Vec<_>>().join("\n")
    };
    close(&read(&first(&one).replace("QUATERNION_TYPE = LAST", "QUATERNION_TYPE = FIRST")), "scalar first");
    // The rates are given in reference axes.
    let tumbling = turning(Vector3::new(2.0, -1.0, 2.0) / 3.0, 0.4, 3, 1.0);
    let two = text(Format::Aem(AemVersion::Two), &loaded, &tumbling)
        .replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = ICRF");
    for (k, rate) in read(&two).rate.iter().enumerate() {
        let attitude = lie::rotation_from_quaternion(&tumbling.quaternion[k]);
        assert!((rate - attitude.tr_mul(&tumbling.angular_velocity[k])).amax() < 1e-15);
    }
}

#[test]
fn epoch_and_names_come_back_with_the_spec() {
    let set = [
        "epoch=\"2016-12-31T23:59:60.25 UTC\"",
        "names={ object = \"A B\", object_id = \"2026-001A\", center = \"MARS\", reference_frame = \
            \"EME2000\", body_frame = \"SC_BODY_2\", originator = \"ME\", spice_id = -7, inputs = [\"r\", \
            \"p\", \"y\"] }",
    ];
    let loaded = good(BASE, &set);
    let document =
        SpecDocument::new(&loaded.problem, &loaded.settings).unwrap().with_identity(&loaded.identity);
    let again = spec::from_str(&document.to_string(), "again.json", spec::Format::Json, &[]).unwrap();
    assert_eq!(again.identity, loaded.identity);
    assert_eq!(loaded.identity.epoch.unwrap().to_string(), "2016-12-31T23:59:60.250 UTC");
    let wheels = good(WHEELS, &["actuators.wheel.1.name=\"north\""]).identity.inputs;
    assert_eq!(wheels[..3], ["+x".to_string(), "north".into(), "wheel 3".into()]);
    let code = |set: &str| bad(BASE, &[set]).0[0].code;
    for epoch in ["2026-11-21T07:00:00", "2026-11-21T07:00:00 UT1", "2026-02-30T07:00:00 UTC", "soon UTC"] {
        assert_eq!(code(&format!("epoch=\"{epoch}\"")), "E0130", "{epoch}");
    }
    assert_eq!(code("names.spice_id=42"), "E0131");
    assert_eq!(code("names.object=\"Ä\""), "E0131");
    assert_eq!(code("names.inputs=[\"one\"]"), "E0026");
    assert_eq!(code("names.objct=\"x\""), "E0020");
}

#[test]
fn what_is_not_said_is_asked_for() {
    let path = turning(Vector3::z(), 0.1, 3, 1.0);
    let lacking = |set: &[&str], format| match written(format, &good(BASE, set), &path, None) {
        Err(ExportError::Lacking(lacking)) => lacking,
        other => panic!("{other:?}"),
    };
    for format in
        [Format::Aem(AemVersion::Two), Format::AemXml, Format::Apm, Format::Stk, Format::Ck, Format::Sclk]
    {
        assert_eq!(lacking(&[NAMED], format), Lacking::Epoch);
    }
    for format in [Format::Ck, Format::Sclk, Format::Fk] {
        assert_eq!(lacking(&[EPOCH], format), Lacking::SpiceId);
    }
    assert_eq!(
        lacking(&[EPOCH, "names={ spice_id = -1, reference_frame = \"GCRF2\" }"], Format::Ck),
        Lacking::SpiceFrame
    );
    let orbit = [
        "environment={ kind = \"gravity_gradient\", orbital_rate_rad_s = 0.001 }",
        EPOCH,
        "start.angular_velocity_rad_s=[0,0.001,0]",
        "end.angular_velocity_rad_s=[0,0.001,0]",
    ];
    let base = BASE.replace("angular_velocity_deg_s = [0, 0, 0]\n", "");
    // CCSDS has names for the axes of the orbit frame, and STK does not.
    for (format, lacks) in
        [(Format::Aem(AemVersion::Two), Lacking::FrameName), (Format::Stk, Lacking::InertialFrame)]
    {
        match written(format, &good(&base, &orbit), &path, None) {
            Err(ExportError::Lacking(lacking)) => assert_eq!(lacking, lacks),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(
        match written(Format::Flight, &good(BASE, &[]), &path, Some(0.7)) {
            Err(ExportError::Lacking(lacking)) => lacking,
            other => panic!("{other:?}"),
        },
        Lacking::Tick
    );
}

const AEM: &str = "CCSDS_AEM_VERS = 2.0
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = ME
META_START
OBJECT_NAME = SAT
OBJECT_ID = 1
REF_FRAME_A = ICRF
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = 2026-01-01T00:00:00
STOP_TIME = 2026-01-01T00:00:20
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = SC_BODY_1
META_STOP
DATA_START
2026-01-01T00:00:00 0 0 0 1 0 0 0
2026-01-01T00:00:10 0 0 0.6 0.8 0 0 1
2026-01-01T00:00:20 0 0 1 0 0 0 0
DATA_STOP
";
const XML: &str = concat!(
    r#"<?xml version="1.0"?>
<aem id="CCSDS_AEM_VERS" version="2.0">
<header><CREATION_DATE>2026-01-01T00:00:00</CREATION_DATE><ORIGINATOR>ME</ORIGINATOR></header>
<body><segment>
<metadata>
<OBJECT_NAME>SAT</OBJECT_NAME><REF_FRAME_A>ICRF</REF_FRAME_A><REF_FRAME_B>SC_BODY_1</REF_FRAME_B>
<TIME_SYSTEM>UTC</TIME_SYSTEM>
<START_TIME>2026-01-01T00:00:00</START_TIME><STOP_TIME>2026-01-01T00:00:10</STOP_TIME>
<ATTITUDE_TYPE>QUATERNION</ATTITUDE_TYPE>
</metadata>
<data>
"#,
    "<attitudeState><quaternionState><EPOCH>2026-01-01T00:00:00</EPOCH>",
    "<quaternion><Q1>0</Q1><Q2>0</Q2><Q3>0</Q3><QC>1</QC></quaternion></quaternionState></attitudeState>\n",
    "<attitudeState><quaternionState><EPOCH>2026-01-01T00:00:10</EPOCH>",
    "<quaternion><Q1>0</Q1><Q2>0</Q2><Q3>0.6</Q3><QC>0.8</QC></quaternion></quaternionState></attitudeState>\n",
    r#"</data>
</segment></body>
</aem>
"#
);
const TABLE: &str = "# attitudes
time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z
0,1,0,0,0
1,0.8,0,0,0.6
2,0,0,0,1
";

/// The files with one mistake each: the replaced text, its replacement, the reported line, and a
/// part of the reason.
#[test]
fn wrong_files_are_told_with_their_line() {
    for good in [AEM, XML, TABLE] {
        read(good);
    }
    let aem: &[(&str, &str, usize, &str)] = &[
        ("CCSDS_AEM_VERS = 2.0", "CCSDS_AEM_VERS = 3.0", 1, "version 3.0 is not known"),
        ("CCSDS_AEM_VERS = 2.0", "CCSDS_AEM_VERS", 1, "not of the form KEY = value"),
        ("CCSDS_AEM_VERS = 2.0", "CCSDS_OEM_VERS = 2.0", 1, "an orbit ephemeris message (OEM)"),
        ("CCSDS_AEM_VERS = 2.0", "CCSDS_AEM_VERS = 1.0", 14, "no `ATTITUDE_DIR`"),
        ("ORIGINATOR = ME\n", "", 3, "no `ORIGINATOR`"),
        ("CREATION_DATE = 2026-01-01T00:00:00\n", "", 3, "no `CREATION_DATE`"),
        ("ORIGINATOR = ME", "ORIGNATOR = ME", 3, "unknown key `ORIGNATOR`"),
        ("OBJECT_NAME = SAT\n", "", 13, "no `OBJECT_NAME`"),
        ("OBJECT_NAME = SAT", "OBJECT_NAME =", 5, "has no value"),
        ("OBJECT_NAME = SAT", "OBJECT_NAME = SAT\nOBJECT_NAME = SAT", 6, "given twice"),
        ("OBJECT_NAME = SAT", "OBJECT NAME = SAT", 5, "unknown key"),
        ("REF_FRAME_A = ICRF\n", "", 13, "no `REF_FRAME_A`"),
        ("REF_FRAME_B = SC_BODY_1\n", "", 13, "no `REF_FRAME_B`"),
        ("TIME_SYSTEM = UTC", "TIME_SYSTEM = SCLK", 9, "time system SCLK"),
        ("START_TIME = 2026-01-01T00:00:00", "START_TIME = 2026-01-01", 10, "not a date with a time of day"),
        ("STOP_TIME = 2026-01-01T00:00:20", "STOP_TIME = 2025-01-01T00:00:20", 11, "before START_TIME"),
        (
            "ATTITUDE_TYPE = QUATERNION/ANGVEL",
            "ATTITUDE_TYPE = SPIN",
            16,
            "the row has 7 numbers after its date, but 4 are needed",
        ),
        ("ANGVEL_FRAME = SC_BODY_1\n", "", 13, "no `ANGVEL_FRAME`"),
        ("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = LVLH", 13, "neither of the two frames"),
        ("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = SC_BODY_1\nATTITUDE_DIR = A2B", 14, "version 1.0"),
        ("META_STOP\n", "", 14, "not of the form KEY = value"),
        ("META_STOP\nDATA_START", "META_STOP\nDATA_BEGIN", 15, "DATA_START is needed"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.8 0 0", 17, "6 numbers after its date, but 7 are needed"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.8 0 0 1 1", 17, "8 numbers"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.8 0 0 one", 17, "`one` is not a number"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.8 0 0 nan", 17, "not finite"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.8 0 0 1e999", 17, "not finite"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0.6 0.9 0 0 1", 17, "has the length 1.0816"),
        ("0 0 0.6 0.8 0 0 1", "0 0 0 0 0 0 1", 17, "has the length 0"),
        ("2026-01-01T00:00:10 0", "2026-01-01T00:00:00 0", 17, "at the same time"),
        ("2026-01-01T00:00:10 0", "2025-12-31T00:00:10 0", 17, "not between START_TIME"),
        ("2026-01-01T00:00:10 0", "2026-01-32T00:00:10 0", 17, "does not exist"),
        ("2026-01-01T00:00:10 0", "2026-01-01T00:00:60 0", 17, "does not exist"),
        ("2026-01-01T00:00:10 0", "2026-01-01 00:00:10 0", 17, "`00:00:10` is not a number"),
        ("DATA_STOP\n", "", 18, "the data do not end"),
        ("DATA_STOP\n", "DATA_STOP\nEND\n", 20, "only another META_START"),
    ];
    let xml: &[(&str, &str, usize, &str)] = &[
        ("version=\"2.0\"", "", 2, "does not state its version"),
        ("<aem id", "<oem id", 2, "an orbit ephemeris message (OEM)"),
        ("</metadata>", "</meta>", 10, "</meta> is found where </metadata>"),
        ("</aem>\n", "", 15, "an element is not closed"),
        ("</aem>", "</aem", 16, "an element is not closed"),
        ("<?xml version=\"1.0\"?>", "<!DOCTYPE x [<!ENTITY a \"b\">]>", 1, "document type"),
        ("<QC>0.8</QC>", "", 13, "no <QC>"),
        ("<QC>0.8</QC>", "<QC>0.8</QC><QC>0.8</QC>", 13, "<QC> twice"),
        ("<QC>0.8</QC>", "<QC>x</QC>", 13, "`x` is not a number"),
        ("<EPOCH>2026-01-01T00:00:10</EPOCH>", "", 13, "no <EPOCH>"),
        ("<OBJECT_NAME>SAT</OBJECT_NAME>", "<OBJECT_NAME/>", 6, "has no value"),
        ("<TIME_SYSTEM>UTC</TIME_SYSTEM>", "", 5, "no `TIME_SYSTEM`"),
    ];
    let table: &[(&str, &str, usize, &str)] = &[
        ("time_s,", "time,", 2, "no column `time_s`"),
        ("quaternion_z", "quaternion_x", 2, "occurs twice"),
        ("1,0.8,0,0,0.6", "1,0.8,0,0", 4, "4 cells, but the header has 5"),
        ("1,0.8,0,0,0.6", "1,0.8,0,0,", 4, "is not a number"),
        ("1,0.8,0,0,0.6", "-1,0.8,0,0,0.6", 4, "before the one above"),
        ("1,0.8,0,0,0.6", "1,0.8,0,0,0.7", 4, "has the length"),
        ("1,0.8,0,0,0.6", "1e308,0.8,0,0,0.6", 4, "more than 30 000 years away"),
        ("1,0.8,0,0,0.6\n2,0,0,0,1\n", "", 3, "the number of attitudes is 1, but at least two are needed"),
        ("quaternion_z", "quaternion_z,angular_velocity_x_rad_s", 2, "no column `angular_velocity_y_rad_s`"),
        ("time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z\n", "", 2, "occurs twice"),
    ];
    let (mut count, mut wrong) = (0, vec![]);
    for (good, cases) in [(AEM, aem), (XML, xml), (TABLE, table)] {
        for (from, to, line, reason) in cases {
            assert!(good.contains(from), "{from}");
            let text = good.replacen(from, to, 1);
            let errors = match read_attitudes(text.as_bytes(), "wrong.aem") {
                Ok(found) => {
                    wrong.push(format!("accepted {from} → {to}: {found:?}"));
                    continue;
                }
                Err(errors) => errors,
            };
            let error = &errors.0[0];
            if !error.reason.contains(reason) || (error.line, error.file.as_str()) != (*line, "wrong.aem") {
                wrong.push(format!("{from} → {to}: line {}: {}", error.line, error.reason));
            }
            assert!(!error.remedy.is_empty());
            count += 1;
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    for whole in ["", "   \n", "\u{feff}", "# only\n", "\0\0"] {
        assert!(read_attitudes(whole.as_bytes(), "x").is_err(), "{whole:?}");
        count += 1;
    }
    let error = read_attitudes(&b"CCSDS_AEM_VERS = 2.0\n\xff\xfe"[..], "x").unwrap_err();
    assert_eq!(error.0[0].line, 2);
    assert!(count >= 40, "{count}");
}

/// Whatever is cut off or turned over is read or refused, and never a panic.
#[test]
fn mutilated_files_never_break_the_reader() {
    for good in [AEM, XML, TABLE] {
        for end in (0..good.len()).filter(|end| good.is_char_boundary(*end)) {
            let _ = read_attitudes(&good.as_bytes()[..end], "cut");
            let mut bytes = good.as_bytes().to_vec();
            for byte in [b'<', b'=', b' ', b'\n', b'9', b'-', 0, 0xff] {
                bytes[end] = byte;
                let _ = read_attitudes(&bytes[..], "changed");
            }
        }
    }
}

#[test]
fn flight_tables_keep_the_impulse_and_sign_for_their_bytes() {
    let loaded = good(BASE, &["maneuver.steps=10"]);
    let mut path = turning(Vector3::z(), 0.2, 10, 6.0);
    for k in 0..=10 {
        path.torque[k] = Vector3::new(k as f64, 1.0, (k * k) as f64);
    }
    let held: Vector3 = (0..10).map(|k| 0.5 * (path.torque[k] + path.torque[k + 1]) * 6.0).sum();
    for tick in [None, Some(6.0), Some(1.5), Some(20.0), Some(0.75)] {
        let table = String::from_utf8(written(Format::Flight, &loaded, &path, tick).unwrap()).unwrap();
        let rows: Vec<Vec<f64>> =
            table.lines().filter(|line| line.as_bytes()[0].is_ascii_digit()).map(numbers).collect();
        let step = tick.unwrap_or(6.0);
        assert_eq!(rows.len(), (60.0 / step) as usize + 1);
        let impulse: Vector3 = rows.iter().map(|row| Vector3::new(row[9], row[10], row[11]) * step).sum();
        assert!((impulse - held).amax() < 1e-10, "{tick:?} {impulse} {held}");
        // A steady rotation is met exactly by the cubic.
        for row in &rows {
            let angle = 0.1 * row[1];
            let expected = [angle.cos(), 0.0, 0.0, angle.sin()];
            let sign = if row[2] * expected[0] + row[5] * expected[3] < 0.0 { -1.0 } else { 1.0 };
            assert!((0..4).all(|part| (sign * row[2 + part] - expected[part]).abs() < 1e-14), "{row:?}");
        }
        assert!(table.lines().last().unwrap().starts_with("# crc32 "));
    }
}
