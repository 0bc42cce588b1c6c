//! The program that counts and measures the figures of slewkit, with one command for each count.
//!
//! `cargo run --release -p evidence -- COMMAND …` runs a command. `evidence help` lists the
//! commands, and `evidence help COMMAND` prints the page of one. The exit code is 2 if the command
//! line is wrong, and 1 if a count finds something that must not occur.

#![forbid(unsafe_code)]

mod commands;

use commands::COMMANDS;
use evidence::words::{Misuse, Words};
use std::process::ExitCode;

/// The usage of the command line, printed above the index.
const USE: &str = "usage: evidence COMMAND [WORD …]
       evidence help [COMMAND]   what a command counts, and which words it takes

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

/// Returns the list of all commands, one line for each.
fn index() -> String {
    let longest = COMMANDS.iter().map(|command| command.name.len()).max().unwrap_or_default();
    let line = |command: &commands::Command| format!("  {:longest$}  {}\n", command.name, command.counts());
    format!("{USE}\n{}", COMMANDS.iter().map(line).collect::<String>())
}

/// Reports a command that does not exist.
fn unknown(name: &str) -> ExitCode {
    eprintln!("evidence: `{name}` is no command\n\n{}", index());
    ExitCode::from(2)
}
