//! Reading of `[environment]`: gravity and other external forces and torques.

use super::boundary::Boundary;
use super::{Section, short, show};
use slewkit::maneuver::Motion;
use slewkit::mechanics::{
    CentralGravity, Environment, EnvironmentError, Free, GravityGradient, Inertia, SecondOrderGravity,
    UniformGravity,
};
use slewkit::numerics::figures::{rounded, told_apart};
use std::sync::Arc;

/// The table `[environment]`, with the data of the spec that its checks need.
pub(crate) struct Surroundings<'a> {
    pub section: Option<&'a Section>,
    pub motion: Motion,
    /// Mass of the body \[kg\].
    pub mass: Option<f64>,
    /// Table of the spec that contains the boundary states, for messages.
    pub place: &'static str,
}

/// Largest mean motion of an orbit \[rad/s\]: √(4πGρ/3), the mean motion at the surface of a sphere
/// with the density of osmium, ρ = 22 600 kg/m³. No planet or moon is as dense.
const FASTEST_ORBIT: f64 = 0.0025;
/// Largest relative difference between the total mass of the points and the mass of the body that
/// counts as rounding.
const MASS_ROUNDING: f64 = 1e-9;

impl Surroundings<'_> {
    /// Reads the environment. If the table is absent, no external force or torque acts.
    pub fn read(&self, inertia: Option<&Inertia>) -> Option<Arc<dyn Environment>> {
        let Some(section) = &self.section else { return Some(Arc::new(Free)) };
        let kind = section.word("kind")?;
        let moves = kind == "central_gravity";
        if moves && self.motion == Motion::Attitude {
            let reason = "central_gravity acts on position and attitude, but no position is given";
            let remedy = format!(
                "add `position_m` and `velocity_m_s` to {}; or use kind = \"gravity_gradient\"",
                self.place
            );
            return section.refuse("E0085", "kind", reason, remedy);
        }
        if !moves && self.motion == Motion::RigidBody {
            let reason = format!("{kind} acts on the attitude only, but positions are given");
            let remedy = "remove `position_m` and `velocity_m_s`, or use kind = \"central_gravity\"";
            return section.refuse("E0085", "kind", reason, remedy);
        }
        match kind {
            "uniform_gravity" => {
                let environment = UniformGravity::new(
                    section.number("mass_kg")?,
                    section.number("gravity_m_s2")?,
                    section.vector("direction")?,
                    section.vector("pivot_to_mass_center_m")?,
                );
                accept(environment, section)
            }
            "gravity_gradient" => {
                let rate = section.number("orbital_rate_rad_s")?;
                if rate.abs() > FASTEST_ORBIT {
                    let reason = format!(
                        "no orbit has the rate {} rad/s: around the densest matter it is at most \
                        {FASTEST_ORBIT} rad/s, above the Earth 0.00124",
                        show(rate)
                    );
                    let per_second = show(rate.to_radians());
                    let remedy = format!(
                        "{} deg/s is {per_second} rad/s, and a period of T seconds 2 pi/T",
                        show(rate)
                    );
                    section.warn("W0072", "orbital_rate_rad_s", reason, remedy);
                }
                let environment = GravityGradient::new(rate, inertia?);
                accept(environment, section)
            }
            _ => self.central_gravity(section, inertia),
        }
    }

    fn central_gravity(&self, section: &Section, inertia: Option<&Inertia>) -> Option<Arc<dyn Environment>> {
        let parameter = section.number("gravitational_parameter_m3_s2");
        if section.word("body")? == "second_order" {
            if section.has("points") {
                let reason = "`points` are given, but body = \"second_order\" does not use them";
                let remedy = "remove `points`, or write body = \"points\"";
                section.error("E0028", "points", reason, remedy);
            }
            let environment = SecondOrderGravity::new(parameter?, self.mass?, inertia?);
            return accept(environment, section);
        }
        let points = section.list("points");
        if points.is_empty() {
            if !section.has("points") || section.is_empty_list("points") {
                let reason = "body = \"points\" needs `points`";
                let remedy = "add points = [ { mass_kg = 0.5, position_m = [0.15, 0, 0] }, … ]";
                section.error("E0021", "points", reason, remedy);
            }
            return None;
        }
        let points: Option<Vec<_>> = points
            .iter()
            .map(|point| Some((point.number("mass_kg")?, point.vector("position_m")?)))
            .collect();
        let (points, mass) = (points?, self.mass?);
        let sum: f64 = points.iter().map(|(mass, _)| mass).sum();
        if (sum - mass).abs() > MASS_ROUNDING * mass {
            let (sum, mass) = (short(sum), show(mass));
            let reason =
                format!("the masses of the points sum to {sum} kg, but the mass of the body is {mass} kg");
            return section.refuse("E0087", "points", reason, "make the sum equal to the mass of the body");
        }
        accept(CentralGravity::of_masses(parameter?, points), section)
    }

    /// Checks that the boundary states satisfy the requirements of the environment; the first state
    /// in `ends` is the start.
    pub fn check_ends(&self, ends: &[&Boundary<'_>]) {
        let Some(section) = &self.section else { return };
        match section.word("kind") {
            Some("gravity_gradient") => {
                for end in ends {
                    let told = end.section.rate_key().is_some() || end.rests_in_orbit();
                    if !told && !end.section.has("angular_momentum_body_n_m_s") {
                        let reason = format!(
                            "[{}] needs an angular velocity: under gravity_gradient, rest relative to \
                            LVLH and inertial rest differ",
                            end.section.path
                        );
                        let remedy = "add angular_velocity = \"at rest in LVLH\", or angular_velocity_rad_s, \
                         inertial, in body axes; LVLH here is e1 along the velocity, e2 the orbit \
                         normal, e3 outward; lvlh_axes = \"velocity_antinormal_nadir\" has z to nadir";
                        end.section.error_here("E0021", reason, remedy);
                    }
                }
            }
            Some("central_gravity") => {
                let points = section.list("points");
                let reach = points.iter().filter_map(|point| point.vector("position_m"));
                let reach = reach.map(|position| position.norm()).fold(1e-30, f64::max);
                for end in ends {
                    let Some(radius) = end.position.map(|position| position.norm()) else { continue };
                    if radius <= reach {
                        let reach = if points.is_empty() { 0.0 } else { reach };
                        let [radius, reach] = told_apart([radius, reach], 4, rounded);
                        let reason = format!(
                            "the distance from the attracting point is {radius} m, but the body has \
                            the radius {reach} m: they touch"
                        );
                        let remedy = "the attracting point is at the origin; check `position_m` (m, not km?)";
                        end.section.error("E0083", "position_m", reason, remedy);
                    }
                }
                if let Some(start) = ends.first() {
                    self.warn_escape(section, start);
                }
            }
            _ => {}
        }
    }

    /// Warns if the orbit through the start state is not closed.
    fn warn_escape(&self, section: &Section, start: &Boundary<'_>) {
        let parameter = section.number("gravitational_parameter_m3_s2");
        if let (Some(parameter), Some(position), Some(velocity)) = (parameter, start.position, start.velocity)
        {
            let escape = (2.0 * parameter / position.norm()).sqrt();
            let speed = velocity.norm();
            if speed > escape {
                let [speed, escape] = told_apart([speed, escape], 4, rounded);
                let reason = format!(
                    "the start is on a hyperbolic orbit: speed {speed} m/s, escape velocity {escape} m/s"
                );
                let remedy = "no action is needed if this is intended; else check units and the gravitational \
                    parameter";
                start.section.warn("W0083", "velocity_m_s", reason, remedy);
            }
        }
    }
}

fn accept<E: Environment + 'static>(
    environment: Result<E, EnvironmentError>,
    section: &Section,
) -> Option<Arc<dyn Environment>> {
    let told = |error: &EnvironmentError| match error {
        EnvironmentError::NoDirection { .. } => {
            let remedy = "give the direction in which bodies fall, for example [0, 0, 1]";
            ("E0054", section.spot("direction"), remedy)
        }
        _ => ("E0086", section.here(), "check the numbers of [environment]"),
    };
    Some(Arc::new(section.report.accept(environment, told)?))
}
