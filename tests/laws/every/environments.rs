//! Environments: derivatives against dual numbers, reference vectors, limits, rejected input.

use crate::evidence::{Random, difference, largest, list, matrix, matrix3, number, reference, vector};
use nalgebra::{SMatrix, SVector};
use num_dual::{Dual, Dual64, DualNum};
use slewkit::lie::hat;
use slewkit::mechanics::body::Inertia;
use slewkit::mechanics::environment::*;
use slewkit::{Matrix3, Vector3};

/// Three nested dual numbers: one for each derivative of the potential.
type D = Dual<Dual<Dual64>>;
type Position = SVector<D, 3>;
type Attitude = SMatrix<D, 3, 3>;

/// The formula of a potential for dual numbers.
type Potential = Box<dyn Fn(&Position, &Attitude) -> D>;

/// An environment and its potential.
struct Case {
    name: &'static str,
    environment: Box<dyn Environment>,
    potential: Potential,
    /// Distance of the mass center from the origin [m].
    distance: f64,
}

fn case(
    name: &'static str,
    environment: impl Environment + 'static,
    distance: f64,
    potential: impl Fn(&Position, &Attitude) -> D + 'static,
) -> Case {
    Case { name, environment: Box::new(environment), potential: Box::new(potential), distance }
}

/// Returns every environment. A new environment is one line here.
fn environments() -> Vec<Case> {
    let points = cloud();
    vec![
        case("free", Free, 0.0, |_, _| real(0.0)),
        case("uniform gravity", pendulum(), 0.0, |_, r| -lift(&down()).dot(&(r * lift(&ARM))) * (1.3 * 9.81)),
        case("gravity gradient, LVLH", GravityGradient::new(0.9, &inertia()).unwrap(), 0.0, |_, r| {
            orbit(r, &Vector3::z()) * (1.5 * 0.9 * 0.9)
        }),
        case("gravity gradient, fixed", fixed_gradient(), 0.0, |_, r| orbit(r, &down()) * (1.5 * 0.7 * 0.7)),
        case("central gravity", CentralGravity::new(cloud()).unwrap(), 2.0, move |x, r| {
            points.iter().fold(real(0.0), |u, p| u - norm(&(x + r * lift(&p.position))).recip() * p.parameter)
        }),
        case("second-order gravity", SecondOrderGravity::new(1.9, 0.8, &inertia()).unwrap(), 2.0, |x, r| {
            let (d, kx) = (norm(x), r * lift_matrix(inertia().j()) * r.transpose() * x);
            let quadrupole = d.powi(-3) * inertia().j().trace() - x.dot(&kx) * d.powi(-5) * 3.0;
            -d.recip() * (1.9 * 0.8) - quadrupole * (0.5 * 1.9)
        }),
    ]
}

const ARM: Vector3 = Vector3::new(0.1, -0.2, 0.9);

fn down() -> Vector3 {
    Vector3::new(0.48, -0.6, 0.64)
}

fn inertia() -> Inertia {
    Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap()
}

fn pendulum() -> UniformGravity {
    UniformGravity::new(1.3, 9.81, down(), ARM).unwrap()
}

fn fixed_gradient() -> GravityGradient {
    GravityGradient::along_fixed_direction(0.7, &inertia(), down()).unwrap()
}

/// Returns three points without symmetry, mass center at zero.
fn cloud() -> Vec<PointMass> {
    [(1.0, [0.3, 0.1, -0.2]), (0.5, [-0.2, 0.4, 0.6]), (0.25, [-0.8, -1.2, -0.4])]
        .map(|(parameter, position)| PointMass { parameter, position: Vector3::from(position) })
        .to_vec()
}

fn real(value: f64) -> D {
    D::from(value)
}

fn lift(v: &Vector3) -> Position {
    v.map(real)
}

fn lift_matrix(m: &Matrix3) -> Attitude {
    m.map(real)
}

fn norm(v: &Position) -> D {
    v.dot(v).sqrt()
}

/// Returns `G·JG`, `G = Rᵀo`.
fn orbit(r: &Attitude, outward: &Vector3) -> D {
    let g = r.transpose() * lift(outward);
    g.dot(&(lift_matrix(inertia().j()) * g))
}

/// A variation `(δx, ζ)`, or costates dual to one.
type Variation = SVector<f64, 6>;

fn unit(i: usize) -> Variation {
    Variation::ith(i, 1.0)
}

/// `U` at the pose moved by `v[0]`, from there by `v[1]`, from there by `v[2]`, each infinitesimal
/// with its own dual part: `x + Σ δx`, `R (I + S(ζ₀)) (I + S(ζ₁)) (I + S(ζ₂))`.
fn moved_potential(case: &Case, pose: &Pose, v: [&Variation; 3]) -> D {
    let infinitesimal = [
        D::new(Dual::new(Dual64::new(0.0, 1.0), Dual64::from(0.0)), Dual::from(0.0)),
        D::new(Dual::new(Dual64::from(0.0), Dual64::from(1.0)), Dual::from(0.0)),
        D::new(Dual::from(0.0), Dual::from(1.0)),
    ];
    let (mut x, mut r) = (lift(&pose.position), lift_matrix(&pose.attitude));
    for (epsilon, v) in infinitesimal.into_iter().zip(v) {
        x += lift(&v.fixed_rows::<3>(0).into_owned()) * epsilon;
        r += r * lift_matrix(&hat(&v.fixed_rows::<3>(3).into_owned())) * epsilon;
    }
    (case.potential)(&x, &r)
}

/// Returns `[f; M]`, minus the derivative of the potential.
fn dual_wrench(case: &Case, pose: &Pose) -> Variation {
    let zero = Variation::zeros();
    Variation::from_fn(|i, _| -moved_potential(case, pose, [&zero, &zero, &unit(i)]).eps.re.re)
}

/// Returns `Γ`, whose column `j` is the derivative of `[f; M]` along the variation `j`.
fn dual_gradient(case: &Case, pose: &Pose) -> SMatrix<f64, 6, 6> {
    let zero = Variation::zeros();
    SMatrix::from_fn(|i, j| -moved_potential(case, pose, [&zero, &unit(j), &unit(i)]).eps.eps.re)
}

/// Returns `𝒯`, whose entry (i, j) is the derivative along `j` of `λ·Γ` along `i`.
fn dual_curvature(case: &Case, pose: &Pose, costates: &Variation) -> SMatrix<f64, 6, 6> {
    SMatrix::from_fn(|i, j| -moved_potential(case, pose, [&unit(j), &unit(i), costates]).eps.eps.eps)
}

fn joined(wrench: &Wrench) -> Variation {
    let mut both = Variation::zeros();
    both.fixed_rows_mut::<3>(0).copy_from(&wrench.force);
    both.fixed_rows_mut::<3>(3).copy_from(&wrench.moment);
    both
}

fn assembled(blocks: &Blocks) -> SMatrix<f64, 6, 6> {
    let mut all = SMatrix::<f64, 6, 6>::zeros();
    for (block, (i, j)) in
        [(blocks.xx, (0, 0)), (blocks.xr, (0, 3)), (blocks.rx, (3, 0)), (blocks.rr, (3, 3))]
    {
        all.fixed_view_mut::<3, 3>(i, j).copy_from(&block);
    }
    all
}

const POSES: usize = 60;

/// Returns random poses at the distance of the case, and costates.
fn samples(case: &Case) -> Vec<(Pose, Wrench)> {
    let mut random = Random::new(11);
    (0..POSES)
        .map(|_| {
            let position = case.distance * (1.0 + 0.3 * random.uniform()) * random.direction();
            let pose = Pose { position, attitude: random.rotation() };
            (pose, Wrench { force: random.vector(), moment: random.vector() })
        })
        .collect()
}

/// Runs the comparison on every environment; the error is relative to the largest element expected
/// in the same 3-row, 3-column block over all the poses, so that no block hides behind a larger
/// one.
fn assert_agreement<const C: usize>(
    tolerance: f64,
    compare: impl Fn(&Case, &Pose, &Wrench) -> [SMatrix<f64, 6, C>; 2],
) {
    for case in environments() {
        let pairs: Vec<_> =
            samples(&case).iter().map(|(pose, costates)| compare(&case, pose, costates)).collect();
        for i in 0..2 {
            for j in 0..C.div_ceil(3) {
                let range = ((3 * i, 3 * j), (3, C.min(3)));
                let mut scale = 0.0_f64;
                for [_, expected] in &pairs {
                    scale = scale.max(expected.view(range.0, range.1).amax());
                }
                for (pose, [found, expected]) in pairs.iter().enumerate() {
                    let (found, expected) = (found.view(range.0, range.1), expected.view(range.0, range.1));
                    let error = largest(&(found - expected));
                    assert!(
                        error <= tolerance * scale,
                        "{}, pose {pose}, block ({i}, {j}): off by {:e} of {scale}\n{found}{expected}",
                        case.name,
                        error / scale
                    );
                }
            }
        }
    }
}

#[test]
fn potential_is_the_one_written_out() {
    for case in environments() {
        for (pose, _) in samples(&case) {
            let zero = Variation::zeros();
            let expected = moved_potential(&case, &pose, [&zero, &zero, &zero]).re.re.re;
            let found = case.environment.potential(&pose);
            assert!(
                (found - expected).abs() <= 2e-15 * expected.abs().max(1.0),
                "{}: {found}, {expected}",
                case.name
            );
        }
    }
}

#[test]
fn force_and_moment_are_minus_the_derivative_of_the_potential() {
    assert_agreement(4e-15, |case, pose, _| {
        [joined(&case.environment.wrench(pose)), dual_wrench(case, pose)]
    });
}

#[test]
fn gradient_is_the_derivative_of_force_and_moment() {
    assert_agreement(4e-15, |case, pose, _| {
        [assembled(&case.environment.gradient(pose)), dual_gradient(case, pose)]
    });
}

#[test]
fn curvature_is_the_derivative_of_the_transposed_gradient_on_the_costates() {
    assert_agreement(8e-15, |case, pose, costates| {
        let found = case.environment.curvature(pose, costates);
        [assembled(&found), dual_curvature(case, pose, &joined(costates))]
    });
}

#[test]
fn only_the_free_body_and_vanishing_fields_are_free() {
    for case in environments() {
        assert_eq!(case.environment.is_free(), case.name == "free", "{}", case.name);
    }
    assert!(UniformGravity::new(1.0, 0.0, down(), ARM).unwrap().is_free());
    assert!(UniformGravity::new(1.0, 9.81, down(), Vector3::zeros()).unwrap().is_free());
    assert!(GravityGradient::new(0.0, &inertia()).unwrap().is_free());
}

#[test]
fn only_the_orbital_frame_turns_and_about_its_normal() {
    for case in environments() {
        let expected =
            if case.name.ends_with("LVLH") { Vector3::new(0.0, 0.9, 0.0) } else { Vector3::zeros() };
        assert_eq!(case.environment.frame_rate(), expected, "{}", case.name);
    }
}

/// Returns the pose with this attitude at the origin.
fn attitude(r: Matrix3) -> Pose {
    Pose { position: Vector3::zeros(), attitude: r }
}

fn close<const R: usize, const C: usize>(a: &SMatrix<f64, R, C>, b: &SMatrix<f64, R, C>, tolerance: f64) {
    let error = difference(a, b);
    assert!(error <= tolerance, "off by {error:e}\n{a}{b}");
}

/// Returns the environments of the attitude files, whose numbers are in trajectories.json.
fn reference_environment(name: &str) -> Box<dyn Environment> {
    let file = reference("trajectories");
    match name {
        "free" => Box::new(Free),
        "pendulum" => {
            let (mg, rho) = (number(&file["pendulum"]["mg"]), vector(&file["pendulum"]["rho"]));
            Box::new(UniformGravity::new(mg, 1.0, Vector3::z(), rho).unwrap())
        }
        "gravity_gradient" => {
            let (n2, o) = (number(&file["gravity_gradient"]["n2"]), vector(&file["gravity_gradient"]["o"]));
            let inertia = Inertia::new(matrix3(&file["J"])).unwrap();
            Box::new(GravityGradient::along_fixed_direction(n2.sqrt(), &inertia, o).unwrap())
        }
        _ => panic!("{name}"),
    }
}

#[test]
fn moment_and_potential_agree_with_the_reference_trajectories() {
    let file = reference("trajectories");
    let pose = attitude(matrix3(&file["R0"]));
    for name in ["free", "pendulum", "gravity_gradient"] {
        let (environment, start) = (reference_environment(name), &file["trajectories"][name]);
        close(&environment.wrench(&pose).moment, &vector(&start["M0"]), 1e-15);
        assert!((environment.potential(&pose) - number(&start["U0"])).abs() <= 1e-15, "{name}");
    }
}

#[test]
fn moment_derivatives_agree_with_the_reference_linearisation() {
    let file = reference("linearisation");
    for case in list(&file["cases"]) {
        let environment = reference_environment(case["potential"].as_str().unwrap());
        // The kick of a step acts at its end.
        let pose = attitude(matrix3(&case["R"]) * matrix3(&case["F"]));
        close(&environment.gradient(&pose).rr, &matrix3(&case["MR"]), 2e-15);
        let costates = Wrench {
            force: Vector3::zeros(),
            moment: matrix::<1, 6>(&serde_json::json!([case["lam"]])).fixed_columns::<3>(3).transpose(),
        };
        close(&environment.curvature(&pose, &costates).rr, &matrix3(&case["N_p"]), 4e-15);
    }
}

#[test]
fn cloud_derivatives_agree_with_the_reference_dumbbell() {
    let file = reference("min_energy_se3");
    let points = list(&file["k"])
        .iter()
        .zip(list(&file["rho"]))
        .map(|(k, rho)| PointMass { parameter: number(k), position: vector(rho) })
        .collect();
    let environment = CentralGravity::new(points).unwrap();
    let at = &file["linearisation"];
    let pose = Pose { position: vector(&at["x"]), attitude: matrix3(&at["R"]) };
    let lam = matrix::<1, 12>(&serde_json::json!([at["lam"]])).transpose();
    let costates = Wrench { force: lam.fixed_rows::<3>(3).into(), moment: lam.fixed_rows::<3>(9).into() };
    close(&assembled(&environment.gradient(&pose)), &matrix::<6, 6>(&at["G"]), 2e-15);
    close(&assembled(&environment.curvature(&pose, &costates)), &matrix::<6, 6>(&at["T"]), 8e-15);
}

#[test]
fn second_order_gravity_is_the_gravity_gradient_of_its_place() {
    let mut random = Random::new(12);
    for _ in 0..20 {
        let (mu, x, r) = (1.9, 3.0 * random.direction(), random.rotation());
        let n = f64::sqrt(mu / x.norm().powi(3));
        let second_order = SecondOrderGravity::new(mu, 0.8, &inertia()).unwrap();
        let local = GravityGradient::along_fixed_direction(n, &inertia(), x).unwrap();
        let pose = Pose { position: x, attitude: r };
        close(&second_order.wrench(&pose).moment, &local.wrench(&pose).moment, 1e-15);
        close(&second_order.gradient(&pose).rr, &local.gradient(&pose).rr, 1e-15);
    }
}

/// Returns six points in opposite pairs.
fn symmetric_cloud() -> Vec<PointMass> {
    [(0.3, [0.9, 0.2, -0.1]), (0.2, [-0.2, 0.7, 0.3]), (0.4, [0.1, -0.3, 0.5])]
        .into_iter()
        .flat_map(|(parameter, position)| {
            [1.0, -1.0].map(|side| PointMass { parameter, position: side * Vector3::from(position) })
        })
        .collect()
}

#[test]
fn second_order_gravity_is_the_limit_of_small_clouds() {
    let mut random = Random::new(13);
    let pose = Pose { position: random.direction(), attitude: random.rotation() };
    // Relative errors of force and moment for a cloud shrunk to `size`, in a field μ = 1, seen from
    // a distance of 1.
    let errors = |cloud: &[PointMass], size: f64| {
        let points: Vec<_> =
            cloud.iter().map(|point| PointMass { position: size * point.position, ..*point }).collect();
        let mass = points.iter().map(|point| point.parameter).sum();
        let j = points
            .iter()
            .fold(Matrix3::zeros(), |j, point| j - point.parameter * hat(&point.position).pow(2));
        let exact = CentralGravity::new(points).unwrap().wrench(&pose);
        let approximate =
            SecondOrderGravity::new(1.0, mass, &Inertia::new(j).unwrap()).unwrap().wrench(&pose);
        [
            (approximate.force - exact.force).norm() / exact.force.norm(),
            (approximate.moment - exact.moment).norm() / exact.moment.norm(),
        ]
    };
    for (cloud, orders) in [(cloud(), [3.0, 1.0]), (symmetric_cloud(), [4.0, 2.0])] {
        let (whole, half) = (errors(&cloud, 0.01), errors(&cloud, 0.005));
        for i in 0..2 {
            let order = (whole[i] / half[i]).log2();
            assert!((order - orders[i]).abs() <= 0.05, "{order}, not {} ({i})", orders[i]);
        }
    }
}

#[test]
fn directions_of_any_length_mean_the_same() {
    let pose = attitude(Random::new(14).rotation());
    for length in [1e-200, 3.0, 1e200] {
        let scaled = UniformGravity::new(1.3, 9.81, length * down(), ARM).unwrap();
        close(&scaled.wrench(&pose).moment, &pendulum().wrench(&pose).moment, 1e-14);
        let scaled = GravityGradient::along_fixed_direction(0.7, &inertia(), length * down()).unwrap();
        close(&scaled.wrench(&pose).moment, &fixed_gradient().wrench(&pose).moment, 1e-15);
    }
}

#[test]
fn wrong_numbers_are_rejected_by_name() {
    let (nan, zero) = (f64::NAN, Vector3::zeros());
    let bad = Vector3::new(0.0, f64::INFINITY, 0.0);
    let point = |parameter, position| CentralGravity::new(vec![PointMass { parameter, position }]).map(drop);
    let cases = [
        (UniformGravity::new(0.0, 9.81, down(), ARM).map(drop), "mass is 0; it must be positive"),
        (UniformGravity::new(nan, 9.81, down(), ARM).map(drop), "mass is not finite"),
        (UniformGravity::new(1.0, -9.81, down(), ARM).map(drop), "gravity is -9.81; it must not be negative"),
        (UniformGravity::new(1.0, nan, down(), ARM).map(drop), "gravity is not finite"),
        (UniformGravity::new(1.0, 9.81, bad, ARM).map(drop), "direction of gravity is not finite"),
        (
            UniformGravity::new(1.0, 9.81, zero, ARM).map(drop),
            "direction of gravity is the zero vector and has no direction",
        ),
        (UniformGravity::new(1.0, 9.81, down(), bad).map(drop), "pivot to mass center is not finite"),
        (
            UniformGravity::new(1e200, 1e200, down(), ARM).map(drop),
            "mass times gravity times arm is not finite",
        ),
        (GravityGradient::new(-1.0, &inertia()).map(drop), "orbital rate is -1; it must not be negative"),
        (GravityGradient::new(nan, &inertia()).map(drop), "orbital rate is not finite"),
        (
            GravityGradient::new(1e200, &inertia()).map(drop),
            "orbital rate squared times inertia is not finite",
        ),
        (
            GravityGradient::along_fixed_direction(1.0, &inertia(), zero).map(drop),
            "outward direction is the zero vector and has no direction",
        ),
        (CentralGravity::new(Vec::new()).map(drop), "the body has no point masses"),
        (point(0.0, ARM), "parameter of a point mass is 0; it must be positive"),
        (point(nan, ARM), "parameter of a point mass is not finite"),
        (point(1.0, bad), "position of a point mass is not finite"),
        (
            point(1.0, ARM),
            "the mass center of the point masses is at (0.1, -0.2, 0.9) m in body axes; it must be the origin",
        ),
        (
            SecondOrderGravity::new(0.0, 1.0, &inertia()).map(drop),
            "gravitational parameter is 0; it must be positive",
        ),
        (SecondOrderGravity::new(1.0, -1.0, &inertia()).map(drop), "mass is -1; it must be positive"),
        (
            SecondOrderGravity::new(1e200, 1e200, &inertia()).map(drop),
            "gravitational parameter times mass is not finite",
        ),
        (
            SecondOrderGravity::new(1.7e308, 1.0, &inertia()).map(drop),
            "gravitational parameter times inertia is not finite",
        ),
    ];
    for (result, message) in cases {
        assert_eq!(result.map_err(|error| error.to_string()), Err(message.to_owned()));
    }
}
