//! Checks the verdicts of `slew verify` on attitude files: correct files in every legal style, and
//! files into which faults of every kind were planted.
//!
//! `cargo run --release -p evidence -- false_files [COUNT [SEED]]`, 1,000 of each by default. A
//! verdict is wrong if a faulty file agrees, unless the fault is listed under "not judged" for that
//! file. It is also wrong if a correct file is refused or does not agree.
//!
//! The command ends with 1 if a verdict was wrong.

use evidence::Random;
use evidence::attitude_files::{Frame, Kind, Motion, Notation, Row, Style, file, rows};
use evidence::words::Words;
use slewkit::verify::DEFAULT_ACCURACY_DEG;
use slewkit::{Vector3, lie};
use slewkit_files::exchange::{FileReport, judge_file, read_attitudes};
use slewkit_files::spec::{self, Format, Loaded};
use std::collections::BTreeMap;

/// The planted fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    Frame,
    Direction,
    Sign,
    TimeSystem,
    Offset,
    UnitOfRates,
    Gap,
    SwappedColumns,
    ConeBetweenRows,
}

const FAULTS: [Fault; 9] = [
    Fault::Frame,
    Fault::Direction,
    Fault::Sign,
    Fault::TimeSystem,
    Fault::Offset,
    Fault::UnitOfRates,
    Fault::Gap,
    Fault::SwappedColumns,
    Fault::ConeBetweenRows,
];

/// The verdict on a file.
enum Verdict {
    /// The file is refused, for this reason.
    Refused(String),
    /// The file is read, with this finding against it.
    Told(String),
    /// The file agrees with the maneuver, except for these keys, which are not judged.
    Agrees(Vec<String>),
}

/// A maneuver, its file, and the word under which a fault may be listed as not judged.
struct Case {
    spec: String,
    file: Vec<u8>,
    open: &'static [&'static str],
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let (count, seed) = (words.number("number of files", 1000)?, words.number::<u64>("seed", 1)?);
    words.end()?;
    let mut tally = BTreeMap::<Fault, [u64; 4]>::new();
    let mut wrong = 0;
    for index in 0..count {
        let fault = FAULTS[(index % FAULTS.len() as u64) as usize];
        let case = planted(fault, &mut Random::new(seed << 40 | index));
        let column = match judged(&case)? {
            Verdict::Refused(_) => 0,
            Verdict::Told(_) => 1,
            Verdict::Agrees(open)
                if open.iter().any(|text| case.open.iter().any(|word| text.contains(word))) =>
            {
                2
            }
            Verdict::Agrees(open) => {
                println!("{fault:?}, case {index}: agrees; not judged: {open:?}\n{}", shown(&case));
                wrong += 1;
                3
            }
        };
        tally.entry(fault).or_default()[column] += 1;
    }
    println!("{:<18} {:>8} {:>8} {:>12} {:>8}", "planted", "refused", "told", "not judged", "agrees");
    for (fault, [refused, told, open, agrees]) in &tally {
        println!("{:<18} {refused:>8} {told:>8} {open:>12} {agrees:>8}", format!("{fault:?}"));
    }
    println!("{count} false files: {wrong} agree");
    let mut right = 0;
    for index in 0..count {
        let case = styled(&mut Random::new((seed << 40 | index) ^ 1 << 63));
        match judged(&case)? {
            Verdict::Agrees(_) => right += 1,
            Verdict::Refused(why) => println!("style {index}: refused: {why}\n{}", shown(&case)),
            Verdict::Told(why) => println!("style {index}: told: {why}\n{}", shown(&case)),
        }
    }
    println!("{count} right files: {} refused", count - right);
    if wrong > 0 || right < count { Err("see above".into()) } else { Ok(()) }
}

/// Returns the first lines of a case's file, to be printed.
fn shown(case: &Case) -> String {
    let text = String::from_utf8_lossy(&case.file);
    let head: Vec<&str> = text.lines().take(24).collect();
    format!("{}\n{}\n", case.spec.trim(), head.join("\n"))
}

fn judged(case: &Case) -> Result<Verdict, Box<dyn std::error::Error>> {
    let Loaded { problem, settings, identity, .. } =
        spec::from_str(&case.spec, "spec.toml", Format::Toml, &[]).map_err(|errors| errors.to_string())?;
    let tolerance = settings.continuous_tolerance.unwrap_or(DEFAULT_ACCURACY_DEG.to_radians());
    let found = read_attitudes(&case.file[..], "file")
        .and_then(|found| judge_file(&found, "file", &problem, &identity, tolerance));
    Ok(match found {
        Err(errors) => Verdict::Refused(errors.to_string()),
        Ok(found) if found.passed() => Verdict::Agrees(found.not_judged),
        Ok(found) => Verdict::Told(against(&found)),
    })
}

fn against(found: &FileReport) -> String {
    let checks = found.attitudes.checks.iter().filter(|check| !check.passed);
    let checks =
        checks.map(|check| format!("{} off by {:e}, at most {:e}", check.name, check.value, check.limit));
    checks.chain(found.attitudes.violations.iter().cloned()).collect::<Vec<_>>().join("; ")
}

/// Returns the spec of the maneuver to which a motion belongs.
fn spec_of(motion: &Motion, frame: Frame, named: bool, more: &str) -> String {
    let orbital_rate = if frame == Frame::Orbit { 1.1e-3 } else { 0.0 };
    // A body at rest in the orbit frame rotates with it. Rates in a spec are inertial.
    let attitude = |time: f64| {
        let (attitude, _) = motion.at(time);
        let [w, x, y, z] = lie::quaternion_from_rotation(&attitude);
        let rate = attitude.tr_mul(&(orbital_rate * Vector3::y()));
        format!(
            "attitude = {{ quaternion_wxyz = [{w:e}, {x:e}, {y:e}, {z:e}] }}\nangular_velocity_rad_s = \
                [{:e}, {:e}, {:e}]",
            rate.x, rate.y, rate.z
        )
    };
    let orbit = format!("[environment]\nkind = \"gravity_gradient\"\norbital_rate_rad_s = {orbital_rate}\n");
    let (names, orbit) = match frame {
        Frame::Inertial => ("[names]\nobject = \"DEMO\"\nreference_frame = \"ICRF\"\n", String::new()),
        Frame::Orbit => ("", orbit),
    };
    let names = if named { names } else { "" };
    let epoch = if named { "epoch = \"2026-11-21T07:00:00 UTC\"\n" } else { "" };
    format!(
        "format = 1\n{epoch}{names}[body]\ninertia_kg_m2 = [120, 100, 80]\n[start]\n{}\n[end]\n{}\n\
            [maneuver]\nduration_s = {}\n{orbit}{more}",
        attitude(0.0),
        attitude(motion.duration),
        motion.duration
    )
}

fn keep_out(direction: &Vector3, half_angle: f64) -> String {
    format!(
        "[[constraint]]\nkind = \"keep_out\"\nname = \"Sun\"\nboresight_body = [1, 0, 0]\n\
            direction_inertial = {{ vector = [{:e}, {:e}, {:e}] }}\nhalf_angle_deg = {}\n",
        direction.x,
        direction.y,
        direction.z,
        half_angle.to_degrees()
    )
}

/// Draws a direction in inertial axes, and returns it with its smallest angle to the boresight x
/// over the whole motion \[rad\].
fn far_direction(random: &mut Random, motion: &Motion) -> (Vector3, f64) {
    let away = |direction: &Vector3| {
        let angle = |k: usize| motion.at(motion.duration * k as f64 / 400.0).0.column(0).angle(direction);
        (0..=400).map(angle).fold(f64::INFINITY, f64::min)
    };
    let tried = (0..20).map(|_| random.direction()).map(|direction| (direction, away(&direction)));
    tried.fold((Vector3::x(), 0.0), |best, next| if next.1 > best.1 { next } else { best })
}

/// Draws a correct file in a random style.
fn styled(random: &mut Random) -> Case {
    let motion = Motion::random(random);
    let frame = if random.unit() < 0.2 { Frame::Orbit } else { Frame::Inertial };
    let style = Style::random(random, &motion, frame);
    let more = if frame == Frame::Inertial && random.unit() < 0.3 {
        let (direction, away) = far_direction(random, &motion);
        keep_out(&direction, 0.5 * away)
    } else {
        String::new()
    };
    let file = file(&style, &rows(&motion, &style));
    Case { spec: spec_of(&motion, frame, random.unit() < 0.9, &more), file, open: &[] }
}

/// Draws a correct file and plants a fault into it.
fn planted(fault: Fault, random: &mut Random) -> Case {
    let motion = Motion::random(random);
    let inertial = !matches!(fault, Fault::Frame | Fault::Direction | Fault::Sign) || random.unit() < 0.7;
    let frame = if inertial { Frame::Inertial } else { Frame::Orbit };
    let mut style = Style::random(random, &motion, frame);
    let named = random.unit() < 0.9;
    let mut more = String::new();
    let mut open: &'static [&'static str] = &[];
    match fault {
        Fault::Frame => {
            to_message(&mut style, random);
            let other: &[&str] = match frame {
                Frame::Inertial => {
                    &["ITRF2000", "TEME", "ECLIPJ2000", "LVLH", "TOD_EARTH", "MARSFIXED", "RTN"]
                }
                Frame::Orbit => &["ICRF", "EME2000", "ITRF97", "TEME", "PLANEFRAME", "RSW_INERTIAL", "SEZ"],
            };
            style.reference = random.pick(other);
            // If the old frame is an orbit frame, `rows` are its axes.
            let mut kept = style.clone();
            kept.reference = if inertial { "ICRF" } else { "VNC" };
            let all = rows(&motion, &kept);
            return Case {
                spec: spec_of(&motion, frame, named, ""),
                file: file(&style, &all),
                open: &["reference frame", "the frames"],
            };
        }
        Fault::TimeSystem => {
            to_message(&mut style, random);
            open = &["the start: "];
        }
        Fault::UnitOfRates => {
            style.kind = if style.notation == Notation::Table {
                Kind::QuaternionAngvel
            } else {
                velocity(&mut style, random)
            };
            open = &["whether the rates are the derivatives"];
        }
        Fault::Sign | Fault::SwappedColumns => open = &["whether the rates are the derivatives"],
        Fault::Gap => to_message(&mut style, random),
        _ => {}
    }
    let mut all = rows(&motion, &style);
    match fault {
        Fault::Direction => all.iter_mut().for_each(|row| row.attitude = row.attitude.transpose()),
        Fault::Sign => sign(&style, &mut all, random),
        Fault::SwappedColumns => swap(&style, &mut all, random),
        Fault::UnitOfRates => {
            let scale = random.pick(&[1_f64.to_radians(), 1_f64.to_degrees(), 60.0, 1e3, 1e-3]);
            all.iter_mut().for_each(|row| row.rate *= scale);
        }
        Fault::Offset => {
            if random.coin() && style.notation != Notation::Table {
                // The change exceeds the resolution of the dates.
                let digits = 10_f64.powi(-(style.decimals_of_time as i32)).max(0.01);
                let late = digits * 10_f64.powf(random.within(0.5, 3.0));
                all.iter_mut().for_each(|row| row.time += late);
                open = &["the start: "];
            } else {
                let size = 10_f64.powf(random.within(-1.0, 2.0)).to_radians();
                let off = lie::exp(&(random.direction() * size));
                all.iter_mut().for_each(|row| row.attitude = off * row.attitude);
            }
        }
        Fault::Gap => gap(&mut style, &mut all, random),
        Fault::ConeBetweenRows => more = cone_between(&motion, &mut style, &mut all, random),
        Fault::TimeSystem => {
            let right = style.clone();
            let scales: Vec<&str> = ["UTC", "TAI", "TT", "GPS"]
                .into_iter()
                .filter(|scale| *scale != right.scale && !(right.scale == "TDB" && *scale == "TT"))
                .collect();
            let said = random.pick(&scales);
            let text = String::from_utf8_lossy(&file(&right, &all)).into_owned();
            let text = renamed(&text, right.scale, said, style.lower_values);
            return Case { spec: spec_of(&motion, frame, named, ""), file: text.into_bytes(), open };
        }
        Fault::Frame => {}
    }
    Case { spec: spec_of(&motion, frame, named, &more), file: file(&style, &all), open }
}

/// Changes the style from a table to a message, because a table has no frames, no dates and no
/// blocks.
fn to_message(style: &mut Style, random: &mut Random) {
    if style.notation == Notation::Table {
        style.notation = random.pick(&[Notation::Keywords, Notation::Xml]);
        style.kind = Kind::Quaternion;
    }
}

/// Changes the style to a message, and returns a kind that contains the components of the angular
/// velocity.
fn velocity(style: &mut Style, random: &mut Random) -> Kind {
    (style.first_version, style.a_to_b, style.scalar_first) = (false, true, false);
    random.pick(&[Kind::QuaternionAngvel, Kind::EulerAngvel([2, 1, 0]), Kind::EulerAngvel([0, 2, 0])])
}

fn renamed(text: &str, from: &str, to: &str, lower: bool) -> String {
    let word = |name: &str| if lower { name.to_lowercase() } else { name.to_string() };
    let (from, to) = (word(from), word(to));
    let by_key = ["TIME_SYSTEM = ", "time_system = ", "<TIME_SYSTEM>"];
    by_key
        .iter()
        .fold(text.to_string(), |text, key| text.replace(&format!("{key}{from}"), &format!("{key}{to}")))
}

/// Returns the number of attitude values in a row.
fn attitude_numbers(kind: Kind) -> usize {
    match kind {
        Kind::Quaternion | Kind::QuaternionAngvel | Kind::QuaternionDerivative => 4,
        Kind::Euler(_) | Kind::EulerDerivative(_) | Kind::EulerAngvel(_) | Kind::Spin => 3,
    }
}

/// Changes the sign of one attitude value, or of all rates.
fn sign(style: &Style, all: &mut [Row], random: &mut Random) {
    if style.has_rates() && random.unit() < 0.3 {
        all.iter_mut().for_each(|row| row.rate = -row.rate);
        return;
    }
    let planted: [fn(&mut [f64]); 4] =
        [|row| row[0] = -row[0], |row| row[1] = -row[1], |row| row[2] = -row[2], |row| row[3] = -row[3]];
    let which = planted[random.below(attitude_numbers(style.kind))];
    all.iter_mut().for_each(|row| row.tampered = Some(which));
}

/// Exchanges two attitude values or two rates, or moves the scalar of the quaternion to the other
/// end.
fn swap(style: &Style, all: &mut [Row], random: &mut Random) {
    let count = attitude_numbers(style.kind);
    let rates = matches!(style.kind, Kind::QuaternionAngvel | Kind::QuaternionDerivative);
    let of_four: [fn(&mut [f64]); 6] = [
        |row| row.swap(0, 1),
        |row| row.swap(1, 2),
        |row| row.swap(0, 2),
        |row| row[..4].rotate_right(1),
        |row| row.swap(0, 3),
        |row| row.swap(2, 3),
    ];
    let of_rates: [fn(&mut [f64]); 3] = [|row| row.swap(4, 5), |row| row.swap(5, 6), |row| row.swap(4, 6)];
    let which = if rates && random.coin() {
        random.pick(&of_rates)
    } else if count == 4 {
        random.pick(&of_four)
    } else {
        random.pick(&of_four[..3])
    };
    all.iter_mut().for_each(|row| row.tampered = Some(which));
}

/// Removes the rows of a time interval between two blocks, or at one end of the motion.
fn gap(style: &mut Style, all: &mut Vec<Row>, random: &mut Random) {
    let count = all.len();
    let missing = 1 + random.below(count / 3);
    style.blocks.clear();
    match random.below(3) {
        0 => drop(all.drain(..missing)),
        1 => all.truncate(count - missing),
        _ => {
            let from = 2 + random.below(count - missing - 4);
            all.drain(from + 1..=from + missing);
            (style.blocks, style.apart) = (vec![from], true);
        }
    }
}

/// Returns the text of a cone that the boresight enters only between two rows, whatever the motion
/// between them is.
fn cone_between(motion: &Motion, style: &mut Style, all: &mut Vec<Row>, random: &mut Random) -> String {
    // Keeps only some rows, so that the boresight moves by at least a degree between two of them.
    let keep = 1 + random.below(4);
    let last = all.len() - 1;
    let mut index = 0;
    all.retain(|_| {
        index += 1;
        (index - 1) % keep == 0 || index - 1 == last
    });
    style.blocks.clear();
    style.times = all.iter().map(|row| row.time).collect();
    let boresight = |time: f64| -> Vector3 { motion.at(time).0.column(0).into() };
    let mut best: Option<(f64, Vector3, f64)> = None;
    for _ in 0..200 {
        let k = random.below(all.len() - 1);
        let (from, to) = (all[k].time, all[k + 1].time);
        let axis = boresight(0.5 * (from + to));
        let nearest = all.iter().map(|row| boresight(row.time).angle(&axis)).fold(f64::INFINITY, f64::min);
        // The boresight takes another path if the rate is constant from row to row.
        let [first, second] = [from, to].map(|time| motion.at(time).0);
        let middle = first * lie::exp(&(0.5 * lie::minus(&second, &first)));
        let off = middle.column(0).angle(&axis);
        let depth = nearest - off;
        if best.is_none_or(|(deepest, ..)| depth > deepest) {
            best = Some((depth, axis, 0.5 * (nearest + off)));
        }
    }
    let (_, axis, half_angle) = best.unwrap_or((0.0, Vector3::x(), 0.0));
    keep_out(&axis, half_angle)
}
