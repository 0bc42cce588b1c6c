//! `slew sky`: prints the directions of the targets of a spec, and their accuracy.

use super::console;
use super::{Console, Exit, Failure, ReportArgs, SpecArgs};
use serde::Serialize;
use slewkit::Vector3;
use slewkit::maneuver::constraint::angle_between;
use slewkit::numerics::figures::significant;
use slewkit_files::export::write_document;
use slewkit_files::spec::{Heavens, Loaded, Named};
use slewkit_sky::{Condition, SkyError, Target, elevation};

/// Arguments of `slew sky`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  slew sky problems/ground_pass.toml
  slew sky problems/sun_free_roll.toml --format json

Axes are those of the GCRS. Directions are geometric, unless the spec has light_time or aberration. `light` is
the displacement by both. `apart` is the angle between the direction of the planner and the direction of the
full theories (IAU 2006/2000A, VSOP2000), which the planner does not use.")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// A target with its directions at the start and at the end of a maneuver.
#[derive(Debug, Serialize)]
struct Line {
    target: String,
    used_by: String,
    /// Times of the start and of the end of the maneuver \[s\].
    time_s: [f64; 2],
    /// Right ascension and declination of the target at these two times \[deg\].
    ra_dec_deg: [[f64; 2]; 2],
    /// Angular rate of the direction at these two times \[deg/s\].
    rate_deg_s: [f64; 2],
    /// Distance of the target at these two times \[km\]; `None` if the target is only a direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    range_km: Option<[f64; 2]>,
    /// Elevation of the spacecraft above the horizon of the ground station at these two times
    /// \[deg\]; `None` if the target is not a ground station.
    #[serde(skip_serializing_if = "Option::is_none")]
    elevation_deg: Option<[f64; 2]>,
    /// Angle between the direction that the planner uses and the direction according to the full
    /// astronomical theories, at these two times \[arcsec\].
    apart_arcsec: [f64; 2],
    /// Displacement of the direction by light time and aberration at these two times \[arcsec\].
    /// The spec determines whether directions include this displacement.
    by_light_arcsec: [f64; 2],
}

/// Report on the orbit and the targets of a spec.
#[derive(Debug, Serialize)]
struct Told {
    /// Period of the orbit \[s\]; `None` if the spec has no orbit.
    #[serde(skip_serializing_if = "Option::is_none")]
    period_s: Option<f64>,
    /// Age of the orbital elements at the epoch \[s\]; `None` if the spec gives a table of
    /// positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    age_s: Option<f64>,
    /// Time intervals, counted from the start, in which the spacecraft is in the penumbra or umbra
    /// of the Earth \[s\].
    eclipses_s: Vec<[f64; 2]>,
    /// True if directions are corrected for light time.
    light_time: bool,
    aberration: bool,
    targets: Vec<Line>,
}

/// Time for which targets are computed if the duration of the maneuver is free \[s\].
const AHEAD: f64 = 600.0;

/// Runs `slew sky` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let loaded = super::spec_file::read(&args.spec.spec, &args.spec.reading, console)?;
    let Some(heavens) = &loaded.heavens else {
        console.say("the spec aims at no named target: add `point` or `direction` with at = \"sun\"");
        return Ok(Exit::Solved);
    };
    let told = told(&loaded, heavens).map_err(|error| Failure::Internal(error.to_string()))?;
    console::to_stdout(|output| {
        if args.report.json() {
            return write_document(&told, output);
        }
        write!(output, "{}", table(&told))?;
        Ok(())
    })?;
    Ok(Exit::Solved)
}

fn told(loaded: &Loaded, heavens: &Heavens) -> Result<Told, SkyError> {
    let sky = &heavens.sky;
    let end = loaded.problem.duration.known().or(loaded.problem.duration.at_most()).unwrap_or(AHEAD);
    let (period_s, age_s, eclipses) = match sky.orbit() {
        Some(orbit) => {
            let age = (!orbit.is_table()).then(|| orbit.age());
            (Some(orbit.period()?), age, Condition::Eclipsed.windows(sky, 0.0, end)?)
        }
        None => (None, None, Vec::new()),
    };
    let targets =
        heavens.targets.iter().map(|named| line(heavens, named, [0.0, end])).collect::<Result<_, _>>()?;
    Ok(Told {
        period_s,
        age_s,
        light_time: sky.light().takes_time,
        aberration: sky.light().aberrates,
        eclipses_s: eclipses.iter().map(|window| [window.from, window.to]).collect(),
        targets,
    })
}

fn line(heavens: &Heavens, named: &Named, times: [f64; 2]) -> Result<Line, SkyError> {
    let (sky, target) = (&heavens.sky, &named.target);
    let direction = sky.direction(target, 0.0, times[1].max(1.0))?;
    let none = Vector3::zeros();
    let seen = times.map(|time| direction.in_space(time, &none));
    let mut apart_arcsec = [0.0; 2];
    for (apart, (time, seen)) in apart_arcsec.iter_mut().zip(times.iter().zip(&seen)) {
        *apart = angle_between(&seen.direction, &sky.seen(target, *time)?).to_degrees() * 3600.0;
    }
    let by_light = |time: f64| Ok::<_, SkyError>(sky.moved_by_light(target, time)?.to_degrees() * 3600.0);
    let range = |time: f64| Ok::<_, SkyError>(sky.range(target, time)? / 1e3);
    let elevation_deg = match target {
        Target::Ground { latitude_deg, longitude_deg, height_m } => {
            let at = |time: f64| elevation(sky, *latitude_deg, *longitude_deg, *height_m, time);
            Some([at(times[0])?.to_degrees(), at(times[1])?.to_degrees()])
        }
        _ => None,
    };
    Ok(Line {
        target: named.name.clone(),
        used_by: named.used_by.clone(),
        time_s: times,
        ra_dec_deg: seen.map(|seen| {
            let d = seen.direction;
            [d.y.atan2(d.x).to_degrees().rem_euclid(360.0), d.z.clamp(-1.0, 1.0).asin().to_degrees()]
        }),
        rate_deg_s: seen.map(|seen| seen.rate.norm().to_degrees()),
        range_km: if target.is_place() { Some([range(times[0])?, range(times[1])?]) } else { None },
        elevation_deg,
        apart_arcsec,
        by_light_arcsec: [by_light(times[0])?, by_light(times[1])?],
    })
}

fn table(told: &Told) -> String {
    let mut text = String::new();
    if let Some(period) = told.period_s {
        let elements = told.age_s.map_or_else(
            || "a table of positions".into(),
            |age| {
                // An age of less than a second counts as zero, because the difference between two
                // epochs has round-off errors.
                let days = if age.abs() < 1.0 { 0.0 } else { age.abs() / 86_400.0 };
                let than = if age <= -1.0 { "newer than the epoch" } else { "old" };
                format!("elements {} days {than}", significant(days, 2))
            },
        );
        text.push_str(&format!(
            "orbit       {} min a revolution, {elements}\n",
            significant(period / 60.0, 4)
        ));
        let dark = match &told.eclipses_s[..] {
            [] => "in the Sun for the whole duration".to_string(),
            all => all
                .iter()
                .map(|[from, to]| {
                    format!("in the shadow from {} to {} s", significant(*from, 4), significant(*to, 4))
                })
                .collect::<Vec<_>>()
                .join(", "),
        };
        text.push_str(&format!("light       {dark}\n"));
    }
    let effects = [(told.light_time, "light time"), (told.aberration, "aberration")];
    let taken: Vec<&str> = effects.iter().filter(|(taken, _)| *taken).map(|(_, name)| *name).collect();
    let taken = if taken.is_empty() { "geometric".into() } else { format!("with {}", taken.join(" and ")) };
    text.push_str(&format!("directions  {taken}\n"));
    text.push_str(&format!(
        "{:<22} {:>7} {:>9} {:>9} {:>10} {:>11} {:>10} {:>8} {:>8}\n",
        "target", "t, s", "ra, deg", "dec, deg", "deg/s", "range, km", "elev, deg", "apart, ″", "light, ″"
    ));
    for (number, line) in told.targets.iter().enumerate() {
        // Several constraints may use the same target, which is printed once.
        let same = |other: &Line| other.target == line.target && other.ra_dec_deg == line.ra_dec_deg;
        if told.targets[..number].iter().any(same) {
            continue;
        }
        for end in 0..2 {
            let name = if end == 0 { line.target.as_str() } else { "" };
            let of = |value: Option<[f64; 2]>, digits| {
                value.map_or("-".into(), |value| significant(value[end], digits))
            };
            text.push_str(&format!(
                "{name:<22} {:>7} {:>9} {:>9} {:>10} {:>11} {:>10} {:>8} {:>8}\n",
                significant(line.time_s[end], 5),
                format!("{:.3}", line.ra_dec_deg[end][0]),
                format!("{:.3}", line.ra_dec_deg[end][1]),
                significant(line.rate_deg_s[end], 3),
                of(line.range_km, 6),
                of(line.elevation_deg, 3),
                significant(line.apart_arcsec[end], 2),
                significant(line.by_light_arcsec[end], 2),
            ));
        }
    }
    text
}
