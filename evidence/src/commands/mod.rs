//! All commands. A file of this folder is one, and what stands above its code is its page.

mod best_known;
mod consistency;
mod constrained_robustness;
mod dearer;
mod everyday;
mod false_files;
mod families;
mod flies;
mod fuel_of_forces;
mod global_bound;
mod grids;
mod guard;
mod hostile;
mod images;
mod infeasible;
mod killed_runs;
mod landing;
mod limited_arcs;
mod memory;
mod metamorphic;
mod minimum_fuel;
mod minimum_time;
mod passes;
mod replan;
mod robustness;
mod rolls;
mod same_answers;
mod signals;
mod throughput;
mod tiny_grids;

use evidence::words::Words;
use std::error::Error;

/// A count by its name.
pub struct Command {
    pub name: &'static str,
    source: &'static str,
    pub run: fn(&mut Words) -> Result<(), Box<dyn Error>>,
}

impl Command {
    /// What stands above the code: what is counted, by which law, the words that it takes, how it ends.
    pub fn page(&self) -> String {
        let lines = self.source.lines().map_while(|line| line.strip_prefix("//!"));
        lines.map(|line| format!("{}\n", line.trim_start_matches(' '))).collect()
    }

    /// What is counted, in a line.
    pub fn counts(&self) -> &'static str {
        self.source.lines().next().unwrap_or_default().trim_start_matches("//! ")
    }
}

macro_rules! commands {
    ($($name:ident)*) => {
        &[$(Command {
            name: stringify!($name),
            source: include_str!(concat!(stringify!($name), ".rs")),
            run: $name::run,
        }),*]
    };
}

/// The index.
pub const COMMANDS: &[Command] = commands! {
    best_known
    consistency
    constrained_robustness
    dearer
    everyday
    false_files
    families
    flies
    fuel_of_forces
    global_bound
    grids
    guard
    hostile
    images
    infeasible
    killed_runs
    landing
    limited_arcs
    memory
    metamorphic
    minimum_fuel
    minimum_time
    passes
    replan
    robustness
    rolls
    same_answers
    signals
    throughput
    tiny_grids
};
