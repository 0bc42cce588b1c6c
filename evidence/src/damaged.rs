//! Plan files in which one figure is damaged, in twelve ways.

use crate::Random;
use serde_json::{Map, Value, json};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::exchange::Tables;
use slewkit_files::export::PlanFile;
use slewkit_files::formats::Format as DataFormat;
use slewkit_files::spec::{self, Format, Loaded};
use slewkit_report::plan_page;
use std::error::Error;

/// A kind of damage to a plan file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Damage {
    /// A torque or an input is multiplied by 1.02 to 2.
    Torque,
    /// A time is moved behind the next one, or to the previous one.
    Time,
    /// A component of a quaternion is changed, or a quaternion in the middle is negated.
    Attitude,
    /// All attitudes, or all rates, are replaced by the values of one node.
    Constant,
    /// A component of a rate is changed.
    Rate,
    /// A costate, a multiplier or a gain is changed.
    Costate,
    /// The cost or the duration is changed.
    Cost,
    /// A stored momentum of a wheel is changed.
    Momentum,
    /// A figure is replaced by 1e300, or by `null`, which stands for a number that is not finite.
    NotFinite,
    /// A row is removed from one column or from all columns, or the number of steps is changed.
    Rows,
    /// A claim of the search is changed: the conjugate points, the gap, the rivals or the
    /// covariances.
    Claim,
    /// A figure of the spec in the plan file is changed.
    Spec,
}

/// All kinds of damage.
pub const DAMAGES: [Damage; 12] = [
    Damage::Torque,
    Damage::Time,
    Damage::Attitude,
    Damage::Constant,
    Damage::Rate,
    Damage::Costate,
    Damage::Cost,
    Damage::Momentum,
    Damage::NotFinite,
    Damage::Rows,
    Damage::Claim,
    Damage::Spec,
];

const HEAD: &str = "format = 1\nname = \"damaged\"\n[body]\ninertia_kg_m2 = [[120, 4, -3], [4, 100, 2], \
    [-3, 2, 80]]\n[start]\nattitude = { axis = [0, 0, 1], angle_deg = 10 }\n[end]\nattitude = { \
    euler_zyx_deg = [80, -25, 40] }\n";
const TORQUES: &str = "[actuators]\ntorque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n\
    torque_limit_n_m = 0.2\n";

/// Returns one spec for each kind of plan file.
fn specs() -> [String; 6] {
    let flown = "[feedback]\nkind = \"tvlqr\"\n[uncertainty]\ninertia.relative = 0.02\n";
    [
        format!("{HEAD}[maneuver]\nduration_s = 60\nsteps = 12\n"),
        format!("{HEAD}[maneuver]\nduration_s = 60\nsteps = 12\n{flown}"),
        format!("{HEAD}[maneuver]\nminimize = \"time\"\nsteps = 20\n{TORQUES}"),
        format!("{HEAD}[maneuver]\nminimize = \"fuel\"\nduration_s = 80\nsteps = 20\n{TORQUES}"),
        format!(
            "{HEAD}[maneuver]\nduration_s = 60\nsteps = 12\n[[constraint]]\nkind = \"keep_out\"\n\
                boresight_body = [1, 0, 0]\ndirection_inertial = {{ ra_deg = 50, dec_deg = 15 }}\n\
                half_angle_deg = 20\n"
        ),
        format!(
            "{HEAD}[maneuver]\nduration_s = 60\nsteps = 12\n[[actuators.wheel]]\naxis_body = [1, 0, 0]\n\
                torque_limit_n_m = 0.5\nmomentum_limit_n_m_s = 20\n[[actuators.wheel]]\n\
                axis_body = [0, 1, 0]\ntorque_limit_n_m = 0.5\n[[actuators.wheel]]\n\
                axis_body = [0, 0, 1]\ntorque_limit_n_m = 0.5\nmomentum_n_m_s = 1\n"
        ),
    ]
}

/// Undamaged plan files, one of each kind.
pub struct Files(Vec<Value>);

impl Files {
    /// Plans the maneuvers and builds their plan files.
    ///
    /// # Errors
    /// Returns an error if a spec or a plan fails.
    pub fn new() -> Result<Self, Box<dyn Error>> {
        let mut files = Vec::new();
        for text in specs() {
            let loaded = spec::from_str(&text, "spec.toml", Format::Toml, &[])?;
            let Loaded { problem, settings, identity, closed_loop, .. } = &loaded;
            let made = plan(problem, settings, None, &mut Silent)?;
            if made.status != Status::Solved {
                return Err(format!("no plan: {:?}\n{text}", made.status).into());
            }
            let on_grid = made.solution.on_grid(problem);
            let beside = slewkit::assured::Beside::along(
                &on_grid,
                &made.solution.trajectory,
                closed_loop.feedback,
                closed_loop.uncertainty.as_ref(),
            )?;
            let file = PlanFile::new(problem, settings, &made).with_identity(identity);
            let file = file.with_beside(&on_grid, Some(&beside), closed_loop, None);
            let mut bytes = Vec::new();
            file.write(&mut bytes)?;
            files.push(serde_json::from_slice(&bytes)?);
        }
        Ok(Self(files))
    }

    /// Returns all files.
    pub fn all(&self) -> &[Value] {
        &self.0
    }

    /// Returns a damaged file, and a text with the place and the value of the damage.
    pub fn damaged(&self, damage: Damage, random: &mut Random) -> (Value, String) {
        loop {
            let mut file = self.0[random.below(self.0.len())].clone();
            if let Some(what) = harm(&mut file, damage, random) {
                return (file, what);
            }
        }
    }
}

/// Damages a file and describes the damage; `None` if the file has no value that can be damaged in
/// this way.
fn harm(file: &mut Value, damage: Damage, random: &mut Random) -> Option<String> {
    match damage {
        Damage::Torque => {
            let key = random.pick(&["torque_n_m", "input"]);
            let places = figures(file, &["trajectory", key], |value| value.abs() > 1e-6);
            change(file, &places, random, |random, value| value * (1.02 + random.unit()))
        }
        Damage::Time => {
            let times = file["trajectory"]["time_s"].as_array()?.clone();
            let index = 1 + random.below(times.len() - 2);
            let to = if random.coin() {
                times[index - 1].clone()
            } else {
                json!(times[index + 1].as_f64()? * 1.01)
            };
            file["trajectory"]["time_s"][index] = to;
            Some(format!("time {index}"))
        }
        Damage::Attitude if random.coin() => {
            let places = figures(file, &["trajectory", "quaternion_wxyz"], |_| true);
            change(file, &places, random, |random, value| value + 1e-3 * (1.0 + random.unit()))
        }
        Damage::Attitude => {
            let rows = file["trajectory"]["quaternion_wxyz"].as_array_mut()?;
            let index = 1 + random.below(rows.len() - 2);
            for part in rows[index].as_array_mut()? {
                *part = json!(-part.as_f64()?);
            }
            Some(format!("quaternion {index} negated"))
        }
        Damage::Constant => {
            let key = random.pick(&["quaternion_wxyz", "angular_velocity_rad_s"]);
            let rows = file["trajectory"][key].as_array_mut()?;
            let one = rows[random.below(rows.len())].clone();
            rows.fill(one);
            Some(format!("{key} constant"))
        }
        Damage::Rate => {
            let places = figures(file, &["trajectory", "angular_velocity_rad_s"], |_| true);
            change(file, &places, random, |random, value| value + 1e-3 * (1.0 + random.unit()))
        }
        Damage::Costate => {
            let keys = ["trajectory", "costates_0", "feedback", "active"];
            let key = random.pick(&keys);
            let mut places = figures(file, &[key], |value| value.abs() > 1e-6);
            places.retain(|path| key != "trajectory" || path.contains("/costates/"));
            change(file, &places, random, |random, value| value * (1.02 + random.unit()))
        }
        Damage::Cost => {
            let key = random.pick(&["cost", "duration_s"]);
            change(file, &[format!("/{key}")], random, |random, value| value * (1.001 + random.unit()))
        }
        Damage::Momentum => {
            let places = figures(file, &["trajectory", "wheel_momentum_n_m_s"], |_| true);
            change(file, &places, random, |random, value| value + 1e-2 * (1.0 + random.unit()))
        }
        Damage::NotFinite => {
            let key = random.pick(&["trajectory", "verified", "cost", "duration_s", "step_s", "terminal"]);
            let places = figures(file, &[key], |_| true);
            let place = &places[random.below(places.len())];
            let to = if random.coin() { json!(1e300) } else { Value::Null };
            *file.pointer_mut(place)? = to.clone();
            Some(format!("{place} = {to}"))
        }
        Damage::Rows => rows(file, random),
        Damage::Claim => {
            let keys = ["optimality", "switching", "rivals", "uncertainty", "verified", "ladder"];
            let places = figures(file, &[random.pick(&keys)], |_| true);
            change(file, &places, random, |random, value| value * (1.02 + random.unit()) + 1e-3)
        }
        Damage::Spec => {
            let keys = ["body", "start", "end", "actuators", "constraint", "maneuver"];
            let mut places = figures(file, &["spec", random.pick(&keys)], |value| value != 0.0);
            places.retain(|path| !path.ends_with("steps"));
            change(file, &places, random, |random, value| value * (1.02 + random.unit()))
        }
    }
}

/// Removes a row, or changes the number of steps.
fn rows(file: &mut Value, random: &mut Random) -> Option<String> {
    let keys: Vec<String> = file["trajectory"].as_object()?.keys().cloned().collect();
    match random.below(3) {
        0 => {
            let key = &keys[random.below(keys.len())];
            let list = file["trajectory"][key].as_array_mut()?;
            let index = random.below(list.len());
            list.remove(index);
            Some(format!("{key} without row {index}"))
        }
        1 => {
            let index = 1 + random.below(file["steps"].as_u64()? as usize - 1);
            for key in &keys {
                if let Some(list) = file["trajectory"][key].as_array_mut() {
                    list.remove(index);
                }
            }
            let steps = json!(file["steps"].as_u64()? - 1);
            file["steps"] = steps.clone();
            file["spec"]["maneuver"]["steps"] = steps;
            Some(format!("without row {index}"))
        }
        _ => {
            let steps = file["steps"].as_u64()?;
            let to = if random.coin() { steps + 1 } else { steps - 1 };
            file["steps"] = json!(to);
            Some(format!("steps = {to}"))
        }
    }
}

/// Changes a figure at one of the given places and describes the change.
fn change(
    file: &mut Value,
    places: &[String],
    random: &mut Random,
    to: impl Fn(&mut Random, f64) -> f64,
) -> Option<String> {
    if places.is_empty() {
        return None;
    }
    let place = &places[random.below(places.len())];
    let figure = file.pointer_mut(place)?;
    let was = figure.as_f64()?;
    let is = to(random, was);
    // A whole number stays a whole number.
    *figure = if figure.is_f64() { json!(is) } else { json!(is.ceil() as i64 + 1) };
    Some(format!("{place}: {was} is {figure}"))
}

/// Returns the JSON pointers of all figures below a key that satisfy a condition.
fn figures(file: &Value, at: &[&str], wanted: impl Fn(f64) -> bool + Copy) -> Vec<String> {
    fn below(value: &Value, at: &str, wanted: impl Fn(f64) -> bool + Copy, found: &mut Vec<String>) {
        match value {
            Value::Number(number) if number.as_f64().is_some_and(wanted) => found.push(at.into()),
            Value::Array(list) => {
                for (index, value) in list.iter().enumerate() {
                    below(value, &format!("{at}/{index}"), wanted, found);
                }
            }
            Value::Object(map) => {
                let map: &Map<String, Value> = map;
                map.iter().for_each(|(key, value)| below(value, &format!("{at}/{key}"), wanted, found));
            }
            _ => {}
        }
    }
    let at: String = at.iter().map(|key| format!("/{key}")).collect();
    let mut found = Vec::new();
    if let Some(value) = file.pointer(&at) {
        below(value, &at, wanted, &mut found);
    }
    found
}

/// The commands that report a plan file as verified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Called {
    pub verify: bool,
    pub report: bool,
    pub export: bool,
}

impl Called {
    /// Returns whether any command reports the file as verified.
    pub fn verified(self) -> bool {
        self.verify || self.report || self.export
    }
}

/// Returns which of `slew verify`, `slew report` and `slew export` report the file as verified.
/// None of them does if they refuse to read it.
pub fn called(file: &Value) -> Called {
    let read = || -> Option<Called> {
        let bytes = serde_json::to_vec(file).ok()?;
        let file = PlanFile::read(&bytes[..]).ok()?;
        let mut own = file.spec.as_ref()?.read("plan", &[]).ok()?;
        let judged = file.judge(&own.problem, &own.settings, &own.identity, &own.closed_loop, &|| false);
        let verify = judged.is_ok_and(|found| found.verification.passed());
        let (file, _) = file.settled(&own);
        own.problem = file.on_grid(&own.problem).ok()?;
        let mut text = Vec::new();
        let written =
            DataFormat::Json.write(&file, &own.problem, &own.identity, Tables::default(), &mut text);
        let written = written.ok().and_then(|()| serde_json::from_slice::<Value>(&text).ok());
        let export = written.is_some_and(|written| written["status"] == "solved");
        let report = file.plan().is_ok_and(|plan| {
            let flown = (&own.closed_loop, None);
            let page = plan_page(&own.problem, &own.settings, &plan, &own.identity, flown, "zyx");
            page.contains("solved and verified")
        });
        Some(Called { verify, report, export })
    };
    read().unwrap_or_default()
}
