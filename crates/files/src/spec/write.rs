//! Writing of a maneuver and its settings with the keys of specs.
//!
//! The output reads back to the same numbers, bit for bit. It uses SI units, radians and rotation
//! matrices. It contains `rounding = "keep"`, so that matrices and unit vectors are not corrected a
//! second time. The keys and their order are those of the key tables, which the reader also uses.
//!
//! # Why are specs written, and what is the purpose of `rounding = "keep"`?
//!
//! A plan file contains the maneuver in the notation of specs, so that `slew verify plan.json`
//! needs no other file. The writer uses the key tables of the reader, and chooses notations that
//! read back to the same bits: radians and matrices. The reader corrects attitudes to exact
//! rotations and axes to exact unit vectors, which would change rounded values again; with
//! `rounding = "keep"` it uses the numbers unchanged. A spec cannot express a force field that a
//! caller of the library defines. In this case `spec` is null in the plan file, and `verify` needs
//! the original maneuver.

use super::closed_loop::ClosedLoop;
use super::difference::{Difference, differences};
use super::keys::{Kind, ROOT, Table};
use super::{Diagnostics, Format, Loaded, LoadedSequence, Override, Spec, Wanted, interpret};
use crate::identity::{Identity, Nozzle};
use crate::scenery::Scenery;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};
use slewkit::maneuver::{
    Aim, AimRate, Constraint, Direction, Duration, Motion, Path, Problem, Roll, Rule, Settings, Side, State,
    Weighted,
};
use slewkit::mechanics::direction::Track;
use slewkit::mechanics::{AxisFrame, Description, Thrusters, Wheels};
use slewkit::sequence::order::Visit;
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Matrix3, Vector3};
use thiserror::Error;

/// The spec of a maneuver as a JSON value. It has all contents of [`Problem`] and [`Settings`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct SpecDocument(Value);

/// Part of a problem that no spec can express, although the library can plan it.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("a spec has no notation for {0}")]
pub struct Unwritable(&'static str);

impl SpecDocument {
    /// Creates the spec of a maneuver and of its solver settings.
    ///
    /// # Errors
    /// Returns the part that a spec cannot express, such as an environment that the caller defines.
    pub fn new(problem: &Problem, settings: &Settings) -> Result<Self, Unwritable> {
        let moves = problem.motion == Motion::RigidBody;
        let mut spec = Writing::new(&ROOT);
        spec.put("format", 1);
        spec.put("name", problem.name.as_str());
        spec.put("rounding", "keep");
        spec.table("body", |body| {
            body.put("inertia_kg_m2", symmetric(problem.body.inertia.j().as_slice(), 3));
            body.some("mass_kg", problem.body.mass.filter(|_| moves));
        });
        spec.table("start", |start| boundary(start, &problem.start, moves, true));
        match problem.aim() {
            None => {
                let given = !problem.ends_in_any_attitude();
                spec.table("end", |end| boundary(end, &problem.end, moves, given));
            }
            Some(aim) => {
                writable(aim)?;
                spec.table("end", |end| {
                    end.some("position_m", moves.then(|| row(&problem.end.position)));
                    end.some("velocity_m_s", moves.then(|| row(&problem.end.velocity)));
                    self::aim(end, aim);
                    end.put("rate", if aim.rate == AimRate::Zero { "zero" } else { "matched" });
                    end.some("roll_rate_deg_s", (aim.roll_rate != 0.0).then(|| aim.roll_rate.to_degrees()));
                });
            }
        }
        let path = match &problem.path {
            Path::Best => "best",
            Path::Shortest => "shortest",
            Path::Long => "long",
            Path::AsGiven(turn) => {
                spec.table("end", |end| end.put("rotation_from_start_rad", row(turn)));
                "as_given"
            }
        };
        spec.table("maneuver", |maneuver| {
            maneuver.put("minimize", problem.objective.name());
            let given = if let Duration::Given(duration) = problem.duration { Some(duration) } else { None };
            maneuver.some("duration_s", given);
            maneuver.some("duration_at_most_s", problem.duration.at_most());
            maneuver.some("time_price_per_s", problem.objective.given_time_price());
            maneuver.some("steps", (!problem.chooses_steps).then_some(problem.steps));
            maneuver.put("path", path);
        });
        spec.table("solver", |solver| {
            solver.put("method", settings.method.name());
            solver.put("search", settings.search.name());
            solver.put("scheme", problem.scheme.name());
            solver.put("tolerance", settings.tolerance);
            solver.put("target", settings.target.name());
            solver.some("continuous_tolerance_rad", settings.continuous_tolerance);
            solver.some("time_limit_s", settings.time_limit.map(|limit| limit.as_secs_f64()));
            solver.put("max_iterations", settings.max_iterations);
            solver.some("second_order", (!settings.test_second_order).then_some("skipped"));
        });
        actuators(&mut spec, problem, moves)?;
        environment(&mut spec, problem)?;
        for constraint in &problem.constraints {
            spec.item("constraint", |item| {
                self::constraint(item, constraint, problem.reserve.rate(&constraint.name))
            });
        }
        for of in &problem.alternatives {
            spec.item("any_of", |item| {
                item.put("name", of.name.as_str());
                of.sets.iter().for_each(|set| item.item("set", |item| item.put("constraints", set.clone())));
            });
        }
        Ok(Self(Value::Object(spec.keys)))
    }

    /// Creates the spec of a sequence and of its solver settings.
    ///
    /// # Errors
    /// Returns the part that a spec cannot express.
    pub fn of_sequence(sequence: &Sequence, settings: &Settings) -> Result<Self, Unwritable> {
        let Self(Value::Object(mut keys)) = Self::new(&sequence.craft, settings)? else {
            return Err(Unwritable("a spec that is not a table"));
        };
        keys.remove("end");
        let mut spec = Writing { table: &ROOT, keys };
        for stop in &sequence.stops {
            if let Place::Aim(aim) = &stop.place {
                writable(aim)?;
            }
            spec.item("stop", |item| self::stop(item, stop));
        }
        spec.table("maneuver", |maneuver| {
            maneuver.keys.remove("path");
            maneuver.put("order", if sequence.order == Ordering::Given { "given" } else { "free" });
            let last = sequence.stops.last().filter(|_| sequence.order == Ordering::FreeBeforeLast);
            maneuver.some("last", last.map(|stop| stop.name.as_str()));
        });
        Ok(Self(Value::Object(spec.keys)))
    }

    /// Adds the names and the epoch of the maneuver.
    pub fn with_identity(self, identity: &Identity) -> Self {
        let Self(Value::Object(keys)) = self else { return self };
        let mut spec = Writing { table: &ROOT, keys };
        spec.some("epoch", identity.epoch.map(|epoch| epoch.to_string()));
        let texts = [
            ("object", &identity.object),
            ("object_id", &identity.object_id),
            ("center", &identity.center),
            ("reference_frame", &identity.reference_frame),
            ("body_frame", &identity.body_frame),
            ("originator", &identity.originator),
        ];
        for (name, text) in texts {
            if let Some(text) = text {
                spec.table("names", |names| names.put(name, text.as_str()));
            }
        }
        if let Some(number) = identity.spice_id {
            spec.table("names", |names| names.put("spice_id", number));
        }
        if !identity.inputs.is_empty() {
            spec.table("names", |names| names.put("inputs", identity.inputs.clone()));
        }
        if let Some(scenery) = &identity.scenery {
            spec.table("scenery", |table| self::scenery(table, scenery));
        }
        spec.by_force(&identity.nozzles);
        spec.with_boresights(identity);
        Self(Value::Object(spec.keys))
    }

    /// Adds the sections for simulated flights of the plan, as the user wrote them.
    pub fn with_closed_loop(self, closed_loop: &ClosedLoop) -> Self {
        let Self(Value::Object(mut keys)) = self else { return self };
        for (name, section) in closed_loop.written() {
            keys.insert(name.clone(), section.clone());
        }
        if let Some(Value::Array(constraints)) = keys.get_mut("constraint") {
            for constraint in constraints {
                let name = constraint.get("name").and_then(Value::as_str).map(String::from);
                let chance = name.and_then(|name| closed_loop.asked(&name));
                if let (Some(chance), Some(constraint)) = (chance, constraint.as_object_mut()) {
                    constraint.insert("chance".into(), chance.at_most.into());
                    if chance.of_motion {
                        constraint.insert("chance_over".into(), "motion".into());
                    }
                }
            }
        }
        for (chance, key) in closed_loop.chances.iter().filter_map(|chance| Some((chance, chance.key?))) {
            if let Some(Value::Object(actuators)) = keys.get_mut("actuators") {
                actuators.insert(key.into(), chance.at_most.into());
                if chance.of_motion {
                    actuators.insert("chance_over".into(), "motion".into());
                }
            }
        }
        Self(Value::Object(keys))
    }

    /// Reads the maneuver that the spec describes; `name` is the name of the spec in messages.
    ///
    /// # Errors
    /// Returns all errors and warnings of the spec, in the order of the spec.
    pub fn read(&self, name: &str, overrides: &[Override]) -> Result<Loaded, Diagnostics> {
        let folder = std::path::Path::new("");
        match interpret(&self.to_string(), name, folder, Format::Json, overrides, Wanted::Maneuver)? {
            Spec::Maneuver(loaded) => Ok(*loaded),
            // Unreachable: `interpret` rejects sequences and simulations if only a maneuver is
            // accepted.
            Spec::Sequence(_) | Spec::Simulation(_) => Err(Diagnostics(Vec::new())),
        }
    }

    /// Reads the sequence that the spec describes; `name` is the name of the spec in messages.
    /// Returns `None` if the spec has no stops.
    ///
    /// # Errors
    /// Returns all errors and warnings of the spec, in the order of the spec.
    pub fn read_sequence(
        &self,
        name: &str,
        overrides: &[Override],
    ) -> Result<Option<LoadedSequence>, Diagnostics> {
        let folder = std::path::Path::new("");
        Ok(match interpret(&self.to_string(), name, folder, Format::Json, overrides, Wanted::Any)? {
            Spec::Sequence(loaded) => Some(*loaded),
            Spec::Maneuver(_) | Spec::Simulation(_) => None,
        })
    }

    /// Returns whether a key can affect a plan. Names and the epoch cannot.
    pub(crate) fn is_asked(key: &str) -> bool {
        let section = key.split('.').next().unwrap_or_default();
        key != "epoch"
            && !["names", "scenery", "feedback", "uncertainty", "plant"].contains(&section)
            && !key.ends_with("chance")
            && !key.ends_with(".chance_over")
    }

    /// Returns the keys whose values in the two specs differ by more than round-off, with both
    /// values. The name and the grid (`maneuver.steps` and `solver.scheme`) are not compared.
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let mut found = differences(&self.0, &other.0);
        found.retain(|found| !["name", "maneuver.steps", "solver.scheme"].contains(&found.key.as_str()));
        found
    }
}

/// Writes the spec as JSON, which is one of the formats of spec files.
impl std::fmt::Display for SpecDocument {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&serde_json::to_string_pretty(self).map_err(|_| std::fmt::Error)?)
    }
}

impl Serialize for SpecDocument {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        InOrder(&self.0, Some(&ROOT)).serialize(serializer)
    }
}

/// A JSON value whose tables are serialised with the keys in the order of the key tables.
struct InOrder<'a>(&'a Value, Option<&'static Table>);

impl Serialize for InOrder<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (self.0, self.1) {
            (Value::Object(keys), Some(table)) => {
                let mut entries: Vec<_> = keys.iter().collect();
                entries.sort_by_key(|(name, _)| table.keys.iter().position(|key| key.name == **name));
                let inner = |name: &str| table.key(name).and_then(|key| key.kind.table());
                serializer
                    .collect_map(entries.into_iter().map(|(name, value)| (name, InOrder(value, inner(name)))))
            }
            (Value::Array(items), Some(table)) => {
                serializer.collect_seq(items.iter().map(|item| InOrder(item, Some(table))))
            }
            (value, _) => value.serialize(serializer),
        }
    }
}

/// A table of the spec that is being written.
struct Writing {
    table: &'static Table,
    keys: Map<String, Value>,
}

impl Writing {
    fn new(table: &'static Table) -> Self {
        Self { table, keys: Map::new() }
    }

    /// Returns the kind of the key `name`. If the key is not in the tables, this module has a bug.
    fn kind(&self, name: &str) -> Option<Kind> {
        let key = self.table.key(name);
        debug_assert!(key.is_some(), "no key {name} to write");
        key.map(|key| key.kind)
    }

    fn put(&mut self, name: &str, value: impl Into<Value>) {
        if self.kind(name).is_some() {
            self.keys.insert(name.into(), value.into());
        }
    }

    fn some(&mut self, name: &str, value: Option<impl Into<Value>>) {
        if let Some(value) = value {
            self.put(name, value);
        }
    }

    /// Calls `write` on the table `name`, which is created if it does not exist.
    fn table(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let Some(table) = self.kind(name).and_then(Kind::table) else { return };
        let keys = match self.keys.remove(name) {
            Some(Value::Object(keys)) => keys,
            _ => Map::new(),
        };
        let mut inner = Self { table, keys };
        write(&mut inner);
        self.keys.insert(name.into(), inner.keys.into());
    }

    /// Replaces the thrusters, which are defined by their torques, by the thrusters of the original
    /// spec, which are defined by position and force.
    fn by_force(&mut self, nozzles: &[Nozzle]) {
        let all = self.keys.get("actuators").and_then(|actuators| actuators.get("thruster"));
        let Some(all) =
            all.and_then(Value::as_array).filter(|all| !all.is_empty() && all.len() == nozzles.len())
        else {
            return;
        };
        let priced = all[0].get("fuel_price").is_some();
        self.table("actuators", |actuators| {
            actuators.keys.remove("thruster");
            for nozzle in nozzles {
                actuators.item("thruster", |thruster| {
                    thruster.put("position_m", row(&nozzle.position));
                    thruster.put("force_direction_body", row(&nozzle.direction));
                    thruster.put("force_limit_n", nozzle.force_limit);
                    thruster.some("fuel_price", priced.then_some(nozzle.price));
                });
            }
        });
    }

    /// Adds the names of the boresights to the constraints, the end and the stops.
    fn with_boresights(&mut self, identity: &Identity) {
        let vector = |value: &Value| {
            let row: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
            row.filter(|row| row.len() == 3).map(|row| Vector3::from_column_slice(&row))
        };
        let named = |table: &mut Map<String, Value>| {
            let boresights = table.get("boresight_body");
            let one = boresights.and_then(vector).map(|one| vec![one]);
            let all = one.or_else(|| boresights?.as_array()?.iter().map(vector).collect());
            if let Some(name) = all.and_then(|all| identity.boresights(&all)) {
                table.insert("boresight_name".into(), name.into());
            }
        };
        let constraints = self.keys.get_mut("constraint").and_then(Value::as_array_mut);
        constraints.into_iter().flatten().filter_map(Value::as_object_mut).for_each(named);
        let point = self.keys.get_mut("end").and_then(|end| end.get_mut("point"));
        point.and_then(Value::as_object_mut).into_iter().for_each(named);
        let stops = self.keys.get_mut("stop").and_then(Value::as_array_mut);
        let points = stops.into_iter().flatten().filter_map(|stop| stop.get_mut("point"));
        points.filter_map(Value::as_object_mut).for_each(named);
    }

    /// Appends a table to the list `name`.
    fn item(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let Some(table) = self.kind(name).and_then(Kind::table) else { return };
        let mut inner = Self::new(table);
        write(&mut inner);
        if let Value::Array(items) = self.keys.entry(name).or_insert_with(|| Value::Array(Vec::new())) {
            items.push(inner.keys.into());
        }
    }
}

fn row(vector: &Vector3) -> Value {
    vector.as_slice().into()
}

fn rows<'a>(vectors: impl IntoIterator<Item = &'a Vector3>) -> Vec<Value> {
    vectors.into_iter().map(row).collect()
}

/// Converts a symmetric matrix with `count` columns to its diagonal if it is diagonal, otherwise to
/// a list of rows.
fn symmetric(matrix: &[f64], count: usize) -> Value {
    let off = |index: &usize| index / count != index % count;
    let is_zero = |index: usize| matrix[index].to_bits() == 0;
    if (0..matrix.len()).filter(off).all(is_zero) {
        return matrix.iter().step_by(count + 1).copied().collect();
    }
    let row = |row: usize| -> Value { matrix.iter().skip(row).step_by(count).copied().collect() };
    (0..count).map(row).collect()
}

fn boundary(table: &mut Writing, state: &State, moves: bool, has_attitude: bool) {
    if has_attitude {
        table.table("attitude", |attitude| attitude.put("matrix", rows_of(&state.attitude)));
    }
    table.put("angular_velocity_rad_s", row(&state.angular_velocity));
    table.some("position_m", moves.then(|| row(&state.position)));
    table.some("velocity_m_s", moves.then(|| row(&state.velocity)));
}

/// Checks that a spec can express the targets to which an end or a stop points.
fn writable(aim: &Aim) -> Result<(), Unwritable> {
    let targets = match &aim.roll {
        Roll::Free => vec![&aim.at],
        Roll::Towards { at, .. } => vec![&aim.at, at],
    };
    if targets.into_iter().any(|at| matches!(at, Direction::InFrame(_))) {
        return Err(Unwritable("an end on a direction that turns with the reference frame"));
    }
    Ok(())
}

/// Writes the target and the roll of an end or a stop.
fn aim(end: &mut Writing, aim: &Aim) {
    end.table("point", |point| {
        point.put("boresight_body", row(&aim.boresight));
        target(point, &aim.at);
    });
    if let Roll::Towards { axis, at, within } = &aim.roll {
        end.table("second", |second| {
            second.put("axis_body", row(axis));
            second.put("roll_within_deg", within.to_degrees());
            target(second, at);
        });
    }
}

fn stop(item: &mut Writing, stop: &Stop) {
    item.put("name", stop.name.as_str());
    match &stop.place {
        Place::Attitude(matrix) => {
            item.table("attitude", |attitude| attitude.put("matrix", rows_of(matrix)));
        }
        Place::Aim(aim) => self::aim(item, aim),
    }
    let Visit { settling, hold, window: [from, until], pinned } = stop.visit;
    item.some("settling_s", (settling > 0.0).then_some(settling));
    item.some("hold_s", (hold > 0.0).then_some(hold));
    item.some("start_s", pinned.then_some(from));
    item.some("window_s", (!pinned && until.is_finite()).then(|| vec![from, until]));
    item.some("passing", stop.passing.map(|_| true));
    item.some("angular_velocity_limit_rad_s", stop.passing.filter(|fastest| fastest.is_finite()));
}

fn rows_of(matrix: &Matrix3) -> Vec<Value> {
    <[[f64; 3]; 3]>::from(matrix.transpose()).map(Value::from).to_vec()
}

/// Writes a target. A moving target is written as Chebyshev coefficients.
fn target(table: &mut Writing, direction: &Direction) {
    let track = match direction {
        Direction::Fixed(vector) | Direction::InFrame(vector) => return table.put("vector", row(vector)),
        Direction::Moving(track) | Direction::Disc { centre: track, .. } => track,
    };
    table.put("at", "track");
    way(table, track);
    if let Direction::Disc { radius, .. } = direction {
        table.put("disc_radius", *radius);
    }
}

fn way(table: &mut Writing, track: &Track) {
    let (from, piece, pieces) = track.pieces();
    table.put("from_s", from);
    table.put("piece_s", piece);
    table.put("terms", pieces.first().map_or(0, Vec::len));
    table.put("coefficients", rows(pieces.iter().flatten()));
}

fn scenery(table: &mut Writing, scenery: &Scenery) {
    if let Some(track) = &scenery.spacecraft {
        table.table("spacecraft", |inner| way(inner, track));
    }
    table.table("sun", |inner| way(inner, &scenery.sun));
    table.table("moon", |inner| way(inner, &scenery.moon));
    table.put("earth_axes", <[[f64; 3]; 3]>::from(scenery.earth.transpose()).map(Value::from).to_vec());
    if let Some(target) = &scenery.target {
        table.put("target", target.name.as_str());
        table.some("target_unit_m", target.unit_m);
        if let Some([latitude, longitude, height]) = target.station {
            table.put("latitude_deg", latitude);
            table.put("longitude_deg", longitude);
            table.put("height_m", height);
        }
    }
}

fn actuators(spec: &mut Writing, problem: &Problem, moves: bool) -> Result<(), Unwritable> {
    let reserve = &problem.reserve;
    for (name, held) in [
        ("torque_limit_reserve_n_m", &reserve.torque[..]),
        ("torque_norm_limit_reserve_n_m", std::slice::from_ref(&reserve.torque_norm)),
        ("torque_rate_limit_reserve_n_m_per_s", &reserve.torque_rate),
    ] {
        if held.iter().any(|held| *held > 0.0) {
            let one = (held.len() == 1).then(|| held[0].into());
            spec.table("actuators", |table| {
                table.put(name, one.unwrap_or_else(|| Value::from(held.to_vec())))
            });
        }
    }
    let actuation = &problem.of_craft().actuation;
    let weights = problem.objective.weights();
    let (torque, force) = (weights.torque(actuation), weights.force(actuation));
    if force.is_some() && !moves {
        return Err(Unwritable("forces in a maneuver of the attitude alone"));
    }
    if let Some(thrusters) = &problem.actuation.thrusters {
        return pushing_thrusters(spec, problem, thrusters);
    }
    if let Some(wheels) = &problem.actuation.wheels {
        return self::wheels(spec, &torque, wheels);
    }
    if torque.set.limits().one_sided {
        return thrusters(spec, problem);
    }
    spec.table("actuators", |table| {
        let fuel = problem.objective.fuel();
        table.some("fuel_price", fuel.and_then(|fuel| fuel.prices.clone()));
        table.some("shortest_pulse_s", problem.shortest_pulse());
        let axes = match torque.set.frame() {
            AxisFrame::Body => "torque_axes_body",
            AxisFrame::Reference => "torque_axes_reference",
        };
        let limits = ["torque_limit_n_m", "torque_norm_limit_n_m", "torque_rate_limit_n_m_per_s"];
        channel(table, &torque, [axes, "effort_weight"], limits);
        if let Some(force) = &force {
            let axes = match force.set.frame() {
                AxisFrame::Body => "force_axes_body",
                AxisFrame::Reference => "force_axes_reference",
            };
            let limits = ["force_limit_n", "force_norm_limit_n", "force_rate_limit_n_per_s"];
            table.some("force_fuel_price", fuel.and_then(|fuel| fuel.force_prices.clone()));
            channel(table, force, [axes, "force_effort_weight"], limits);
        } else if moves {
            table.put("force_axes_reference", Vec::<Value>::new());
        }
    });
    Ok(())
}

fn channel(table: &mut Writing, inputs: &Weighted, [axes, weight]: [&str; 2], [size, norm, rate]: [&str; 3]) {
    table.put(axes, rows(inputs.set.axes()));
    table.put(weight, symmetric(inputs.weight.as_slice(), inputs.set.count()));
    let limits = inputs.set.limits();
    table.some(size, limits.size.clone());
    table.some(norm, limits.norm);
    table.some(rate, limits.rate.clone());
}

fn thrusters(spec: &mut Writing, problem: &Problem) -> Result<(), Unwritable> {
    let torque = &problem.actuation.torque;
    let limits = torque.limits();
    let other = torque.frame() != AxisFrame::Body || limits.norm.is_some() || limits.rate.is_some();
    let Some(size) = limits.size.as_ref().filter(|_| !other && problem.actuation.force.is_none()) else {
        return Err(Unwritable("thrusters that turn with the frame, or with a limit of their norm or rate"));
    };
    if torque.axes().iter().any(|axis| (axis.norm() - 1.0).abs() > 1e-12) {
        return Err(Unwritable("thrusters whose axes are not of length 1"));
    }
    if let Some(shortest) = limits.shortest_pulse {
        spec.table("actuators", |table| table.put("shortest_pulse_s", shortest));
    }
    for (index, (axis, limit)) in torque.axes().iter().zip(size).enumerate() {
        spec.table("actuators", |table| {
            table.item("thruster", |thruster| {
                thruster.put("torque_axis_body", row(axis));
                thruster.put("torque_limit_n_m", *limit);
                thruster.some("fuel_price", problem.objective.fuel().map(|fuel| fuel.price(index)));
            });
        });
    }
    Ok(())
}

/// Writes the thrusters of a body that also translates.
fn pushing_thrusters(spec: &mut Writing, problem: &Problem, thrusters: &Thrusters) -> Result<(), Unwritable> {
    let force = problem.actuation.force.as_ref().filter(|force| force.limits().one_sided);
    let limits = force.map(|force| (force, force.limits()));
    let Some((force, limits)) = limits.filter(|(_, limits)| limits.norm.is_none() && limits.rate.is_none())
    else {
        return Err(Unwritable(
            "thrusters that push in both directions, or with a limit of their norm or rate",
        ));
    };
    if force.axes().iter().any(|axis| (axis.norm() - 1.0).abs() > 1e-12) {
        return Err(Unwritable("thrusters whose directions are not of length 1"));
    }
    let given = thrusters.positions.iter().zip(force.axes()).zip(limits.size.iter().flatten());
    for (index, ((position, direction), limit)) in given.enumerate() {
        spec.table("actuators", |table| {
            table.item("thruster", |thruster| {
                thruster.put("position_m", row(position));
                thruster.put("force_direction_body", row(direction));
                thruster.put("force_limit_n", *limit);
                thruster.some("fuel_price", problem.objective.fuel().map(|fuel| fuel.force_price(index)));
            });
        });
    }
    Ok(())
}

fn wheels(spec: &mut Writing, inputs: &Weighted, wheels: &Wheels) -> Result<(), Unwritable> {
    let (torque, weight) = (inputs.set, &inputs.weight);
    let limits = torque.limits();
    if torque.frame() != AxisFrame::Body || limits.norm.is_some() {
        return Err(Unwritable("wheels that turn with the frame, or with a limit of their norm"));
    }
    spec.table("actuators", |table| table.some("torque_rate_limit_n_m_per_s", limits.rate.clone()));
    if (0..weight.len()).any(|index| index % (weight.nrows() + 1) != 0 && weight[index] != 0.0) {
        return Err(Unwritable("a weight of wheels that is not diagonal"));
    }
    for (index, axis) in torque.axes().iter().enumerate() {
        spec.table("actuators", |table| {
            table.item("wheel", |wheel| {
                wheel.put("axis_body", row(axis));
                wheel.some("torque_limit_n_m", limits.size.as_ref().map(|size| size[index]));
                let limit = wheels.momentum_limit[index];
                wheel.some("momentum_limit_n_m_s", limit.is_finite().then_some(limit));
                wheel.put("momentum_n_m_s", wheels.momentum[index]);
                wheel.put("effort_weight", weight[(index, index)]);
            });
        });
    }
    Ok(())
}

fn environment(spec: &mut Writing, problem: &Problem) -> Result<(), Unwritable> {
    let (body, moves) = (&problem.body, problem.motion == Motion::RigidBody);
    let of_body = |inertia: &Matrix3, mass: Option<f64>| {
        let same = inertia == body.inertia.j() && (mass.is_none() || mass == body.mass);
        let other = Unwritable("an environment for another inertia or mass than that of the body");
        if same { Ok(()) } else { Err(other) }
    };
    let description = problem.environment.describe();
    let acts_on_orbit = match description {
        Description::Free | Description::Custom => moves,
        Description::CentralGravity { .. } | Description::SecondOrderGravity { .. } => true,
        Description::UniformGravity { .. } | Description::GravityGradient { .. } => false,
    };
    if acts_on_orbit != moves {
        return Err(Unwritable("an environment that does not fit the motion of the body"));
    }
    match description {
        Description::Free => {}
        Description::UniformGravity { mass, gravity, direction, pivot_to_mass_center } => {
            spec.table("environment", |table| {
                table.put("kind", "uniform_gravity");
                table.put("mass_kg", mass);
                table.put("gravity_m_s2", gravity);
                table.put("direction", row(&direction));
                table.put("pivot_to_mass_center_m", row(&pivot_to_mass_center));
            });
        }
        Description::GravityGradient { orbital_rate, inertia } => {
            of_body(&inertia, None)?;
            spec.table("environment", |table| {
                table.put("kind", "gravity_gradient");
                table.put("orbital_rate_rad_s", orbital_rate);
            });
        }
        Description::CentralGravity { gravitational_parameter, points } => {
            spec.table("environment", |table| {
                table.put("kind", "central_gravity");
                table.put("gravitational_parameter_m3_s2", gravitational_parameter);
                table.put("body", "points");
                for (mass, position) in &points {
                    table.item("points", |point| {
                        point.put("mass_kg", *mass);
                        point.put("position_m", row(position));
                    });
                }
            });
        }
        Description::SecondOrderGravity { gravitational_parameter, mass, inertia } => {
            of_body(&inertia, Some(mass))?;
            spec.table("environment", |table| {
                table.put("kind", "central_gravity");
                table.put("gravitational_parameter_m3_s2", gravitational_parameter);
                table.put("body", "second_order");
            });
        }
        Description::Custom => return Err(Unwritable("a custom environment")),
    }
    Ok(())
}

fn constraint(table: &mut Writing, constraint: &Constraint, held: &[f64]) {
    let limit = "angular_velocity_limit_rad_s";
    let pointing = match &constraint.rule {
        Rule::RateNorm(rate) => {
            table.put("kind", "rate_limit");
            table.put(limit, rate + held.first().unwrap_or(&0.0));
            None
        }
        Rule::RateAxes(rates) => {
            table.put("kind", "rate_limit");
            let held = held.iter().chain(std::iter::repeat(&0.0));
            table.put(limit, rates.iter().zip(held).map(|(rate, held)| rate + held).collect::<Vec<_>>());
            None
        }
        Rule::Pointing(pointing) => Some(pointing),
    };
    table.put("name", constraint.name.as_str());
    let Some(pointing) = pointing else {
        match held {
            [] => {}
            [held] => table.put("margin_rad_s", *held),
            _ => table.put("margin_rad_s", held.to_vec()),
        }
        return;
    };
    let kind = match pointing.side {
        Side::KeepOut => "keep_out",
        Side::KeepIn => "keep_in",
        Side::On { .. } => "on_cone",
    };
    table.put("kind", kind);
    table.put("boresight_body", rows(&pointing.boresights));
    for (name, turning) in [("direction_inertial", false), ("direction_reference", true)] {
        for direction in &pointing.directions {
            let vector = match direction {
                Direction::Fixed(vector) if !turning => vector,
                Direction::InFrame(vector) if turning => vector,
                _ => continue,
            };
            table.item(name, |table| table.put("vector", row(vector)));
        }
    }
    for direction in pointing.directions.iter().filter(|direction| direction.constant().is_none()) {
        table.item("direction", |table| target(table, direction));
    }
    table.put("half_angle_rad", pointing.half_angle);
    match pointing.side {
        Side::On { within } => table.put("within_rad", within),
        Side::KeepOut | Side::KeepIn => table.put("margin_rad", pointing.margin),
    }
    if let Some(intervals) = pointing.during.given() {
        table.put("during_s", Value::Array(intervals.iter().map(|pair| pair.as_slice().into()).collect()));
    }
}
