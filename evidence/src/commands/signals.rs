//! Measures the delay between a signal (Ctrl-C or SIGTERM) at a random time and the end of `slew`,
//! for every long command, on a thousand to a million steps.
//!
//! `cargo build --release && cargo run --release -p evidence -- signals [COUNT [SEED [NAME]]]`, 200
//! runs by default, on Linux. NAME selects the commands whose name contains it. Each run works in
//! its own folder, and receives one signal after a random part of its undisturbed time. Within 0.2
//! s of CPU time, the run must end, or print its result before it writes the file, because the best
//! iterate of a million steps is a file of 400 MB. The run must end with a documented exit code,
//! and leave neither truncated nor temporary files. The command ends with 1 if a run violates this.

use evidence::Random;
use evidence::process::{beside_this, cpu_seconds};
use evidence::words::{Misuse, Words};
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{env, fs, thread};

/// The largest accepted CPU time between the signal and the end or the message [s].
const LATEST: f64 = 0.2;

const SPEC: &str = r#"
format = 1
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
"#;

/// The text that is added to a maneuver to derive other maneuvers, by the name of the file.
const ENDINGS: [(&str, &str); 6] = [
    ("free", "[maneuver]\nduration_s = 60\n"),
    ("limited", "[maneuver]\nduration_s = 60\n[actuators]\ntorque_limit_n_m = [0.14, 0.068, 0.17]\n"),
    (
        "slow_torques",
        "[maneuver]\nduration_s = 60\n[actuators]\ntorque_limit_n_m = [0.14, 0.068, 0.17]\n\
         torque_rate_limit_n_m_per_s = 0.0068\n",
    ),
    ("time", "[maneuver]\nminimize = \"time\"\nsteps = 1000\n[actuators]\ntorque_limit_n_m = 0.1\n"),
    (
        "fuel",
        "[maneuver]\nminimize = \"fuel\"\nduration_s = 90\nsteps = 1000\n[actuators]\ntorque_limit_n_m = 0.1\n",
    ),
    (
        "dispersed",
        "[maneuver]\nduration_s = 60\n[dispersion]\nseed = 1\ncases = 300\n[[dispersion.vary]]\n\
         key = \"maneuver.duration_s\"\nkind = \"uniform\"\nhalf_width_relative = 0.1\n",
    ),
];

/// The names and the words of the commands. The file `plan.json` is a plan of the first maneuver on
/// 100,000 steps.
const COMMANDS: [(&str, &str); 17] = [
    ("plan, 1e3", "plan free.toml -o out.json --set maneuver.steps=1000"),
    ("plan, 1e5", "plan free.toml -o out.json --set maneuver.steps=100000"),
    ("plan, 1e6", "plan free.toml -o out.json --set maneuver.steps=1000000"),
    ("plan within limits, 1e3", "plan limited.toml -o out.json --set maneuver.steps=1000"),
    ("slow torques, 1e4", "plan slow_torques.toml -o out.json --set maneuver.steps=10000"),
    ("slow torques, 1e5", "plan slow_torques.toml -o out.json --set maneuver.steps=100000"),
    ("SCP, 1e4", "plan free.toml -o out.json --set maneuver.steps=10000 --set solver.method=scp"),
    ("least time, 1e3", "plan time.toml -o out.json"),
    ("least fuel, 1e3", "plan fuel.toml -o out.json"),
    ("simulate, 1e6", "simulate free.toml -o out.csv --steps 1000000"),
    ("compare, 1e3", "compare free.toml --set maneuver.steps=1000"),
    ("compare, 1e4", "compare free.toml --set maneuver.steps=10000"),
    ("monte-carlo, 300 cases", "monte-carlo dispersed.toml -o out.jsonl --threads 2"),
    ("verify, 1e5", "verify plan.json"),
    ("report, 1e5", "report plan.json -o out.html"),
    ("plot, 1e5", "plot plan.json -o out.svg"),
    ("export, 1e5", "export plan.json -o out.aem --set epoch=\"2026-11-21T07:00:00 UTC\""),
];

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = words.number("number of signals", 200)?;
    let mut random = Random::new(words.number("seed", 1)?);
    let wanted = words.take().unwrap_or_default();
    words.end()?;
    let names = COMMANDS.map(|(name, _)| name);
    if !names.iter().any(|name| name.contains(&wanted)) {
        return Err(Misuse::of("part of the name of a command", &wanted, &names).into());
    }
    let commands = COMMANDS.iter().filter(|(name, _)| name.contains(&wanted));
    let slew = beside_this("slew")?;
    let folder = env::temp_dir().join(format!("slew-signals-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    for (name, ending) in ENDINGS {
        fs::write(folder.join(format!("{name}.toml")), format!("{SPEC}{ending}"))?;
    }
    start(&slew, &folder, "plan free.toml -o plan.json --set maneuver.steps=100000")?.wait_with_output()?;
    let mut wrong = 0;
    for (name, line) in commands.clone() {
        let began = Instant::now();
        let undisturbed = start(&slew, &folder, line)?.wait_with_output()?;
        let took = began.elapsed().as_secs_f64();
        if !undisturbed.status.success() {
            return Err(format!("{name}: {}", String::from_utf8_lossy(&undisturbed.stderr)).into());
        }
        sweep(&folder)?;
        let (mut answers, mut ends) = (Vec::new(), Vec::new());
        for _ in 0..count.div_ceil(commands.clone().count() as u64) {
            let Signalled { signal, answer, ending, ended } =
                signalled(&slew, &folder, line, took, &mut random)?;
            answers.push(answer);
            ends.push(ending);
            let mut complaints = sweep(&folder)?;
            if answer > LATEST {
                complaints.push(format!("{answer:.2} s of CPU"));
            }
            // Before its handler is installed, the signal itself ends the program.
            if let Some(code) = ended.code().filter(|code| ![0, 130].contains(code)) {
                complaints.push(format!("exit code {code}"));
            }
            complaints.iter().for_each(|what| println!("{name}, {signal}: {what}"));
            wrong += complaints.len();
        }
        answers.sort_by(f64::total_cmp);
        let (middle, latest) = (answers[answers.len() / 2], answers[answers.len() - 1]);
        let ended = ends.iter().copied().fold(0.0, f64::max);
        println!(
            "{name:<26} {took:6.2} s undisturbed; {} signals: answered within median {middle:.3}, latest \
                {latest:.3} s; \
             written and ended within {ended:.3} s",
            answers.len()
        );
    }
    fs::remove_dir_all(&folder)?;
    println!("{wrong} wrong");
    if wrong > 0 { Err("see above".into()) } else { Ok(()) }
}

/// How a run reacted to its signal.
struct Signalled {
    signal: &'static str,
    /// The CPU time from the signal to the message or the end [s].
    answer: f64,
    /// The elapsed time from the signal to the end [s].
    ending: f64,
    ended: ExitStatus,
}

/// Runs a command, which takes about `took` seconds, and sends it a signal at a random time.
fn signalled(
    slew: &Path,
    folder: &Path,
    line: &str,
    took: f64,
    random: &mut Random,
) -> Result<Signalled, Box<dyn std::error::Error>> {
    let mut child = start(slew, folder, line)?;
    let id = child.id().to_string();
    let printed = watched(&mut child);
    thread::sleep(Duration::from_secs_f64(took * random.unit()));
    let signal = if random.below(2) == 0 { "-INT" } else { "-TERM" };
    let before = cpu_seconds(&id);
    Command::new("kill").args([signal, &id]).stderr(Stdio::null()).status()?;
    let mut last = before;
    let ended = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        last = cpu_seconds(&id).or(last);
        thread::sleep(Duration::from_millis(2));
    };
    let since = |at: Option<f64>| at.zip(before).map_or(0.0, |(at, before)| at - before);
    let ending = since(last);
    // Output before the signal is not a reaction to the signal.
    let printed = printed.join().map_err(|_| "the reader of what is printed failed")?;
    let answer = printed.map(|at| since(Some(at))).filter(|at| *at >= 0.0).unwrap_or(ending).min(ending);
    Ok(Signalled { signal, answer, ending, ended })
}

/// Removes the files that a run wrote, and describes truncated or temporary ones.
fn sweep(folder: &Path) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let mut wrong = Vec::new();
    for entry in fs::read_dir(folder)?.flatten() {
        let (path, file) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if file.starts_with(".slew-") {
            wrong.push("a temporary file is left".into());
        } else if file == "out.json"
            && serde_json::from_slice::<serde_json::Value>(&fs::read(&path)?).is_err()
        {
            wrong.push("a torn file".into());
        }
        if file.starts_with(".slew-") || file.starts_with("out.") {
            fs::remove_file(&path)?;
        }
    }
    Ok(wrong)
}

fn start(slew: &Path, folder: &Path, line: &str) -> std::io::Result<Child> {
    let mut command = Command::new(slew);
    // The only value that contains a space is the last one.
    let (words, value) =
        line.split_once(" --set epoch=").map_or((line, None), |(words, value)| (words, Some(value)));
    command.args(words.split(' ')).current_dir(folder).stdin(Stdio::null());
    command.args(value.map(|value| format!("--set=epoch={value}")));
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
}

/// Reads the output of a process on stderr, and returns its CPU time at the first line.
fn watched(child: &mut Child) -> JoinHandle<Option<f64>> {
    let (id, output) = (child.id().to_string(), child.stderr.take());
    thread::spawn(move || {
        let mut output = output?;
        let first = output.read(&mut [0]).ok().filter(|count| *count > 0).and_then(|_| cpu_seconds(&id));
        std::io::copy(&mut output, &mut std::io::sink()).ok();
        first
    })
}
