//! Check that a plan fits into the available memory.

use super::{Console, Failure, Message};
use slewkit::maneuver::{Problem, Settings};
use slewkit::numerics::figures::significant;
use slewkit::plan::{PeakMemory, Status};
use std::fs;

/// Returns an error if a plan probably does not fit into the available memory, and prints a warning
/// if this is possible but not probable.
pub fn check(problem: &Problem, settings: &Settings, console: &mut Console) -> Result<(), Failure> {
    let Some((reason, remedy, sure)) = concern(problem, settings, available()) else { return Ok(()) };
    if sure {
        return Err(Failure::Plan(Status::LimitReached, Message::new("E0125", reason, remedy)));
    }
    console.warn("W0142", &reason, &remedy);
    Ok(())
}

/// Prints a warning if a plan of the spec might not fit into the available memory. It is used by
/// commands that only check the spec.
pub fn warn(problem: &Problem, settings: &Settings, console: &mut Console) {
    if let Some((reason, remedy, _)) = concern(problem, settings, available()) {
        console.warn("W0142", &reason, &remedy);
    }
}

/// Describes the amount of memory that a plan needs.
pub fn told(PeakMemory { likely, most }: PeakMemory) -> String {
    let up_to = if most > likely { format!(", up to {}", size(most)) } else { String::new() };
    format!("about {}{up_to}, to plan it", size(likely))
}

/// Returns the reason why a plan might not fit into the available memory, the remedy, and true if
/// it probably does not fit. Returns `None` if it fits.
fn concern(problem: &Problem, settings: &Settings, available: Option<f64>) -> Option<(String, String, bool)> {
    let (room, peak) = (available?, PeakMemory::of(problem, settings));
    let sure = peak.likely > room;
    if peak.most <= room {
        return None;
    }
    let (takes, needed) = if sure { ("takes about", peak.likely) } else { ("may take", peak.most) };
    let steps = problem.steps;
    let reason = format!(
        "a plan on {steps} steps {takes} {} of memory, and {} are available",
        size(needed),
        size(room)
    );
    let fewer = PeakMemory::steps_within(problem, settings, room).filter(|fewer| *fewer < steps);
    let fewer =
        fewer.map_or("use fewer steps".into(), |fewer| format!("use {fewer} steps: `maneuver.steps`"));
    let remedy = if sure {
        format!("{fewer}; or provide more memory")
    } else {
        "if the memory ends, use fewer steps".into()
    };
    Some((reason, remedy, sure))
}

/// Formats a number of bytes with a unit.
fn size(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{} GB", significant(bytes / 1e9, 2)) }
}

/// Returns the number of bytes that this process may still allocate. This is the smallest remainder
/// of the limits of the machine, of the control group and of the process. Returns `None` if the
/// system reports no limit; only Linux reports them.
fn available() -> Option<f64> {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let machine = field(&read("/proc/meminfo"), "MemAvailable:").map(|kib| 1024.0 * kib);
    let used = field(&read("/proc/self/status"), "VmSize:").map_or(0.0, |kib| 1024.0 * kib);
    let own = field(&read("/proc/self/limits"), "Max address space").map(|limit| limit - used);
    let number = |path: &str| read(path).trim().parse::<f64>().ok();
    let group = number("/sys/fs/cgroup/memory.max").zip(number("/sys/fs/cgroup/memory.current"));
    let group = group.map(|(limit, used)| limit - used);
    [machine, own, group].into_iter().flatten().reduce(f64::min)
}

/// Returns the number that follows `name` at the beginning of a line of `text`; `None` if no line
/// has this name, or if a word such as "unlimited" follows it.
fn field(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}
