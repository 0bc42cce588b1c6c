//! Results of `slew fly`: statistics over many cases, the result of each case, and one case step by
//! step.

use super::plan::{Part, PointingRecord, boresights};
use super::whole::Mark;
use crate::cells::quoted;
use crate::exchange::Arrays;
use crate::export::{ExportError, write_document};
use serde::Serialize;
use slewkit::Vector3;
use slewkit::closed_loop::{Flown, Lost, Moment, Proportion, Sampled, quantile};
use slewkit::lie;
use slewkit::maneuver::Problem;
use slewkit::mechanics::LimitKind;
use slewkit::optimize::discrete::linear_plan::{Matrix6, Vector6};
use slewkit::uncertainty::{Covariance, Radius, Uncertainty};
use std::io::Write;

/// Simulated flights of a plan in one loop, with the linear prediction.
#[derive(Debug)]
pub struct Flight<'a> {
    /// Name of the loop: "closed loop" or "open loop".
    pub name: &'static str,
    /// Covariance predicted by the motion linearised about the plan.
    pub covariance: &'a Covariance,
    /// Result of each simulated case; an error if the case has no result.
    pub cases: Vec<Result<Flown, Lost>>,
}

/// Document that `slew fly` writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRecord {
    /// Name of the maneuver.
    pub name: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of cases.
    pub cases: usize,
    /// Wall time \[s\]. No other key differs between two runs.
    pub time_s: f64,
    /// Statistics of each loop.
    pub loops: Vec<LoopRecord>,
}

/// Statistics over the cases of one loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopRecord {
    /// Name of the loop: "closed loop" or "open loop".
    pub name: String,
    /// Number of cases without a result, because the motion could not be propagated.
    pub lost: usize,
    /// Number of drawn inertia matrices that were rejected because no rigid body has them. They
    /// were drawn again.
    pub rejected_inertias: u64,
    /// Fraction of the steps in which a commanded torque was clipped to a limit, averaged over the
    /// cases.
    pub saturated: f64,
    /// Statistics at the end of the flight.
    pub end: CampaignRecord,
    /// Statistics at each instant at which the spacecraft must have reached a stop of a sequence.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stops: Vec<MarkRecord>,
}

/// Attitude errors of many cases at an instant at which the spacecraft must have reached a stop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkRecord {
    /// Name of the stop.
    pub stop: String,
    /// Event at this instant: "hold begins", "hold ends" or "passed".
    pub event: String,
    /// Time of the event since the start of the sequence \[s\].
    pub time_s: f64,
    /// Quantiles of the attitude error angle \[deg\]: the angles that 50, 90, 99 and 99.73 % of the
    /// cases do not exceed.
    pub angle_quantiles_deg: [f64; 4],
    /// Standard deviation of the attitude error over the cases, in body axes \[deg\].
    pub attitude_sigma_deg: [f64; 3],
    /// Linear prediction of the standard deviations in `attitude_sigma_deg` \[deg\].
    pub attitude_sigma_linear_deg: [f64; 3],
}

impl MarkRecord {
    /// Computes the statistics at the instant `mark` from the errors of all cases and the predicted
    /// covariance.
    fn new(mark: &Mark, errors: &[Vector6], covariance: &Covariance) -> Self {
        let turns = errors.iter().map(|error| error.fixed_rows::<3>(0).norm().to_degrees());
        let turns = sorted(turns);
        let sampled = Sampled::of(errors, &Matrix6::identity());
        let predicted = |row: usize| covariance.states[mark.node][(row, row)].sqrt().to_degrees();
        Self {
            stop: mark.stop.clone(),
            event: mark.event.into(),
            time_s: mark.time,
            angle_quantiles_deg: LEVELS.map(|level| quantile(&turns, level)),
            attitude_sigma_deg: degrees(&sampled.sigma(), 0),
            attitude_sigma_linear_deg: [0, 1, 2].map(predicted),
        }
    }
}

/// Statistics at the end of many simulated flights, with their linear prediction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CampaignRecord {
    /// Mean attitude error over the cases, in body axes \[deg\].
    pub attitude_mean_deg: [f64; 3],
    /// Standard deviation of the attitude error over the cases, in body axes \[deg\].
    pub attitude_sigma_deg: [f64; 3],
    /// Linear prediction of the standard deviations in `attitude_sigma_deg` \[deg\].
    pub attitude_sigma_linear_deg: [f64; 3],
    /// Standard deviation of the angular velocity error over the cases, in body axes \[deg/s\].
    pub rate_sigma_deg_s: [f64; 3],
    /// Linear prediction of the standard deviations in `rate_sigma_deg_s` \[deg/s\].
    pub rate_sigma_linear_deg_s: [f64; 3],
    /// Quantiles of the attitude error angle \[deg\]: the angles that 50, 90, 99 and 99.73 % of the
    /// cases do not exceed.
    pub angle_quantiles_deg: [f64; 4],
    /// Smallest and largest eigenvalue of the sampled covariance relative to the predicted
    /// covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eigenvalues: Option<[f64; 2]>,
    /// Fraction of the cases whose error is inside the ellipsoid that contains 99.73 % according to
    /// the predicted covariance.
    pub inside_9973: Part,
    /// Statistics of the pointing error of each boresight.
    pub pointing: Vec<PointedRecord>,
    /// Statistics of the margin to each constraint.
    pub constraints: Vec<ConstraintRecord>,
    /// Statistics of the margin to each torque limit, for the commanded torques before saturation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<ConstraintRecord>,
}

/// Pointing error of a boresight at the end of all cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointedRecord {
    /// Linear prediction of the pointing error.
    #[serde(flatten)]
    pub linear: PointingRecord,
    /// Pointing error that 99.73 % of the simulated cases do not exceed \[deg\].
    pub sampled_9973_deg: f64,
}

/// Margin to a constraint or torque limit over all cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConstraintRecord {
    /// Name of the constraint or torque limit.
    pub name: String,
    /// Fraction of the cases that violate the constraint or limit at any time.
    pub violated: Part,
    /// Smallest margin during a flight: its median over the cases, its 0.1 % quantile, and its
    /// minimum. The unit is deg for cones; other margins are fractions of the limit.
    pub room_quantiles: [f64; 3],
}

const LEVELS: [f64; 4] = [0.5, 0.9, 0.99, 0.9973];

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn degrees(vector: &Vector6, first: usize) -> [f64; 3] {
    [0, 1, 2].map(|row| vector[first + row].to_degrees())
}

impl LoopRecord {
    /// Computes the statistics over the cases of a loop. `marks` are the instants at which the
    /// spacecraft must have reached a stop.
    pub fn new(problem: &Problem, marks: &[Mark], flight: &Flight<'_>) -> Self {
        let flown: Vec<&Flown> = flight.cases.iter().filter_map(|case| case.as_ref().ok()).collect();
        let ends: Vec<Vector6> = flown.iter().map(|flown| flown.end).collect();
        let sampled = Sampled::of(&ends, &flight.covariance.end);
        let (sigma, linear) = (sampled.sigma(), flight.covariance.end_sigma());
        let turn = |end: &Vector6| end.fixed_rows::<3>(0).norm().to_degrees();
        let angles = sorted(ends.iter().map(turn));
        let of_attitude = flight.covariance.end.fixed_view::<3, 3>(0, 0).into_owned();
        let pointing = boresights(problem).into_iter().map(|boresight| {
            let radius = Radius::of(&boresight, &of_attitude);
            let off = |end: &Vector6| {
                let turned = lie::exp(&end.fixed_rows::<3>(0).into_owned()) * boresight;
                boresight.cross(&turned).norm().atan2(boresight.dot(&turned)).to_degrees()
            };
            PointedRecord {
                linear: PointingRecord {
                    boresight_body: boresight.into(),
                    sigma_deg: radius.sigma.map(f64::to_degrees),
                    within_9973_deg: radius.within.to_degrees(),
                },
                sampled_9973_deg: quantile(&sorted(ends.iter().map(off)), LEVELS[3]),
            }
        });
        let constraints = problem.constraints.iter().enumerate().map(|(index, constraint)| {
            let unit = |room: f64| if is_cone(constraint) { room.to_degrees() } else { room };
            let rooms = sorted(flown.iter().map(|flown| flown.room[index]));
            ConstraintRecord::new(&constraint.name, &rooms, 0.0, unit)
        });
        let limits = input_limits(problem).into_iter().map(|(name, first, bounds)| {
            let least = |flown: &&Flown| {
                let rooms = flown.input_room[first..].iter().zip(&bounds);
                rooms.map(|(room, bound)| room / bound).fold(f64::INFINITY, f64::min)
            };
            ConstraintRecord::new(&name, &sorted(flown.iter().map(least)), ROUNDING, |room| room)
        });
        let count = flown.len().max(1) as f64;
        let stops = marks.iter().enumerate().map(|(index, mark)| {
            // The last instant may be the end of the flight, which `stops` does not contain.
            let error = |flown: &&Flown| flown.stops.get(index).copied().unwrap_or(flown.end);
            let errors: Vec<Vector6> = flown.iter().map(error).collect();
            MarkRecord::new(mark, &errors, flight.covariance)
        });
        Self {
            name: flight.name.into(),
            lost: flight.cases.len() - flown.len(),
            rejected_inertias: flown.iter().map(|flown| u64::from(flown.rejected)).sum(),
            saturated: flown.iter().map(|flown| flown.saturated).sum::<f64>() / count,
            end: CampaignRecord {
                attitude_mean_deg: degrees(&sampled.mean, 0),
                attitude_sigma_deg: degrees(&sigma, 0),
                attitude_sigma_linear_deg: degrees(&linear, 0),
                rate_sigma_deg_s: degrees(&sigma, 3),
                rate_sigma_linear_deg_s: degrees(&linear, 3),
                angle_quantiles_deg: LEVELS.map(|level| quantile(&angles, level)),
                eigenvalues: sampled.eigenvalues,
                inside_9973: sampled.inside.into(),
                pointing: pointing.collect(),
                constraints: constraints.collect(),
                limits: limits.collect(),
            },
            stops: stops.collect(),
        }
    }
}

impl ConstraintRecord {
    /// Computes the statistics from the margins `rooms` of all cases, sorted in increasing order. A
    /// margin below `-rounding` is a violation. `unit` converts a margin to the unit of the record.
    fn new(name: &str, rooms: &[f64], rounding: f64, unit: impl Fn(f64) -> f64) -> Self {
        let violated = rooms.iter().filter(|room| **room < -rounding).count();
        Self {
            name: name.into(),
            violated: Proportion::new(violated as u64, rooms.len() as u64).into(),
            room_quantiles: [0.5, 1e-3, 0.0].map(|level| unit(quantile(rooms, level))),
        }
    }
}

/// Relative amount by which a command may exceed its limit without counting as a violation. It
/// allows for round-off.
const ROUNDING: f64 = 1e-9;

/// Returns the torque limits: the name, the index of the first margin in [`Flown::input_room`], and
/// the bounds that the spacecraft has, without reserves.
fn input_limits(problem: &Problem) -> Vec<(String, usize, Vec<f64>)> {
    let craft = problem.of_craft();
    let mut first = 0;
    let torques = craft.actuation.limits().filter(|limit| !limit.of_force);
    let counted = torques.filter(|limit| limit.kind != LimitKind::WheelMomentum);
    let told = counted.map(|limit| {
        first += limit.bounds.len();
        (limit.name.to_string(), first - limit.bounds.len(), limit.bounds.to_vec())
    });
    told.collect()
}

/// Returns the number of margins to torque limits that a flight has.
pub fn input_rooms(problem: &Problem) -> usize {
    input_limits(problem).iter().map(|(_, _, bounds)| bounds.len()).sum()
}

fn is_cone(constraint: &slewkit::maneuver::Constraint) -> bool {
    matches!(constraint.rule, slewkit::maneuver::Rule::Pointing(_))
}

impl RunRecord {
    /// Writes the document as JSON.
    ///
    /// # Errors
    /// Returns the errors of the stream.
    pub fn write(&self, output: impl Write) -> Result<(), ExportError> {
        write_document(self, output)
    }
}

/// Columns of the table of cases: their headings, and their numbers for each case.
struct Columns<'a> {
    problem: &'a Problem,
    uncertainty: &'a Uncertainty,
    marks: &'a [Mark],
}

impl Columns<'_> {
    fn heads(&self) -> Vec<String> {
        let mut heads: Vec<String> =
            ["x", "y", "z"].map(|axis| format!("attitude_error_{axis}_rad")).to_vec();
        heads.extend(["x", "y", "z"].map(|axis| format!("rate_error_{axis}_rad_s")));
        for constraint in &self.problem.constraints {
            let unit = if is_cone(constraint) { "_rad" } else { "" };
            heads.push(format!("room {}{unit}", constraint.name));
        }
        let limits = input_limits(self.problem);
        heads.extend(limits.iter().flat_map(|(name, _, bounds)| {
            (1..=bounds.len()).map(move |index| {
                let of = if bounds.len() > 1 { format!(" {index}") } else { String::new() };
                format!("room {name}{of}")
            })
        }));
        let of_mark = |mark: &Mark| format!("attitude_error {}, {}_rad", mark.stop, mark.event);
        heads.extend(self.marks.iter().map(of_mark));
        heads.extend(["saturated".into(), "rejected_inertias".into()]);
        heads.extend(self.uncertainty.parameters.iter().map(|(name, ..)| name.clone()));
        heads
    }

    /// Returns the numbers of a case in the order of the columns; NaN if the case has no result.
    fn row(&self, case: &Result<Flown, Lost>) -> Vec<f64> {
        let Ok(flown) = case else { return vec![f64::NAN; self.heads().len()] };
        let mut row: Vec<f64> = flown.end.iter().copied().collect();
        row.extend(&flown.room);
        row.extend(&flown.input_room);
        let errors = (0..self.marks.len()).map(|index| flown.stops.get(index).unwrap_or(&flown.end));
        row.extend(errors.map(|error| error.fixed_rows::<3>(0).norm()));
        row.extend([flown.saturated, f64::from(flown.rejected)]);
        row.extend(&flown.parameters);
        row
    }
}

/// Writes the results of all cases, which are numbered from 1. If `as_arrays` is true, they are NPZ
/// arrays, with NaN for a case without a result; otherwise a CSV table, with empty cells.
///
/// # Errors
/// Returns the errors of the stream.
pub fn write_cases(
    (problem, uncertainty, marks): (&Problem, &Uncertainty, &[Mark]),
    flights: &[Flight<'_>],
    as_arrays: bool,
    output: &mut dyn Write,
) -> Result<(), ExportError> {
    let columns = Columns { problem, uncertainty, marks };
    let heads = columns.heads();
    if as_arrays {
        let mut arrays = Arrays::new(output);
        for flight in flights {
            let prefix = flight.name.replace(' ', "_");
            let rows: Vec<f64> = flight.cases.iter().flat_map(|case| columns.row(case)).collect();
            arrays.add(&format!("{prefix}_cases"), flight.cases.len(), heads.len(), &rows)?;
        }
        return Ok(arrays.close()?);
    }
    writeln!(output, "loop,case,{}", heads.iter().map(|head| quoted(head)).collect::<Vec<_>>().join(","))?;
    for flight in flights {
        for (index, case) in flight.cases.iter().enumerate() {
            write!(output, "{},{}", flight.name, index + 1)?;
            for number in columns.row(case) {
                if number.is_nan() { write!(output, ",")? } else { write!(output, ",{number:?}")? }
            }
            writeln!(output)?;
        }
    }
    Ok(())
}

/// Writes one case step by step as CSV; `inputs` is the number of inputs.
///
/// # Errors
/// Returns the errors of the stream.
pub fn write_trace(inputs: usize, moments: &[Moment], output: &mut dyn Write) -> Result<(), ExportError> {
    let commanded: Vec<String> = (1..=inputs).map(|index| format!("command_{index}")).collect();
    writeln!(
        output,
        "time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z,angular_velocity_x_rad_s,\
         angular_velocity_y_rad_s,angular_velocity_z_rad_s,attitude_error_x_rad,attitude_error_y_rad,\
         attitude_error_z_rad,rate_error_x_rad_s,rate_error_y_rad_s,rate_error_z_rad_s,{}",
        commanded.join(",")
    )?;
    let mut before = [1.0, 0.0, 0.0, 0.0];
    for moment in moments {
        let mut quaternion = lie::quaternion_from_rotation(&moment.attitude);
        if quaternion.iter().zip(before).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
            quaternion = quaternion.map(|part| -part);
        }
        before = quaternion;
        write!(output, "{:?}", moment.time)?;
        let rate: &Vector3 = &moment.angular_velocity;
        for number in quaternion.iter().chain(rate.iter()).chain(moment.beside.iter()) {
            write!(output, ",{number:?}")?;
        }
        // At the end of the flight no command is given, so its cells are empty.
        for index in 0..inputs {
            match moment.commanded.get(index) {
                Some(number) => write!(output, ",{number:?}")?,
                None => write!(output, ",")?,
            }
        }
        writeln!(output)?;
    }
    Ok(())
}
