//! Newton on the lengths of arcs, on the levels of loose inputs, and on what inputs of limited rates begin with.
//!
//! With `s` the change of these unknowns, `Z` the null space of `G`, and the Lagrangian `L = J + λᵀg`,
//!
//! ```text
//! s = s_y + Z s_z ,    G s_y = −g (the shortest) ,    ZᵀHZ s_z = −Zᵀ(∇J + H s_y) ,    Gᵀλ = −∇J (least squares)
//! ```
//!
//! First derivatives are those of the flow, chained from arc to arc; what one more unit of time of an arc does is the velocity at its
//! end, carried on. `H` is a difference of gradients of `L`: Newton's last steps are nearly quadratic, and its error does
//! not touch what they converge to. Where `ZᵀHZ` is not positive its eigenvalues are taken by their size. With loose inputs
//! the equations alone are solved: these have more than they need, and what is stationary there is so from the start.

use super::motion::{Input, Law, Level, Maneuver};
use super::state::{CHANGES, Change, DISTURBANCE, State, at};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Largest of the equations that counts as met, scaled.
const MET: f64 = 1e-12;

/// Largest of the gradient in the null space that counts as none: of the cost it leaves its square, and differences of the flow leave
/// it about this.
const STATIONARY: f64 = 1e-7;

const MOST_ITERATIONS: usize = 40;

/// Most arcs: what reads as more chatters, and a plan of it would be no shorter.
const MOST_ARCS: usize = 24;

/// Largest change of a length in one step, as a part of the duration.
const LARGEST_STEP: f64 = 0.1;

/// Part of the duration below which an arc that is to become shorter has vanished.
pub(crate) const NO_LENGTH: f64 = 1e-9;

/// A small change of a length, as a part of the duration: lengths are disturbed by it for `H`, and the merit of a step below it, which
/// round-off decides, is not asked for.
const SMALL: f64 = 1e-6;

/// Singular values of `G` below this part of the largest are none.
const RANK: f64 = 1e-9;

/// Least curvature that a step is taken by, as a part of the largest.
const LEAST_CURVATURE: f64 = 1e-6;

/// Weight of the equations in the merit of a step, as a multiple of the largest multiplier.
const MERIT: f64 = 2.0;

/// Halvings of a step.
const MOST_HALVINGS: usize = 10;

/// A level is where it ends within this.
const AT_END: f64 = 1e-9;

impl Law {
    /// With an input that changes at a limited rate doing what it does by another law.
    fn doing_as(&self, other: &Self, input: usize, maneuver: &Maneuver) -> Self {
        let mut law = self.clone();
        let number = maneuver.inputs[input].ramp.map(|ramp| ramp.number);
        let own = |limit: &usize| maneuver.limits[*limit].ramp().map(|(number, _)| number) == number;
        law.levels[input] = other.levels[input];
        law.holds.retain(|limit| !own(limit));
        law.holds.extend(other.holds.iter().copied().filter(own));
        law.holds.sort_unstable();
        law
    }

    /// Changes the level of a loose input.
    fn disturb(&mut self, input: usize, change: f64) {
        if let Level::Loose(level) = &mut self.levels[input] {
            *level += change;
        }
    }
}

impl Input {
    /// Where a level that changes in this direction ends: at a limit, or off where that is what costs least.
    fn end_of_level(&self, level: f64, step: f64) -> f64 {
        let [lowest, highest] = match (self.price > 0.0, level) {
            (true, level) if level < 0.0 || level == 0.0 && step < 0.0 => [self.lowest, 0.0],
            (true, _) => [0.0, 1.0],
            (false, _) => [self.lowest, 1.0],
        };
        if step < 0.0 { lowest } else { highest }
    }
}

/// A maneuver of arcs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Arcs {
    pub laws: Vec<Law>,
    pub lengths: Vec<f64>,
    /// Limits that the motion touches where arc k ends.
    pub contacts: Vec<Vec<usize>>,
    /// What inputs that change at limited rates begin with, as parts of their limits.
    pub first: Vec<f64>,
}

/// A number that Newton finds: first what inputs begin with, then those of arcs, of earlier ones first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown {
    pub arc: usize,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// What an input that changes at a limited rate begins with.
    First(usize),
    /// The length of the arc.
    Length,
    /// The level of a loose input.
    Level(usize),
}

impl Unknown {
    /// Whether it has to do with the state that an arc begins with.
    fn is_before(&self, arc: usize) -> bool {
        matches!(self.kind, Kind::First(_)) || self.arc < arc
    }

    pub fn is_length(&self) -> bool {
        matches!(self.kind, Kind::Length)
    }

    /// The loose input whose level it is.
    fn loose(&self) -> Option<usize> {
        if let Kind::Level(input) = self.kind { Some(input) } else { None }
    }
}

/// A limit is met where an arc begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Which arc begins.
    pub arc: usize,
    pub limit: usize,
    /// Whether it is its rate of change that vanishes.
    pub slope: bool,
}

/// The motion along arcs, with first derivatives.
pub(crate) struct Followed {
    /// At the ends of all arcs, and the start first.
    pub nodes: Vec<State>,
    pub cost: f64,
    /// Of the cost, by the unknowns.
    pub gradient: DVector<f64>,
    /// `g` and `G`: the end, contacts, the duration where it is given.
    pub equations: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    pub contacts: Vec<Contact>,
}

/// Arcs that are stationary, with their multipliers.
pub(crate) struct Stationary {
    pub arcs: Arcs,
    pub followed: Followed,
    /// Of the equations.
    pub multipliers: DVector<f64>,
    /// Least eigenvalue of the curvature in the null space, `+∞` where that is empty, and where loose inputs make it flat.
    pub curvature: f64,
}

impl Contact {
    /// What vanishes where it is met.
    pub fn missed(&self, maneuver: &Maneuver, state: &State) -> f64 {
        let limit = &maneuver.limits[self.limit];
        if self.slope { limit.slope(state) } else { limit.value(state) }
    }
}

impl Arcs {
    pub fn duration(&self) -> f64 {
        self.lengths.iter().sum()
    }

    /// Where limits are met: those that begin to be held, also from the start on where what begins is free, and those touched.
    pub fn contacts(&self, maneuver: &Maneuver) -> Vec<Contact> {
        let at_first = self.laws.first().map_or(&[][..], |law| &law.holds);
        let is_free = |limit: &&usize| maneuver.limits[**limit].ramp().is_some();
        let at_first = at_first.iter().filter(is_free);
        let mut contacts: Vec<Contact> =
            at_first.map(|limit| Contact { arc: 0, limit: *limit, slope: false }).collect();
        for arc in 1..self.laws.len() {
            let (before, law) = (&self.laws[arc - 1].holds, &self.laws[arc].holds);
            let entered = law.iter().filter(|limit| !before.contains(limit));
            let touched = self.contacts[arc - 1].iter();
            let touched = touched.filter(|limit| !law.contains(limit) && !before.contains(limit));
            for limit in entered.chain(touched) {
                let slopes = [false, true];
                let of_order = slopes.iter().take(maneuver.limits[*limit].order());
                contacts.extend(of_order.map(|slope| Contact { arc, limit: *limit, slope: *slope }));
            }
        }
        contacts
    }

    /// Whether some input is loose on some arc.
    pub fn is_loose(&self) -> bool {
        self.laws.iter().flat_map(|law| &law.levels).any(|level| matches!(level, Level::Loose(_)))
    }

    /// The inputs that are loose on some arc.
    pub fn loose_inputs(&self) -> Vec<usize> {
        self.unknowns().iter().filter_map(Unknown::loose).collect()
    }

    pub(super) fn unknowns(&self) -> Vec<Unknown> {
        let of_arc = |(arc, law): (usize, &Law)| {
            let loose = |input: &usize| matches!(law.levels[*input], Level::Loose(_));
            let levels: Vec<usize> = (0..law.levels.len()).filter(loose).collect();
            let all = std::iter::once(Kind::Length).chain(levels.into_iter().map(Kind::Level));
            all.map(move |kind| Unknown { arc, kind })
        };
        let first = (0..self.first.len()).map(|ramp| Unknown { arc: 0, kind: Kind::First(ramp) });
        first.chain(self.laws.iter().enumerate().flat_map(of_arc)).collect()
    }

    /// With one unknown changed.
    fn disturbed(&self, unknown: &Unknown, change: f64) -> Self {
        let mut disturbed = self.clone();
        match unknown.kind {
            Kind::First(ramp) => disturbed.first[ramp] += change,
            Kind::Length => disturbed.lengths[unknown.arc] += change,
            Kind::Level(input) => disturbed.laws[unknown.arc].disturb(input, change),
        }
        disturbed
    }

    /// Follows the arcs; `None` where a law cannot be followed.
    pub fn followed(&self, maneuver: &Maneuver) -> Option<Followed> {
        self.followed_from(maneuver, 0, self.start(maneuver))
    }

    /// What they begin with.
    pub fn start(&self, maneuver: &Maneuver) -> State {
        maneuver.start.giving(&self.first)
    }

    /// The same from an arc on, which begins in `state`: what earlier arcs have to do with it is left out.
    fn followed_from(&self, maneuver: &Maneuver, begun: usize, mut state: State) -> Option<Followed> {
        let (unknowns, contacts) = (self.unknowns(), self.contacts(maneuver));
        let given = maneuver.given_duration;
        let ends = maneuver.ends();
        let rows = ends + contacts.len() + usize::from(given.is_some());
        let is_length = |unknown: &Unknown| if unknown.is_length() { 1.0 } else { 0.0 };
        let lengths = DVector::from_iterator(unknowns.len(), unknowns.iter().map(is_length));
        let mut followed = Followed {
            nodes: vec![state],
            cost: maneuver.time_price * self.duration(),
            gradient: maneuver.time_price * &lengths,
            equations: DVector::zeros(rows),
            jacobian: DMatrix::zeros(rows, unknowns.len()),
            contacts,
        };
        // What a change of each unknown has done to the state so far.
        let mut changes = vec![Change::zeros(); unknowns.len()];
        let from = if begun == 0 { 0 } else { unknowns.partition_point(|unknown| unknown.is_before(begun)) };
        for (change, unknown) in changes.iter_mut().zip(&unknowns).skip(from) {
            if let Kind::First(ramp) = unknown.kind {
                change[at::RAMPS + ramp] = 1.0;
            }
        }
        for (arc, (law, length)) in self.laws.iter().zip(&self.lengths).enumerate().skip(begun) {
            let own = unknowns.partition_point(|unknown| unknown.is_before(arc));
            for (row, contact) in followed.contacts.iter().enumerate() {
                if contact.arc == arc {
                    followed.equations[ends + row] = contact.missed(maneuver, &state);
                    let slope = state.gradient(&|state| contact.missed(maneuver, state));
                    for (column, change) in changes.iter().enumerate().take(own).skip(from) {
                        followed.jacobian[(ends + row, column)] = slope.dot(change);
                    }
                }
            }
            let driven = maneuver.driven(law)?;
            let steps = driven.steps(&state, *length);
            let (to, slope) = driven.linearised(&state, *length, steps);
            for (column, change) in changes.iter_mut().enumerate().take(own).skip(from) {
                let moved = slope * *change;
                followed.gradient[column] += moved[CHANGES];
                *change = moved.fixed_rows::<CHANGES>(0).into();
            }
            for (column, unknown) in
                unknowns.iter().enumerate().skip(own).take_while(|(_, own)| own.arc == arc)
            {
                let (burning, change) = match unknown.loose() {
                    None => driven.rates(&to),
                    Some(input) => {
                        let mut ends = [to; 2];
                        for (end, size) in ends.iter_mut().zip([DISTURBANCE, -DISTURBANCE]) {
                            let mut disturbed = law.clone();
                            disturbed.disturb(input, size);
                            *end = maneuver.driven(&disturbed)?.flow(&state, *length, steps);
                        }
                        let [ahead, behind] = ends;
                        let change = ahead.minus(&to) - behind.minus(&to);
                        let burnt = ahead.burnt() - behind.burnt();
                        (burnt / (2.0 * DISTURBANCE), change / (2.0 * DISTURBANCE))
                    }
                };
                changes[column] = change;
                followed.gradient[column] += burning;
            }
            state = to;
            followed.nodes.push(state);
        }
        followed.cost += state.burnt();
        let missed = state.minus(&maneuver.end);
        followed.equations.rows_mut(0, ends).copy_from(&missed.rows(0, ends));
        for row in 0..ends {
            let end = |state: &State| state.minus(&maneuver.end)[row];
            let slope = state.gradient(&end);
            for (column, change) in changes.iter().enumerate() {
                followed.jacobian[(row, column)] = slope.dot(change);
            }
        }
        if let Some(given) = given {
            followed.equations[rows - 1] = self.duration() - given;
            followed.jacobian.row_mut(rows - 1).tr_copy_from(&lengths);
        }
        let finite = state.is_finite() && followed.jacobian.iter().all(|number| number.is_finite());
        finite.then_some(followed)
    }

    /// How far each unknown may go either way, and none further than `most`.
    pub fn room(&self, maneuver: &Maneuver, most: f64) -> Vec<[f64; 2]> {
        let room = |unknown: &Unknown| match unknown.kind {
            Kind::First(ramp) => [-1.0, 1.0].map(|end| end - self.first[ramp]),
            Kind::Length => [-self.lengths[unknown.arc], most],
            Kind::Level(input) => {
                let level = self.laws[unknown.arc].levels[input].part().unwrap_or(0.0);
                [-1.0, 1.0].map(|side| maneuver.inputs[input].end_of_level(level, side) - level)
            }
        };
        let within = |[down, up]: [f64; 2]| [down.clamp(-most, 0.0), up.clamp(0.0, most)];
        self.unknowns().iter().map(room).map(within).collect()
    }

    /// With every unknown changed by a part of a step.
    pub fn moved(&self, step: &DVector<f64>, part: f64) -> Self {
        let mut moved = self.clone();
        for (unknown, step) in self.unknowns().iter().zip(step.iter()) {
            match unknown.kind {
                Kind::First(ramp) => moved.first[ramp] += part * step,
                Kind::Length => {
                    let length = &mut moved.lengths[unknown.arc];
                    *length = (*length + part * step).max(0.0);
                }
                Kind::Level(input) => moved.laws[unknown.arc].disturb(input, part * step),
            }
        }
        moved
    }

    /// With the loose inputs that are where their levels end, and would go on, left there; `None` where there are none.
    fn settled(&self, maneuver: &Maneuver, step: &DVector<f64>) -> Option<Self> {
        let mut settled = self.clone();
        let mut any = false;
        for (unknown, step) in self.unknowns().iter().zip(step.iter()) {
            let Some(input) = unknown.loose() else { continue };
            let level = &mut settled.laws[unknown.arc].levels[input];
            let Level::Loose(now) = *level else { continue };
            let end = maneuver.inputs[input].end_of_level(now, *step);
            if (end - now).abs() <= AT_END && (end - now) * step >= 0.0 {
                *level = Level::At(end);
                any = true;
            }
        }
        any.then(|| settled.joined())
    }

    /// Without an arc. What it held is touched where it was, and neighbours of one law become one arc.
    pub fn without(&self, arc: usize) -> Self {
        let mut rest = self.clone();
        let (law, _) = (rest.laws.remove(arc), rest.lengths.remove(arc));
        let ended = rest.contacts.remove(arc.min(rest.contacts.len().saturating_sub(1)));
        if rest.laws.is_empty() {
            return rest;
        }
        // The junction that is left of two: that before the arc, or the new end.
        if arc > 0 && arc < rest.laws.len() {
            let kept = &mut rest.contacts[arc - 1];
            kept.extend(ended.into_iter().chain(law.holds));
            kept.sort_unstable();
            kept.dedup();
        }
        rest.joined()
    }

    /// With arcs of no length between what inputs that change at limited rates do at once, so that each can do it at a time of its own. What
    /// is best may be that they do so, as wheels from rest to rest: without these arcs their multipliers would not be unique.
    fn parted(mut self, maneuver: &Maneuver) -> Self {
        let mut arc = 1;
        while arc < self.laws.len() {
            let (before, after) = (&self.laws[arc - 1], &self.laws[arc]);
            let changed = |(input, of): (usize, &Input)| {
                of.ramp.filter(|_| before.levels[input] != after.levels[input]).map(|_| input)
            };
            let changed: Vec<usize> = maneuver.inputs.iter().enumerate().filter_map(changed).collect();
            if changed.len() > 1 {
                let between = before.doing_as(after, changed[0], maneuver);
                self.laws.insert(arc, between);
                self.lengths.insert(arc, 0.0);
                self.contacts.insert(arc - 1, Vec::new());
            }
            arc += 1;
        }
        self
    }

    /// With what begins and what ends an arc the other way round, where these are ramps of different inputs. Two of one length that begin
    /// together end together: without the arc between them they would stay together, with multipliers that are not unique.
    fn swapped(&self, maneuver: &Maneuver, arc: usize) -> Option<Self> {
        let [before, law, after] = [arc.checked_sub(1)?, arc, arc + 1].map(|arc| self.laws.get(arc));
        let (before, law, after) = (before?, law?, after?);
        let changed = |a: &Law, b: &Law, input: usize| a.levels[input] != b.levels[input];
        let mut swapped = before.clone();
        let (mut begins, mut ends) = (false, false);
        for (input, of) in maneuver.inputs.iter().enumerate() {
            let [first, last] = [changed(before, law, input), changed(law, after, input)];
            (begins, ends) = (begins || first, ends || last);
            if last {
                of.ramp.filter(|_| !first)?;
                swapped = swapped.doing_as(after, input, maneuver);
            }
        }
        let mut all = self.clone();
        all.laws[arc] = swapped;
        (begins && ends && self.contacts[arc - 1].is_empty() && self.contacts[arc].is_empty()).then_some(all)
    }

    /// Neighbours of one law, with nothing touched between them, as one arc.
    pub fn joined(mut self) -> Self {
        let mut arc = 1;
        while arc < self.laws.len() {
            if self.laws[arc] == self.laws[arc - 1] && self.contacts[arc - 1].is_empty() {
                self.laws.remove(arc);
                self.contacts.remove(arc - 1);
                let length = self.lengths.remove(arc);
                self.lengths[arc - 1] += length;
            } else {
                arc += 1;
            }
        }
        self
    }

    /// The Hessian of the Lagrangian, by differences of its gradient: a length has to do with what comes after it alone, and the rest
    /// follows as it is symmetric.
    fn hessian(
        &self,
        maneuver: &Maneuver,
        followed: &Followed,
        multipliers: &DVector<f64>,
    ) -> Option<DMatrix<f64>> {
        let unknowns = self.unknowns();
        let (count, length) = (unknowns.len(), SMALL * self.duration());
        let gradient = |followed: &Followed| &followed.gradient + followed.jacobian.tr_mul(multipliers);
        let undisturbed = gradient(followed);
        let mut hessian = DMatrix::zeros(count, count);
        for (column, unknown) in unknowns.iter().enumerate() {
            let size = if unknown.is_length() { length } else { SMALL };
            let disturbed = self.disturbed(unknown, size);
            let begun = unknown.arc;
            let state = if begun == 0 { disturbed.start(maneuver) } else { followed.nodes[begun] };
            let change = gradient(&disturbed.followed_from(maneuver, begun, state)?);
            for row in column..count {
                let second = (change[row] - undisturbed[row]) / size;
                hessian[(row, column)] = second;
                hessian[(column, row)] = second;
            }
        }
        Some(hessian)
    }

    /// Stationary arcs of this order, or of fewer where some vanish; `None` where Newton does not come to any in the iterations that
    /// are left.
    pub fn solve(mut self, maneuver: &Maneuver, left: &mut usize) -> Option<Stationary> {
        self = self.parted(maneuver);
        if self.laws.len() > MOST_ARCS {
            return None;
        }
        for _ in 0..MOST_ITERATIONS {
            *left = left.checked_sub(1).filter(|_| !maneuver.is_spent())?;
            let followed = self.followed(maneuver)?;
            let newton = Newton::of(&self, maneuver, &followed)?;
            let missed = followed.equations.amax();
            let is_stationary = newton.slope < STATIONARY * (1.0 + followed.gradient.amax());
            if missed < MET && is_stationary {
                let Newton { multipliers, curvature, .. } = newton;
                return Some(Stationary { arcs: self, followed, multipliers, curvature });
            }
            if missed < MET && self.is_loose() {
                return None;
            }
            let duration = self.duration();
            let none = NO_LENGTH * duration;
            let unknowns = self.unknowns();
            let steps = || unknowns.iter().zip(newton.step.iter());
            let of_lengths = || steps().filter(|(unknown, _)| unknown.is_length()).map(|(_, step)| *step);
            let longest = of_lengths().fold(0.0, |longest: f64, step| longest.max(step.abs()));
            let mut part = (LARGEST_STEP * duration / longest).min(1.0);
            // An arc of no length that is to become shorter goes.
            let worst = of_lengths()
                .enumerate()
                .filter(|(arc, step)| self.lengths[*arc] < none && *step < -none && self.laws.len() > 1)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((arc, _)) = worst {
                self = self.swapped(maneuver, arc).unwrap_or_else(|| self.without(arc));
                continue;
            }
            if let Some(settled) = self.settled(maneuver, &newton.step) {
                self = settled;
                continue;
            }
            // No further than where the first arc vanishes, or the first level ends.
            for (unknown, step) in steps() {
                match unknown
                    .loose()
                    .and_then(|input| Some((input, self.laws[unknown.arc].levels[input].part()?)))
                {
                    Some((input, level)) => {
                        let room = maneuver.inputs[input].end_of_level(level, *step) - level;
                        if step.abs() > room.abs() {
                            part = part.min(room / step);
                        }
                    }
                    None if unknown.is_length() && *step < -none => {
                        part = part.min(-self.lengths[unknown.arc] / step)
                    }
                    None => {}
                }
            }
            let weight = MERIT * newton.multipliers.amax();
            let merit = |followed: &Followed| followed.cost + weight * followed.equations.lp_norm(1);
            let before = merit(&followed);
            let lowers = |part: f64| {
                let next = self.moved(&newton.step, part).followed(maneuver);
                let small = part * newton.step.amax() < SMALL * duration;
                small || next.is_some_and(|next| merit(&next) < before)
            };
            let mut halvings = 0;
            while !lowers(part) {
                if halvings == MOST_HALVINGS {
                    return None;
                }
                (part, halvings) = (0.5 * part, halvings + 1);
            }
            self = self.moved(&newton.step, part);
        }
        None
    }
}

/// One step of Newton.
struct Newton {
    step: DVector<f64>,
    multipliers: DVector<f64>,
    /// Largest of the gradient of the cost in the null space.
    slope: f64,
    curvature: f64,
}

impl Newton {
    fn of(arcs: &Arcs, maneuver: &Maneuver, followed: &Followed) -> Option<Self> {
        let count = followed.gradient.len();
        // All singular vectors on the right: padded to a square, the rest of them span the null space.
        let (rows, mut jacobian) = (followed.jacobian.nrows(), followed.jacobian.clone());
        if rows < count {
            jacobian = jacobian.insert_rows(rows, count - rows, 0.0);
        }
        let svd = jacobian.svd(true, true);
        let none = RANK * svd.singular_values.max();
        let (u, right) = (svd.u.as_ref()?, svd.v_t.as_ref()?);
        let of_rank: Vec<bool> = svd.singular_values.iter().map(|value| *value > none).collect();
        let mut normal = DVector::zeros(count);
        let mut multipliers = DVector::zeros(rows);
        for (index, value) in svd.singular_values.iter().enumerate().filter(|(index, _)| of_rank[*index]) {
            let left = u.column(index).rows(0, rows).into_owned();
            let along = right.row(index).transpose();
            normal -= left.dot(&followed.equations) / value * &along;
            multipliers -= along.dot(&followed.gradient) / value * left;
        }
        let null: Vec<DVector<f64>> = (0..count)
            .filter(|index| !of_rank.get(*index).copied().unwrap_or(false))
            .map(|index| right.row(index).transpose())
            .collect();
        if null.is_empty() {
            return Some(Self { step: normal, multipliers, slope: 0.0, curvature: f64::INFINITY });
        }
        let slope = null.iter().fold(0.0, |most: f64, along| most.max(along.dot(&followed.gradient).abs()));
        if arcs.is_loose() {
            // Loose inputs have nothing to gain in many directions: differences of gradients would lead along them.
            return Some(Self { step: normal, multipliers, slope, curvature: f64::INFINITY });
        }
        let null = DMatrix::from_columns(&null);
        let hessian = arcs.hessian(maneuver, followed, &multipliers)?;
        let curved = SymmetricEigen::new(null.tr_mul(&(&hessian * &null)));
        let wanted = -null.tr_mul(&(&followed.gradient + &hessian * &normal));
        let floor = LEAST_CURVATURE * curved.eigenvalues.amax();
        let mut along = curved.eigenvectors.tr_mul(&wanted);
        for (part, value) in along.iter_mut().zip(curved.eigenvalues.iter()) {
            *part /= value.abs().max(floor).max(f64::MIN_POSITIVE);
        }
        let step = normal + &null * (&curved.eigenvectors * along);
        let curvature = curved.eigenvalues.min();
        let finite = step.iter().chain(multipliers.iter()).all(|number| number.is_finite());
        finite.then_some(Self { step, multipliers, slope, curvature })
    }
}
