//! Compares the plans of a maneuver with the plans of its symmetric maneuvers: time-reversed, three
//! mirror images, permuted body axes.
//!
//! `cargo run --release -p evidence -- images [COUNT [KIND [FIRST]]]`, 100 of each kind by default.
//! Symmetric maneuvers differ only in their description, so their costs should be equal. Each line
//! states the number of maneuvers whose costs agree to 1e-4 (or up to the gaps), the number of
//! maneuvers whose original has the lowest cost, the largest excess over a symmetric maneuver, how
//! often only some of them are solved, and the computing time. `evidence::switching` has the laws
//! of the random maneuvers.

use evidence::metamorphic::images;
use evidence::switching::{KINDS, cost_and_gap, maneuver};
use evidence::words::Words;
use slewkit::maneuver::{Problem, Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

/// The relative difference up to which two costs agree.
const SAME: f64 = 1e-4;

/// The results of one maneuver and its symmetric maneuvers.
struct Compared {
    index: u64,
    costs: Vec<(&'static str, Option<f64>)>,
    gap: f64,
    seconds: Vec<f64>,
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: u64 = words.number("number of cases", 100)?;
    let all = ["all"].into_iter().chain(KINDS.map(|(name, _)| name)).collect::<Vec<_>>();
    let asked = words.one_of("kind", &all)?.filter(|word| word != "all");
    let first: u64 = words.number("number of the first case", 0)?;
    words.end()?;
    let kinds = KINDS.into_iter().filter(|(name, _)| asked.as_ref().is_none_or(|asked| asked == name));
    for (name, kind) in kinds {
        let (next, all) = (AtomicU64::new(first), Mutex::new(Vec::new()));
        thread::scope(|scope| {
            for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= first + count {
                            break;
                        }
                        let found = maneuver(kind, index).map(|problem| compared(index, &problem));
                        all.lock().unwrap().extend(found);
                    }
                });
            }
        });
        let mut all = all.into_inner()?;
        all.sort_by_key(|one: &Compared| one.index);
        tell(name, &all);
    }
    Ok(())
}

fn tell(name: &str, all: &[Compared]) {
    let (mut same, mut best_first, mut partly, mut worst) = (0, 0, 0, 0.0_f64);
    let mut seconds: Vec<f64> = Vec::new();
    for Compared { index, costs, gap, seconds: taken } in all {
        seconds.extend(taken);
        let solved = costs.iter().filter_map(|(name, cost)| Some((name, (*cost)?)));
        let Some((of, least)) = solved.clone().min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let most = solved.map(|(_, cost)| cost).fold(0.0, f64::max);
        let apart = most / least - 1.0;
        let lacks = costs.iter().any(|(_, cost)| cost.is_none());
        let one = apart <= SAME.max(*gap) && !lacks;
        let first = costs[0].1.is_some_and(|cost| cost <= least * (1.0 + SAME.max(*gap)));
        same += usize::from(one);
        best_first += usize::from(first);
        partly += usize::from(lacks);
        worst = worst.max(apart);
        if !one {
            let told = costs.iter().map(|(name, cost)| match cost {
                Some(cost) => format!("{name} {cost:.6}"),
                None => format!("{name} none"),
            });
            println!("  {name} {index}: best {of}; {}", told.collect::<Vec<_>>().join(", "));
        }
    }
    seconds.sort_by(f64::total_cmp);
    let slowest = |one: &Compared| one.seconds.iter().copied().fold(0.0, f64::max);
    let slow = all.iter().max_by(|a, b| slowest(a).total_cmp(&slowest(b))).map_or(0, |one| one.index);
    let at =
        |part: f64| seconds.get((seconds.len().saturating_sub(1) as f64 * part) as usize).map_or(0.0, |s| *s);
    println!(
        "{name:<14} {:>5} maneuvers: one answer {same}, the first is the best {best_first}, solved in some \
            images only {partly}, \
         worst {:.2} %; median {:.3} s, 99 % {:.2} s, most {:.2} s ({slow})",
        all.len(),
        100.0 * worst,
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

fn compared(index: u64, problem: &Problem) -> Compared {
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let (mut gap, mut seconds) = (0.0_f64, Vec::new());
    let mut cost_of = |problem: &Problem| {
        let began = Instant::now();
        let planned = plan(problem, &settings, None, &mut Silent).ok();
        seconds.push(began.elapsed().as_secs_f64());
        let planned = planned.filter(|plan| plan.status == Status::Solved)?;
        let (cost, of_plan) = cost_and_gap(&planned);
        gap = gap.max(of_plan);
        Some(cost)
    };
    let mut costs = vec![("itself", cost_of(problem))];
    costs.extend(images(problem).iter().map(|(name, image)| (*name, cost_of(image))));
    Compared { index, costs, gap, seconds }
}
