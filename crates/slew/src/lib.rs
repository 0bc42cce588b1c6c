//! The program `slew`, with one file for each command. Arguments are first parsed, then checked and
//! combined.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[macro_use]
mod document;

/// Code examples of the README, which the tests compile and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// Code examples of the page on the library, which the tests compile and run.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/library.md")]
struct Library;

mod advice;
mod args;
mod batch;
mod check;
mod compare;
mod console;
mod convert;
mod export;
mod failure;
mod fly;
mod interrupt;
mod memory;
mod output;
mod pictured;
mod plan;
mod plot;
mod report;
mod simulate;
mod sky;
mod spec_file;
mod summary;
mod table;
mod texts;
mod timeline;
mod verify;

pub(crate) use args::{Common, Notation, Reading, ReportArgs, SpecArgs};
pub(crate) use console::{Console, Tone};
pub(crate) use failure::{Exit, Failure, Message};
pub(crate) use output::{Destination, Format, OutputArgs};
pub(crate) use summary::{Lines, headline, line};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use slewkit_files::spec::escape_lines;
use std::ffi::OsString;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Optimal attitude maneuvers, planned and independently verified.
///
/// Text for people goes to stderr, data to stdout or to the file of `-o`.
#[derive(Debug, Parser)]
#[command(name = "slew", version, max_term_width = 100, after_help = EXIT_CODES, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "\
Exit codes:
  0  solved and verified      4  proved infeasible        7  solved, verification failed
  1  internal error           5  not converged            8  file or stream
  2  usage                    6  time or memory ended     130  interrupted, best result kept
  3  spec invalid             9  some cases of a batch failed; a number of a simulation is not finite

`slew init > maneuver.toml` writes a spec to start from; `slew plan maneuver.toml -o plan.json` plans it.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Print a commented spec to start from
    Init(texts::InitArgs),
    /// Check a spec and report all its errors at once
    Check(check::Args),
    /// Print where the targets of a spec are, and how accurate that is
    Sky(sky::Args),
    /// Plan the maneuver of a spec and verify it
    Plan(plan::Args),
    /// Fly a plan many times, with gains and uncertainties
    Fly(fly::Args),
    /// Verify a plan file by the witnesses, without the solver
    Verify(verify::Args),
    /// Write a plan file in the formats of other programs
    Export(export::Args),
    /// Write a plan as one page for a browser
    Report(report::Args),
    /// Draw a plan as SVG files
    Plot(plot::Args),
    /// Plan many maneuvers: a table of cases, or a folder of specs
    Batch(batch::table::Args),
    /// Plan a maneuver over a grid of some of its keys
    Sweep(batch::sweep::Args),
    /// Plan a maneuver for random draws from the `dispersion` of its spec
    MonteCarlo(batch::monte_carlo::Args),
    /// Join the results of the shards of a batch
    Merge(batch::merge::Args),
    /// Tabulate the times, or efforts, of all turns of a spacecraft from rest to rest
    Table(table::Args),
    /// Read a timeline of pointings, PTR or PRM, and plan the slews between them
    Timeline(timeline::Args),
    /// Compare methods on a maneuver, or integrators on a simulation
    Compare(compare::Args),
    /// Propagate the bodies of a spec from their start, without optimisation
    Simulate(simulate::Args),
    /// Convert an attitude from one notation to all others
    Convert(convert::Args),
    /// Print the JSON Schema of specs or of plan files
    Schema(texts::SchemaArgs),
    /// Explain a command, or a topic: `replay` (how a plan is integrated), `glossary`,
    /// `conventions`
    Help {
        /// A command, or replay, glossary, conventions
        topic: Vec<String>,
    },
    /// Explain the code of an error or a warning, as in `slew explain E0123`; without a code, list
    /// them all
    Explain {
        /// The code
        code: Option<String>,
    },
    /// Print the manual page of the program or of a command
    Man {
        /// A command
        command: Option<String>,
    },
    /// Print completions for a shell
    Completions {
        /// Name of the shell
        shell: clap_complete::Shell,
    },
}

impl Command {
    fn common(&self) -> Common {
        match self {
            Self::Plan(args) => args.output.common(),
            Self::Fly(args) => args.output.common(),
            Self::Simulate(args) => args.output.common(),
            Self::Export(args) => args.output.common(),
            Self::Check(args) => args.report.common(),
            Self::Sky(args) => args.report.common(),
            Self::Verify(args) => args.report.common(),
            Self::Table(args) => args.output.common(),
            Self::Timeline(args) => args.common(),
            Self::Compare(args) => args.report.common(),
            Self::Convert(args) => args.report.common(),
            Self::Plot(args) => args.common(),
            Self::Report(args) => args.common(),
            Self::Batch(args) => args.running.common(),
            Self::Sweep(args) => args.running.common(),
            Self::MonteCarlo(args) => args.running.common(),
            Self::Merge(args) => args.common(),
            Self::Schema(_)
            | Self::Init(_)
            | Self::Completions { .. }
            | Self::Help { .. }
            | Self::Explain { .. }
            | Self::Man { .. } => Common::default(),
        }
    }

    fn run(self, console: &mut Console) -> Result<Exit, Failure> {
        match self {
            Self::Plan(args) => plan::run(&args, console),
            Self::Fly(args) => fly::run(&args, console),
            Self::Check(args) => check::run(&args, console),
            Self::Sky(args) => sky::run(&args, console),
            Self::Verify(args) => verify::run(&args, console),
            Self::Export(args) => export::run(&args, console),
            Self::Report(args) => report::run(&args, console),
            Self::Plot(args) => plot::run(&args, console),
            Self::Batch(args) => batch::table::run(&args, console),
            Self::Sweep(args) => batch::sweep::run(&args, console),
            Self::MonteCarlo(args) => batch::monte_carlo::run(&args, console),
            Self::Merge(args) => batch::merge::run(&args, console),
            Self::Table(args) => table::run(&args, console),
            Self::Timeline(args) => timeline::run(&args, console),
            Self::Compare(args) => compare::run(&args, console),
            Self::Simulate(args) => simulate::run(&args, console),
            Self::Convert(args) => convert::run(&args, console),
            Self::Schema(args) => texts::run(&args.output, &texts::schema(args.of), console),
            Self::Help { topic } => print(texts::help(Cli::command(), &topic)?.as_bytes()),
            Self::Explain { code: None } => print(texts::codes().as_bytes()),
            Self::Explain { code: Some(code) } => match texts::explanation(&code) {
                Some(text) => print(text.as_bytes()),
                None => {
                    let reason = format!("no code {} exists", slewkit_files::spec::escape(&code));
                    Err(Failure::Usage(format!("{reason}; a code is a letter and four digits, as E0123")))
                }
            },
            Self::Man { command } => print(&texts::manual(Cli::command(), command.as_deref())?),
            Self::Init(args) => texts::run(&args.output, &texts::template(&args), console),
            Self::Completions { shell } => {
                // The script is first written to memory, because the generator panics if the
                // program that reads stdout closes the stream.
                let mut script = Vec::new();
                clap_complete::generate(shell, &mut Cli::command(), "slew", &mut script);
                print(&script)
            }
        }
    }
}

/// Prints text on stdout.
fn print(text: &[u8]) -> Result<Exit, Failure> {
    console::to_stdout(|output| Ok(output.write_all(text)?))?;
    Ok(Exit::Solved)
}

/// Runs the program and returns its exit code. `arguments` are the words of the command line, of
/// which the first is the name of the program.
///
/// The program writes to the streams of the process and handles its signals. A process should
/// therefore call this function only once, and do nothing else.
///
/// ```
/// assert_eq!(slewkit_cli::run(["slew", "explain", "E0123"]), 0);
/// assert_eq!(slewkit_cli::run(["slew", "drive"]), 2);
/// ```
pub fn run<A: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = A>) -> u8 {
    interrupt::prepare();
    let parsed = Cli::command().try_get_matches_from(arguments).and_then(|matches| {
        let name = matches.subcommand_name().unwrap_or_default().to_string();
        Ok((Cli::from_arg_matches(&matches)?.command, name))
    });
    let (command, name) = match parsed {
        Ok(parsed) => parsed,
        Err(said) => return tell(&said).code(),
    };
    let common = command.common();
    let mut console = Console::new(common.quiet);
    // A panic has a separate exit code, so that a bug is not mistaken for another status. The
    // message of the panic has already been printed.
    let outcome = catch_unwind(AssertUnwindSafe(|| command.run(&mut console)));
    let exit = match outcome {
        Ok(Ok(exit)) => exit,
        Ok(Err(failure)) => failure.report(&mut console, common.json, &name),
        Err(_) => {
            let failure = Failure::Internal("the program panicked, see above".into());
            failure.report(&mut console, common.json, &name)
        }
    };
    // `--quiet` suppresses the text of a success only. Every failure prints a text, because not
    // every shell shows exit codes.
    if exit != Exit::Solved && console.is_silent() && !common.json {
        let (status, code) = (exit.status(), exit.code());
        console.plain_error(&format!("{status} (exit code {code}); run it without --quiet for the reason"));
    }
    exit.code()
}

/// Prints help and version on stdout and returns exit code 0, or prints usage errors on stderr and
/// returns exit code 2.
fn tell(said: &clap::Error) -> Exit {
    let words = said.to_string();
    let shown = escape_lines(&words);
    // The message quotes input of the user, whose escape sequences must not reach the terminal.
    let told = if said.use_stderr() && shown != words {
        write!(io::stderr().lock(), "{shown}")
    } else {
        said.print().and_then(|()| io::stdout().flush())
    };
    match told {
        // If the program that reads the stream has closed it, this is not an error.
        Err(error) if !said.use_stderr() && error.kind() != io::ErrorKind::BrokenPipe => Exit::File,
        _ if said.use_stderr() => Exit::Usage,
        _ => Exit::Solved,
    }
}
