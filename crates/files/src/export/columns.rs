//! The columns of a trajectory. Plan files, JSON lines, tables and checks use the same columns.

use crate::identity::{Identity, Nozzle};
use serde::{Serialize, Serializer};
use slewkit::Vector3;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::mechanics::ActuatorSet;

/// Reason why a trajectory cannot be written, or is rejected when it is read.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum TrajectoryError {
    /// A number of the trajectory is NaN or infinite.
    #[error("{key} of the trajectory is not finite in row {row}")]
    NotFinite {
        /// Key of the quantity in the file.
        key: &'static str,
        /// Index of the row, counted from 0.
        row: usize,
    },
    /// An array has a length that does not fit the maneuver.
    #[error("{key} of the trajectory has {found} {of}, the maneuver needs {needed}")]
    Shape {
        /// Key of the quantity in the file.
        key: &'static str,
        /// Unit of the counts: "rows" or "numbers in a row".
        of: &'static str,
        /// Number of values in the file.
        found: usize,
        /// Number of values that the maneuver requires.
        needed: usize,
    },
}

/// Values of one quantity of a trajectory, with one row for each node or step.
#[derive(Clone, Copy)]
pub(super) enum Values<'a> {
    Numbers(&'a [f64]),
    Quaternions(&'a [[f64; 4]]),
    Vectors(&'a [Vector3]),
    /// All rows in one slice; the number is the length of a row.
    Flat(&'a [f64], usize),
}

impl<'a> Values<'a> {
    /// Returns the number of rows.
    pub fn len(self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Quaternions(values) => values.len(),
            Self::Vectors(values) => values.len(),
            Self::Flat(values, width) => values.len() / width.max(1),
        }
    }

    /// Returns row `index`; `None` if the row does not exist or is empty.
    pub fn row(self, index: usize) -> Option<&'a [f64]> {
        match self {
            Self::Numbers(values) => values.get(index).map(std::slice::from_ref),
            Self::Quaternions(values) => values.get(index).map(<[f64; 4]>::as_slice),
            Self::Vectors(values) => values.get(index).map(Vector3::as_slice),
            Self::Flat(values, width) => {
                values.get(index * width..(index + 1) * width).filter(|row| !row.is_empty())
            }
        }
    }

    /// Returns the index of the first row that contains a number that is not finite.
    fn first_not_finite(self) -> Option<usize> {
        let is_wrong = |value: &f64| !value.is_finite();
        match self {
            // An incomplete last row also counts as a row.
            Self::Flat(values, width) => values.iter().position(is_wrong).map(|at| at / width.max(1)),
            _ => (0..self.len()).find(|row| self.row(*row).is_some_and(|row| row.iter().any(is_wrong))),
        }
    }
}

/// Serialises the values as a list of numbers or as a list of rows.
impl Serialize for Values<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Numbers(values) => values.serialize(serializer),
            Self::Quaternions(values) => serializer.collect_seq(values),
            Self::Vectors(values) => serializer.collect_seq(values.iter().map(Vector3::as_slice)),
            Self::Flat(values, width) => serializer.collect_seq(values.chunks(width.max(1))),
        }
    }
}

/// A quantity of a trajectory, with its key and its columns.
#[derive(Clone, Copy)]
pub(super) struct Column<'a> {
    /// Key of the quantity in JSON.
    pub key: &'static str,
    /// Column heading in a table, in which `{}` is replaced by the name of the component.
    pub header: &'static str,
    pub values: Values<'a>,
    /// Number of columns in a table; 0 if tables do not contain the quantity.
    pub width: usize,
    /// True if JSON documents contain the quantity.
    pub shown: bool,
    /// True if the quantity has one row for each input row, false if it has one row for each node.
    pub of_input: bool,
}

impl Column<'_> {
    /// Returns the column headings in a table; `names` contains the names of inputs and wheels.
    pub fn headers(&self, names: &Names<'_>) -> Vec<String> {
        let component = |index: usize| match (self.key, self.values) {
            ("input", _) => names.input(index),
            ("wheel_momentum_n_m_s", _) => names.wheel(index),
            ("costates", _) => costate(self.width, index),
            (_, Values::Quaternions(_)) => ["w", "x", "y", "z"][index].to_string(),
            (_, Values::Vectors(_)) => ["x", "y", "z"][index].to_string(),
            (_, Values::Numbers(_) | Values::Flat(..)) => (index + 1).to_string(),
        };
        (0..self.width).map(|index| self.header.replace("{}", &component(index))).collect()
    }

    /// Returns whether the number of columns depends on the maneuver.
    pub fn is_flat(&self) -> bool {
        matches!(self.values, Values::Flat(..))
    }
}

/// Names of inputs and wheels in the headings of tables.
pub(crate) struct Names<'a> {
    /// Names of the inputs. They are used only if every input has a name; otherwise inputs are
    /// numbered.
    inputs: &'a [String],
    /// Number of force inputs (in newtons), which precede the torque inputs.
    forces: usize,
    /// Lever arms of the thrusters \[m\], if the spec defines the thrusters by position and force
    /// and their torques are the inputs of the plan; otherwise empty.
    levers: Vec<f64>,
}

impl<'a> Names<'a> {
    pub fn new(problem: &Problem, identity: &'a Identity) -> Self {
        let actuation = &problem.actuation;
        let named = identity.inputs.len() == actuation.count();
        let forces = actuation.force.as_ref().map_or(0, ActuatorSet::count);
        let by_force = identity.nozzles.len() == actuation.count();
        let levers = identity.nozzles.iter().filter(|_| by_force).map(Nozzle::lever).collect();
        Self { inputs: if named { &identity.inputs } else { &[] }, forces, levers }
    }

    /// Converts the value of input `index` from the plan to its unit in tables. For a thruster that
    /// the spec defines by its force, the table contains the force.
    pub fn in_its_unit(&self, index: usize, value: f64) -> f64 {
        self.levers.get(index).map_or(value, |lever| value / lever)
    }

    /// Returns the column heading of input `index`: its name and its unit.
    pub fn input(&self, index: usize) -> String {
        let is_force = index < self.forces || index < self.levers.len();
        let unit = if is_force { "n" } else { "n_m" };
        format!("{}_{unit}", self.bare(index, index))
    }

    /// Returns the name of the wheel that torque input `index` drives, or its number if it has no
    /// name.
    fn wheel(&self, index: usize) -> String {
        self.bare(index + self.forces, index)
    }

    fn bare(&self, input: usize, number: usize) -> String {
        self.inputs.get(input).map_or_else(|| (number + 1).to_string(), |name| plain(name))
    }
}

/// Replaces commas, quotes and line breaks in a name, so that the name can be used in a table
/// header.
pub(super) fn plain(name: &str) -> String {
    name.replace([',', '"', '\n', '\r'], "_")
}

/// Returns the column heading of costate `index`, if each node has `width` costates: the quantity,
/// the component and the unit. The unit is the cost per unit of the quantity. The unit of the cost
/// depends on the weights and prices of the spec.
fn costate(width: usize, index: usize) -> String {
    const OF: [(&str, &str); 4] =
        [("position", "m"), ("linear_momentum", "n_s"), ("attitude", "rad"), ("momentum", "n_m_s")];
    let (of, unit) = OF[OF.len() - width / 3 + index / 3];
    format!("{of}_{}_cost_per_{unit}", ["x", "y", "z"][index % 3])
}

/// Returns all columns of a trajectory, in the order of a JSON document.
pub(super) fn columns(of: &Trajectory) -> [Column<'_>; 10] {
    let (moving, controlled) = (!of.position.is_empty(), !of.torque.is_empty());
    let three = |shown: bool| if shown { 3 } else { 0 };
    let (wheels, costates) = (wheel_count(of), if of.costates.is_empty() { 0 } else { costate_width(of) });
    let node = |key, header, values, width: usize, shown| Column {
        key,
        header,
        values,
        width,
        shown,
        of_input: false,
    };
    let input = |key, header, values, width: usize, shown| Column {
        key,
        header,
        values,
        width,
        shown,
        of_input: true,
    };
    use Values::{Flat, Numbers, Quaternions, Vectors};
    [
        node("time_s", "time_s", Numbers(&of.time), 1, true),
        node("quaternion_wxyz", "quaternion_{}", Quaternions(&of.quaternion), 4, true),
        node("angular_velocity_rad_s", "angular_velocity_{}_rad_s", Vectors(&of.angular_velocity), 3, true),
        node("position_m", "position_{}_m", Vectors(&of.position), three(moving), moving),
        node("velocity_m_s", "velocity_{}_m_s", Vectors(&of.velocity), three(moving), moving),
        input("input", "input_{}", Flat(&of.input, of.input_count), of.input_count, true),
        input("torque_n_m", "torque_{}_n_m", Vectors(&of.torque), three(controlled), true),
        input("force_n", "force_{}_n", Vectors(&of.force), three(controlled && moving), moving),
        node(
            "wheel_momentum_n_m_s",
            "wheel_momentum_{}_n_m_s",
            Flat(&of.wheel_momentum, wheels),
            wheels,
            wheels > 0,
        ),
        input("costates", "costate_{}", Flat(&of.costates, costate_width(of)), costates, true),
    ]
}

/// Checks that every number of the trajectory is finite.
pub(crate) fn check_finite(trajectory: &Trajectory) -> Result<(), TrajectoryError> {
    let wrong = columns(trajectory)
        .into_iter()
        .find_map(|column| Some((column.key, column.values.first_not_finite()?)));
    wrong.map_or(Ok(()), |(key, row)| Err(TrajectoryError::NotFinite { key, row }))
}

/// Returns the number of costates at a node: 6, or 12 if the trajectory has positions.
pub(super) fn costate_width(trajectory: &Trajectory) -> usize {
    if trajectory.position.is_empty() { 6 } else { 12 }
}

/// Returns the number of reaction wheels, which follows from the number of recorded wheel momenta.
fn wheel_count(trajectory: &Trajectory) -> usize {
    trajectory.wheel_momentum.len() / trajectory.time.len().max(1)
}

/// Returns the quantities that a trajectory has. Each has its key, its number of rows, the length
/// of a row, and its numbers row by row.
pub(crate) fn table(trajectory: &Trajectory) -> Vec<(&'static str, usize, usize, Vec<f64>)> {
    let filled = columns(trajectory).into_iter().filter(|column| column.shown && column.width > 0);
    let numbers = |values: Values<'_>| {
        (0..values.len()).filter_map(move |row| values.row(row)).flatten().copied().collect()
    };
    filled.map(|column| (column.key, column.values.len(), column.width, numbers(column.values))).collect()
}
