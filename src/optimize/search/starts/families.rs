//! Families of paths from which descents start, and their number, depending on the maneuver and the
//! thoroughness.

use crate::Vector3;
use crate::maneuver::problem::{Motion, Path, Problem};
use crate::maneuver::settings::Thoroughness;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::search::starts::paths::{self, Paces};
use std::f64::consts::TAU;

/// Uncontrolled rotation below which a body needs few starts \[rad\].
const SLOW: f64 = 1e-3;
/// Uncontrolled rotation above which the search also varies how the body brakes \[rad\].
const FAST: f64 = 3.0;
/// Uncontrolled rotation above which a body may brake at any phase of its rotation \[rad\].
const TUMBLING: f64 = 10.0;
/// Ratio of the largest to the smallest principal moment above which random paths from both ends
/// are used for a moving body (`evidence -- unequal_moments`).
const UNEQUAL: f64 = 4.0;
/// Full turns about the axis of the smallest moment that are added to paths of a body with unequal
/// moments. The turns cost little, and the gyroscopic torques of a spinning rod bend its path.
const TWISTS: [i32; 4] = [1, -1, 2, -2];
/// Largest number of minima on the coarse grid that are refined on the requested grid.
const MOST_MINIMA: usize = 6;
/// Largest number of minima that are followed further for a body with unequal moments, whose minima
/// are so close that the coarse grid sorts them wrongly.
const MOST_MINIMA_UNEQUAL: usize = 8;
/// Number of random paths by default.
const RANDOM: usize = 24;
/// Number of random paths for a free body whose uncontrolled rotation is less than `TUMBLING`.
const RANDOM_FREE: usize = 56;
/// Number of random paths from each end for a body with unequal moments.
const RANDOM_UNEQUAL: usize = 16;
/// Number of random paths if inputs about an axis are missing; twice as many if inputs about an
/// axis are costly.
const RANDOM_FEW_INPUTS: usize = 72;
/// Number of random paths in a thorough search.
const RANDOM_THOROUGH: usize = 160;
/// Number of successive hops between minima without a new lowest minimum after which the search
/// ends, if inputs about an axis are missing or costly; twice as many in a thorough search.
const HOPS: usize = 48;

/// Families of paths from which a search starts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts {
    /// Rotation vector to follow, if one is given.
    given: Option<Vector3>,
    /// Numbers of additional turns, one for each smooth path.
    smooth: Vec<i32>,
    /// Numbers of additional turns, one for each coasting path.
    coasting: Vec<i32>,
    /// Paces of slowed coasts.
    slowed: Paces,
    /// Amplitudes of bent paths \[rad\].
    bent: Vec<f64>,
    random: usize,
    /// True if smooth and random paths also begin at the end, which gives other paths.
    from_end: bool,
    /// Axis of the smallest moment, if promising paths are twisted about it.
    pub twist: Option<Vector3>,
    /// Number of successive hops between minima without a new lowest minimum after which the search
    /// ends.
    pub hops: usize,
}

impl Starts {
    /// Returns the families of paths for a maneuver.
    pub fn of<const N: usize>(
        problem: &Problem,
        bvp: &BoundaryValueProblem<N>,
        thoroughness: Thoroughness,
    ) -> Self {
        let dynamics = &bvp.dynamics;
        let few = !dynamics.has_all_axes();
        let stiff = dynamics.is_stiff();
        let coupled = problem.motion == Motion::RigidBody && dynamics.is_coupled();
        let simple = problem.environment.is_free() && !few && !stiff && !coupled;
        let turned = problem.start.angular_velocity.norm().max(problem.end.angular_velocity.norm())
            * problem.seconds();
        let given = if let Path::AsGiven(rotation) = problem.path { Some(rotation) } else { None };
        let turns = super::wanted_turns(problem);
        let plain = Self { given, smooth: turns.clone(), coasting: turns, ..Self::default() };
        let simple_slew = simple && turned <= SLOW && thoroughness == Thoroughness::Default;
        if given.is_some()
            || problem.path != Path::Best && (simple_slew || thoroughness == Thoroughness::Quick)
        {
            return plain;
        }
        let (hops, random) = match (few, stiff) {
            (true, _) => (HOPS, RANDOM_FEW_INPUTS),
            (false, true) => (HOPS, 2 * RANDOM_FEW_INPUTS),
            (false, false) => (0, RANDOM),
        };
        // Half of the random paths are in the other homotopy class; they are skipped if one class
        // is requested.
        let senses = if problem.path == Path::Best { 1 } else { 2 };
        let twist =
            (simple && turned > SLOW && is_unequal(problem)).then(|| problem.body.inertia.least_axis());
        let all = Self { hops, random: senses * random, from_end: twist.is_some(), twist, ..Self::all() };
        match thoroughness {
            Thoroughness::Quick => {
                let all = Self { from_end: false, twist: None, ..all };
                Self { slowed: Paces::None, bent: Vec::new(), random: 0, hops: 0, ..all }
            }
            Thoroughness::Thorough => Self { random: senses * RANDOM_THOROUGH, hops: 2 * HOPS, ..all },
            Thoroughness::Default if simple && turned <= SLOW => {
                Self { smooth: vec![0, -1], ..Self::default() }
            }
            // Gyroscopic torques are comparable to the control torques, so many minima are close
            // together.
            Thoroughness::Default if simple && turned <= TUMBLING && is_unequal(problem) => {
                Self { slowed: Paces::Even, bent: Vec::new(), random: senses * RANDOM_UNEQUAL, ..all }
            }
            Thoroughness::Default if simple && turned <= FAST => {
                Self { slowed: Paces::None, bent: Vec::new(), random: 0, ..all }
            }
            // Paths shifted in phase lead to the same few minima here; random paths lead to more.
            Thoroughness::Default if simple && turned <= TUMBLING => {
                Self { slowed: Paces::Even, random: senses * RANDOM_FREE, ..all }
            }
            Thoroughness::Default => all,
        }
    }

    /// Returns whether there are more families than one path per homotopy class.
    pub fn is_wide(&self) -> bool {
        self.slowed != Paces::None || !self.bent.is_empty() || self.random > 0 || self.smooth.len() > 2
    }

    /// Returns all families of paths, with the default number of random paths.
    pub fn all() -> Self {
        Self {
            smooth: vec![0, -1, 1, -2],
            coasting: vec![0, -1, 1],
            slowed: Paces::Shifted,
            bent: vec![2.0, 1.0],
            random: RANDOM,
            from_end: false,
            twist: None,
            given: None,
            hops: 0,
        }
    }

    /// Returns the paths: promising ones first, then the other families interleaved, since a search
    /// may end before the last.
    pub fn paths<const N: usize>(&self, bvp: &BoundaryValueProblem<N>) -> Vec<Candidate> {
        let as_given = |rotation: &Vector3| paths::smooth(bvp, "as given".into(), rotation, paths::straight);
        let mut out: Vec<Candidate> = self.given.iter().map(as_given).collect();
        out.extend(paths::smooth_ways(bvp, &self.smooth));
        out.extend(paths::coasting(bvp, &self.coasting).unwrap_or_default());
        let slowed = paths::slowed(bvp, self.slowed);
        let bent = self.bent.iter().flat_map(|by| paths::bent(bvp, *by)).collect();
        let mut random: Vec<Candidate> = paths::random(bvp, self.random).collect();
        if self.from_end {
            let reversed = bvp.reversed();
            out.extend(paths::smooth_ways(&reversed, &self.smooth).map(backwards));
            // Interleaved, since a search may end before the last.
            let others = paths::random(&reversed, self.random).map(backwards);
            random = random.into_iter().zip(others).flat_map(|(one, other)| [one, other]).collect();
        }
        if let Some(axis) = &self.twist {
            let twisted = TWISTS
                .iter()
                .flat_map(|turns| out.iter().map(|path| paths::twisted(bvp, path, axis, *turns)));
            out.extend(twisted.collect::<Vec<_>>());
        }
        out.extend(in_turn([slowed, bent, random]));
        out
    }
}

/// Converts a path of the time-reversed maneuver.
fn backwards(mut path: Candidate) -> Candidate {
    path.states.reverse();
    path.provenance.start.push_str(" from the end");
    path
}

/// Returns the largest angle of the turns that are added about the axis of the smallest moment
/// \[rad\], for a moving body with unequal moments; zero for other bodies.
pub fn twisted_by(problem: &Problem) -> f64 {
    let moves = [&problem.start, &problem.end].iter().any(|end| end.angular_velocity != Vector3::zeros());
    if moves && is_unequal(problem) { TAU * f64::from(TWISTS.into_iter().max().unwrap_or(0)) } else { 0.0 }
}

/// Returns the largest number of minima on the coarse grid that are refined on the requested grid.
pub fn most_minima(problem: &Problem) -> usize {
    if is_unequal(problem) { MOST_MINIMA_UNEQUAL } else { MOST_MINIMA }
}

/// Returns whether the moments of a body differ so much that random paths lead to minima that no
/// other paths find.
fn is_unequal(problem: &Problem) -> bool {
    let moments = problem.body.inertia.principal();
    moments[2] > UNEQUAL * moments[0]
}

/// Interleaves several lists so that each is spread evenly over the result.
fn in_turn(lists: [Vec<Candidate>; 3]) -> Vec<Candidate> {
    let mut placed: Vec<(f64, Candidate)> = Vec::new();
    for list in lists {
        let count = list.len() as f64;
        let place = |(index, candidate): (usize, Candidate)| ((index as f64 + 0.5) / count, candidate);
        placed.extend(list.into_iter().enumerate().map(place));
    }
    placed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    placed.into_iter().map(|(_, candidate)| candidate).collect()
}
