//! Tests of pointing files: comparison with published samples and closed forms, and rejection of
//! every construct that is not supported.

use super::{Observation, PointingFile, Roll, Target, Timeline, read_pointing};
use crate::epoch::Epoch;
use crate::exchange::Lacking;
use crate::export::ExportError;
use crate::identity::Identity;
use slewkit::maneuver::{Problem, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::numerics::random::Stream;
use slewkit::sequence::Place;
use slewkit::{Direction, Matrix3, Vector3, lie};
use std::f64::consts::{FRAC_PI_2, PI};

/// A timeline of two observations. The first observation is from the published sample, for which
/// the attitude that OSVE computes is known.
const PTR: &str = r#"<prm><body><segment><data><timeline frame="SC">
  <block ref="OBS"><startTime>2032-12-26T10:15:31</startTime><endTime>2032-12-26T10:25:31</endTime>
    <attitude ref="inertial"><boresight ref="SC_Zaxis"/>
      <phaseAngle ref="align"><SCAxis frame="SC"><x>1</x><y>0</y><z>0</z></SCAxis>
        <inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
      <target frame="EME2000"><lon units="deg">235.671</lon><lat units="deg">-34.7104</lat></target></attitude></block>
  <block ref="SLEW"/>
  <block ref="OBS"><startTime>2032-12-26T11:15:31.250</startTime><endTime>2032-12-26T11:25:31</endTime>
    <attitude ref="inertial"><boresight frame="SC"><x>0</x><y>0.6</y><z>0.8</z></boresight>
      <phaseAngle ref="align"><SCAxis frame="SC"><x>1</x><y>0</y><z>0</z></SCAxis>
        <inertialAxis frame="EME2000"><x>0</x><y>0</y><z>1</z></inertialAxis></phaseAngle>
      <target frame="EME2000"><x>1</x><y>2</y><z>-0.5</z></target></attitude>
    <metadata><comment>Second &amp; last</comment></metadata></block>
</timeline></data></segment></body></prm>
"#;

/// A message with two blocks. The first block is from the published sample.
const PRM: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<prm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" id="CCSDS_PRM_VERS" version="1.0">
<header><CREATION_DATE>2032-01-01T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR></header>
<body><segment><metadata>
<OBJECT_NAME>JUICE</OBJECT_NAME><OBJECT_ID>2023-053A</OBJECT_ID><TIME_SYSTEM>UTC</TIME_SYSTEM>
<START_TIME>2032-12-26T10:15:31.000</START_TIME><STOP_TIME>2032-12-26T11:25:31.000</STOP_TIME>
<definition name="mine" version="1.3">
<frame baseFrame="none" name="EME2000" />
<frame baseFrame="EME2000" name="SC" />
<block name="inertial">
<startEpoch localName="blockStart" /><endEpoch localName="blockEnd" />
<attitude>
<frameDir localName="boresight" />
<baseFrameDir localName="target" />
<phaseAngle>
<frameDir frame="SC" coord="cartesian" units="">1. 0. 0.</frameDir>
<baseFrameDir frame="EME2000" coord="cartesian" units="-">0. 0. 1.</baseFrameDir>
<projAngle localName="phaseAngle" />
</phaseAngle>
<offsetAngle>
<frameDir frame="SC" coord="cartesian" units="">1. 0. 0.</frameDir>
<baseFrameDir frame="EME2000" coord="raDec" units="deg">68.97917 16.50917</baseFrameDir>
<projAngle localName="offsetAngle" />
</offsetAngle>
<angularRate localName="angularRate" />
</attitude>
</block>
</definition>
</metadata><data><timeline frame="SC">
<block ref="inertial"><blockStart>2032-12-26T10:15:31.000</blockStart><blockEnd>2032-12-26T10:25:31.000</blockEnd>
  <boresight frame="SC" coord="cartesian" units="">0. 0. 1.</boresight>
  <target frame="EME2000" coord="spherical" units="deg">235.671 -34.7104</target><phaseAngle units="deg">0.</phaseAngle></block>
<block ref="inertial" name="Second"><blockStart format="DOY">2032-361T11:15:31.</blockStart>
  <blockEnd>2032-12-26T11:25:31</blockEnd>
  <boresight frame="SC">0. 3. 4.</boresight>
  <target frame="EME2000" coord="raDec" units="rad">-0.5 0.25</target>
  <phaseAngle>30</phaseAngle><offsetAngle units="deg">0.0</offsetAngle><angularRate units="deg/s">0</angularRate></block>
</timeline></data></segment></body></prm>
"#;

/// The second block of the message on Sun pointing in annex J of the standard, without offset, rate
/// and comments.
const SUN: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<prm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
xmlns:xsd="http://www.w3.org/2001/XMLSchema" id="CCSDS_PRM_VERS" version="1.0">
<header>
<CREATION_DATE>2017-01-01T00:00:00</CREATION_DATE>
<ORIGINATOR>NAV-WG</ORIGINATOR>
</header>
<body>
<segment>
<metadata>
<TIME_SYSTEM>TDB</TIME_SYSTEM>
<OBJECT_ID>1995-065A</OBJECT_ID>
<OBJECT_NAME>SOHO</OBJECT_NAME>
<START_TIME>2016-02-10T23:00:00.000</START_TIME>
<STOP_TIME>2016-02-27T01:30:00.000</STOP_TIME>
<definition name="myDefinition" version="1.0">
<frame baseFrame="none" name="GCRF" />
<frame baseFrame="GCRF" name="BODY" />
<frame baseFrame="none" name="BODY" />
<block name="sunPointing">
<startEpoch localName="blockStart" />
<endEpoch localName="blockEnd" />
<attitude>
<frameDir localName="boresight" />
<baseFrameDir>
<origin>
<orbitFile>http://ms.esa.int/orbit/OEM_ops.xml</orbitFile>
</origin>
<target>
<orbit name="Sun">
<ephObject>SUN</ephObject>
</orbit>
</target>
</baseFrameDir>
<phaseAngle>
<frameDir frame="BODY"
coord="cartesian"
units="">0.0 1.0 0.0</frameDir>
<baseFrameDir frame="GCRF"
coord="raDec"
units="deg">68.97917 16.50917</baseFrameDir>
<projAngle localName="phaseAngle" />
</phaseAngle>
</attitude>
</block>
</definition>
</metadata>
<data>
<timeline frame="BODY">
<block ref="sunPointing">
<blockStart>2016-02-27T00:00:00.000</blockStart>
<blockEnd>2016-02-27T01:30:00.000</blockEnd>
<boresight frame="BODY"
coord="cartesian"
units="">1.0 0.0 0.0</boresight>
<phaseAngle units="deg">0.0</phaseAngle>
</block>
</timeline>
</data>
</segment>
</body>
</prm>
"#;

fn read(text: &str) -> PointingFile {
    read_pointing(text.as_bytes(), "file").unwrap_or_else(|error| panic!("{error}"))
}

fn ptr_of(file: &PointingFile) -> String {
    let mut out = Vec::new();
    file.write_ptr(&mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn prm_of(file: &PointingFile) -> String {
    let mut out = Vec::new();
    file.write_prm(&Epoch::parse("2032-01-01T00:00:00 UTC").unwrap(), "TEST", &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn direction(observation: &Observation) -> Vector3 {
    match observation.target {
        Target::Inertial(direction) => direction,
        Target::Sun => panic!("the Sun"),
    }
}

fn attitude(observation: &Observation) -> Matrix3 {
    observation.attitude(&direction(observation)).unwrap()
}

fn is_close(found: &Matrix3, wanted: &Matrix3, within: f64) {
    let off = lie::log(&(found.transpose() * wanted)).norm();
    assert!(off < within, "{off:e} rad: {found} {wanted}");
}

/// Draws a random unit vector that is uniformly distributed over the sphere.
fn random(draws: &mut Stream) -> Vector3 {
    Vector3::from_fn(|_, _| draws.normal()).normalize()
}

/// Draws an observation with random axes that define its roll.
fn random_observation(draws: &mut Stream, begin: Epoch) -> Observation {
    loop {
        let [boresight, target, body_axis, inertial_axis] = std::array::from_fn(|_| random(draws));
        let apart = |a: &Vector3, b: &Vector3| a.cross(b).norm() > 0.01;
        if apart(&boresight, &body_axis) && apart(&target, &inertial_axis) {
            return Observation {
                name: None,
                begin,
                end: begin.after(120.25),
                boresight,
                target: Target::Inertial(target),
                roll: Roll::Referred { body_axis, inertial_axis, angle: PI * (2.0 * draws.unit() - 1.0) },
            };
        }
    }
}

/// The columns of R follow from the boresight along z and the reference axis x. OSVE computes the
/// attitude of the sample with an error of 5e-8 rad.
#[test]
fn the_sample_of_a_ptr_has_the_attitude_of_its_engine() {
    let file = read(PTR);
    assert_eq!((file.reference_frame.as_str(), file.body_frame.as_str()), ("EME2000", "SC"));
    let [first, second] = &file.observations[..] else { panic!("{file:?}") };
    assert_eq!(first.begin, Epoch::parse("2032-12-26T10:15:31 UTC").unwrap());
    assert_eq!(first.lasting(), 600.0);
    assert_eq!((first.name.as_deref(), second.name.as_deref()), (None, Some("Second & last")));
    let (lon, lat) = (235.671_f64.to_radians(), (-34.7104_f64).to_radians());
    let d = Vector3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    let a = Vector3::z();
    let x = (a - a.dot(&d) * d).normalize();
    is_close(&attitude(first), &Matrix3::from_columns(&[x, d.cross(&x), d]), 1e-15);
    // The row of quaternions.csv that OSVE 2.9.0 (AGM 9.3.35) computes for this file: the
    // transposed attitude, scalar last.
    let [x, y, z, w] = [-0.413629864635967, 0.783342011852720, -0.216652449219218, 0.410301527897567_f64];
    is_close(&attitude(first), &lie::rotation_from_quaternion(&[w, -x, -y, -z]), 1e-7);
}

#[test]
fn a_prm_states_what_a_ptr_states() {
    let (ptr, prm) = (read(PTR), read(PRM));
    let of_ptr = Observation { name: None, ..ptr.observations[0].clone() };
    assert_eq!(of_ptr, prm.observations[0]);
    assert_eq!((prm.object.as_deref(), prm.object_id.as_deref()), (Some("JUICE"), Some("2023-053A")));
    assert!(prm.not_taken[0].contains("azimuth and elevation"), "{:?}", prm.not_taken);
    let second = &prm.observations[1];
    assert_eq!(second.begin, Epoch::parse("2032-12-26T11:15:31 UTC").unwrap());
    assert_eq!(second.name.as_deref(), Some("Second"));
    assert!((second.boresight - Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
    let wanted =
        Vector3::new(0.25_f64.cos() * 0.5_f64.cos(), -(0.25_f64.cos() * 0.5_f64.sin()), 0.25_f64.sin());
    assert!((direction(second) - wanted).norm() < 1e-15);
}

/// Tests the definition of the phase angle in 509.0-B-1, 4.2.1 d: the angle about the target from
/// the projected inertial axis to the projected body axis, in the plane normal to the target.
#[test]
fn attitudes_have_the_properties_that_define_them() {
    let mut draws = Stream::new(7, 0, 0);
    let begin = Epoch::parse("2032-12-26T10:15:31 UTC").unwrap();
    for case in 0..1000 {
        let observation = random_observation(&mut draws, begin);
        let Roll::Referred { body_axis, inertial_axis, angle } = observation.roll else { panic!() };
        let (r, d) = (attitude(&observation), direction(&observation));
        assert!((r.tr_mul(&r) - Matrix3::identity()).norm() < 1e-14, "{case}");
        assert!((r.determinant() - 1.0).abs() < 1e-14, "{case}");
        assert!((r * observation.boresight - d).norm() < 1e-14, "{case}");
        let projected = |vector: Vector3| (vector - vector.dot(&d) * d).normalize();
        let (from, to) = (projected(inertial_axis), projected(r * body_axis));
        let found = from.cross(&to).dot(&d).atan2(from.dot(&to));
        let off = (found - angle).sin().abs() + (1.0 - (found - angle).cos());
        assert!(off < 1e-12, "{case}: {found} {angle}");
    }
    // A quarter turn about z, from x to y.
    let quarter = Observation {
        boresight: Vector3::z(),
        target: Target::Inertial(Vector3::z()),
        roll: Roll::Referred { body_axis: Vector3::x(), inertial_axis: Vector3::x(), angle: FRAC_PI_2 },
        ..random_observation(&mut draws, begin)
    };
    assert!((attitude(&quarter) * Vector3::x() - Vector3::y()).norm() < 1e-15);
}

#[test]
fn files_read_back_what_was_written() {
    let mut draws = Stream::new(11, 0, 0);
    let begin = Epoch::parse("2032-12-26T10:15:31.125 UTC").unwrap();
    let observations: Vec<Observation> = (0..300)
        .map(|k| {
            let mut next = random_observation(&mut draws, begin.after(1000.0 * f64::from(k)));
            if let (Roll::Referred { body_axis, .. }, true) = (&mut next.roll, k % 3 == 0) {
                // Some observations have the roll axes of the previous observation and share its
                // segment.
                *body_axis = Vector3::new(0.0, 0.6, 0.8);
            }
            next.name = (k % 2 == 0).then(|| format!("<{k}> & \"co\""));
            next
        })
        .collect();
    let whole = PointingFile {
        object: Some("A & B".into()),
        object_id: Some("2026-001A".into()),
        reference_frame: "EME2000".into(),
        body_frame: "SC".into(),
        observations,
        ..PointingFile::default()
    };
    assert_eq!(read(&prm_of(&whole)), whole);
    // A PTR has no phase angle, so the inertial axis is turned instead.
    let resolved = read(&ptr_of(&whole));
    assert_eq!(resolved.observations.len(), whole.observations.len());
    for (found, wanted) in resolved.observations.iter().zip(&whole.observations) {
        assert_eq!((found.begin, found.end), (wanted.begin, wanted.end));
        assert_eq!((&found.name, found.boresight), (&wanted.name, wanted.boresight));
        assert_eq!(found.target, wanted.target);
        is_close(&attitude(found), &attitude(wanted), 1e-12);
    }
    assert_eq!(ptr_of(&resolved), ptr_of(&whole));
    // Both samples are written in both formats and read back.
    for sample in [PTR, PRM] {
        let mut file = read(sample);
        file.not_taken.clear();
        let again = read(&prm_of(&file));
        assert_eq!(again.observations, file.observations);
        let again = read(&ptr_of(&file));
        for (found, wanted) in again.observations.iter().zip(&file.observations) {
            is_close(&attitude(found), &attitude(wanted), 1e-14);
        }
    }
}

#[test]
fn the_sun_and_a_free_roll_have_their_template() {
    let mut file = read(SUN);
    assert_eq!(file.observations[0].target, Target::Sun);
    assert_eq!(file.observations[0].begin.scale().name(), "TDB");
    assert_eq!(file.orbit.as_deref(), Some("http://ms.esa.int/orbit/OEM_ops.xml"));
    assert_eq!(read(&prm_of(&file)), file);
    file.observations[0].roll = Roll::Free;
    assert_eq!(read(&prm_of(&file)), file);
    assert!(matches!(file.write_ptr(&mut Vec::new()), Err(ExportError::Lacking(Lacking::Roll))));
    let mut file = read(PTR);
    file.observations[1].roll = Roll::Free;
    let written = prm_of(&file);
    assert_eq!(written.matches("<segment>").count(), 2, "{written}");
    assert_eq!(read(&written).observations, file.observations);
    // Observations built from given attitudes have these attitudes.
    let mut draws = Stream::new(3, 0, 0);
    for _ in 0..200 {
        let wanted = lie::exp(&(PI * draws.unit() * random(&mut draws)));
        file.observations[1].boresight = random(&mut draws);
        let found = file.observations[1].in_attitude(&wanted);
        is_close(&attitude(&found), &wanted, 1e-14);
        file.observations[1] = Observation { roll: Roll::Free, ..found.clone() };
    }
}

#[test]
fn inertial_directions_turn_with_their_frame() {
    let file = read(PTR);
    let turned = file.in_frame("ICRF").unwrap();
    let bias = lie::log(&(attitude(&turned.observations[0]) * attitude(&file.observations[0]).transpose()));
    // The frame bias between the pole and equinox of J2000 and the ICRF is 23 milliarcseconds.
    assert!((bias.norm().to_degrees() * 3.6e6 - 23.1).abs() < 0.1, "{}", bias.norm());
    let back = turned.in_frame("EME2000").unwrap();
    is_close(&attitude(&back.observations[0]), &attitude(&file.observations[0]), 1e-15);
    assert_eq!(read(PTR).in_frame("LVLH"), None);
    assert!(ptr_of(&turned).contains("frame=\"EME2000\""));
}

#[test]
fn times_of_a_ptr_stay_within_the_hold() {
    let mut file = read(PTR);
    file.observations[0].begin = Epoch::parse("2032-12-26T10:15:31.1234 UTC").unwrap();
    file.observations[0].end = Epoch::parse("2032-12-26T10:20:08.9999 TAI").unwrap();
    let written = ptr_of(&file);
    assert!(written.contains("<startTime>2032-12-26T10:15:31.124</startTime>"), "{written}");
    assert!(written.contains("<endTime>2032-12-26T10:19:31.999</endTime>"), "{written}");
    // Sums of seconds in doubles keep every millisecond.
    file.observations[0].begin = Epoch::parse("2032-12-26T10:00:00 UTC").unwrap().after(0.1 + 0.2);
    assert!(ptr_of(&file).contains("<startTime>2032-12-26T10:00:00.300</startTime>"));
}

/// Every construct that is not supported is rejected, with its line.
#[test]
fn what_a_ptr_may_not_hold_is_refused() {
    for (from, to, line, told) in [
        ("<prm>", "<prm version=\"1\">", 1, "the attribute version of <prm>"),
        ("<prm>", "<prm><header/>", 1, "<header> in <prm> is not supported"),
        ("<segment>", "<segment><metadata/>", 1, "<metadata> in <segment> is not supported"),
        ("</segment>", "</segment><segment/>", 14, "<segment> occurs twice"),
        (" frame=\"SC\">\n", ">\n", 1, "<timeline> has no attribute frame"),
        ("timeline frame=\"SC\"", "timeline frame=\"MGA\"", 1, "frame=\"MGA\" of <timeline>"),
        ("ref=\"OBS\"", "ref=\"MOCM\"", 2, "blocks of the kind MOCM"),
        ("block ref=\"OBS\"", "block name=\"a\" ref=\"OBS\"", 2, "the attribute name of <block>"),
        ("block ref=\"OBS\"", "block", 2, "<block> has no attribute ref"),
        ("ref=\"inertial\"", "ref=\"track\"", 3, "ref=\"track\" of <attitude>"),
        ("ref=\"SC_Zaxis\"", "ref=\"SC_HGA\"", 3, "the boresight SC_HGA is defined nowhere"),
        ("ref=\"align\"", "ref=\"powerOptimised\"", 4, "ref=\"powerOptimised\" of <phaseAngle>"),
        ("</inertialAxis>", "</inertialAxis><angle>1</angle>", 5, "<angle> in <phaseAngle> is not supported"),
        ("target frame=\"EME2000\"", "target frame=\"J2000\"", 6, "frame=\"J2000\" of <target>"),
        ("<target frame=\"EME2000\"", "<target ref=\"Jupiter\"", 6, "the attribute ref of <target>"),
        ("<lon units=\"deg\">", "<lon>", 6, "<lon> has no attribute units"),
        ("<lat units=\"deg\">", "<lat units=\"arcMin\">", 6, "the unit arcMin"),
        ("-34.7104", "95", 6, "outside -90 to 90"),
        ("235.671", "360.001", 6, "outside -360 to 360"),
        ("<lon units=\"deg\">235.671</lon>", "", 6, "<target> has no <lon>"),
        ("235.671", "NaN", 6, "not finite"),
        ("235.671", "1e999", 6, "not finite"),
        ("235.671", "up", 6, "`up` is not a number"),
        ("235.671", "", 6, "<lon> is empty"),
        ("<y>0.6</y><z>0.8</z>", "<y>0</y><z>0</z>", 9, "a vector of length zero"),
        ("<x>0</x><y>0.6</y>", "<y>0.6</y>", 9, "<boresight> has no <x>"),
        ("<y>0.6</y>", "<y>0.6</y><y>0</y>", 9, "<y> occurs twice"),
        ("<x>1</x><y>0</y><z>0</z>", "<x>0</x><y>0</y><z>2</z>", 4, "<SCAxis> is parallel"),
        ("<x>1</x><y>0</y><z>0</z>", "<x>1e-7</x><y>0</y><z>1</z>", 4, "<SCAxis> is parallel"),
        ("2032-12-26T10:15:31", "2032-361T10:15:31", 2, "not a time of a PTR"),
        ("2032-12-26T10:15:31", "2032-12-26T10:15:31Z", 2, "not a time of a PTR"),
        ("2032-12-26T10:15:31", "2032-12-26T10:15:31.25", 2, "not a time of a PTR"),
        ("2032-12-26T10:15:31", "2032-12-26 10:15:31", 2, "not a time of a PTR"),
        ("2032-12-26T10:15:31", "2032-02-30T10:15:31", 2, "does not exist"),
        ("10:25:31", "10:15:31", 2, "ends when it begins"),
        ("10:25:31", "10:05:31", 2, "ends when it begins"),
        ("11:15:31.250", "10:20:31", 8, "begins 300 s before the block above ends"),
        ("2032-12-26T11", "2032-12-25T11", 8, "before the block above ends"),
        ("11:15:31.250", "10:25:31", 8, "begins when the block above ends"),
        (
            "<block ref=\"SLEW\"/>",
            "<block ref=\"SLEW\"/>\n<block ref=\"SLEW\"/>",
            8,
            "no observation precedes",
        ),
        ("<block ref=\"SLEW\"/>", "<block ref=\"SLEW\"><startTime/></block>", 7, "<startTime> in <block>"),
        (
            "<timeline frame=\"SC\">",
            "<timeline frame=\"SC\"><block ref=\"SLEW\"/>",
            1,
            "no observation precedes",
        ),
        ("</timeline>", "<block ref=\"SLEW\"/></timeline>", 14, "no observation follows this slew"),
        ("<block ref=\"SLEW\"/>", "now", 7, "text between the elements of <timeline>"),
        ("<prm>", "<!DOCTYPE prm><prm>", 1, "document type declarations are not supported"),
        ("</attitude>", "", 6, "is expected"),
        ("</prm>", "", 14, "is not closed"),
        ("<prm>", "<aem>", 1, "is expected"),
    ] {
        let text = match from {
            // Both the start and the end of the block are moved to the other day.
            "2032-12-26T11" => PTR.replace(from, to),
            _ => PTR.replacen(from, to, 1),
        };
        assert_ne!(text, PTR, "{from}");
        let found = read_pointing(text.as_bytes(), "plan.ptx").unwrap_err().0.remove(0);
        assert!(found.reason.contains(told), "{from} -> {to}: {}", found.reason);
        if told != "is expected" {
            assert_eq!(found.line, line, "{from} -> {to}: {found}");
        }
        assert_eq!((found.code, found.file.as_str()), ("E0154", "plan.ptx"));
    }
    let empty = PTR.split_once("<block").unwrap().0.to_string() + "</timeline></data></segment></body></prm>";
    for (text, told) in [
        (empty.as_str(), "the timeline has no observation"),
        ("<aem/>", "the file is <aem>"),
        ("", "not valid XML"),
        ("<prm/>", "<prm> has no <body>"),
        ("time_s,x\n0,1\n", "not valid XML"),
    ] {
        let found = read_pointing(text.as_bytes(), "file").unwrap_err();
        assert!(found.0[0].reason.contains(told), "{text}: {found}");
    }
}

#[test]
fn what_a_prm_may_not_hold_is_refused() {
    let second = "name=\"Second\"";
    for (from, to, line, told) in [
        ("CCSDS_PRM_VERS", "CCSDS_AEM_VERS", 2, "id=\"CCSDS_AEM_VERS\""),
        ("version=\"1.0\">", "version=\"2.0\">", 2, "version=\"2.0\" of <prm>"),
        ("<ORIGINATOR>", "<X/><ORIGINATOR>", 3, "<X> in <header>"),
        ("<definition name", "<source name=\"a\"/><definition name", 7, "<source> in <metadata>"),
        ("<TIME_SYSTEM>UTC", "<TIME_SYSTEM>MET", 5, "the time system MET"),
        ("<TIME_SYSTEM>UTC</TIME_SYSTEM>", "", 4, "<metadata> has no <TIME_SYSTEM>"),
        ("</STOP_TIME>", "</STOP_TIME><END_TIME>2032-12-26T11:25:31</END_TIME>", 6, "STOP_TIME and END_TIME"),
        ("11:25:31.000</STOP", "11:20:31.000</STOP", 33, "not within START_TIME and STOP_TIME"),
        ("<frame baseFrame=\"none\" name=\"EME2000\" />", "", 9, "only two frames"),
        ("name=\"SC\" />", "name=\"SC\" /><frame baseFrame=\"SC\" name=\"MGA\" />", 9, "frame MGA"),
        (
            "<block name=\"inertial\">",
            "<dirVector name=\"a\"/><block name=\"inertial\">",
            10,
            "<dirVector> in",
        ),
        (
            "block name=\"inertial\"",
            "block name=\"limbWithPowerOptimizedYawSteering\"",
            10,
            "is not supported",
        ),
        (
            "<projAngle localName=\"phaseAngle\" />",
            "<angle localName=\"phaseAngle\" />",
            18,
            "<angle> in <phaseAngle>",
        ),
        ("localName=\"boresight\"", "frame=\"SC\"", 13, "the attribute frame of <frameDir>"),
        ("ref=\"inertial\"", "ref=\"sunPointing\"", 30, "no definition in its segment"),
        ("timeline frame=\"SC\"", "timeline frame=\"MGA\"", 29, "frame=\"MGA\""),
        ("boresight frame=\"SC\" coord", "boresight frame=\"EME2000\" coord", 31, "frame=\"EME2000\""),
        ("coord=\"spherical\"", "coord=\"polar\"", 32, "the kind polar"),
        ("coord=\"spherical\"", "type=\"spherical\"", 32, "the attribute type"),
        ("235.671 -34.7104", "235.671", 32, "1 numbers, where spherical has 2"),
        ("235.671 -34.7104", "235.671 nan", 32, "not finite"),
        ("<phaseAngle units=\"deg\">0.</phaseAngle>", "", 30, "the block has no <phaseAngle>"),
        ("<phaseAngle units=\"deg\">", "<phaseAngle units=\"as\">", 32, "the unit as"),
        (">0. 3. 4.<", ">1. 0. 0.<", 37, "parallel to the boresight"),
        ("offsetAngle units=\"deg\">0.0", "offsetAngle units=\"deg\">10.0", 37, "<offsetAngle> of 10.0"),
        ("units=\"deg/s\">0<", "units=\"deg/s\">0.1<", 37, "<angularRate> of 0.1"),
        ("<angularRate localName=\"angularRate\" />", "", 37, "<angularRate> is not in the definition"),
        ("2032-361T11:15:31.", "2032-361T10:25:30.", 33, "begins 1 s before"),
        (second, "colour=\"red\"", 33, "the attribute colour"),
        ("units=\"\">0. 0. 1.", "units=\"km\">0. 0. 1.", 31, "cartesian coordinates have no unit"),
    ] {
        let text = PRM.replacen(from, to, 1);
        assert_ne!(text, PRM, "{from}");
        let found = read_pointing(text.as_bytes(), "file").unwrap_err().0.remove(0);
        assert!(found.reason.contains(told), "{from} -> {to}: {}", found.reason);
        assert_eq!(found.line, line, "{from} -> {to}: {found}");
    }
    for (from, to, told) in
        [("EME2000", "ITRF", "not known to be inertial"), ("<block ref", "<block xx", "the attribute xx")]
    {
        let found = read_pointing(PRM.replace(from, to).as_bytes(), "file").unwrap_err();
        assert!(found.0[0].reason.contains(told), "{found}");
    }
    let moon = SUN.replace("<ephObject>SUN", "<ephObject>MOON");
    let found = read_pointing(moon.as_bytes(), "file").unwrap_err();
    assert!(found.0[0].reason.contains("the target MOON"), "{found}");
}

#[test]
fn metadata_name_an_observation_and_are_left_out_otherwise() {
    let planning = "<planning><observations designer=\"X\"/></planning><comment>Second";
    let file = read(&PTR.replace("<comment>Second", planning));
    assert_eq!(file.observations[1].name.as_deref(), Some("Second & last"));
    assert_eq!(file.not_taken.len(), 1);
    let file = read(&PTR.replace("<comment>Second &amp; last</comment>", "<planning/>"));
    assert_eq!((file.observations[1].name.as_deref(), file.not_taken.len()), (None, 1));
    assert_eq!(read(PTR).not_taken.len(), 0);
}

/// Reading arbitrary bytes ends with an error, in bounded time and without a panic.
#[test]
fn hostile_bytes_are_refused() {
    let mut utf16 = vec![0xff, 0xfe];
    utf16.extend(PTR.encode_utf16().flat_map(u16::to_le_bytes));
    assert_eq!(read_pointing(&utf16[..], "file").unwrap_err().0[0].code, "E0003");
    assert_eq!(read_pointing(&b"<prm>\xff"[..], "file").unwrap_err().0[0].code, "E0150");
    for open in ["<prm>", "<prm><body><segment><data><timeline frame=\"SC\">", "<a b='>'>"] {
        let deep = open.repeat(200_000);
        assert!(read_pointing(deep.as_bytes(), "file").is_err());
    }
    let deep = format!("<prm>{}{}</prm>", "<body>".repeat(200_000), "</body>".repeat(200_000));
    let found = read_pointing(deep.as_bytes(), "file").unwrap_err();
    assert!(found.0[0].reason.contains("<body> in <body>"), "{found}");
    let laughs = format!("<!DOCTYPE prm [<!ENTITY a \"aaaa\">]>{}", PTR.replace("SC_Zaxis", "&a;"));
    assert!(read_pointing(laughs.as_bytes(), "file").unwrap_err().0[0].reason.contains("document type"));
    let mut draws = Stream::new(5, 0, 0);
    for text in [PTR, PRM, SUN] {
        for _ in 0..400 {
            let mut bytes = text.as_bytes().to_vec();
            let at = (draws.unit() * bytes.len() as f64) as usize;
            match (draws.unit() * 3.0) as usize {
                0 => bytes[at] = (draws.unit() * 256.0) as u8,
                1 => bytes.truncate(at),
                _ => drop(bytes.drain(at..(at + 20).min(text.len()))),
            }
            if let Ok(file) = read_pointing(&bytes[..], "file") {
                assert!(file.check().is_ok());
                assert!(!file.observations.is_empty());
            }
        }
    }
}

#[test]
fn observations_that_are_none_are_not_written() {
    let sound = read(PTR);
    let refuses = |change: &dyn Fn(&mut PointingFile)| {
        let mut file = sound.clone();
        change(&mut file);
        for written in [
            file.write_ptr(&mut Vec::new()),
            file.write_prm(&sound.observations[0].begin, "TEST", &mut Vec::new()),
        ] {
            assert!(matches!(written, Err(ExportError::Lacking(Lacking::Observations))), "{written:?}");
        }
    };
    refuses(&|file| file.observations.clear());
    refuses(&|file| file.observations[0].boresight.x = f64::NAN);
    refuses(&|file| file.observations[0].target = Target::Inertial(Vector3::zeros()));
    refuses(&|file| file.observations[0].end = file.observations[0].begin);
    refuses(&|file| file.observations.swap(0, 1));
    refuses(&|file| {
        let axes = (file.observations[0].boresight, Vector3::x());
        file.observations[0].roll = Roll::Referred { body_axis: axes.0, inertial_axis: axes.1, angle: 0.0 };
    });
    refuses(&|file| {
        if let Roll::Referred { angle, .. } = &mut file.observations[0].roll {
            *angle = f64::INFINITY;
        }
    });
}

fn craft() -> Problem {
    let inertia = Inertia::new(Matrix3::from_diagonal(&Vector3::new(10.0, 12.0, 14.0))).unwrap();
    let rest = State::at_rest(Matrix3::identity());
    Problem::attitude(Body { inertia, mass: None }, rest, rest, 100.0)
}

#[test]
fn observations_become_stops() {
    let file = read(PTR);
    let identity = Identity {
        epoch: Some(Epoch::parse("2032-12-26T10:05:31 UTC").unwrap()),
        reference_frame: Some("J2000".into()),
        ..Identity::default()
    };
    let timeline = Timeline::new(&file, "file", &craft(), &identity).unwrap();
    assert_eq!((timeline.first, timeline.sequence.stops.len()), (0, 2));
    assert_eq!(timeline.available(), [600.0, 3000.25]);
    let visit = timeline.sequence.stops[1].visit;
    assert_eq!((visit.window, visit.hold, visit.pinned), ([4200.25, 4800.0], 599.75, true));
    let Place::Attitude(found) = timeline.sequence.stops[0].place else { panic!() };
    is_close(&found, &attitude(&file.observations[0]), 1e-15);
    assert_eq!(timeline.sequence.stops[1].name, "Second & last");
    assert!(timeline.open[0].contains("body frame"), "{:?}", timeline.open);

    // Attitudes in another frame are rotated into the frame of the spec.
    let icrf = Identity { reference_frame: Some("ICRF".into()), ..identity.clone() };
    let turned = Timeline::new(&file, "file", &craft(), &icrf).unwrap();
    let Place::Attitude(found) = turned.sequence.stops[0].place else { panic!() };
    is_close(&found, &attitude(&file.in_frame("ICRF").unwrap().observations[0]), 1e-15);

    // If the spec has no epoch, the first observation is the start.
    let nameless = Identity { epoch: None, ..identity.clone() };
    let timeline = Timeline::new(&file, "file", &craft(), &nameless).unwrap();
    assert_eq!((timeline.first, timeline.sequence.stops.len()), (1, 1));
    assert_eq!(timeline.available(), [3000.25]);
    is_close(&timeline.sequence.craft.start.attitude, &attitude(&file.observations[0]), 1e-15);

    let mut free = file.clone();
    free.observations[0].roll = Roll::Free;
    let timeline = Timeline::new(&free, "file", &craft(), &identity).unwrap();
    assert!(matches!(timeline.sequence.stops[0].place, Place::Aim(_)));
    let refused = |file: &PointingFile, identity: &Identity, told: &str| {
        let found = Timeline::new(file, "file", &craft(), identity).unwrap_err();
        assert!(found.0[0].reason.contains(told), "{found}");
    };
    refused(&free, &nameless, "starts in observation 1, whose roll is free");
    free.observations[0].target = Target::Sun;
    // The formula of the Astronomical Almanac gives the longitude 275.198° with respect to the
    // equinox of date, which is 0.460° from the equinox of J2000.
    let timeline = Timeline::new(&free, "file", &craft(), &identity).unwrap();
    let Place::Aim(aim) = &timeline.sequence.stops[0].place else { panic!() };
    let Direction::Fixed(sun) = aim.at else { panic!() };
    let longitude = (275.198_f64 - 0.460).to_radians();
    let obliquity = 23.4393_f64.to_radians();
    let wanted =
        Vector3::new(longitude.cos(), longitude.sin() * obliquity.cos(), longitude.sin() * obliquity.sin());
    assert!(sun.dot(&wanted) > 0.02_f64.to_radians().cos(), "{sun}");
    assert!(timeline.open.iter().any(|text| text.contains("the Sun is seen")), "{:?}", timeline.open);
    let late = Identity { epoch: Some(Epoch::parse("2032-12-26T10:15:32 UTC").unwrap()), ..identity.clone() };
    refused(&file, &late, "from the start of the maneuver to observation 1 has only -1 s");
    let mut touching = file.clone();
    touching.observations[1].begin = touching.observations[0].end;
    refused(&touching, &identity, "from observation 1 to Second & last has only 0 s");
    let other = Identity { reference_frame: Some("LVLH".into()), ..identity };
    refused(&file, &other, "EME2000");
}
