//! How soon `slew` hears a signal: Ctrl-C and SIGTERM at random times, on a thousand to a million steps.
//!
//! `cargo build --release && cargo run --release --example signals [-- COUNT [SEED]]`, 200 by default, on Linux. Each
//! run plans, simulates, verifies or compares in a folder of its own, and is sent one signal after a random part of the time
//! that it takes undisturbed. Within 0.2 s of CPU time it must end, or print what it has found before it writes that: the best
//! iterate of a million steps is a file of 400 MB. It must end with an exit code that is its own, no torn file and no
//! temporary one left. Ends with 1 where one did not.

#[path = "../tests/common/random.rs"]
mod random;

use random::Random;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{env, fs, thread};

/// What a signal may take [s of CPU].
const LATEST: f64 = 0.2;

const SPEC: &str = r#"
format = 1
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
[maneuver]
duration_s = 60
"#;

/// Limits of the size of the torques.
const LIMITS: &str = "[actuators]\ntorque_limit_n_m = [0.14, 0.068, 0.17]\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = env::args().skip(1).map(|text| text.parse::<u64>());
    let (count, seed) = (numbers.next().unwrap_or(Ok(200))?, numbers.next().unwrap_or(Ok(1))?);
    let slew = beside_this("slew")?;
    let folder = env::temp_dir().join(format!("slew-signals-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("free.toml"), SPEC)?;
    fs::write(folder.join("limited.toml"), format!("{SPEC}{LIMITS}"))?;
    let commands: [(&str, &[&str]); 6] = [
        ("plan, 1e3", &["plan", "free.toml", "-o", "out.json", "--set", "maneuver.steps=1000"]),
        ("plan, 1e5", &["plan", "free.toml", "-o", "out.json", "--set", "maneuver.steps=100000"]),
        ("plan, 1e6", &["plan", "free.toml", "-o", "out.json", "--set", "maneuver.steps=1000000"]),
        (
            "plan within limits, 1e3",
            &["plan", "limited.toml", "-o", "out.json", "--set", "maneuver.steps=1000"],
        ),
        ("simulate, 1e6", &["simulate", "free.toml", "-o", "out.csv", "--steps", "1000000"]),
        ("compare, 1e3", &["compare", "free.toml", "--set", "maneuver.steps=1000"]),
    ];
    let mut random = Random::new(seed);
    let mut wrong = 0;
    for (name, args) in commands {
        let took = {
            let began = Instant::now();
            start(&slew, &folder, args)?.wait()?;
            fs::remove_file(folder.join(args[3].trim_start_matches("--set"))).ok();
            began.elapsed().as_secs_f64()
        };
        let (mut answers, mut ends) = (Vec::new(), Vec::new());
        for _ in 0..count.div_ceil(commands.len() as u64) {
            let mut child = start(&slew, &folder, args)?;
            let printed = watched(&mut child);
            thread::sleep(Duration::from_secs_f64(took * random.unit()));
            let signal = if random.below(2) == 0 { "-INT" } else { "-TERM" };
            let before = cpu_seconds(child.id());
            Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status()?;
            let mut last = before;
            let ended = loop {
                if let Some(status) = child.try_wait()? {
                    break status;
                }
                last = cpu_seconds(child.id()).or(last);
                thread::sleep(Duration::from_millis(2));
            };
            let since = |at: Option<f64>| at.zip(before).map_or(0.0, |(at, before)| at - before);
            let ending = since(last);
            // What was printed before the signal is no answer to it.
            let printed = printed.join().map_err(|_| "the reader of what is printed failed")?;
            let answer =
                printed.map(|at| since(Some(at))).filter(|at| *at >= 0.0).unwrap_or(ending).min(ending);
            answers.push(answer);
            ends.push(ending);
            let mut complain = |what: String| {
                println!("{name}: {what}");
                wrong += 1;
            };
            if answer > LATEST {
                complain(format!("{answer:.2} s of CPU after {signal}"));
            }
            // Before the handler stands, the signal itself ends the program.
            if let Some(code) = ended.code()
                && ![0, 130].contains(&code)
            {
                complain(format!("exit code {code} after {signal}"));
            }
            for entry in fs::read_dir(&folder)?.flatten() {
                let (path, file) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
                if file.starts_with(".slew-") {
                    complain("a temporary file is left".into());
                } else if file == "out.json"
                    && serde_json::from_slice::<serde_json::Value>(&fs::read(&path)?).is_err()
                {
                    complain("a torn file".into());
                }
                if file.starts_with(".slew-") || file.starts_with("out.") {
                    fs::remove_file(&path)?;
                }
            }
        }
        answers.sort_by(f64::total_cmp);
        let (middle, latest) = (answers[answers.len() / 2], answers[answers.len() - 1]);
        let ended = ends.iter().copied().fold(0.0, f64::max);
        println!(
            "{name:<26} {took:6.2} s undisturbed; {} signals: answered within median {middle:.3}, latest {latest:.3} s; \
             written and ended within {ended:.3} s",
            answers.len()
        );
    }
    fs::remove_dir_all(&folder)?;
    println!("{wrong} wrong");
    if wrong > 0 { Err("see above".into()) } else { Ok(()) }
}

fn start(slew: &Path, folder: &Path, args: &[&str]) -> std::io::Result<Child> {
    let mut command = Command::new(slew);
    command.args(args).current_dir(folder).stdin(Stdio::null());
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
}

/// Reads all that a process says, which it does on stderr; its CPU time at the first of it.
fn watched(child: &mut Child) -> JoinHandle<Option<f64>> {
    let (id, output) = (child.id(), child.stderr.take());
    thread::spawn(move || {
        let mut output = output?;
        let first = output.read(&mut [0]).ok().filter(|count| *count > 0).and_then(|_| cpu_seconds(id));
        std::io::copy(&mut output, &mut std::io::sink()).ok();
        first
    })
}

/// CPU time of a process that runs [s], in hundredths; `None` where it is gone.
fn cpu_seconds(process: u32) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // After the name in parentheses, which may hold anything.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at).and_then(|text| text.parse::<f64>().ok());
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// The binary that was built with this example.
fn beside_this(name: &str) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let built = env::current_exe()?.parent().and_then(Path::parent).map(|folder| folder.join(name));
    built
        .filter(|path| path.exists())
        .ok_or_else(|| "no binary beside this example: `cargo build --release`".into())
}
