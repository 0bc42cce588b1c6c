//! An environment of your own: a magnetic dipole `m`, fixed to the body, in a constant field `b`.
//!
//! ```text
//! G = Rᵀb     U = −m·G     M = m × G     M_R = S(m) S(G)     𝒯 = S(p × m) S(G)
//! ```
//!
//! `cargo run --release --example own_environment`

use slewkit::lie::{exp, hat};
use slewkit::{
    Blocks, Body, Environment, Inertia, Matrix3, Pose, Problem, Settings, Silent, State, Status, Vector3,
    Wrench, plan,
};

#[derive(Clone, Debug)]
struct Dipole {
    moment: Vector3,
    field: Vector3,
}

impl Environment for Dipole {
    fn potential(&self, pose: &Pose) -> f64 {
        -self.moment.dot(&pose.attitude.tr_mul(&self.field))
    }
    fn wrench(&self, pose: &Pose) -> Wrench {
        Wrench { moment: self.moment.cross(&pose.attitude.tr_mul(&self.field)), ..Wrench::zero() }
    }
    fn gradient(&self, pose: &Pose) -> Blocks {
        Blocks { rr: hat(&self.moment) * hat(&pose.attitude.tr_mul(&self.field)), ..Blocks::zero() }
    }
    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        let turned = hat(&costates.moment.cross(&self.moment));
        Blocks { rr: turned * hat(&pose.attitude.tr_mul(&self.field)), ..Blocks::zero() }
    }
}

/// Returns the largest difference of moment, gradient and curvature from central differences of
/// what they derive.
fn derivative_error(field: &Dipole, attitude: Matrix3) -> f64 {
    let step = 1e-5;
    let at = |axis: usize, size: f64| Pose {
        position: Vector3::zeros(),
        attitude: attitude * exp(&(Vector3::ith(axis, size))),
    };
    let here = at(0, 0.0);
    let costates = Wrench { moment: Vector3::new(0.3, -0.7, 0.5), ..Wrench::zero() };
    let mut worst = 0.0f64;
    for axis in 0..3 {
        let (ahead, behind) = (at(axis, step), at(axis, -step));
        let slope = (field.potential(&ahead) - field.potential(&behind)) / (2.0 * step);
        let moment = (field.wrench(&ahead).moment - field.wrench(&behind).moment) / (2.0 * step);
        let dual = |pose: &Pose| field.gradient(pose).rr.tr_mul(&costates.moment);
        let bend = (dual(&ahead) - dual(&behind)) / (2.0 * step);
        worst = worst.max((slope + field.wrench(&here).moment[axis]).abs());
        worst = worst.max((moment - field.gradient(&here).rr.column(axis)).amax());
        worst = worst.max((bend - field.curvature(&here, &costates).rr.column(axis)).amax());
    }
    worst
}

fn main() {
    let field = Dipole { moment: Vector3::new(0.0, 0.0, 0.8), field: Vector3::new(0.6, 0.0, 0.8) };
    let derivatives = derivative_error(&field, exp(&Vector3::new(0.5, -1.0, 0.3)));
    println!("derivatives against differences  {derivatives:.1e}");

    let inertia = Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1)).expect("a physical inertia");
    let end = State::at_rest(exp(&Vector3::new(0.0, 1.5, 0.5)));
    let free = Problem::attitude(Body { inertia, mass: None }, State::at_rest(Matrix3::identity()), end, 2.0);
    let pulled = free.clone().with_environment(field);
    let solve = |problem| plan(problem, &Settings::default(), None, &mut Silent).expect("a valid problem");
    let (without, with) = (solve(&free), solve(&pulled));
    println!("cost without the field           {:.6}", without.solution.cost);
    println!("cost with it                     {:.6}   {}", with.solution.cost, with.status.name());

    assert!(derivatives < 1e-9);
    assert_eq!((without.status, with.status), (Status::Solved, Status::Solved));
    assert!((with.solution.cost - without.solution.cost).abs() > 1e-3);
}

#[test]
fn runs() {
    main();
}
