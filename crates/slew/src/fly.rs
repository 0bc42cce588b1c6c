//! `slew fly`: a plan flown by a craft that differs from it, again and again.

use super::{
    Console, Destination, Exit, Failure, Format, Message, OutputArgs, Reading, interrupt, spec_file,
};
use clap::ValueEnum;
use slewkit::assured::Beside;
use slewkit::closed_loop::{Campaign, Flown, Lost};
use slewkit::maneuver::{Outcome, Problem};
use slewkit::uncertainty::Uncertainty;
use slewkit_files::export::{ExportError, PlanFile};
use slewkit_files::flown::{Flight, LoopRecord, RunRecord, write_cases, write_trace};
use slewkit_files::spec::{ClosedLoop, Loaded};
use slewkit_report::summary::flown as told;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `slew fly`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
What the craft differs by stands in [uncertainty] of the spec that the plan holds, its gains in [feedback], how its
actuators follow in [plant]; --set changes any of them. The plan stays: `slew monte-carlo` plans every draw anew.

Every case flies the continuous motion of its own inertia under torques held over a tick, with the noise, the errors and
the delays of its own; the random numbers of a case depend on the seed and its number alone. CSV and NPZ hold a row a
case, JSON what all say together; with --case, CSV holds that case step by step.

Examples:
  slew plan maneuver.toml -o plan.json && slew fly plan.json
  slew fly plan.json --cases 100000 -o cases.npz
  slew fly plan.json --set uncertainty.inertia.relative=0.05 --format json
  slew fly plan.json --case 17 -o case.csv")]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; `-` reads stdin
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Number of cases
    #[arg(long, value_name = "NUMBER", default_value = "1000", value_parser = clap::value_parser!(u64).range(2..=Campaign::MOST_CASES))]
    pub cases: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "NUMBER", default_value = "1")]
    pub seed: u64,
    /// Fly this case alone, counted from 0, and show it step by step
    #[arg(long, value_name = "NUMBER")]
    pub case: Option<u64>,
    /// Which loop: with the gains of the plan, without, or both side by side
    #[arg(long = "loop", value_name = "LOOP", default_value = "both")]
    pub which: Which,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Which loop is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Which {
    /// With the gains of the plan
    Closed,
    /// Without gains
    Open,
    /// Both
    Both,
}

/// Formats that can hold cases.
const FORMATS: [Format; 4] = [Format::Text, Format::Json, Format::Csv, Format::Npz];

/// Cases between two looks at what the user wants: some tenths of a second.
const CHUNK: usize = 4096;

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(&FORMATS, &[&args.plan])?;
    let unusable = |error: ExportError| Failure::unusable(&args.plan, &error);
    let plan = PlanFile::read(spec_file::open_plan(&args.plan)?).map_err(unusable)?;
    let held = plan.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let Loaded { problem, closed_loop, .. } = spec_file::read_held(held, &args.plan, &args.reading, console)?;
    if plan.outcome != Outcome::Converged {
        let reason = format!("{}: this plan did not reach its end", args.plan.display());
        return Err(Failure::File(Message::new("E0173", reason, "fly a plan that is solved")));
    }
    let problem = plan.on_grid(&problem).map_err(unusable)?;
    let Some(uncertainty) = &closed_loop.uncertainty else {
        let reason = "the plan says nothing that the craft could differ by: it would fly as planned";
        let remedy = "give it [uncertainty] in its spec, or as --set uncertainty.inertia.relative=0.02";
        return Err(Failure::File(Message::new("E0173", reason, remedy)));
    };
    let trajectory = &plan.trajectory.0;
    let beside =
        Beside::along(&problem, trajectory, closed_loop.feedback, Some(uncertainty)).map_err(|error| {
            Failure::File(Message::new(
                "E0170",
                error.to_string(),
                "give [feedback] kind = \"tvlqr\", or none",
            ))
        })?;
    let flown = Runs { args, problem: &problem, closed_loop: &closed_loop, uncertainty, beside: &beside };
    match args.case {
        Some(case) => flown.one(case, &destination, console),
        None => flown.all(&destination, console),
    }
}

/// A plan that is flown.
struct Runs<'a> {
    args: &'a Args,
    problem: &'a Problem,
    closed_loop: &'a ClosedLoop,
    uncertainty: &'a Uncertainty,
    beside: &'a Beside,
}

impl Runs<'_> {
    fn campaign(&self, closed: bool) -> Campaign<'_> {
        let gains = self.beside.gains.as_ref().filter(|_| closed);
        let plant = self.closed_loop.plant;
        Campaign::new(self.problem, &self.beside.linear, gains, self.uncertainty, plant, self.args.seed)
    }

    /// The loops that are asked for: closed, open.
    fn loops(&self) -> Result<Vec<bool>, Failure> {
        let has = self.beside.gains.is_some();
        match self.args.which {
            Which::Closed if !has => {
                let remedy = "give it [feedback] in its spec, or as --set feedback.kind=tvlqr";
                Err(Failure::File(Message::new("E0173", "the plan has no gains", remedy)))
            }
            Which::Closed => Ok(vec![true]),
            Which::Open => Ok(vec![false]),
            Which::Both => Ok(if has { vec![true, false] } else { vec![false] }),
        }
    }

    fn one(&self, case: u64, destination: &Destination, console: &mut Console) -> Result<Exit, Failure> {
        if matches!(destination.format(), Some(Format::Npz | Format::Json)) {
            let reason = "one case is a table of its steps";
            return Err(Failure::Output(Message::new("E0107", reason, "give -o FILE.csv")));
        }
        let closed = self.loops()?[0];
        let Ok((flown, moments)) = self.campaign(closed).traced(case) else {
            let reason = format!("case {case} turns faster than can be followed, or its inertia is none");
            return Err(Failure::Problem(Message::new(
                "E0174",
                reason,
                "fly another case, or make less uncertain",
            )));
        };
        let inputs = self.problem.actuation.torque.count();
        console.say(&told::case(self.problem, self.uncertainty, case, closed, &flown).join("\n"));
        destination.write(console, |_, output| write_trace(inputs, &moments, output))?;
        Ok(Exit::Solved)
    }

    fn all(&self, destination: &Destination, console: &mut Console) -> Result<Exit, Failure> {
        interrupt::watch();
        let began = Instant::now();
        let mut flights = Vec::new();
        for closed in self.loops()? {
            let campaign = self.campaign(closed);
            let mut cases: Vec<Result<Flown, Lost>> = Vec::new();
            while (cases.len() as u64) < self.args.cases && !interrupt::requested() {
                let left = self.args.cases - cases.len() as u64;
                let count = (left as usize).min(CHUNK);
                cases.extend(campaign.fly_all(cases.len() as u64, count));
                let (done, all) = (cases.len(), self.args.cases);
                console.progress(|| format!("  {done} of {all} cases"));
            }
            let covariance = if closed { &self.beside.closed } else { &self.beside.open };
            if let Some(covariance) = covariance {
                flights.push(Flight {
                    name: if closed { "closed loop" } else { "open loop" },
                    covariance,
                    cases,
                });
            }
        }
        let record = RunRecord {
            name: self.problem.name.clone(),
            seed: self.args.seed,
            cases: flights.first().map_or(0, |flight| flight.cases.len()),
            time_s: began.elapsed().as_secs_f64(),
            loops: flights.iter().map(|flight| LoopRecord::new(self.problem, flight)).collect(),
        };
        let stopped = interrupt::requested();
        interrupt::writing();
        console.say(&told::runs(console.colour, &record).join("\n"));
        destination.write(console, |format, output| match format {
            Format::Json => record.write(output),
            _ => {
                let as_arrays = format == Format::Npz;
                write_cases(self.problem, self.uncertainty, &flights, as_arrays, output)
            }
        })?;
        Ok(if stopped { Exit::Plan(slewkit::plan::Status::Interrupted) } else { Exit::Solved })
    }
}
