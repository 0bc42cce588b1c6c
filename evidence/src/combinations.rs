//! Combinations of ends, inputs, limits and objectives, with a small spec for each.
//!
//! The tables of `docs/combinations.md` have a cell for each combination. Tests compare the cells
//! of refused combinations with the reader of specs, and some of the other cells with the planner.

use slewkit::plan::{Control, Observer, Progress, Status, plan};
use slewkit_files::spec::{self, Format};
use std::time::Instant;

/// A part of a combination: its name in the table, and the text that it adds to a spec.
pub type Part = (&'static str, &'static str);

const REST: &str = "[end]\nattitude = { axis = [1, 2, 3], angle_deg = 60 }\n";
const MOVING: &str =
    "[end]\nattitude = { axis = [1, 2, 3], angle_deg = 60 }\nangular_velocity_deg_s = [0, 0.5, 0.5]\n";
const BORESIGHT: &str = "[end]\npoint = { boresight_body = [0, 0, 1], ra_deg = 0, dec_deg = 30 }\n";
const TARGET: &str = "[end]\npoint = { boresight_body = [0, 0, 1], at = \"turning\", \
    turning_vector = [1, 0, 0.6], turning_rate_deg_s = [0, 0, 0.2] }\n";
const SPIN: &str = "[end]\npoint = { boresight_body = [0, 0, 1], ra_deg = 0, dec_deg = 30 }\n\
    angular_velocity_deg_s = [0, 0, 2]\n";
const RATE: &str = "[end]\nangular_velocity_deg_s = [0, 0, 0]\n";

/// The terminal conditions.
pub const ENDS: [Part; 6] = [
    ("attitude, at rest", REST),
    ("attitude and rate", MOVING),
    ("boresight, roll free", BORESIGHT),
    ("moving target, roll free", TARGET),
    ("boresight and a spin", SPIN),
    ("rate alone", RATE),
];

const AXES: &str =
    "[actuators]\ntorque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ntorque_limit_n_m = 0.5\n";
const WHEELS: &str = "[[actuators.wheel]]\naxis_body = [1, 0, 0]\ntorque_limit_n_m = 0.5\n\
    momentum_limit_n_m_s = 8\n[[actuators.wheel]]\naxis_body = [0, 1, 0]\ntorque_limit_n_m = 0.5\n\
    momentum_limit_n_m_s = 8\n[[actuators.wheel]]\naxis_body = [0, 0, 1]\ntorque_limit_n_m = 0.5\n\
    momentum_limit_n_m_s = 8\n";

const RATES: &str = "torque_rate_limit_n_m_per_s = 0.1\n";

/// The kinds of inputs. Limited torque rates and pulses are combined with limited torques about
/// three axes.
pub const INPUTS: [Part; 8] = [
    ("torque", ""),
    ("limited torques", AXES),
    ("limit of the norm", "[actuators]\ntorque_norm_limit_n_m = 0.5\n"),
    ("limited torque rates", RATES),
    ("wheels", WHEELS),
    ("wheels, limited torque rates", "slow wheels"),
    ("thrusters", "thrusters"),
    ("shortest pulses", "shortest_pulse_s = 1\n"),
];

const CONE: &str = "[[constraint]]\nkind = \"keep_out\"\nboresight_body = [1, 0, 0]\n\
    direction_inertial = { vector = [0.78, 0.45, -0.1] }\nhalf_angle_deg = 12\n";
const RATE_LIMIT: &str = "[[constraint]]\nkind = \"rate_limit\"\nangular_velocity_limit_deg_s = 3\n";

/// The limits of the motion.
pub const LIMITS: [Part; 3] = [("none", ""), ("cone", CONE), ("rate limit", RATE_LIMIT)];

/// The objectives.
pub const OBJECTIVES: [Part; 3] = [
    ("effort", "duration_s = 60\n"),
    ("time", "minimize = \"time\"\n"),
    ("fuel", "minimize = \"fuel\"\nduration_s = 60\n"),
];

/// The number of steps of every plan.
const STEPS: usize = 40;

/// A combination of an end, inputs, limits and an objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Combination {
    pub objective: &'static str,
    pub end: &'static str,
    pub limit: &'static str,
    pub input: &'static str,
}

/// The result of a combination: a plan, or the reason why it is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Became {
    /// The plan is solved and verified, after this elapsed time \[s\].
    Planned(f64),
    /// The spec is refused with this error code.
    Refused(String),
    /// No verified plan was found after this elapsed time \[s\]. The status states why.
    Slow(f64, Status),
}

/// Returns all combinations, in the order of the tables.
pub fn all() -> Vec<Combination> {
    let mut found = Vec::new();
    for (objective, _) in OBJECTIVES {
        for (end, _) in ENDS {
            for (limit, _) in LIMITS {
                found.extend(INPUTS.map(|(input, _)| Combination { objective, end, limit, input }));
            }
        }
    }
    found
}

fn text(of: &str, parts: &[Part]) -> &'static str {
    parts.iter().find(|(name, _)| *name == of).map_or("", |(_, text)| text)
}

impl Combination {
    /// Returns the spec of the combination.
    pub fn spec(&self) -> String {
        let turns = match self.end {
            "rate alone" => "angular_velocity_deg_s = [2, -1, 1]\n",
            "boresight and a spin" => "angular_velocity_deg_s = [0, 0, 2]\n",
            _ => "",
        };
        let input = match text(self.input, &INPUTS) {
            "thrusters" => thrusters(),
            "slow wheels" => format!("[actuators]\n{RATES}{WHEELS}"),
            more if more.starts_with("torque_rate") || more.starts_with("shortest") => {
                format!("{AXES}{more}")
            }
            whole => whole.to_string(),
        };
        format!(
            "format = 1\nepoch = \"2026-11-21T07:00:00 UTC\"\n[body]\ninertia_kg_m2 = [40, 45, 60]\n[start]\n\
                attitude = {{ quaternion_wxyz = [1, 0, 0, 0] }}\n{turns}{}[maneuver]\nsteps = {STEPS}\n{}{input}{}",
            text(self.end, &ENDS),
            text(self.objective, &OBJECTIVES),
            text(self.limit, &LIMITS),
        )
    }

    /// Returns the error code with which the spec is refused; `None` if it is accepted.
    pub fn refused(&self) -> Option<String> {
        let errors = spec::from_str(&self.spec(), "spec.toml", Format::Toml, &[]).err()?;
        errors.0.first().map(|error| error.code.to_string())
    }

    /// Plans the maneuver within `most` seconds of elapsed time.
    pub fn became(&self, most: f64) -> Became {
        if let Some(code) = self.refused() {
            return Became::Refused(code);
        }
        let Ok(loaded) = spec::from_str(&self.spec(), "spec.toml", Format::Toml, &[]) else {
            return Became::Refused(String::new());
        };
        let began = Instant::now();
        let found = plan(&loaded.problem, &loaded.settings, None, &mut Within { began, most });
        let took = began.elapsed().as_secs_f64();
        match found {
            Ok(found) if found.status == Status::Solved => Became::Planned(took),
            Ok(found) => Became::Slow(took, found.status),
            Err(_) => Became::Refused("E0121".into()),
        }
    }
}

/// Writes four pairs of thrusters that together produce torques in every direction.
fn thrusters() -> String {
    let places = [
        ([0.5, 0.0, 0.4], [0, 1, 0]),
        ([0.5, 0.0, -0.4], [0, -1, 0]),
        ([-0.5, 0.0, 0.4], [0, -1, 0]),
        ([-0.5, 0.0, -0.4], [0, 1, 0]),
        ([0.5, 0.3, 0.0], [0, 0, 1]),
        ([0.5, -0.3, 0.0], [0, 0, -1]),
        ([-0.5, 0.3, 0.0], [0, 0, -1]),
        ([-0.5, -0.3, 0.0], [0, 0, 1]),
    ];
    let thruster = |(place, force): ([f64; 3], [i32; 3])| {
        format!(
            "[[actuators.thruster]]\nposition_m = {place:?}\nforce_direction_body = {force:?}\nforce_limit_n = 1\n"
        )
    };
    places.map(thruster).concat()
}

/// An observer that stops the search after a time.
struct Within {
    began: Instant,
    most: f64,
}

impl Observer for Within {
    fn on_progress(&mut self, _: &Progress) -> Control {
        if self.began.elapsed().as_secs_f64() > self.most { Control::Stop } else { Control::Continue }
    }
}

/// Returns the cell of a combination in the tables of `docs/combinations.md`.
pub fn cell(page: &str, of: Combination) -> Option<String> {
    let section = page.split("\n## ").find(|part| part.to_lowercase().starts_with(of.objective))?;
    let rows = section.lines().filter(|line| line.starts_with("| "));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect();
    let mut rows = rows.map(cells).collect::<Vec<Vec<String>>>().into_iter();
    let column = rows.next()?.iter().position(|name| name == of.input)?;
    rows.find(|row| row[..2] == [of.end, of.limit])?.get(column).cloned()
}
