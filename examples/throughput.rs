//! How many maneuvers a second: one thread against several, and what a long Monte Carlo run holds in memory.
//!
//! `cargo run --release --example throughput -- [CASES] [STEPS]`: slews of a free asymmetric body between states of
//! rest, end attitudes drawn within a ball of rotation vectors of 1.5 rad, verified by all witnesses, through the
//! batch with a file of results, as `slew monte-carlo` runs them.

use slewkit::batch::{Batch, Journal, Options, Shard, Tally, run};
use slewkit::files::spec::{Base, Format, Override};
use std::error::Error;
use std::time::Instant;

const SPEC: &str = r#"
format = 1
body = { inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]] }
start = { attitude = { axis = [0, 0, 1], angle_deg = 0 } }
end = { attitude = { axis = [1, 2, 3], angle_deg = 60 } }
maneuver = { duration_s = 60 }

[dispersion]
seed = 1
cases = 1000
[[dispersion.vary]]
key = "end.attitude.rotation_vector_rad"
kind = "ellipsoid"
semi_axes = [1.5, 1.5, 1.5]
"#;

const WAYS: [(&str, &[&str]); 2] =
    [("quick, shortest way", &["solver.search=quick", "maneuver.path=shortest"]), ("default", &[])];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let cases: u64 = arguments.next().map_or(Ok(400), |text| text.parse())?;
    let steps: usize = arguments.next().map_or(Ok(100), |text| text.parse())?;
    let folder = tempfile();
    std::fs::create_dir_all(&folder)?;
    println!("{cases} slews, {steps} steps, verified");
    for (name, settings) in WAYS {
        let most = Options::default().threads;
        let mut single = f64::NAN;
        for threads in if most > 1 { vec![1, most] } else { vec![1] } {
            let set = [format!("dispersion.cases={cases}"), format!("maneuver.steps={steps}")];
            let set = set.iter().map(String::as_str).chain(settings.iter().copied()).map(Override::parse);
            let base = Base::from_reader(
                SPEC.as_bytes(),
                "throughput.toml",
                Format::Toml,
                &set.collect::<Result<Vec<_>, _>>()?,
            )?;
            let batch = Batch::of_dispersion(base)?;
            let options = Options { threads, ..Options::default() };
            let mut tally = Tally::default();
            let path = folder.join("results.jsonl");
            let (mut journal, _) = Journal::open(&path, &batch.header(Shard::ALL, false), true, &mut |_| {})?;
            let began = Instant::now();
            run(
                &batch,
                Shard::ALL,
                0,
                &options,
                &|| false,
                &mut |result, line| {
                    tally.add(result);
                    journal.line(line)
                },
                &mut || {},
            )?;
            journal.close()?;
            let rate = cases as f64 / began.elapsed().as_secs_f64();
            if threads == 1 {
                single = rate;
            }
            let (solved, ratio) = (tally.solved(), rate / single);
            println!(
                "  {name:<20} {threads} threads: {rate:8.0} a second, {ratio:.2} × one thread, {solved} solved"
            );
        }
    }
    std::fs::remove_dir_all(&folder)?;
    // Of Linux: the most that was resident at any time.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(peak) = status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
        println!("  peak memory {}", peak.trim());
    }
    Ok(())
}

fn tempfile() -> std::path::PathBuf {
    std::env::temp_dir().join(format!("slewkit-throughput-{}", std::process::id()))
}
