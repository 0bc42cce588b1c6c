//! Attitudes of other programs, read and judged by their meaning: faults that users reported of
//! such files, each with its right value.
//!
//! All are of one motion, 120° about z in 60 s from rest to rest, θ = 120° (3s² − 2s³) with s =
//! t/60 s, so that its rate is 720°/60 s · s (1 − s) and largest, 3 deg/s, in the middle.

use super::{bad, good};
use slewkit::Vector3;
use slewkit_files::exchange::{FileReport, judge_file, read_attitudes};
use slewkit_files::spec::{Diagnostics, Loaded};

pub const REST: &str = r#"
format = 1
epoch = "2026-11-21T07:00:00 UTC"
[names]
object = "DEMO"
reference_frame = "ICRF"
[body]
inertia_kg_m2 = [120, 100, 80]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { axis = [0, 0, 1], angle_deg = 120 }
[maneuver]
duration_s = 60
"#;
const CONE: &str = r#"
[[constraint]]
kind = "keep_out"
name = "Sun"
boresight_body = [1, 0, 0]
direction_inertial = { ra_deg = 30, dec_deg = 0 }
half_angle_deg = 10
"#;

fn angle(time: f64) -> f64 {
    let s = time / 60.0;
    120.0 * (3.0 * s * s - 2.0 * s * s * s)
}

fn rate(time: f64) -> f64 {
    let s = time / 60.0;
    12.0 * s * (1.0 - s)
}

/// Returns the times every so many seconds.
fn times(step: usize) -> Vec<f64> {
    (0..=60 / step).map(|k| (k * step) as f64).collect()
}

fn date(time: f64) -> String {
    let whole = time.floor();
    format!(
        "2026-11-21T07:{:02}:{:02}.{:03}",
        whole as u64 / 60,
        whole as u64 % 60,
        ((time - whole) * 1e3).round() as u64
    )
}

/// Returns one row of the motion: a quaternion of so many digits, scalar last.
fn quaternion(time: f64, digits: usize) -> String {
    let (sin, cos) = (0.5 * angle(time)).to_radians().sin_cos();
    format!("{:.digits$} {:.digits$} {sin:.digits$} {cos:.digits$}", 0.0, 0.0)
}

/// Returns an AEM with these keys instead of the keys of the standard's simplest example, and these
/// rows.
fn aem(changes: &[(&str, &str)], row: impl Fn(f64) -> String, times: &[f64]) -> String {
    let mut keys: Vec<(String, String)> = [
        ("OBJECT_NAME", "DEMO"),
        ("OBJECT_ID", "UNKNOWN"),
        ("REF_FRAME_A", "ICRF"),
        ("REF_FRAME_B", "SC_BODY_1"),
        ("TIME_SYSTEM", "UTC"),
        ("START_TIME", &date(times[0])),
        ("STOP_TIME", &date(*times.last().unwrap())),
        ("ATTITUDE_TYPE", "QUATERNION"),
    ]
    .map(|(key, value)| (key.to_string(), value.to_string()))
    .into();
    let mut version = "2.0";
    for (key, value) in changes {
        match keys.iter_mut().find(|(known, _)| known == key) {
            _ if *key == "version" => version = value,
            Some((_, old)) => *old = value.to_string(),
            None => keys.push((key.to_string(), value.to_string())),
        }
    }
    let keys: Vec<String> = keys.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let rows: Vec<String> = times.iter().map(|time| format!("{} {}", date(*time), row(*time))).collect();
    format!(
        "CCSDS_AEM_VERS = {version}\nCREATION_DATE = 2026-11-20T00:00:00\nORIGINATOR = TEST\n\nMETA_START\n\
            {}\nMETA_STOP\n\n\
         DATA_START\n{}\nDATA_STOP\n",
        keys.join("\n"),
        rows.join("\n")
    )
}

fn judged_by(loaded: &Loaded, text: &str) -> Result<FileReport, Diagnostics> {
    let found = read_attitudes(text.as_bytes(), "file")?;
    judge_file(&found, "file", &loaded.problem, &loaded.identity, 0.01_f64.to_radians())
}

fn judged(text: &str) -> FileReport {
    judged_by(&good(REST, &[]), text).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

fn assert_agrees(text: &str) -> FileReport {
    let found = judged(text);
    assert!(found.passed(), "{found:?}\n{text}");
    found
}

/// Returns the failed checks and the violated limits.
fn told(found: &FileReport) -> Vec<String> {
    let checks = found.attitudes.checks.iter().filter(|check| !check.passed).map(|check| check.name.clone());
    checks.chain(found.attitudes.violations.iter().cloned()).collect()
}

fn with_rate(time: f64) -> String {
    format!("{} 0 0 {:.9}", quaternion(time, 9), rate(time))
}

const ANGVEL: [(&str, &str); 2] = [("ATTITUDE_TYPE", "QUATERNION/ANGVEL"), ("ANGVEL_FRAME", "SC_BODY_1")];

/// The body's x axis passes 30° at 15 s. At a constant rate it enters a cone of 10° about this
/// direction at 10 s and leaves it at 20 s, through its axis.
#[test]
fn a_cone_entered_between_two_rows_is_violated() {
    let loaded = good(&format!("{REST}{CONE}"), &[]);
    let at_one_rate = |time: f64| {
        let (sin, cos) = (time * 1_f64.to_radians()).sin_cos();
        format!("0 0 {sin:.12} {cos:.12}")
    };
    for times in [vec![0.0, 60.0], vec![0.0, 9.0, 21.0, 60.0]] {
        let found = judged_by(&loaded, &aem(&[], at_one_rate, &times)).unwrap();
        let told = told(&found).concat();
        for part in
            ["Sun: the boresight enters the cone by 10 deg at 15.0000 s", "between 10.0000 s and 20.0000 s"]
        {
            assert!(told.contains(part), "{told}");
        }
        // The row before that.
        assert_eq!(found.attitudes.violated_at, [times.len() / 2 - 1]);
    }
    // It stays out of a cone beyond the end.
    let beside = good(&format!("{REST}{CONE}"), &["constraint.0.direction_inertial.ra_deg=131"]);
    assert!(judged_by(&beside, &aem(&[], at_one_rate, &[0.0, 60.0])).unwrap().passed());
}

/// A mean rate of 2 deg/s between rows implies a rate of at least 2 deg/s somewhere between them.
#[test]
fn a_rate_limit_is_held_against_the_mean_rates_of_rows_without_rates() {
    let limit = |degrees: f64| {
        let text = format!(
            "{REST}[[constraint]]\nkind = \"rate_limit\"\nangular_velocity_limit_deg_s = {degrees}\n"
        );
        judged_by(&good(&text, &[]), &aem(&[], |time| quaternion(time, 12), &times(20))).unwrap()
    };
    // The body turns from 20 s to 40 s by 120° · 13/27 in 20 s.
    let mean = 120.0 * 13.0 / 27.0 / 20.0;
    assert!(told(&limit(mean - 0.001)).concat().contains("the rate is 2.88889 deg/s at 30.0000 s"));
    let found = limit(mean + 0.001);
    assert!(
        found.passed() && found.not_judged.iter().any(|text| text.contains("beyond the mean rates")),
        "{found:?}"
    );
}

#[test]
fn time_without_attitudes_between_blocks_is_told() {
    let first = aem(&[], |time| quaternion(time, 9), &(0..=20).map(f64::from).collect::<Vec<_>>());
    let second = aem(&[], |time| quaternion(time, 9), &(41..=60).map(f64::from).collect::<Vec<_>>());
    let text = format!("{first}\n{}", &second[second.find("META_START").unwrap()..]);
    assert!(told(&judged(&text)).concat().contains("no attitude is given between 20.0000 s and 41.0000 s"));
}

/// The rates are in another unit, of another sign, missing, about another axis, and too large by a
/// twentieth.
#[test]
fn rates_that_are_not_those_of_the_attitudes_are_told() {
    let file = |row: &dyn Fn(f64) -> String, step| aem(&ANGVEL, row, &times(step));
    for step in [1, 5, 10] {
        assert_agrees(&file(&with_rate, step));
        let other = |rates: &dyn Fn(f64) -> [f64; 3]| {
            let row = |time: f64| {
                let [x, y, z] = rates(time);
                format!("{} {x:.9} {y:.9} {z:.9}", quaternion(time, 9))
            };
            told(&judged(&file(&row, step)))
        };
        for rates in [
            &(|time| [0.0, 0.0, rate(time).to_radians()]) as &dyn Fn(f64) -> [f64; 3],
            &|time| [0.0, 0.0, -rate(time)],
            &|_| [0.0; 3],
            &|time| [rate(time), 0.0, 0.0],
        ] {
            let told = other(rates);
            assert!(told.iter().any(|name| name == "rates against attitudes"), "{step}: {told:?}");
        }
        // Attitudes ten seconds apart do not determine the rate that closely.
        if step < 10 {
            let told = other(&|time| [0.0, 0.0, 1.05 * rate(time)]);
            assert!(told.iter().any(|name| name == "rates against attitudes"), "{step}: {told:?}");
        }
    }
    // Two rows are too few to decide.
    let found = assert_agrees(&file(&with_rate, 60));
    assert!(
        found.not_judged.iter().any(|text| text.contains("the rows are too far apart to decide")),
        "{found:?}"
    );
}

/// About z, J = 80 kg·m²: the rates change most from 0 to 5 s, by 12 · 5/60 · 55/60 deg/s.
#[test]
fn the_torque_that_rows_need_is_told_by_rates_and_by_attitudes_and_held_against_the_limit() {
    let text = aem(&ANGVEL, with_rate, &times(5));
    let expected = 80.0 * (12.0 * (5.0 / 60.0) * (55.0 / 60.0) / 5.0_f64).to_radians();
    let found = assert_agrees(&text);
    let by_rates = found.attitudes.peak_torque_n_m.unwrap();
    assert!((by_rates - expected).abs() < 1e-8, "{by_rates} {expected}");
    // The mean rate of the first stretch is the rate at 2.5 s, so the torque is this rate over that
    // time.
    let by_attitudes = found.attitudes.peak_torque_of_attitudes_n_m.unwrap();
    let expected = 80.0 * (angle(5.0) / 5.0 / 2.5).to_radians();
    assert!((by_attitudes - expected).abs() < 1e-6, "{by_attitudes} {expected}");
    let limit = |n_m: f64| {
        let actuators =
            format!("torque_axes_body = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]\ntorque_limit_n_m = {n_m}");
        judged_by(
            &good(&format!("{REST}[actuators]\n{actuators}\ntorque_norm_limit_n_m = {n_m}"), &[]),
            &text,
        )
        .unwrap()
    };
    assert!(limit(0.257).passed());
    assert!(
        told(&limit(0.254)).concat().contains("torque: the rates need a mean torque of 0.255982 N·m"),
        "{:?}",
        limit(0.254)
    );
}

/// The keyword of a frame is one of its names; the rate about z is the same in both frames.
#[test]
fn the_frame_of_rates_may_be_named_by_its_keyword() {
    for frame in ["REF_FRAME_A", "REF_FRAME_B", "ICRF", "sc_body_1"] {
        assert_agrees(&aem(&[ANGVEL[0], ("ANGVEL_FRAME", frame)], with_rate, &times(5)));
    }
}

/// The rates in the file, about z, are the rates of B relative to A, whichever of the two is the
/// body.
#[test]
fn rates_of_the_reference_against_the_body_are_turned_round() {
    let row = |time: f64| {
        let (sin, cos) = (0.5 * angle(time)).to_radians().sin_cos();
        format!("0 0 {:.9} {cos:.9} 0 0 {:.9}", -sin, -rate(time))
    };
    let frames = [("REF_FRAME_A", "SC_BODY_1"), ("REF_FRAME_B", "ICRF"), ANGVEL[0], ("ANGVEL_FRAME", "ICRF")];
    let found = assert_agrees(&aem(&frames, row, &times(5)));
    assert!(found.attitudes.checks.iter().any(|check| check.name == "rates against attitudes"));
}

/// Every equipment of SANA's registry is the body's side.
#[test]
fn frames_of_the_spacecraft_are_known_by_name() {
    let back = |time: f64| {
        let (sin, cos) = (0.5 * angle(time)).to_radians().sin_cos();
        format!("0 0 {:.9} {cos:.9}", -sin)
    };
    for name in [
        "AST_1",
        "ACC_2",
        "CSS_1",
        "DSS",
        "GYRO_FRAME_1",
        "IMU_FRAME_1",
        "MTA_1",
        "RW_4",
        "SA_1",
        "SENSOR_3",
        "STARTRACKER_2",
        "TAM_1",
    ] {
        let found = assert_agrees(&aem(&[("REF_FRAME_A", name), ("REF_FRAME_B", "ICRF")], back, &times(5)));
        assert!(found.not_judged.iter().any(|text| text.contains(name)), "{found:?}");
        // The spec knows how its own body is called.
        let own = good(REST, &["names.body_frame=\"SC_BODY_2\""]);
        let other = aem(&[("REF_FRAME_A", name), ("REF_FRAME_B", "ICRF")], back, &times(5));
        assert_eq!(judged_by(&own, &other).unwrap_err().0[0].code, "E0152");
    }
    let old = [
        ("version", "1.0"),
        ("REF_FRAME_B", "IMU_FRAME_1"),
        ("ATTITUDE_DIR", "B2A"),
        ("QUATERNION_TYPE", "LAST"),
    ];
    assert_agrees(&aem(&old, back, &times(5)));
    let both = aem(&[("REF_FRAME_A", "SC_BODY_1"), ("REF_FRAME_B", "AST_1")], back, &times(5));
    let reason = read_attitudes(both.as_bytes(), "file").unwrap_err().0[0].reason.clone();
    assert!(reason.contains("both frames of the spacecraft"), "{reason}");
}

#[test]
fn another_frame_moment_or_time_system_is_no_agreement() {
    let of = |changes: &[(&str, &str)]| aem(changes, |time| quaternion(time, 9), &times(5));
    for frame in ["ITRF2000", "TEME", "LVLH", "MYFRAME"] {
        let errors = judged_by(&good(REST, &[]), &of(&[("REF_FRAME_A", frame)])).unwrap_err();
        assert_eq!((errors.0[0].code, errors.0[0].line), ("E0152", 8), "{frame}");
        assert!(errors.0[0].reason.contains(frame) && errors.0[0].reason.contains("ICRF"), "{errors}");
    }
    // A difference of 23 milliarcseconds is within the tolerance, and the 23° of the ecliptic are
    // not.
    for frame in ["GCRF", "EME2000", "J2000", "icrf"] {
        assert_agrees(&of(&[("REF_FRAME_A", frame)]));
    }
    assert_eq!(told(&judged(&of(&[("REF_FRAME_A", "ECLIPJ2000")]))).len(), 2);
    for (system, off) in [("TAI", 37.0), ("TT", 69.184), ("GPS", 18.0)] {
        let found = judged(&of(&[("TIME_SYSTEM", system)]));
        assert_eq!(told(&found), ["moment of the start"], "{system}");
        let check = found.attitudes.checks.iter().find(|check| !check.passed).unwrap();
        assert!((check.value - off).abs() < 1e-9, "{system} {}", check.value);
    }
    let early = of(&[]).replace("2026-11-21T", "2019-11-21T");
    assert_eq!(told(&judged(&early)), ["moment of the start"]);
    // A statement of one side alone is reported as not judged.
    let unnamed =
        REST.replace("reference_frame = \"ICRF\"\n", "").replace("epoch = \"2026-11-21T07:00:00 UTC\"\n", "");
    let found = judged_by(&good(&unnamed, &[]), &early).unwrap();
    let not_judged = found.not_judged.join("\n");
    assert!(found.passed() && not_judged.contains("ICRF") && not_judged.contains("no epoch"), "{not_judged}");
}

#[test]
fn values_and_keywords_may_be_in_lower_case() {
    let text = aem(
        &[("TIME_SYSTEM", "utc"), ("ATTITUDE_TYPE", "quaternion")],
        |time| quaternion(time, 9),
        &times(5),
    );
    assert_agrees(&text);
    let all: String = text
        .lines()
        .map(|line| match line.split_once(" = ") {
            Some((key, value)) => format!("{} = {value}\n", key.to_lowercase()),
            None if line.starts_with("20") => format!("{line}\n"),
            None => format!("{}\n", line.to_lowercase()),
        })
        .collect();
    assert_agrees(&all);
}

/// Quaternions of three to six digits: the nearest rotation is taken, with a word on it.
#[test]
fn rows_of_few_digits_are_rounded_and_not_refused() {
    for digits in [4, 5, 6] {
        let text = aem(&[], |time| quaternion(time, digits), &times(5));
        assert_agrees(&text);
        let found = read_attitudes(text.as_bytes(), "file").unwrap();
        assert_eq!(found.warnings[0].code, "W0051", "{digits}");
        assert!(found.rounding.attitude <= 2.0 * 10_f64.powi(-(digits as i32)), "{:?}", found.rounding);
    }
    let wrong = aem(&[], |time| quaternion(time, 5).replace("0.82468", "0.92468"), &times(5));
    assert!(read_attitudes(wrong.as_bytes(), "file").is_err());
}

/// θ about z is the first angle of ZYX, of 321 and of ZXZ; its derivative is the rate.
#[test]
fn euler_angles_and_spin_are_read() {
    let first = |time: f64| format!("{:.9} 0 0", angle(time));
    for sequence in ["ZYX", "321", "ZXZ", "zyx"] {
        assert_agrees(&aem(
            &[("ATTITUDE_TYPE", "EULER_ANGLE"), ("EULER_ROT_SEQ", sequence)],
            first,
            &times(5),
        ));
    }
    let last = |time: f64| format!("0 0 {:.9} 0 0 {:.9}", angle(time), rate(time));
    let derivative = [("ATTITUDE_TYPE", "EULER_ANGLE/DERIVATIVE"), ("EULER_ROT_SEQ", "XYZ")];
    assert!(assert_agrees(&aem(&derivative, last, &times(5))).attitudes.peak_torque_n_m.is_some());
    let velocity = [("ATTITUDE_TYPE", "EULER_ANGLE/ANGVEL"), ("EULER_ROT_SEQ", "XYZ"), ANGVEL[1]];
    assert_agrees(&aem(&velocity, last, &times(5)));
    let one = [("version", "1.0"), ("ATTITUDE_DIR", "A2B")];
    let old =
        [("ATTITUDE_TYPE", "EULER_ANGLE/RATE"), ("EULER_ROT_SEQ", "123"), ("RATE_FRAME", "REF_FRAME_B")];
    assert_agrees(&aem(&[&one[..], &old].concat(), last, &times(5)));
    // A body that spins about z has its axis at the pole; x is 90° on at the right ascension 0 of
    // the pole's node.
    let spin = |time: f64| format!("0 90 {:.9} {:.9}", angle(time) - 90.0, rate(time));
    let found = assert_agrees(&aem(&[("ATTITUDE_TYPE", "SPIN")], spin, &times(5)));
    assert!(found.not_judged.iter().any(|text| text.contains("SPIN")), "{found:?}");
}

/// A file with QUATERNION/RATE of version 1.0 is accepted if both readings give one rate; otherwise
/// the rates are reported as not used.
#[test]
fn rates_of_version_one_are_taken_where_their_readings_agree() {
    let one = [
        ("version", "1.0"),
        ("ATTITUDE_DIR", "A2B"),
        ("ATTITUDE_TYPE", "QUATERNION/RATE"),
        ("QUATERNION_TYPE", "LAST"),
        ("RATE_FRAME", "REF_FRAME_B"),
    ];
    let text = aem(&[&one[..], &[("EULER_ROT_SEQ", "123")]].concat(), with_rate, &times(5));
    assert!(assert_agrees(&text).attitudes.peak_torque_n_m.is_some());
    let open = assert_agrees(&aem(&one, with_rate, &times(5)));
    assert!(open.attitudes.peak_torque_n_m.is_none());
    assert!(open.not_judged.iter().any(|text| text.contains("RATE of version 1.0")), "{open:?}");
}

const XML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<aem id="CCSDS_AEM_VERS" version="2.0">
<header><CREATION_DATE>2026-11-20T00:00:00</CREATION_DATE><ORIGINATOR>T</ORIGINATOR></header>
<body><segment><metadata><OBJECT_NAME>DEMO</OBJECT_NAME><OBJECT_ID>1</OBJECT_ID><REF_FRAME_A>ICRF</REF_FRAME_A>
<REF_FRAME_B>SC_BODY_1</REF_FRAME_B><TIME_SYSTEM>UTC</TIME_SYSTEM><START_TIME>2026-11-21T07:00:00</START_TIME>
<STOP_TIME>2026-11-21T07:01:00</STOP_TIME><ATTITUDE_TYPE>QUATERNION</ATTITUDE_TYPE></metadata><data>
ROWS</data></segment></body></aem>
"#;

#[test]
fn xml_has_either_quotes_blanks_and_prefixes() {
    let rows: Vec<String> = times(5)
        .iter()
        .map(|time| {
            let q: Vec<String> = quaternion(*time, 9).split(' ').map(String::from).collect();
            format!(
                "<attitudeState><quaternionEphemeris><EPOCH>{}</EPOCH><quaternion><QC>{}</QC><Q1>{}</Q1><Q2>\
                    {}</Q2><Q3>{}</Q3></quaternion></quaternionEphemeris></attitudeState>",
                date(*time),
                q[3],
                q[0],
                q[1],
                q[2]
            )
        })
        .collect();
    let text = XML.replace("ROWS", &rows.join("\n"));
    assert_agrees(&text);
    assert_agrees(&text.replace('"', "'"));
    assert_agrees(&text.replace("version=\"2.0\"", "a = '>' version = \"2.0\""));
    let prefixed = text.replace("<aem ", "<n:aem xmlns:n=\"urn:ccsds\" ").replace("</aem>", "</n:aem>");
    assert_agrees(&prefixed);
    // Named components need no order, whatever QUATERNION_TYPE states.
    let one = text.replace("version=\"2.0\"", "version=\"1.0\"").replace(
        "<TIME_SYSTEM>",
        "<ATTITUDE_DIR>A2B</ATTITUDE_DIR><QUATERNION_TYPE>FIRST</QUATERNION_TYPE><TIME_SYSTEM>",
    );
    assert_agrees(&one);
}

/// Angles of version 1.0 are named by their place in the sequence.
#[test]
fn euler_angles_in_xml_are_read() {
    let rows: Vec<String> = times(5)
        .iter()
        .map(|time| {
            format!(
                "<attitudeState><eulerAngleRate><EPOCH>{}</EPOCH><rotationAngles><rotation1 \
                    angle=\"X_ANGLE\" units=\"deg\">0</rotation1>\
                 <rotation2 angle=\"Y_ANGLE\" units=\"deg\">0</rotation2><rotation3 angle=\"Z_ANGLE\" \
                 units=\"deg\">{:.9}</rotation3>\
                 </rotationAngles><rotationRates><rotation1 rate=\"X_RATE\">0</rotation1><rotation2 \
                 rate=\"Y_RATE\">0</rotation2>\
                 <rotation3 \
                     rate=\"Z_RATE\">{:.9}</rotation3></rotationRates></eulerAngleRate></attitudeState>",
                date(*time),
                angle(*time),
                rate(*time)
            )
        })
        .collect();
    let keys = "<ATTITUDE_DIR>A2B</ATTITUDE_DIR><EULER_ROT_SEQ>123</EULER_ROT_SEQ><RATE_FRAME>REF_FRAME_B\
        </RATE_FRAME><TIME_SYSTEM>";
    let text = XML
        .replace("ROWS", &rows.join("\n"))
        .replace("version=\"2.0\"", "version=\"1.0\"")
        .replace("<TIME_SYSTEM>", keys)
        .replace("QUATERNION<", "EULER_ANGLE/RATE<");
    assert!(assert_agrees(&text).attitudes.peak_torque_n_m.is_some());
}

/// Readers accept quoted heads, semicolons, tabs, an index column and a byte order mark, and refuse
/// a foreign encoding.
#[test]
fn tables_of_any_program_are_read_by_one_rule() {
    let table = |head: [&str; 5], sign: &str, index: bool| {
        let mut lines = vec![format!("{}{}", if index { sign } else { "" }, head.join(sign))];
        for (k, time) in times(5).iter().enumerate() {
            let q: Vec<String> = quaternion(*time, 9).split(' ').map(String::from).collect();
            let index = if index { format!("{k}{sign}") } else { String::new() };
            lines.push(format!("{index}{time}{sign}{}{sign}{}{sign}{}{sign}{}", q[3], q[0], q[1], q[2]));
        }
        lines.join("\r\n")
    };
    let plain = ["time_s", "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z"];
    let quoted = plain.map(|name| format!("\"{name}\""));
    for sign in [",", ";", "\t"] {
        assert_agrees(&table(plain, sign, false));
        assert_agrees(&table(plain, sign, true));
        assert_agrees(&table(quoted.each_ref().map(String::as_str), sign, false));
    }
    assert_agrees(&table(plain, " ", false));
    let text = table(plain, ",", false);
    assert_agrees(&format!("\u{feff}{text}"));
    let utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let error = read_attitudes(&utf16[..], "file").unwrap_err();
    assert_eq!((error.0[0].code, error.0[0].remedy.as_str()), ("E0003", "save it as UTF-8"));
    // A table that begins at another time does not state the moment.
    let late = table(plain, ",", false).replace("\n0,", "\n-0.5,");
    let found = judged_by(&good(REST, &["maneuver.duration_s=60.5"]), &late).unwrap();
    assert!(found.not_judged.iter().any(|text| text.contains("begin at -0.5 s")), "{found:?}");
}

/// A matrix is accepted with six and five digits, as `%f` prints it, and with three at least.
#[test]
fn matrices_of_a_spec_are_rounded_as_quaternions_are() {
    let of = |digits: usize| {
        let rows = [
            [-0.502_458_1, 0.222_045_9, -0.835_602_4],
            [-0.771_157_3, -0.552_117_2, 0.316_990_8],
            [-0.390_963_7, 0.803_654_9, 0.448_648_4],
        ];
        let rows = rows.map(|row| row.map(|part| format!("{part:.digits$}")).join(", "));
        format!("end.attitude.matrix=[[{}]]", rows.join("], ["))
    };
    let base = REST.replace(
        "attitude = { axis = [0, 0, 1], angle_deg = 120 }",
        "attitude = { matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }",
    );
    for digits in [6, 5, 4] {
        let warnings = good(&base, &[&of(digits)]).warnings;
        assert_eq!(warnings.iter().map(|warning| warning.code).collect::<Vec<_>>(), ["W0051"], "{digits}");
    }
    assert_eq!(bad(&base, &[&of(1)]).0[0].code, "E0055");
}

/// A plate of 1 kg, 1 m by 0.5 m, in four digits, is accepted; moments that no rounding explains
/// are reported in figures that differ.
#[test]
fn moments_of_a_plate_may_be_rounded() {
    for moments in ["[0.08333, 0.02083, 0.1042]", "[1e-4, 1e-4, 2.0000001e-4]"] {
        let loaded = good(REST, &[&format!("body.inertia_kg_m2={moments}")]);
        assert_eq!(loaded.warnings[0].code, "W0042", "{moments}");
        let [a, b, c] = <[f64; 3]>::from(*loaded.problem.body.inertia.principal());
        assert!((c - (a + b)).abs() < 1e-12 * c);
    }
    let reason = &bad(REST, &["body.inertia_kg_m2=[0.08333, 0.02083, 0.10430]"]).0[0].reason;
    assert!(reason.contains("0.1043") && reason.contains("0.10416"), "{reason}");
}

#[test]
fn epochs_may_have_a_blank_or_an_offset_of_zero() {
    let wanted = good(REST, &[]).identity.epoch;
    for epoch in [
        "2026-11-21 07:00:00 UTC",
        "2026-11-21T07:00:00+00:00",
        "2026-11-21T07:00:00UTC",
        "2026-11-21T07:00:00Z",
    ] {
        assert_eq!(good(REST, &[&format!("epoch=\"{epoch}\"")]).identity.epoch, wanted, "{epoch}");
    }
    let error = bad(REST, &["epoch=\"2026-11-21T08:00:00+01:00\""]);
    assert!(error.0[0].reason.contains("+01:00"), "{error}");
}

/// 90° about z: σ = e tan(φ/4), g = e tan(φ/2); x points to right ascension 90°.
#[test]
fn attitudes_may_be_rodrigues_parameters_or_a_pointing_with_its_roll() {
    let attitude =
        |notation: &str| good(REST, &[&format!("end.attitude={{ {notation} }}")]).problem.end.attitude;
    let wanted = attitude("axis = [0, 0, 1], angle_deg = 90");
    let quarter = 22.5_f64.to_radians().tan();
    for notation in [
        format!("mrp = [0, 0, {quarter:e}]"),
        format!("mrp = [0, 0, {:e}]", -1.0 / quarter),
        "rodrigues = [0, 0, 1]".into(),
        "ra_deg = 90, dec_deg = 0, roll_deg = 0".into(),
    ] {
        assert!((attitude(&notation) - wanted).amax() < 1e-15, "{notation}");
    }
    let pointed = attitude("ra_deg = 231, dec_deg = -18.3, roll_deg = 12");
    let (ra, dec) = (231_f64.to_radians(), (-18.3_f64).to_radians());
    let boresight = slewkit::Vector3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
    assert!((pointed.column(0) - boresight).amax() < 1e-15);
    // If the roll is 0, the body's y axis has no part to the north.
    assert!(attitude("ra_deg = 231, dec_deg = -18.3, roll_deg = 0")[(2, 1)].abs() < 1e-15);
    assert!(pointed[(2, 1)] > 0.1);
    assert_eq!(bad(REST, &["end.attitude={ ra_deg = 1, dec_deg = 2 }"]).0[0].code, "E0021");
    assert_eq!(bad(REST, &["end.attitude={ ra_deg = 1, dec_deg = 92, roll_deg = 0 }"]).0[0].code, "E0074");
}

/// Returns an attitude file of STK: these keywords, a row a time.
fn stk(format: &str, axes: &str, more: &str, row: impl Fn(f64) -> String, times: &[f64]) -> String {
    let rows: Vec<String> = times.iter().map(|time| format!("{time:.6} {}", row(*time))).collect();
    format!(
        "stk.v.11.0\n# a comment\nBEGIN Attitude\nNumberOfAttitudePoints {}\nBlockingFactor 20\n\
            {more}CentralBody Earth\n\
         ScenarioEpoch 21 Nov 2026 07:00:00.000000\nCoordinateAxes {axes}\n{format}\n\n{}\n\nEND Attitude\n",
        times.len(),
        rows.join("\n")
    )
}

#[test]
fn attitude_files_of_stk_are_read() {
    let plain = |time: f64| quaternion(time, 12);
    let first = |time: f64| {
        let text = quaternion(time, 12);
        let words: Vec<&str> = text.split(' ').collect();
        format!("{} {} {} {}", words[3], words[0], words[1], words[2])
    };
    for text in [
        stk("AttitudeTimeQuaternions", "ICRF", "InterpolationOrder 1\n", plain, &times(2)),
        stk("AttitudeTimeQuaternions", "J2000", "", plain, &times(2)),
        stk("attitudetimequatscalarfirst", "ICRF", "", first, &times(2)),
        stk("AttitudeTimeQuatAngVels", "ICRF", "TimeFormat EpSec\n", with_rate, &times(2)),
    ] {
        assert_agrees(&text);
    }
    for (keys, note) in [
        ("InterpolationOrder 0\n", "Lagrange of degree 0"),
        ("InterpolationOrder 30\n", "25 is the highest supported degree"),
        ("InterpolationMethod Spline\nInterpolationOrder 3\n", "Spline, which is not supported"),
    ] {
        let found = assert_agrees(&stk("AttitudeTimeQuaternions", "ICRF", keys, plain, &times(2)));
        assert!(found.not_judged.iter().any(|text| text.contains(note)), "{:?}", found.not_judged);
    }
    let wrong = stk("AttitudeTimeQuaternions", "ICRF", "", first, &times(2));
    assert!(!judged(&wrong).passed());
    for (text, reason) in [
        (
            stk("AttitudeTimeYPRAngles", "ICRF", "", plain, &times(2)),
            "rows of AttitudeTimeYPRAngles are not supported",
        ),
        (
            stk("AttitudeTimeQuaternions", "ICRF", "", with_rate, &times(2)),
            "the row has 8 numbers, but 5 are needed",
        ),
        (
            stk("AttitudeTimeQuaternions", "ICRF", "TimeFormat EpMin\n", plain, &times(2)),
            "times in the format EpMin are not supported",
        ),
        (wrong.replace("Points 31", "Points 30"), "NumberOfAttitudePoints is 30, but the file has 31 rows"),
        (wrong.replace("END Attitude", ""), "END Attitude is missing"),
        (wrong.replace("21 Nov", "21 11"), "not a date in a format of STK"),
        (wrong.replace("ScenarioEpoch", "# "), "no ScenarioEpoch"),
    ] {
        let said = read_attitudes(text.as_bytes(), "file").unwrap_err().0[0].reason.clone();
        assert!(said.contains(reason), "{said}");
    }
    let turning = stk("AttitudeTimeQuaternions", "Fixed", "", plain, &times(2));
    assert!(judged_by(&good(REST, &[]), &turning).is_err());
}

/// Three rows: by the polynomial of degree 2 that the file declares x of the body passes (10°,
/// 7.9°) 0.37° away, at one rate 2.57°.
#[test]
fn cones_are_judged_on_the_motion_that_a_file_declares() {
    let cone = "\n[[constraint]]\nkind = \"keep_out\"\nname = \"Moon\"\nboresight_body = [1, 0, 0]\n\
                direction_inertial = { ra_deg = 10, dec_deg = 7.9 }\nhalf_angle_deg = 2\n";
    let loaded = good(&format!("{REST}{cone}").replace("angle_deg = 120", "angle_deg = 40"), &[]);
    let bow = |time: f64| {
        let rows = [
            "0 0 0 1",
            "0.015134435901 -0.085831651177 0.172987393925 0.981060262190",
            "0 0 0.342020143326 0.939692620786",
        ];
        rows[(time / 30.0) as usize].to_string()
    };
    let of = |degree: &str| {
        let keys = [("INTERPOLATION_METHOD", "LAGRANGE"), ("INTERPOLATION_DEGREE", degree)];
        judged_by(&loaded, &aem(&keys, bow, &[0.0, 30.0, 60.0])).unwrap()
    };
    let found = of("2");
    assert_eq!(found.attitudes.violations.len(), 1, "{found:?}");
    // 0.37° from the axis of a cone of 2°.
    assert!(found.attitudes.violations[0].contains("enters the cone by 1.6"), "{found:?}");
    assert_eq!(found.attitudes.violated_at.len(), 1);
    assert!(of("1").passed());
    // The degree needs seven rows more than exist, so the interpolation is not judged.
    let found = of("9");
    assert!(found.passed());
    assert!(
        found.not_judged.iter().any(|text| text.contains("DEGREE 9 needs 10 rows, but a block has 3")),
        "{found:?}"
    );
    let odd =
        aem(&[("INTERPOLATION_METHOD", "SPLINE"), ("INTERPOLATION_DEGREE", "3")], bow, &[0.0, 30.0, 60.0]);
    let found = judged_by(&loaded, &odd).unwrap();
    assert!(found.not_judged.iter().any(|text| text.contains("SPLINE, which is not supported")), "{found:?}");
}

/// If a file has rates and declares Hermite's polynomial, a cone between two rows is met as the
/// motion meets it.
#[test]
fn hermite_between_rows_follows_the_rates() {
    let loaded = good(&format!("{REST}{CONE}").replace("half_angle_deg = 10", "half_angle_deg = 0.5"), &[]);
    let of = |method: &str| {
        let keys = [&ANGVEL[..], &[("INTERPOLATION_METHOD", method), ("INTERPOLATION_DEGREE", "3")]].concat();
        judged_by(&loaded, &aem(&keys, with_rate, &[0.0, 12.0, 30.0, 48.0, 60.0])).unwrap()
    };
    let told = told(&of("HERMITE")).concat();
    // x is at 30° where 3s² − 2s³ = 1/4: s = 0.32635, 19.581 s; between rows so far apart the
    // polynomial is 0.02 s off.
    assert!(told.contains("Sun: the boresight enters the cone by 0.5 deg at 19.56"), "{told}");
}

/// The attitude ephemeris of an `<ndm>` is read, whatever message is before it.
#[test]
fn an_ephemeris_behind_other_messages_is_read() {
    let state = |time: f64| {
        let text = quaternion(time, 12);
        let words: Vec<&str> = text.split(' ').collect();
        format!(
            "<attitudeState><quaternionEphemeris><EPOCH>{}</EPOCH><quaternion><Q1>{}</Q1><Q2>{}</Q2><Q3>\
                <![CDATA[{}]]></Q3>\
             <QC>{}</QC></quaternion></quaternionEphemeris></attitudeState>",
            date(time),
            words[0],
            words[1],
            words[2],
            words[3]
        )
    };
    let rows: String = times(2).into_iter().map(state).collect();
    let aem = format!(
        "<aem id=\"CCSDS_AEM_VERS\" version=\"2.0\"><header/><body><segment><metadata><OBJECT_NAME>A &amp; \
            B</OBJECT_NAME>\
         <OBJECT_ID>X</OBJECT_ID><REF_FRAME_A>ICRF</REF_FRAME_A><REF_FRAME_B>SC_BODY_1</REF_FRAME_B>\
         <TIME_SYSTEM>UTC</TIME_SYSTEM>\
         <START_TIME>{}</START_TIME><STOP_TIME>{}</STOP_TIME><ATTITUDE_TYPE>QUATERNION</ATTITUDE_TYPE>\
         </metadata><data>{rows}</data>\
         </segment></body></aem>",
        date(0.0),
        date(60.0)
    );
    let apm = "<apm id=\"CCSDS_APM_VERS\" version=\"2.0\"><header/><body><segment><metadata><TIME_SYSTEM>UTC\
        </TIME_SYSTEM></metadata>\
               <data><EPOCH>2026-11-21T07:00:00</EPOCH></data></segment></body></apm>";
    let head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    assert_agrees(&format!("{head}<ndm>{apm}{aem}</ndm>"));
    assert_agrees(&format!("{head}{aem}"));
    for (text, reason) in [
        (format!("{head}<ndm>{apm}</ndm>"), "an attitude parameter message (APM)"),
        (format!("{head}<ndm><opm/></ndm>"), "an orbit parameter message (OPM)"),
        (format!("{head}<acm version=\"2.0\"/>"), "an attitude comprehensive message (ACM)"),
        (format!("<!DOCTYPE x>{aem}"), "document type declarations are not supported"),
        (aem.replace("</aem>", ""), "is not closed"),
        (aem.replace("<data>", "<datum>"), "</data> is found where </datum> is expected"),
        ("CCSDS_ACM_VERS = 2.0\n".into(), "an attitude comprehensive message (ACM)"),
        ("CCSDS_OPM_VERS = 2.0\n".into(), "an orbit parameter message (OPM)"),
        ("CCSDS_APM_VERS = 2.0\n".into(), "it has only one attitude"),
    ] {
        let said = read_attitudes(text.as_bytes(), "file").unwrap_err().0[0].reason.clone();
        assert!(said.contains(reason), "{reason}: {said}");
    }
    // A nesting far deeper than any message is reported, and no stack overflows, whatever values
    // contain.
    for open in ["<a>", "<a b=\"/>\">", "<a b='\"/'>"] {
        let deep = format!("{}{}", open.repeat(100_000), "</a>".repeat(100_000));
        let said = read_attitudes(deep.as_bytes(), "file").unwrap_err().0[0].reason.clone();
        assert!(said.contains("there is no <aem>"), "{said}");
        let deep = format!("<aem version=\"2.0\">{deep}</aem>");
        let said = read_attitudes(deep.as_bytes(), "file").unwrap_err().0[0].reason.clone();
        assert!(said.contains("more than 100 levels deep"), "{said}");
    }
}

#[test]
fn what_is_no_text_is_named() {
    for (bytes, reason) in [
        (&b"\x1f\x8b\x08\x00packed"[..], "compressed by gzip"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"DAF/SPK ", "a binary SPICE kernel"),
    ] {
        let error = read_attitudes(bytes, "file").unwrap_err();
        assert!(error.0[0].reason.contains(reason), "{}", error.0[0].reason);
    }
    // A kernel does not state the ticks of its clock.
    let mut kernel = vec![0; 2048];
    kernel[..8].copy_from_slice(b"DAF/CK  ");
    kernel[88..96].copy_from_slice(b"LTL-IEEE");
    let error = read_attitudes(&kernel[..], "file").unwrap_err();
    assert!(error.0[0].reason.contains("ticks of a clock"), "{}", error.0[0].reason);
}

/// Blocks of two objects are no motion.
#[test]
fn blocks_of_two_objects_are_refused() {
    let first = aem(&[], |time| quaternion(time, 9), &times(5));
    let second = first
        .split_once("META_START")
        .unwrap()
        .1
        .replace("DEMO", "OTHER")
        .replace("07:00", "07:02")
        .replace("07:01", "07:03");
    let error = read_attitudes(format!("{first}META_START{second}").as_bytes(), "file").unwrap_err();
    assert!(error.0[0].reason.contains("this block is of OTHER UNKNOWN"), "{}", error.0[0].reason);
}

/// The start of a maneuver out of a file, by a row and between two of them, in the frame of the
/// spec.
#[test]
fn an_end_is_taken_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let apm = "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2026-11-20T00:00:00\nORIGINATOR = TEST\n\
        OBJECT_NAME = DEMO\nOBJECT_ID = X\n\
               TIME_SYSTEM = UTC\nEPOCH = 2026-11-21T07:00:20\nQUAT_START\nREF_FRAME_A = ICRF\n\
               REF_FRAME_B = SC_BODY_1\n";
    let (sin, cos) = 12.5_f64.to_radians().sin_cos();
    let old = "CCSDS_APM_VERS = 1.0\nCREATION_DATE = 2026-11-20T00:00:00\nORIGINATOR = TEST\n\
        OBJECT_NAME = DEMO\nOBJECT_ID = X\n\
               TIME_SYSTEM = UTC\nEPOCH = 2026-11-21T07:00:20\nQ_FRAME_A = SC_BODY_1\nQ_FRAME_B = ICRF\nQ_DIR = B2A\n";
    for (name, text) in [
        ("told.aem", aem(&[], |time| quaternion(time, 12), &times(10))),
        ("told.a", stk("AttitudeTimeQuatAngVels", "ICRF", "", with_rate, &times(10))),
        ("told.apm", format!("{apm}Q1 = 0\nQ2 = 0\nQ3 = {sin:.12}\nQC = {cos:.12}\nQUAT_STOP\n")),
        (
            "angles.apm",
            format!("{apm}EULER_ROT_SEQ = ZYX\nANGLE_1 = 25 [deg]\nANGLE_2 = 0\nANGLE_3 = 0\nQUAT_STOP\n"),
        ),
        ("old.apm", format!("{old}QC = {cos:.12}\nQ1 = 0\nQ2 = 0\nQ3 = {sin:.12}\n")),
        ("told.acm", "CCSDS_ACM_VERS = 2.0\n".into()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let start = "attitude = { axis = [0, 0, 1], angle_deg = 0 }\n[end]";
    let spec = |file: &str, epoch: &str| {
        let text = REST
            .replace(start, &format!("attitude = {{ file = \"{file}\" }}\n[end]"))
            .replace("2026-11-21T07:00:00", epoch);
        let path = folder.path().join("spec.toml");
        std::fs::write(&path, text).unwrap();
        slewkit_files::spec::read(&path, &[])
    };
    let at = |file: &str, epoch: &str| {
        let loaded = spec(file, epoch).unwrap_or_else(|errors| panic!("{file}: {errors}"));
        slewkit::lie::log(&loaded.problem.start.attitude).z.to_degrees()
    };
    // Twelve digits, and nine.
    for (file, open) in [("told.aem", 1e-8), ("told.a", 1e-6)] {
        assert!((at(file, "2026-11-21T07:00:20") - angle(20.0)).abs() < open, "{file}");
    }
    // Between two rows at one rate, or along the cubic of the rates, which is the motion here.
    let middle = at("told.aem", "2026-11-21T07:00:25");
    assert!((middle - 0.5 * (angle(20.0) + angle(30.0))).abs() < 1e-8, "{middle}");
    assert!((at("told.a", "2026-11-21T07:00:25") - angle(25.0)).abs() < 1e-6);
    for file in ["told.apm", "angles.apm", "old.apm"] {
        assert!((at(file, "2026-11-21T07:00:20") - 25.0).abs() < 1e-8, "{file}");
    }
    for (file, epoch, reason) in [
        ("told.apm", "2026-11-21T07:00:21", "is for 2026-11-21T07:00:20.000 UTC"),
        ("told.aem", "2026-11-21T07:01:01", "no attitude 61.000 s after its first row"),
        ("told.acm", "2026-11-21T07:00:20", "an attitude comprehensive message (ACM)"),
        ("none.aem", "2026-11-21T07:00:20", "cannot be read"),
    ] {
        let said = spec(file, epoch).unwrap_err().to_string();
        assert!(said.contains(reason), "{said}");
    }
}

/// The body has turned by 25° about z, its star tracker by 180° about x.
#[test]
fn an_attitude_of_several_frames_is_that_of_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let head = "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2026-11-20T00:00:00\nORIGINATOR = TEST\nMETA_START\n\
        OBJECT_NAME = DEMO\nOBJECT_ID = X\nTIME_SYSTEM = UTC\nMETA_STOP\nEPOCH = 2026-11-21T07:00:00\n";
    let quaternion = |a: &str, b: &str, [x, y, z, w]: [f64; 4]| {
        format!(
            "QUAT_START\nREF_FRAME_A = {a}\nREF_FRAME_B = {b}\nQ1 = {x:.12}\nQ2 = {y:.12}\nQ3 = {z:.12}\n\
             QC = {w:.12}\nQUAT_STOP\n"
        )
    };
    let angles = |degrees: f64| {
        format!(
            "EULER_START\nREF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\nEULER_ROT_SEQ = ZYX\nANGLE_1 = {degrees}\n\
             ANGLE_2 = 0\nANGLE_3 = 0\nEULER_STOP\n"
        )
    };
    let (sin, cos) = 12.5_f64.to_radians().sin_cos();
    let body = quaternion("ICRF", "SC_BODY_1", [0.0, 0.0, sin, cos]);
    let star = quaternion("ICRF", "STARTRACKER_1", [1.0, 0.0, 0.0, 0.0]);
    let other = quaternion("ICRF", "STARTRACKER_2", [0.0, 1.0, 0.0, 0.0]);
    let of_orbit = quaternion("LVLH", "SC_BODY_1", [1.0, 0.0, 0.0, 0.0]);
    let mounted = quaternion("STARTRACKER_1", "SC_BODY_1", [1.0, 0.0, 0.0, 0.0]);
    let begins = |text: &str, names: &str| {
        std::fs::write(folder.path().join("told.apm"), text).unwrap();
        let spec = REST
            .replace("attitude = { axis = [0, 0, 1], angle_deg = 0 }", "attitude = { file = \"told.apm\" }")
            .replace("reference_frame = \"ICRF\"", names);
        let path = folder.path().join("spec.toml");
        std::fs::write(&path, spec).unwrap();
        slewkit_files::spec::read(&path, &[])
    };
    let named = "reference_frame = \"ICRF\"";
    for (text, names, axis, degrees, warnings) in [
        (format!("{head}{star}{body}"), named, Vector3::z(), 25.0, 0),
        (format!("{head}{of_orbit}{body}"), named, Vector3::z(), 25.0, 0),
        (format!("{head}{mounted}{body}{}", angles(25.0)), named, Vector3::z(), 25.0, 0),
        (
            format!("{head}{star}{body}"),
            &format!("{named}\nbody_frame = \"STARTRACKER_1\""),
            Vector3::x(),
            180.0,
            0,
        ),
        // Frames that the spec does not name.
        (format!("{head}{star}"), named, Vector3::x(), 180.0, 1),
        (format!("{head}{body}"), "", Vector3::z(), 25.0, 1),
        // Four digits.
        (format!("{head}{body}").replace("0.216439613938", "0.2164"), named, Vector3::z(), 25.0, 1),
    ] {
        let loaded = begins(&text, names).unwrap_or_else(|errors| panic!("{text}: {errors}"));
        let turned = slewkit::lie::log(&loaded.problem.start.attitude);
        assert!(
            (turned.cross(&axis)).norm() < 1e-3 && (turned.norm().to_degrees() - degrees).abs() < 0.01,
            "{text}"
        );
        let codes: Vec<_> = loaded.warnings.iter().map(|warning| warning.code).collect();
        assert_eq!(codes, vec!["W0092"; warnings], "{text}");
    }
    for (text, reason) in [
        (
            format!("{head}{star}{other}"),
            "the attitudes of STARTRACKER_1 and STARTRACKER_2 differ by 180 deg",
        ),
        (format!("{head}{body}{}", angles(35.0)), "two attitudes of SC_BODY_1 differ by 10.0 deg"),
        (format!("{head}{of_orbit}"), "map to LVLH"),
        (format!("{head}{mounted}"), "are both frames of the spacecraft"),
        (format!("{head}{body}{head}{body}"), "2 messages with attitudes: DEMO, DEMO"),
    ] {
        let said = begins(&text, named).unwrap_err().to_string();
        assert!(said.contains(reason), "{said}");
    }
}
