//! What the figures of slewkit are counted by: one program, a command for each count.
//!
//! `cargo run --release -p evidence -- COMMAND …`; `evidence help` is the index of the commands, `evidence help COMMAND` the page of
//! one. Ends with 2 where the command line is wrong, with 1 where a count finds what must not be.

#![forbid(unsafe_code)]

mod commands;

use commands::COMMANDS;
use evidence::words::{Misuse, Words};
use std::process::ExitCode;

/// What the command line is for, above the index.
const USE: &str = "usage: evidence COMMAND [WORD …]
       evidence help [COMMAND]   what a command counts, and the words that it takes

commands:";

fn main() -> ExitCode {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let mut words = Words::new(words.collect());
    let Some(name) = words.take() else {
        eprint!("{}", index());
        return ExitCode::from(2);
    };
    if ["help", "--help", "-h"].contains(&name.as_str()) {
        return match words.take() {
            None => {
                print!("{}", index());
                ExitCode::SUCCESS
            }
            Some(name) => match COMMANDS.iter().find(|command| command.name == name) {
                Some(command) => {
                    print!("{}", command.page());
                    ExitCode::SUCCESS
                }
                None => unknown(&name),
            },
        };
    }
    let Some(command) = COMMANDS.iter().find(|command| command.name == name) else { return unknown(&name) };
    let Err(error) = (command.run)(&mut words) else { return ExitCode::SUCCESS };
    eprintln!("{name}: {error}");
    if error.is::<Misuse>() {
        eprintln!("see `evidence help {name}`");
        return ExitCode::from(2);
    }
    ExitCode::FAILURE
}

/// All commands, a line each.
fn index() -> String {
    let longest = COMMANDS.iter().map(|command| command.name.len()).max().unwrap_or_default();
    let line = |command: &commands::Command| format!("  {:longest$}  {}\n", command.name, command.counts());
    format!("{USE}\n{}", COMMANDS.iter().map(line).collect::<String>())
}

fn unknown(name: &str) -> ExitCode {
    eprintln!("evidence: `{name}` is no command\n\n{}", index());
    ExitCode::from(2)
}
