//! The index of all commands. Each file of this folder is one command. The comment at the top of
//! the file is printed by `evidence help`.

mod best_known;
mod biased;
mod combinations;
mod consistency;
mod constrained_robustness;
mod damaged;
mod day;
mod dearer;
mod durations;
mod dwells;
mod ends;
mod everyday;
mod false_files;
mod families;
mod figures;
mod flies;
mod fuel_of_forces;
mod gains;
mod global_bound;
mod grids;
mod guard;
mod hostile;
mod images;
mod infeasible;
mod killed_runs;
mod landing;
mod limbs;
mod limited_arcs;
mod memory;
mod metamorphic;
mod minimum_fuel;
mod minimum_time;
mod orders;
mod passes;
mod replan;
mod robustness;
mod rolls;
mod same_answers;
mod signals;
mod size;
mod spins;
mod stretches;
mod table;
mod throughput;
mod tiny_grids;
mod unequal_moments;
mod validation;

use evidence::words::Words;
use std::error::Error;

/// A command of `evidence`.
pub struct Command {
    pub name: &'static str,
    source: &'static str,
    pub run: fn(&mut Words) -> Result<(), Box<dyn Error>>,
}

impl Command {
    /// Returns the page of the command, the comment at the top of its file: the counted quantity,
    /// the law, the arguments of the command, and its exit code.
    pub fn page(&self) -> String {
        let lines = self.source.lines().map_while(|line| line.strip_prefix("//!"));
        lines.map(|line| format!("{}\n", line.trim_start_matches(' '))).collect()
    }

    /// Returns the description of the counted quantity: the first paragraph of the page, in one
    /// line.
    pub fn counts(&self) -> String {
        let page = self.page();
        page.lines().take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
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

/// All commands, in alphabetical order.
pub const COMMANDS: &[Command] = commands! {
    best_known
    biased
    combinations
    consistency
    constrained_robustness
    damaged
    day
    dearer
    durations
    dwells
    ends
    everyday
    false_files
    families
    figures
    flies
    fuel_of_forces
    gains
    global_bound
    grids
    guard
    hostile
    images
    infeasible
    killed_runs
    landing
    limbs
    limited_arcs
    memory
    metamorphic
    minimum_fuel
    minimum_time
    orders
    passes
    replan
    robustness
    rolls
    same_answers
    signals
    size
    spins
    stretches
    table
    throughput
    tiny_grids
    unequal_moments
    validation
};
