//! Compares the bytes of a long Monte Carlo run with those of the same run when it is killed at
//! random times and continued, and prints its memory.
//!
//! `cargo build --release && cargo run --release -p evidence -- killed_runs [CASES [KILLS
//! [SEED]]]`, 20,000 cases and three kills by default, on Linux. The cases are attitude slews on 50
//! steps with uncertain inertia, end and duration. They use the quick search, because the test
//! concerns files. The kills are by SIGKILL, to which a process cannot react. The command ends with
//! 1 if the results differ, or if a run ended before it could be killed.

use evidence::Random;
use evidence::process::{beside_this, peak_memory};
use evidence::words::Words;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, thread};

const SPEC: &str = r#"
format = 1
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { rotation_vector_deg = [80, -25, 40] }
[maneuver]
duration_s = 60
steps = 50
path = "shortest"
[solver]
search = "quick"
[dispersion]
seed = 7
cases = CASES
[[dispersion.vary]]
key = "body.inertia_kg_m2"
kind = "normal"
covariance = [[4, 1, 0], [1, 9, 0], [0, 0, 1]]
[[dispersion.vary]]
key = "end.attitude.rotation_vector_deg"
kind = "normal"
sigma = [5, 5, 5]
[[dispersion.vary]]
key = "maneuver.duration_s"
kind = "uniform"
half_width_relative = 0.1
"#;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let (cases, kills) = (words.number("number of cases", 20_000)?, words.number("number of kills", 3)?);
    let mut random = Random::new(words.number("seed", 1)?);
    words.end()?;
    let slew = beside_this("slew")?;
    let folder = env::temp_dir().join(format!("slew-killed-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("spec.toml"), SPEC.replace("CASES", &cases.to_string()))?;

    let began = Instant::now();
    let mut whole = start(&slew, &folder, "whole.jsonl")?;
    let peak = watched(&mut whole, None)?.ok_or("the run failed")?;
    let took = began.elapsed();
    let size = fs::metadata(folder.join("whole.jsonl"))?.len();
    println!(
        "{cases} cases in {:.0} s, {:.0} a second, a file of {} MB, peak memory {:.0} MB",
        took.as_secs_f64(),
        cases as f64 / took.as_secs_f64(),
        size / 1_000_000,
        peak / 1e6
    );

    let mut killed = 0;
    let mut most = 0.0_f64;
    loop {
        let mut run = start(&slew, &folder, "killed.jsonl")?;
        // The kill comes early enough to leave work for the kills after it.
        let share = (killed < kills).then(|| took.mul_f64(random.unit() / kills as f64));
        if let Some(peak) = watched(&mut run, share)? {
            most = most.max(peak);
            break;
        }
        killed += 1;
        let written = fs::metadata(folder.join("killed.jsonl")).map_or(0, |file| file.len());
        println!("killed with {} MB written", written / 1_000_000);
    }
    let same = same_bytes(&folder.join("whole.jsonl"), &folder.join("killed.jsonl"))?;
    println!(
        "killed {killed} times, peak memory of the last run {:.0} MB: {}",
        most / 1e6,
        if same { "the same bytes" } else { "DIFFERENT" }
    );
    fs::remove_dir_all(&folder)?;
    if same && killed == kills { Ok(()) } else { Err("see above".into()) }
}

fn start(slew: &Path, folder: &Path, output: &str) -> std::io::Result<Child> {
    let mut command = Command::new(slew);
    command.args(["monte-carlo", "-q", "spec.toml", "-o", output]).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).spawn()
}

/// Waits for the end of the run, or kills it after `patience`. Returns the peak memory \[bytes\];
/// `None` if the run was killed.
fn watched(run: &mut Child, patience: Option<Duration>) -> Result<Option<f64>, Box<dyn std::error::Error>> {
    let (began, mut peak) = (Instant::now(), 0.0_f64);
    loop {
        if let Some(status) = run.try_wait()? {
            let ended = status.success().then_some(Some(peak));
            return ended.ok_or_else(|| format!("the run ended with {status}").into());
        }
        peak = peak_memory(&run.id().to_string()).unwrap_or(0.0).max(peak);
        if patience.is_some_and(|patience| began.elapsed() > patience) {
            run.kill()?;
            run.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(20));
    }
}

fn same_bytes(a: &Path, b: &Path) -> std::io::Result<bool> {
    let [mut a, mut b] = [BufReader::new(File::open(a)?), BufReader::new(File::open(b)?)];
    let (mut left, mut right) = (vec![0; 1 << 20], Vec::with_capacity(1 << 20));
    loop {
        let count = a.read(&mut left)?;
        right.clear();
        b.by_ref().take(count.max(1) as u64).read_to_end(&mut right)?;
        if left[..count] != right[..] {
            return Ok(false);
        }
        if count == 0 {
            return Ok(true);
        }
    }
}
