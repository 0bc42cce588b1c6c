//! Plans and verifies a day of many stops: stars and moving targets, with wheels and cones.
//!
//! `cargo run --release -p evidence -- day [spec] [STOPS [SEED]]`: STOPS (100 by default) stops in
//! a given order over a day on a low orbit, in minimum time. Every fifth stop points at a moving
//! target (nadir, zenith, along the track, or the orbit normal) and follows it for a minute. The
//! other stops point at random stars, all for the same time. Every tenth stop has a free roll. The
//! spacecraft has four wheels and a rate limit, and its telescope stays 45° from the Sun and 10°
//! from the Moon. Stars within these cones are drawn again.
//!
//! The command prints the times of planning and verification, how many legs and holds pass the
//! witnesses, and how long the body turns. With `spec` it prints the spec instead. It ends with 1
//! if a leg or a hold does not pass.

use evidence::words::Words;
use evidence::{Random, median};
use slewkit::plan::Silent;
use slewkit_files::export::SequenceFile;
use slewkit_files::spec::{self, Format, Spec};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// The duration of the day without its last hour [s].
const DAY: f64 = 82_800.0;
/// The time for which a moving target is followed [s].
const FOLLOWED: f64 = 60.0;
/// The assumed longest duration of a slew [s], from which the length of the holds is computed.
const SLEW: f64 = 90.0;

const CRAFT: &str = r#"
format = 1
name = "A day"
epoch = "2026-11-21T07:00:00 UTC"

[orbit]
tle = [
    "1 28057U 03049A   26324.97796667  .00000060  00000-0  35940-4 0  1838",
    "2 28057  98.4283 247.6961 0000884  88.1964 271.9322 14.35478080140550",
]

[body]
inertia_kg_m2 = [20, 18, 12]

[actuators]
wheel = [
    { name = "RW1", axis_body = [0.8, 0, 0.6], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
    { name = "RW2", axis_body = [0, 0.8, 0.6], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
    { name = "RW3", axis_body = [-0.8, 0, 0.6], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
    { name = "RW4", axis_body = [0, -0.8, 0.6], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
]

[start]
point = { boresight_body = [0, 0, 1], ra_deg = 60.0, dec_deg = -30.0 }
second = { axis_body = [1, 0, 0], vector = [0, 0, 1] }

[maneuver]
minimize = "time"
steps = 60

[[constraint]]
kind = "rate_limit"
angular_velocity_limit_deg_s = 3

[[constraint]]
name = "Sun"
kind = "keep_out"
boresight_body = [0, 0, 1]
direction = "sun"
half_angle_deg = 45

[[constraint]]
name = "Moon"
kind = "keep_out"
boresight_body = [0, 0, 1]
direction = "moon"
half_angle_deg = 10
"#;

/// The cones that stars must avoid, about the Sun and about two points on the path of the Moon of
/// that day: right ascension, declination and half angle [deg].
const AVOIDED: [[f64; 3]; 3] = [[236.8, -20.0, 50.0], [22.0, 8.0, 25.0], [30.0, 12.0, 25.0]];

/// Draws a star outside of the cones, and returns its right ascension and declination [deg].
fn star(random: &mut Random) -> [f64; 2] {
    loop {
        let at = random.direction();
        let star = [at.y.atan2(at.x).to_degrees().rem_euclid(360.0), at.z.asin().to_degrees()];
        let unit = |[ra, dec]: [f64; 2]| {
            let ((sin_ra, cos_ra), (sin, cos)) = (ra.to_radians().sin_cos(), dec.to_radians().sin_cos());
            slewkit::Vector3::new(cos * cos_ra, cos * sin_ra, sin)
        };
        let clear = |[ra, dec, away]: &[f64; 3]| unit([*ra, *dec]).angle(&at) > away.to_radians();
        if AVOIDED.iter().all(clear) {
            return star;
        }
    }
}

/// Returns the text of the spec.
fn text(stops: usize, seed: usize) -> String {
    let mut random = Random::of_case(81, seed);
    let moving = ["nadir", "zenith", "along_track", "orbit_normal", "anti_orbit_normal"];
    let hold = (DAY / stops as f64 - SLEW).max(1.0);
    let mut text = CRAFT.to_string();
    for index in 0..stops {
        let name = index + 1;
        if index % 5 == 4 {
            let target = moving[index / 5 % moving.len()];
            text += &format!(
                "\n[[stop]]\nname = \"{name} {target}\"\npoint = {{ boresight_body = [1, 0, 0], at = \"{target}\" }}\n\
                 hold_s = {FOLLOWED}\n"
            );
            continue;
        }
        let [ra, dec] = star(&mut random);
        text += &format!(
            "\n[[stop]]\nname = \"{name}\"\npoint = {{ boresight_body = [0, 0, 1], ra_deg = {ra:.6}, dec_deg = {dec:.6} }}\n\
             hold_s = {hold}\nsettling_s = 10\n"
        );
        if index % 10 != 0 {
            text += "second = { axis_body = [1, 0, 0], vector = [0, 0, 1] }\n";
        }
    }
    text
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let is_asked = words.next_is("spec");
    let stops: usize = words.number("number of stops", 100)?;
    let seed: usize = words.number("seed", 0)?;
    words.end()?;
    if is_asked {
        print!("{}", text(stops, seed));
        return Ok(());
    }
    let began = Instant::now();
    let read = spec::load_from_str(&text(stops, seed), "day.toml", Path::new(""), Format::Toml, &[]);
    let Spec::Sequence(loaded) = read.map_err(|found| format!("{found}"))? else {
        return Err("the day is no sequence".into());
    };
    let reading = began.elapsed().as_secs_f64();
    let began = Instant::now();
    let plan = loaded.sequence.plan(&loaded.settings, &mut Silent)?;
    let planning = began.elapsed().as_secs_f64();
    let began = Instant::now();
    let file = SequenceFile::new(&loaded, &plan);
    let judged = file.judge(&loaded, &|| false)?;
    let verifying = began.elapsed().as_secs_f64();
    let legs = judged.legs.iter().filter(|leg| leg.verification.passed()).count();
    let holds = judged.holds.iter().filter(|(_, hold)| hold.verification.passed()).count();
    let (checks, all) = (judged.checks.iter().filter(|check| check.passed).count(), judged.checks.len());
    let mut turning: Vec<f64> = plan.legs.iter().map(|leg| leg.plan.solution.cost).collect();
    println!("read in {reading:.1} s, planned in {planning:.1} s, verified in {verifying:.1} s");
    println!("{legs} of {stops} legs, {holds} of {} holds pass; {checks} of {all} joins", judged.holds.len());
    println!(
        "{:.0} s in all, of which {:.0} s turn, median {:.1} s a leg",
        plan.end,
        plan.cost,
        median(&mut turning)
    );
    let failed = judged.checks.iter().filter(|check| !check.passed);
    failed.for_each(|check| println!("{}: {:.1e}, at most {:.1e}", check.name, check.value, check.limit));
    if judged.passed() && legs == stops { Ok(()) } else { Err("see above".into()) }
}
