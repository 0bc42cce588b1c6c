//! Counts how often a slew with torque limits and keep-out cones is solved from a cold start.
//!
//! `cargo run --release -p evidence -- constrained_robustness [CASES [FOLDER]]` plans CASES (2 000
//! by default) by the law of `evidence::constrained`. A case that is neither solved nor proved
//! infeasible is printed with all attempts, and with the result without its cones. With a FOLDER,
//! each of these cases is also written as a JSON plan file. For these cases the command counts how
//! often a shortest duration is found, and how much longer it is than the given one.

use evidence::words::Words;
use slewkit::maneuver::{Problem, Rung, Settings};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::export::PlanFile;
use std::collections::BTreeMap;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = words.number("number of cases", 2000)?;
    let folder = words.take();
    words.end()?;
    let settings = Settings::default();
    let (mut times, mut winner, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    let mut tally = BTreeMap::<&str, usize>::new();
    let mut worst = f64::INFINITY;
    let (mut unsolved, mut by_torque) = (0, 0);
    let mut excess = Vec::new();
    for seed in 0..count {
        let Some(problem) = evidence::constrained::case(seed, None) else {
            *tally.entry("no unconstrained slew").or_default() += 1;
            continue;
        };
        let found = plan(&problem, &settings, None, &mut Silent)?;
        let solution = &found.solution;
        times.push(solution.solve_time);
        *tally.entry(found.status.name()).or_default() += 1;
        if let Some(interior) = &solution.interior {
            winner.push(interior.iterations);
            starts.push(interior.starts);
        }
        if found.status == Status::Solved {
            let margins = found.verification.iter().flat_map(|verification| &verification.margins);
            worst = margins.map(|margin| margin.scaled).fold(worst, f64::min);
            continue;
        }
        println!("case {seed}: {}, {}", found.status.name(), problem.name);
        match &solution.shortfall {
            Some(shortfall) => println!("    {shortfall}"),
            None => println!("    nothing is known to be missing"),
        }
        let without = Problem { constraints: Vec::new(), ..problem.clone() };
        let without = plan(&without, &settings, None, &mut Silent)?.status;
        println!("    without the cones: {}", without.name());
        unsolved += 1;
        excess.extend(solution.shortest.map(|shortest| 100.0 * (shortest / problem.seconds() - 1.0)));
        by_torque += usize::from(without != Status::Solved);
        for rung in solution.ladder.iter().filter(|rung| rung.rung == Rung::InteriorPoint) {
            let left = rung.residuals.last().copied().unwrap_or(f64::NAN);
            println!(
                "    {} {}: {:?} after {}, {left:.1e}",
                rung.rung, rung.start, rung.outcome, rung.iterations
            );
        }
        if let Some(folder) = &folder {
            std::fs::create_dir_all(folder)?;
            let file = std::fs::File::create(format!("{folder}/case_{seed}.json"))?;
            PlanFile::new(&problem, &settings, &found).write(file)?;
        }
    }
    let at = |list: &mut Vec<usize>, share: f64| {
        list.sort_unstable();
        list.get((share * list.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(0)
    };
    times.sort_by(f64::total_cmp);
    let time = |share: f64| 1e3 * times[(share * (times.len() - 1) as f64) as usize];
    println!("{tally:?}; smallest scaled margin of what is called solved: {worst:.1e}");
    println!("of {unsolved} not solved, {by_torque} are not solved without the cones either");
    excess.sort_by(f64::total_cmp);
    if let (Some(least), Some(most)) = (excess.first(), excess.last()) {
        let median = excess[excess.len() / 2];
        println!(
            "for {} a shortest duration: {least:.3} to {most:.1} % longer, median {median:.1} %",
            excess.len()
        );
    }
    println!(
        "iterations of the winning start: median {}, 95 % {}",
        at(&mut winner, 0.5),
        at(&mut winner, 0.95)
    );
    println!("solves of all starts: median {}, 95 % {}", at(&mut starts, 0.5), at(&mut starts, 0.95));
    println!("solve time: median {:.1} ms, 95 % {:.1} ms, worst {:.1} ms", time(0.5), time(0.95), time(1.0));
    Ok(())
}
