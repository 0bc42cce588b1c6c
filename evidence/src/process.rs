//! Reads what Linux reports about a process, and finds the path of a binary.

use std::path::PathBuf;
use std::time::Instant;
use std::{env, fs};

/// Returns the CPU time of all threads of a process so far \[s\], with a resolution of 0.01 s;
/// `None` if the process has ended, or if the system does not report it.
pub fn cpu_seconds(process: &str) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The fields follow the name in parentheses, which may contain anything.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at).and_then(|text| text.parse::<f64>().ok());
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Returns the CPU time of this process; NaN if the system does not report it.
pub fn own_cpu_seconds() -> f64 {
    cpu_seconds("self").unwrap_or(f64::NAN)
}

/// A stopwatch for this process. It measures elapsed time, limited to the CPU time of the process
/// where the system reports that time, so that waiting does not count.
pub struct Watch {
    clock: Instant,
    cpu: f64,
}

impl Watch {
    pub fn start() -> Self {
        Self { clock: Instant::now(), cpu: own_cpu_seconds() }
    }

    pub fn seconds(&self) -> f64 {
        let (clock, cpu) = (self.clock.elapsed().as_secs_f64(), own_cpu_seconds() - self.cpu);
        if cpu.is_nan() { clock } else { clock.clamp((cpu - HUNDREDTH).max(0.0), cpu + HUNDREDTH) }
    }
}

/// The resolution of the CPU time that the system reports \[s\].
const HUNDREDTH: f64 = 0.01;

/// Returns the peak of the resident memory of a process \[bytes\]. `process` is `self` or a process
/// number. Returns `None` if the process has ended, or if the system does not report the peak.
pub fn peak_memory(process: &str) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = peak.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(1024.0 * kib)
}

/// Returns the path of a binary in the folder of the running program.
pub fn beside_this(name: &str) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let built = env::current_exe()?.parent().map(|folder| folder.join(name));
    built
        .filter(|path| path.exists())
        .ok_or_else(|| "no binary beside this one: `cargo build --release`".into())
}
