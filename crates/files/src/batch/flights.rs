//! Files of simulated flights of a plan, one line for each case. An interrupted run can be
//! continued, and a complete run extended.

use super::error::shown;
use super::{BatchError, Entry};
use crate::fingerprint::Fingerprint;
use crate::flown::{Runs, input_rooms};
use serde::{Deserialize, Serialize};
use slewkit::closed_loop::{Flown, Lost};
use std::path::Path;

/// First line of a file of flights, with all data on which the cases depend. It does not hold the
/// number of cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlightHeader {
    /// Version of the file format, [`FlightHeader::FORMAT`]. The name of this key identifies a file
    /// of flights.
    pub slew_flights: u32,
    /// Name and version of the program that simulates the flights.
    pub generator: String,
    /// Name of the maneuver.
    pub name: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Names of the simulated loops, in the order of the results: "closed loop", "open loop".
    pub loops: Vec<String>,
    /// Names of the constraints, in the order of the clearances of a case.
    pub constraints: Vec<String>,
    /// Number of torque limits, which is the length of the list of input margins of a case.
    #[serde(default)]
    pub input_limits: usize,
    /// Number of instants before the end at which the spacecraft must have reached a stop.
    #[serde(default)]
    pub stops: usize,
    /// Names of the uncertain parameters.
    pub parameters: Vec<String>,
    /// Hash of the plan, its gains, its uncertainty and the version of the program.
    pub fingerprint: String,
}

/// Result of one case: the end of its flight in each loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlightCase {
    /// Number of the case, counted from 1.
    pub case: u64,
    /// Values of the parameters drawn for the case; empty if the flight failed in every loop.
    pub parameters: Vec<f64>,
    /// Number of drawn inertia matrices that were rejected because no rigid body has such an
    /// inertia.
    pub rejected_inertias: u32,
    /// Result of the flight in each loop; `None` if the body turned too fast to be propagated, or
    /// if no drawn inertia was possible.
    pub loops: Vec<Option<FlightEnd>>,
}

/// Terminal error and margins of a simulated flight in one loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlightEnd {
    /// Terminal error `[ζ; δΩ]` in body axes, true minus planned: attitude error ζ \[rad\] and rate
    /// error δΩ \[rad/s\].
    pub error: [f64; 6],
    /// Attitude error ζ \[rad\] and rate error δΩ \[rad/s\], as `[ζ; δΩ]`, at each instant before
    /// the end at which the spacecraft must have reached a stop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stops: Vec<[f64; 6]>,
    /// Smallest margin to each constraint during the flight: an angle \[rad\] for cones, a fraction
    /// of the limit for rates.
    pub room: Vec<f64>,
    /// Smallest margin to each torque limit during the flight, in SI units.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub input_room: Vec<f64>,
    /// Fraction of the steps in which the commanded torque was clipped to a limit.
    pub saturated: f64,
}

impl FlightHeader {
    /// Version of the format that this program writes and reads.
    pub const FORMAT: u32 = 2;

    /// Creates the header for flights of the plan in `runs`. `closed` lists the simulated loops:
    /// true for the closed loop, false for the open loop.
    pub fn new(runs: &Runs<'_>, closed: &[bool]) -> Self {
        let Runs { problem, closed_loop, uncertainty, beside, seed, .. } = runs;
        // Numbers are formatted so that they read back to the same bits.
        let decides = format!("{problem:?} {:?} {closed_loop:?} {uncertainty:?}", beside.linear);
        Self {
            slew_flights: Self::FORMAT,
            generator: concat!("slewkit ", env!("CARGO_PKG_VERSION")).into(),
            name: problem.name.clone(),
            seed: *seed,
            loops: closed.iter().map(|closed| Runs::name(*closed).into()).collect(),
            constraints: problem.constraints.iter().map(|constraint| constraint.name.clone()).collect(),
            input_limits: input_rooms(problem),
            stops: beside.linear.stops().len(),
            parameters: uncertainty.parameters.iter().map(|(name, ..)| name.clone()).collect(),
            fingerprint: Fingerprint::of_program().and(decides.as_bytes()).text(),
        }
    }
}

impl FlightCase {
    /// Creates the result of case number `case` (counted from 1) from its flights, one for each
    /// loop.
    pub fn new(case: u64, flights: &[&Result<Flown, Lost>]) -> Self {
        let any = flights.iter().find_map(|flight| flight.as_ref().ok());
        let end = |flight: &&Result<Flown, Lost>| {
            let Flown { end, stops, room, input_room, saturated, .. } = flight.as_ref().ok()?;
            let (room, input_room) = (room.clone(), input_room.clone());
            let stops = stops.iter().map(|error| (*error).into()).collect();
            Some(FlightEnd { error: (*end).into(), stops, room, input_room, saturated: *saturated })
        };
        Self {
            case,
            parameters: any.map(|flown| flown.parameters.clone()).unwrap_or_default(),
            rejected_inertias: any.map_or(0, |flown| flown.rejected),
            loops: flights.iter().map(end).collect(),
        }
    }

    /// Returns the flights of the case, one for each loop.
    pub fn flights(&self) -> impl Iterator<Item = Result<Flown, Lost>> + '_ {
        self.loops.iter().map(|end| {
            let FlightEnd { error, stops, room, input_room, saturated } = end.as_ref().ok_or(Lost)?;
            Ok(Flown {
                end: (*error).into(),
                stops: stops.iter().map(|error| (*error).into()).collect(),
                room: room.clone(),
                input_room: input_room.clone(),
                saturated: *saturated,
                rejected: self.rejected_inertias,
                parameters: self.parameters.clone(),
            })
        })
    }
}

impl Entry for FlightCase {
    type Header = FlightHeader;

    const REMEDY: &'static str = "give another file, or delete this one";

    fn header(path: &Path, line: &[u8]) -> Result<FlightHeader, BatchError> {
        let none = || {
            let reason = format!("{} exists, but is not a file of flights", shown(path));
            BatchError::file("E0112", reason, Self::REMEDY)
        };
        // The version is read first, because another version may have other keys.
        #[derive(Deserialize)]
        struct Version {
            slew_flights: u32,
        }
        let Version { slew_flights } = serde_json::from_slice(line).map_err(|_| none())?;
        if slew_flights != FlightHeader::FORMAT {
            let reason = format!(
                "{}: the flights have format {slew_flights}, and this program reads {}",
                shown(path),
                FlightHeader::FORMAT
            );
            return Err(BatchError::file("E0112", reason, Self::REMEDY));
        }
        serde_json::from_slice(line).map_err(|_| none())
    }

    fn check(&self, header: &FlightHeader, done: u64) -> Result<(), String> {
        if self.case != done + 1 {
            return Err(format!("it is case {}, not {}", self.case, done + 1));
        }
        let is_whole = |end: &FlightEnd| {
            end.room.len() == header.constraints.len()
                && end.input_room.len() == header.input_limits
                && end.stops.len() == header.stops
        };
        let is_lost = self.loops.iter().all(Option::is_none);
        let parameters = if is_lost { 0 } else { header.parameters.len() };
        let fits = self.loops.len() == header.loops.len()
            && self.loops.iter().flatten().all(is_whole)
            && self.parameters.len() == parameters;
        if fits { Ok(()) } else { Err("its numbers contradict the first line".into()) }
    }

    fn another(found: &FlightHeader, wanted: &FlightHeader) -> String {
        if found.generator != wanted.generator {
            format!("they were written by {}, and this program is {}", found.generator, wanted.generator)
        } else if found.seed != wanted.seed {
            format!("their seed is {}, not {}", found.seed, wanted.seed)
        } else if found.loops != wanted.loops {
            let told = |loops: &[String]| shown(loops.join(" and ").as_ref());
            format!("they cover the {}, not the {}", told(&found.loops), told(&wanted.loops))
        } else {
            "the plan, its gains or its uncertainty differ".into()
        }
    }
}
