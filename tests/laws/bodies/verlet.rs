//! Lie group velocity Verlet (3.22–3.26), written out for these tests.

use slewkit::lie::{exp, vee};
use slewkit::mechanics::body::Body;
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::Potential;
use slewkit::mechanics::full_body::invariants::Momentum;
use slewkit::{Matrix3, Vector3};

/// Returns `F` of `S(g) = F J_d − J_d Fᵀ` by Newton: `δg = E F ξ`, `E = tr(F J_d) I − F J_d`.
fn implicit(g: &Vector3, j_d: &Matrix3) -> Matrix3 {
    let mut f = Matrix3::identity();
    for _ in 0..20 {
        let fj = f * j_d;
        let residual = g - vee(&(fj - fj.transpose()));
        let slope = (fj.trace() * Matrix3::identity() - fj) * f;
        f *= exp(&slope.lu().solve(&residual).unwrap());
    }
    f
}

/// Takes one step of length `h`; `wrenches` holds the wrenches at `poses` before and after.
pub fn step(
    bodies: &[Body],
    potential: &dyn Potential,
    h: f64,
    poses: &mut [Pose],
    momenta: &mut [Momentum],
    wrenches: &mut [Wrench],
) {
    for (((body, pose), momentum), wrench) in
        bodies.iter().zip(&mut *poses).zip(&mut *momenta).zip(&*wrenches)
    {
        momentum.linear += 0.5 * h * wrench.force;
        momentum.angular += 0.5 * h * wrench.moment;
        pose.position += h / body.mass.unwrap() * momentum.linear;
        let f = implicit(&(h * momentum.angular), body.inertia.j_d());
        pose.attitude *= f;
        momentum.angular = f.tr_mul(&momentum.angular);
    }
    potential.wrenches(poses, wrenches);
    for (momentum, wrench) in momenta.iter_mut().zip(&*wrenches) {
        momentum.linear += 0.5 * h * wrench.force;
        momentum.angular += 0.5 * h * wrench.moment;
    }
}
