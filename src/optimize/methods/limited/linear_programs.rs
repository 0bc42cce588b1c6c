//! Arcs near the optimum that a first order leads to, within limits all the way, by a sequence of linear programs.
//!
//! ```text
//! minimise   ∇J·s + ½ρ |s|² + μ (Σ |g + G s| + Σ_l max(0, c_l + C_l s))     where   ℓ + s ≥ 0 ,   |s| ≤ Δ
//! ```
//!
//! with the unknowns and equations of [`newton`](super::newton), and with every limit that an arc does not hold, `c`, at points along it. Such a
//! step is taken where it leaves less cost or less of what is missed and exceeded than at every point before (a filter), and Δ becomes
//! smaller where it does not. What is linear has its optimum at a vertex: arcs to which it leaves no length are none, and limits
//! that it meets at junctions are touched. Newton makes the rest exact.
//!
//! Fletcher and Leyffer, *Nonlinear programming without a penalty function*, 2002.

use super::motion::Maneuver;
use super::newton::{Arcs, Contact, Followed};
use crate::optimize::convex::cone::{Cone, ConeSettings, ConeSolver, Program};
use crate::optimize::convex::sparse::{Sparse, SparseParts};
use nalgebra::{DMatrix, DVector};

/// Most arcs of a first order: half of them vanish as a rule.
const MOST_ARCS: usize = 40;

const MOST_PROGRAMS: usize = 60;

/// Points along the duration at which limits are looked at, besides junctions.
const POINTS: f64 = 32.0;

/// The first and largest Δ, as a part of the duration, and that below which a step leads nowhere.
const RADIUS: [f64; 2] = [0.1, 1e-7];

/// By how much Δ becomes smaller and larger again.
const SCALED: [f64; 2] = [0.4, 2.0];

/// `ρ`, so that a step of the first Δ costs this part of what it gains: of many optima the nearest.
const NEAREST: f64 = 1e-3;

/// `μ` at first, as a multiple of the largest multiplier; by how much it grows where a program leaves equations, and the most.
const PRICE: [f64; 3] = [2.0, 10.0, 1e5];

/// Of what is missed and exceeded a step that is to be taken leaves less than this part, or lowers the cost by as much of it.
const LESS: [f64; 2] = [0.9, 1e-5];

/// What one more program could gain, as a part of the cost, and what may be missed, when Newton takes over.
const ENOUGH: f64 = 1e-8;

/// What is missed within this is not.
const MET: f64 = 1e-10;

/// Parts of the duration below which an arc has no length at a vertex: what programs leave of it, and what is not worth an arc.
const NO_LENGTH: [f64; 2] = [1e-6, 1e-3];

/// A limit acts where its multiplier is this part of the largest.
const ACTS: f64 = 1e-3;

/// A limit at a point of an arc.
struct Row {
    limit: usize,
    /// The arc that ends there.
    junction: Option<usize>,
    value: f64,
    gradient: DVector<f64>,
}

/// Arcs with their motion, and all limits on the way.
struct Point {
    arcs: Arcs,
    cost: f64,
    gradient: DVector<f64>,
    equations: DVector<f64>,
    jacobian: DMatrix<f64>,
    rows: Vec<Row>,
    /// What equations miss, and the most by which each limit is exceeded, in sum.
    missed: f64,
}

/// What a linear program says.
struct Said {
    step: DVector<f64>,
    /// What it leaves of what is missed and exceeded.
    left: f64,
    /// Multipliers of the rows.
    multipliers: Vec<f64>,
}

impl Point {
    fn of(arcs: Arcs, maneuver: &Maneuver) -> Option<Self> {
        let (fine, parents) = finer(&arcs, maneuver);
        let followed = fine.followed(maneuver)?;
        let own = arcs.unknowns();
        // What a change of an unknown does to those of the finer arcs.
        let pieces = |arc: usize| parents.iter().filter(|parent| **parent == arc).count() as f64;
        let mut changes = DMatrix::zeros(followed.gradient.len(), own.len());
        for (row, unknown) in fine.unknowns().iter().enumerate() {
            let arc = parents[unknown.arc];
            let column = own.iter().position(|own| own.kind == unknown.kind && own.arc == arc)?;
            changes[(row, column)] = if unknown.is_length() { 1.0 / pieces(arc) } else { 1.0 };
        }
        let Followed { cost, gradient, equations, jacobian, contacts, .. } = followed;
        let jacobian = jacobian * &changes;
        let ends = maneuver.ends();
        let is_equation = |contact: &Contact| {
            let (before, law) = (&fine.laws[contact.arc - 1], &fine.laws[contact.arc]);
            let [before, after] = [before, law].map(|law| law.holds.contains(&contact.limit));
            let touched = ended(&parents, contact.arc).and_then(|arc| arcs.contacts.get(arc));
            !before && after || touched.is_some_and(|own| own.contains(&contact.limit))
        };
        let (mut kept, mut rows): (Vec<usize>, Vec<Row>) = ((0..ends).collect(), Vec::new());
        for (index, contact) in contacts.iter().enumerate() {
            let row = ends + index;
            if contact.arc == 0 || is_equation(contact) {
                kept.push(row);
            } else if !contact.slope {
                let gradient = jacobian.row(row).transpose();
                let junction = ended(&parents, contact.arc);
                rows.push(Row { limit: contact.limit, junction, value: equations[row], gradient });
            }
        }
        kept.extend(ends + contacts.len()..equations.len());
        let (equations, jacobian) = (equations.select_rows(&kept), jacobian.select_rows(&kept));
        let gradient = changes.tr_mul(&gradient);
        let mut point = Self { arcs, cost, gradient, equations, jacobian, rows, missed: 0.0 };
        point.missed = point.left(maneuver, &DVector::zeros(own.len())).max(MET);
        (point.cost + point.missed).is_finite().then_some(point)
    }

    /// What a step leaves of what is missed and exceeded, to first order.
    fn left(&self, maneuver: &Maneuver, step: &DVector<f64>) -> f64 {
        let mut exceeded = vec![0.0_f64; maneuver.limits.len()];
        for row in &self.rows {
            exceeded[row.limit] = exceeded[row.limit].max(row.value + row.gradient.dot(step));
        }
        (&self.equations + &self.jacobian * step).lp_norm(1) + exceeded.iter().sum::<f64>()
    }

    /// The largest multiplier of the equations by least squares.
    fn largest_multiplier(&self) -> Option<f64> {
        let svd = self.jacobian.transpose().svd(true, true);
        let none = f64::EPSILON.sqrt() * svd.singular_values.max();
        Some(svd.solve(&self.gradient, none).ok()?.amax())
    }

    /// The linear program with prices `μ` and `ρ`, within `radius`.
    fn program(&self, maneuver: &Maneuver, price: f64, nearest: f64, radius: f64) -> Option<Said> {
        let (count, equations) = (self.gradient.len(), self.equations.len());
        let all = count + equations + maneuver.limits.len();
        let (mut entries, mut bound) = (Vec::new(), Vec::new());
        let mut push = |of: &dyn Fn(usize) -> f64, slack: Option<usize>, most: f64| {
            let row = bound.len();
            let own = (0..count).map(|column| (row, column, of(column)));
            entries.extend(own.filter(|(_, _, number)| *number != 0.0));
            entries.extend(slack.map(|slack| (row, slack, -1.0)));
            bound.push(most);
        };
        for (row, side) in (0..equations).flat_map(|row| [(row, 1.0), (row, -1.0)]) {
            push(
                &|column| side * self.jacobian[(row, column)],
                Some(count + row),
                -side * self.equations[row],
            );
        }
        let room = self.arcs.room(maneuver, radius);
        for (unknown, [down, up]) in room.iter().enumerate() {
            push(&|column| if column == unknown { -1.0 } else { 0.0 }, None, -down);
            push(&|column| if column == unknown { 1.0 } else { 0.0 }, None, *up);
        }
        let first_limit = count + equations;
        for limit in 0..maneuver.limits.len() {
            push(&|_| 0.0, Some(first_limit + limit), 0.0);
        }
        // What no step within the radius can reach is left out.
        let highest = |row: &Row| {
            let most =
                row.gradient.iter().zip(&room).map(|(slope, [down, up])| (slope * down).max(slope * up));
            row.value + most.sum::<f64>()
        };
        let near: Vec<usize> = (0..self.rows.len()).filter(|row| highest(&self.rows[*row]) >= 0.0).collect();
        for row in near.iter().map(|row| &self.rows[*row]) {
            push(&|column| row.gradient[column], Some(first_limit + row.limit), -row.value);
        }
        let rows = bound.len();
        let mut linear = vec![price; all];
        linear[..count].copy_from_slice(self.gradient.as_slice());
        let squares: Vec<(usize, usize, f64)> = (0..count).map(|column| (column, column, nearest)).collect();
        let program = Program {
            quadratic: Sparse::of_entries(all, all, &squares),
            linear,
            matrix: Sparse::of_entries(rows, all, &entries),
            bound,
            cones: vec![Cone::Nonnegative(rows)],
        };
        let answer = ConeSolver::new(program, &ConeSettings::default()).ok()?.solve();
        let optimum = answer.step()?;
        let step = DVector::from_row_slice(&optimum.x[..count]);
        let mut multipliers = vec![0.0; self.rows.len()];
        for (row, multiplier) in near.iter().zip(&optimum.z[rows - near.len()..]) {
            multipliers[*row] = *multiplier;
        }
        Some(Said { left: self.left(maneuver, &step), step, multipliers })
    }

    /// The arcs without those of no length, with the limits touched that act at junctions.
    fn vertex(&self, said: &Said, no_length: f64) -> Arcs {
        let mut arcs = self.arcs.clone();
        let acts = ACTS * said.multipliers.iter().copied().fold(0.0, f64::max);
        for (row, multiplier) in self.rows.iter().zip(&said.multipliers) {
            if let Some(contacts) = row.junction.and_then(|arc| arcs.contacts.get_mut(arc))
                && *multiplier > acts
            {
                contacts.push(row.limit);
            }
        }
        let none = no_length * arcs.duration();
        while let Some(arc) = arcs.lengths.iter().position(|length| *length < none) {
            if arcs.laws.len() == 1 {
                break;
            }
            arcs = arcs.without(arc);
        }
        arcs
    }
}

/// The arc that ends where a finer one begins, if one does.
fn ended(parents: &[usize], begins: usize) -> Option<usize> {
    let before = parents[begins - 1];
    (before != parents[begins]).then_some(before)
}

/// The arcs cut into pieces with every limit looked at where one ends, and which arc each piece is of.
fn finer(arcs: &Arcs, maneuver: &Maneuver) -> (Arcs, Vec<usize>) {
    let piece = arcs.duration() / POINTS;
    let mut fine =
        Arcs { laws: Vec::new(), lengths: Vec::new(), contacts: Vec::new(), first: arcs.first.clone() };
    let mut parents = Vec::new();
    for (arc, (law, length)) in arcs.laws.iter().zip(&arcs.lengths).enumerate() {
        let pieces = (length / piece).ceil().clamp(1.0, POINTS) as usize;
        for _ in 0..pieces {
            fine.laws.push(law.clone());
            fine.lengths.push(length / pieces as f64);
            fine.contacts.push((0..maneuver.limits.len()).collect());
            parents.push(arc);
        }
    }
    fine.contacts.pop();
    (fine, parents)
}

/// What a sequence of linear programs makes of a first order; `None` where it is too long, or a motion cannot be followed.
pub(super) fn descended(first: &Arcs, maneuver: &Maneuver, stop: &dyn Fn() -> bool) -> Option<[Arcs; 2]> {
    if first.laws.len() > MOST_ARCS {
        return None;
    }
    let mut at = Point::of(first.clone(), maneuver)?;
    let duration = at.arcs.duration();
    let [largest, least] = RADIUS.map(|part| part * duration);
    let [first_price, dearer, most_price] = PRICE;
    let mut price = first_price * at.largest_multiplier()?;
    let nearest = NEAREST * at.gradient.amax() / largest;
    let mut filter = vec![(at.cost, at.missed)];
    let mut radius = largest;
    let mut said = at.program(maneuver, price, nearest, radius)?;
    for _ in 0..MOST_PROGRAMS {
        if stop() {
            return None;
        }
        let size = said.step.amax();
        let gain = -at.gradient.dot(&said.step);
        let is_met = at.missed < ENOUGH;
        if is_met && gain.abs() < ENOUGH * at.cost || radius < least {
            break;
        }
        if !is_met && said.left > 0.5 * at.missed && size < radius && price < most_price {
            price *= dearer;
        } else {
            let next = Point::of(at.arcs.moved(&said.step, 1.0), maneuver);
            let [of_missed, of_cost] = LESS;
            let improves = |next: &Point| {
                filter.iter().all(|(cost, missed)| {
                    next.cost < cost - of_cost * missed || next.missed < of_missed * missed
                })
            };
            match next.filter(improves) {
                Some(next) => {
                    filter.push((next.cost, next.missed));
                    at = next;
                    radius = (SCALED[1] * radius).min(largest);
                }
                None => radius = SCALED[0] * size.min(radius),
            }
        }
        said = at.program(maneuver, price, nearest, radius)?;
    }
    Some(NO_LENGTH.map(|part| at.vertex(&said, part)))
}
