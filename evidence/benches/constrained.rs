//! Solve time of constrained slews: 100 steps, torque box, two keep-out cones, cold start.
//!
//! `cargo bench -p benches --bench constrained` prints the median time of 100 random slews that are
//! solved, the median time of plans whose discrete motion meets the end, and the numbers of
//! iterations and of solves of the interior point. `evidence/src/constrained.rs` has the law of the
//! slews.

use slewkit::maneuver::settings::Settings;
use slewkit::maneuver::solution::Outcome;
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;

fn main() {
    let settings = Settings::default();
    let (mut times, mut discrete) = (Vec::new(), Vec::new());
    let (mut winner, mut starts) = (Vec::new(), Vec::new());
    for seed in 0..150 {
        let Some(problem) = evidence::constrained::case(seed, Some(2)) else { continue };
        let best_of = |settings: &Settings| {
            let runs = (0..3).filter_map(|_| solve(&problem, settings, None, &mut Silent).ok());
            runs.min_by(|a, b| a.solve_time.total_cmp(&b.solve_time))
        };
        let Some(best) = best_of(&settings) else { continue };
        let (Outcome::Converged, Some(interior)) = (best.outcome, &best.interior) else { continue };
        times.push(1e3 * best.solve_time);
        winner.push(interior.iterations as f64);
        starts.push(interior.starts as f64);
        discrete.extend(best_of(&Settings::discrete()).map(|found| 1e3 * found.solve_time));
        if times.len() == 100 {
            break;
        }
    }
    println!("100 steps, torque box, two keep-out cones; {} slews, best of 3 runs each", times.len());
    for (name, unit, list) in [
        ("solve time", "ms", &mut times),
        ("of the discrete target", "ms", &mut discrete),
        ("iterations, winning start", "", &mut winner),
        ("solves of all starts", "", &mut starts),
    ] {
        list.sort_by(f64::total_cmp);
        let at = |share: f64| list.get((share * list.len().saturating_sub(1) as f64) as usize).copied();
        let (low, median, high) = (at(0.05), at(0.5), at(0.95));
        println!(
            "{name:<28} median {:8.1} {unit}   5 %–95 %: {:.1}–{:.1}",
            median.unwrap_or(f64::NAN),
            low.unwrap_or(f64::NAN),
            high.unwrap_or(f64::NAN)
        );
    }
}
