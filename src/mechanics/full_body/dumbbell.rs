//! Dumbbells: two equal spheres on a massless rod. Their mutual potential has a closed form.
//!
//! Let `a = R e₁ l/2`. The four pairs of spheres of two dumbbells, at the distance vectors
//! `d_pq = x_i + p a_i − x_j − q a_j`, give
//! ```text
//! U = −(G m_i m_j/4) Σ_{p,q = ±1} 1/|d_pq|                  g_pq = −(G m_i m_j/4) d_pq/|d_pq|³
//! f_i = Σ g_pq     M_i = (l_i/2) e₁ × R_iᵀ Σ p g_pq        f_j = −f_i     M_j = −(l_j/2) e₁ × R_jᵀ Σ q g_pq
//! ```
//! (equation 3.8 and the potential of section 3.4, with its sign). The result is exact for
//! homogeneous spheres, which attract as points do.

use super::error::{Checked, count};
use super::{MassPoint, PointCloud, Potential};
use crate::mechanics::body::{Body, Inertia};
use crate::mechanics::environment::{Pose, Symmetry, Wrench};
use crate::mechanics::number::{finite, positive};
use crate::{Matrix3, Vector3};

/// Two equal homogeneous spheres joined by a massless rod along the first body axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dumbbell {
    /// Total mass of both spheres \[kg\].
    pub mass: f64,
    /// Distance `l` between the centres of the spheres \[m\].
    pub length: f64,
    /// Radius of a sphere \[m\]. It affects only the inertia.
    pub sphere_radius: f64,
}

impl Dumbbell {
    /// Returns the inertia `diag(J_a, J_a + m l²/4, J_a + m l²/4)`, `J_a = (2/5) m r²` [kg·m²],
    /// body axes.
    pub fn inertia(&self) -> Matrix3 {
        let axial = 0.4 * self.mass * self.sphere_radius.powi(2);
        let across = axial + 0.25 * self.mass * self.length.powi(2);
        Matrix3::from_diagonal(&Vector3::new(axial, across, across))
    }

    /// Returns the rigid body for the integrators.
    ///
    /// # Errors
    /// Returns an [`InertiaError`](crate::mechanics::body::InertiaError) if the inertia is invalid,
    /// as for a radius of zero.
    pub fn body(&self) -> Result<Body, crate::mechanics::body::InertiaError> {
        Ok(Body { inertia: Inertia::new(self.inertia())?, mass: Some(self.mass) })
    }

    /// Returns the two spheres as a cloud of two point masses.
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](super::FullBodyError) if mass or length is not a positive
    /// number.
    pub fn cloud(&self) -> Checked<PointCloud> {
        self.check()?;
        let ends = [0.5, -0.5].map(|side| MassPoint {
            mass: 0.5 * self.mass,
            position: Vector3::new(side * self.length, 0.0, 0.0),
        });
        PointCloud::new(ends.to_vec())
    }

    fn check(&self) -> Checked<()> {
        positive("mass of a dumbbell", self.mass)?;
        positive("length of a dumbbell", self.length)?;
        Ok(())
    }
}

/// The mutual gravity of dumbbells.
#[derive(Clone, Debug, PartialEq)]
pub struct Dumbbells {
    gravitational_constant: f64,
    /// For each dumbbell, the mass of one sphere \[kg\] and half the length of the rod \[m\].
    halves: Vec<(f64, f64)>,
}

impl Dumbbells {
    /// The largest number of dumbbells. Their pairs are summed one by one.
    pub const BODIES: usize = 10_000;

    /// Builds the mutual gravity of `dumbbells`, with the gravitational constant `G` [m³/(kg·s²)].
    ///
    /// # Errors
    /// Returns a [`FullBodyError`](super::FullBodyError) if the list is empty or too long, or if
    /// the constant, a mass or a length is not a positive number.
    pub fn new(gravitational_constant: f64, dumbbells: &[Dumbbell]) -> Checked<Self> {
        positive("gravitational constant", gravitational_constant)?;
        count("dumbbells", dumbbells.len(), Self::BODIES)?;
        dumbbells.iter().try_for_each(Dumbbell::check)?;
        let total: f64 = dumbbells.iter().map(|dumbbell| dumbbell.mass).sum();
        finite(
            "gravitational constant times the square of the masses",
            gravitational_constant * total * total,
        )?;
        let halves = dumbbells.iter().map(|dumbbell| (0.5 * dumbbell.mass, 0.5 * dumbbell.length)).collect();
        Ok(Self { gravitational_constant, halves })
    }

    /// Returns the strength `G m_i m_j/4`, offset `x_i − x_j` and half rods `a_i`, `a_j` of every
    /// pair.
    fn pairs(&self, poses: &[Pose]) -> impl Iterator<Item = Pair> {
        assert_eq!(poses.len(), self.halves.len(), "one pose per dumbbell");
        let rod = |i: usize| self.halves[i].1 * poses[i].attitude.column(0);
        (0..poses.len()).flat_map(move |i| {
            (i + 1..poses.len()).map(move |j| Pair {
                bodies: (i, j),
                strength: self.gravitational_constant * self.halves[i].0 * self.halves[j].0,
                offset: poses[i].position - poses[j].position,
                rods: (rod(i), rod(j)),
            })
        })
    }
}

struct Pair {
    bodies: (usize, usize),
    strength: f64,
    offset: Vector3,
    rods: (Vector3, Vector3),
}

/// The signs p, q of the four pairs of spheres.
const ENDS: [(f64, f64); 4] = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];

impl Pair {
    /// Returns the vector `d_pq` between two spheres.
    fn distance(&self, (p, q): (f64, f64)) -> Vector3 {
        self.offset + p * self.rods.0 - q * self.rods.1
    }
}

impl Potential for Dumbbells {
    /// Returns full symmetry, because the energy depends only on relative poses.
    fn symmetry(&self) -> Symmetry {
        Symmetry::All
    }

    fn energy(&self, poses: &[Pose]) -> f64 {
        let of = |pair: Pair| {
            -pair.strength * ENDS.iter().map(|&ends| 1.0 / pair.distance(ends).norm()).sum::<f64>()
        };
        self.pairs(poses).map(of).sum()
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        wrenches.fill(Wrench::zero());
        // The moments hold Σ ± g, in the reference frame, until all pairs are summed.
        for pair in self.pairs(poses) {
            let (mut force, mut first, mut second) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for (p, q) in ENDS {
                let d = pair.distance((p, q));
                let squared = d.norm_squared();
                let g = -pair.strength / (squared * squared.sqrt()) * d;
                force += g;
                first += p * g;
                second += q * g;
            }
            let (i, j) = pair.bodies;
            wrenches[i].force += force;
            wrenches[i].moment += first;
            wrenches[j].force -= force;
            wrenches[j].moment -= second;
        }
        for ((wrench, pose), (_, half)) in wrenches.iter_mut().zip(poses).zip(&self.halves) {
            let across = *half * pose.attitude.tr_mul(&wrench.moment);
            wrench.moment = Vector3::new(0.0, -across.z, across.y);
        }
    }
}
