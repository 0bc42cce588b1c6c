//! Reading of `[dispersion]`: random quantities as linear functions of standard random numbers.

use super::attitude::{self, Use};
use super::keys::{Kind, SPREADS};
use super::paths::{self, Place};
use super::{Limits, Node, Section, Value, escape, short};
use nalgebra::{DMatrix, SymmetricEigen};
use slewkit::lie::{exp, log};
use slewkit::{Matrix3, Vector3};

/// Random quantities of a spec, for `slew monte-carlo`.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispersion {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of random cases.
    pub cases: u64,
    /// Random quantities, which are drawn independently of each other.
    pub varied: Vec<Varied>,
}

/// A random quantity: its nominal numbers, and their random offset `map · ξ`, where ξ is a vector
/// of standard random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied {
    /// Key of the spec that a case sets.
    pub key: String,
    /// Nominal value, without a random offset.
    pub nominal: Nominal,
    /// Distribution of the standard random numbers ξ.
    pub distribution: Distribution,
    /// Matrix that maps ξ to the offset of the numbers, in the unit of the key. The offset of an
    /// attitude is a rotation vector \[rad\].
    pub map: DMatrix<f64>,
}

/// Distribution of the standard random numbers ξ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Independent normal distributions with mean 0 and variance 1.
    Normal,
    /// Independent uniform distributions on (−1, 1).
    Uniform,
    /// Joint uniform distribution in the unit ball.
    Ball,
}

/// Nominal value of an uncertain quantity, with its notation.
#[derive(Clone, Debug, PartialEq)]
pub enum Nominal {
    /// A single number.
    Number(f64),
    /// A list of numbers.
    List(Vec<f64>),
    /// A matrix, given by rows of numbers.
    Rows(Vec<Vec<f64>>),
    /// An inertia \[kg·m²\]; its numbers are xx, yy, zz, xy, xz, yz.
    Inertia(Matrix3),
    /// An attitude R, given by its rotation vector \[rad\]. A random offset δ changes the attitude
    /// to R exp(δ).
    Attitude(Vector3),
    /// A rotation vector from the start attitude \[rad\], of any length; whole turns are kept.
    Turn(Vector3),
}

/// Row and column of each of the six numbers of an inertia, in the order xx, yy, zz, xy, xz, yz.
const ELEMENTS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Nominal {
    /// Returns the nominal numbers to which the offset is added.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(number) => vec![*number],
            Self::List(numbers) => numbers.clone(),
            Self::Rows(rows) => rows.concat(),
            Self::Inertia(inertia) => ELEMENTS.iter().map(|place| inertia[*place]).collect(),
            Self::Attitude(_) | Self::Turn(_) => vec![0.0; 3],
        }
    }

    /// Returns the value with `offset` added to its numbers, in the notation of a spec. It reads
    /// back to the same bits.
    pub fn moved(&self, offset: &[f64]) -> String {
        let at = |index: usize| offset.get(index).copied().unwrap_or_default();
        let row = |numbers: &[f64]| {
            let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
            format!("[{}]", numbers.join(", "))
        };
        let rotation = |vector: &Vector3| log(&(exp(vector) * exp(&Vector3::new(at(0), at(1), at(2)))));
        match self {
            Self::Number(number) => format!("{:?}", number + at(0)),
            Self::List(numbers) => {
                row(&numbers.iter().enumerate().map(|(index, number)| number + at(index)).collect::<Vec<_>>())
            }
            Self::Rows(rows) => {
                let mut index = 0..;
                let mut moved = |number: &f64| number + index.next().map_or(0.0, at);
                let rows: Vec<String> = rows
                    .iter()
                    .map(|numbers| row(&numbers.iter().map(&mut moved).collect::<Vec<_>>()))
                    .collect();
                format!("[{}]", rows.join(", "))
            }
            Self::Inertia(inertia) => {
                let mut moved = *inertia;
                for (index, (i, j)) in ELEMENTS.into_iter().enumerate() {
                    moved[(i, j)] = inertia[(i, j)] + at(index);
                    moved[(j, i)] = moved[(i, j)];
                }
                let rows: Vec<String> =
                    (0..3).map(|i| row(&[moved[(i, 0)], moved[(i, 1)], moved[(i, 2)]])).collect();
                format!("[{}]", rows.join(", "))
            }
            Self::Attitude(vector) => {
                format!("{{ rotation_vector_rad = {} }}", row(rotation(vector).as_slice()))
            }
            Self::Turn(vector) => {
                let turn = nearest_turn(&rotation(vector), vector);
                format!("{{ rotation_vector_rad = {} }}", row(turn.as_slice()))
            }
        }
    }
}

/// Of the rotation vectors that differ from `shortest` by whole turns, returns the one nearest to
/// `wanted` \[rad\].
fn nearest_turn(shortest: &Vector3, wanted: &Vector3) -> Vector3 {
    let angle = shortest.norm();
    // Whole turns are added about the axis of the nominal rotation.
    let axis = if angle > 0.0 { shortest / angle } else { wanted.try_normalize(0.0).unwrap_or_default() };
    let turns = ((wanted.dot(&axis) - angle) / std::f64::consts::TAU).round();
    axis * (angle + turns * std::f64::consts::TAU)
}

/// Reads `[dispersion]`. Returns `None` if the table is absent or has an error.
pub(crate) fn read(root: &Section, tree: &Node) -> Option<Dispersion> {
    let section = root.section("dispersion")?;
    let varied: Vec<Option<Varied>> =
        section.list("vary").iter().map(|entry| varied(entry, root, tree)).collect();
    let varied = varied.into_iter().collect::<Option<Vec<_>>>()?;
    for (index, one) in varied.iter().enumerate() {
        let inside = |a: &str, b: &str| a == b || a.starts_with(&format!("{b}."));
        let earlier = varied[..index].iter();
        if let Some(other) =
            earlier.clone().find(|other| inside(&other.key, &one.key) || inside(&one.key, &other.key))
        {
            let reason = format!("`{}` already varies, with `{}`", escape(&one.key), escape(&other.key));
            return section.list("vary")[index].refuse("E0011", "key", reason, "vary each number once");
        }
    }
    Some(Dispersion { seed: section.whole("seed")?, cases: section.whole("cases")?, varied })
}

fn varied(entry: &Section, root: &Section, tree: &Node) -> Option<Varied> {
    let path = entry.word("key")?;
    let (key, nominal, scale) = nominal(entry, path, root, tree)?;
    let name = SPREADS.iter().copied().find(|name| entry.has(name))?;
    let distribution = match entry.word("kind")? {
        "normal" => Distribution::Normal,
        "uniform" => Distribution::Uniform,
        _ => Distribution::Ball,
    };
    let numbers = nominal.numbers();
    // If three spreads are given for an inertia, only its diagonal varies.
    let inertia = matches!(nominal, Nominal::Inertia(_));
    let fits = |count: usize| count == numbers.len() || (inertia && count == 3);
    let misfit = |count: usize| {
        let needed = if inertia { "3 (the diagonal) or 6".into() } else { numbers.len().to_string() };
        let reason = format!("`{name}` has {count} numbers, but `{}` has {needed}", escape(path));
        entry.refuse("E0026", name, reason, "give one number for each")
    };
    let map = match name {
        "covariance" | "semi_axes" => {
            let rows = entry.square(name)?;
            if !fits(rows.len()) {
                return misfit(rows.len());
            }
            let given = DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j]);
            if name == "covariance" { root_of(entry, given)? } else { given.transpose() }
        }
        _ => {
            let relative = name.ends_with("_relative");
            let size = |index: usize| if relative { numbers[index].abs() } else { 1.0 };
            let spreads = match entry.limits(name)? {
                Limits::All(spread) => vec![spread; numbers.len()],
                Limits::Each(spreads) if fits(spreads.len()) => spreads,
                Limits::Each(spreads) => return misfit(spreads.len()),
            };
            if relative && matches!(nominal, Nominal::Attitude(_) | Nominal::Turn(_)) {
                let reason =
                    format!("`{name}`: an attitude has no magnitude, so a relative spread has no meaning");
                let remedy = format!("write {} in the unit of the key", name.trim_end_matches("_relative"));
                return entry.refuse("E0160", name, reason, remedy);
            }
            let spreads = spreads.iter().enumerate().map(|(index, spread)| spread * size(index));
            DMatrix::from_diagonal(&spreads.collect::<Vec<_>>().into())
        }
    };
    Some(Varied { key, nominal, distribution, map: map * scale })
}

/// Returns a matrix `A` for which `A Aᵀ` is the covariance. Reports an error if the covariance is
/// not symmetric and positive semidefinite.
fn root_of(entry: &Section, covariance: DMatrix<f64>) -> Option<DMatrix<f64>> {
    /// Relative tolerance on asymmetry and on negative eigenvalues; it allows for rounding of the
    /// elements.
    const ROUNDING: f64 = 1e-12;
    let size = covariance.amax();
    let refuse = |reason: String| {
        entry.refuse("E0160", "covariance", reason, "give a symmetric, positive semidefinite covariance")
    };
    if (&covariance - covariance.transpose()).amax() > ROUNDING * size {
        return refuse("the covariance is not symmetric".into());
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(covariance);
    if let Some(negative) = eigenvalues.iter().find(|value| **value < -ROUNDING * size) {
        return refuse(format!("the covariance has the negative eigenvalue {}", short(*negative)));
    }
    let deviations = eigenvalues.map(|variance| variance.max(0.0).sqrt());
    Some(eigenvectors * DMatrix::from_diagonal(&deviations))
}

/// Returns the key that each case sets, its nominal value, and the size of the unit in which the
/// spec gives the spread, relative to the unit of the offset.
fn nominal(entry: &Section, path: &str, root: &Section, tree: &Node) -> Option<(String, Nominal, f64)> {
    if let Err((code, reason, remedy)) = paths::place(tree, path) {
        return entry.refuse(code, "key", reason, remedy);
    }
    for (ending, scale) in [(".rotation_vector_deg", 1_f64.to_radians()), (".rotation_vector_rad", 1.0)] {
        let Some(key) = path.strip_suffix(ending) else { continue };
        let (end, name) = key.split_once('.')?;
        let purpose = if name == "attitude" { Use::Attitude } else { Use::Turn };
        let Some(section) = root.section(end).and_then(|end| end.section(name)) else {
            return absent(entry, key);
        };
        let vector = attitude::rotation(section, purpose)?.vector;
        let nominal = if name == "attitude" { Nominal::Attitude(vector) } else { Nominal::Turn(vector) };
        return Some((key.into(), nominal, scale));
    }
    if path == "body.inertia_kg_m2" {
        return Some((path.into(), Nominal::Inertia(root.section("body")?.matrix("inertia_kg_m2")?), 1.0));
    }
    if let Ok(Place::Key(key)) = paths::place(tree, path)
        && matches!(key.kind, Kind::Steps(_) | Kind::Count(..) | Kind::Format)
    {
        let reason = format!("`{}` is a count: it cannot vary continuously", escape(path));
        return entry.refuse("E0160", "key", reason, "vary it with `slew sweep SPEC --over KEY=A,B,C`");
    }
    let mut node = Some(tree);
    for part in path.split('.') {
        node = node.and_then(|node| match &node.value {
            Value::Array(items) => part.parse::<usize>().ok().and_then(|index| items.get(index)),
            _ => node.entry(part).map(|entry| &entry.node),
        });
    }
    let Some(node) = node else { return absent(entry, path) };
    match numbers(node) {
        Some(nominal) => Some((path.into(), nominal, 1.0)),
        None => {
            let reason = format!("`{}` holds no numbers", escape(path));
            let remedy = "name a key with a number, a list or rows of numbers; an attitude as \
                end.attitude.rotation_vector_deg";
            entry.refuse("E0160", "key", reason, remedy)
        }
    }
}

fn absent<T>(entry: &Section, path: &str) -> Option<T> {
    let reason = format!("`{}` varies, but the spec has no value for it", escape(path));
    entry.refuse("E0160", "key", reason, "add the key with its mean value")
}

/// Reads a number, a list of numbers, or rows of numbers; `None` for other values.
fn numbers(node: &Node) -> Option<Nominal> {
    let number = |node: &Node| match &node.value {
        Value::Number(number) => Some(number.value),
        _ => None,
    };
    let list = |node: &Node| match &node.value {
        Value::Array(items) if !items.is_empty() => items.iter().map(number).collect::<Option<Vec<f64>>>(),
        _ => None,
    };
    if let Some(number) = number(node) {
        return Some(Nominal::Number(number));
    }
    if let Some(list) = list(node) {
        return Some(Nominal::List(list));
    }
    match &node.value {
        Value::Array(rows) if !rows.is_empty() => {
            rows.iter().map(list).collect::<Option<Vec<_>>>().map(Nominal::Rows)
        }
        _ => None,
    }
}
