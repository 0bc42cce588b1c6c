//! Texts that the program prints: starter specs, schemas, manual pages and explanations of codes.

use super::console;
use super::{Console, Exit, Failure, summary};
use slewkit_files::export::{ExportError, Target};
use slewkit_files::spec::escape;
use std::path::PathBuf;

/// Arguments of `slew schema` and `slew init`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write to FILE instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `slew init`.
#[derive(Debug, clap::Args)]
pub struct InitArgs {
    /// A simulation instead of a maneuver
    #[arg(long)]
    pub simulation: bool,
    /// A spec for one purpose, short and ready to be planned
    #[arg(long = "for", value_name = "PURPOSE", conflicts_with = "simulation")]
    pub purpose: Option<Purpose>,
    #[command(flatten)]
    pub output: Args,
}

/// The purpose of a short spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Purpose {
    /// Reaction wheels that store momentum, a star tracker and the Sun
    Wheels,
    /// Minimum fuel with thrusters, given by position and force
    Thrusters,
    /// Minimum time under torque limits
    Time,
}

/// Arguments of `slew schema`.
#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// Kind of files
    #[arg(value_name = "FILES", default_value = "spec")]
    pub of: SchemaOf,
    #[command(flatten)]
    pub output: Args,
}

/// Files that have a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SchemaOf {
    /// Specs
    Spec,
    /// Plan files
    Plan,
}

/// Returns the JSON Schema of specs or of plan files.
pub fn schema(of: SchemaOf) -> String {
    match of {
        SchemaOf::Spec => format!("{:#}\n", slewkit_files::spec::schema()),
        SchemaOf::Plan => slewkit_files::export::PLAN_SCHEMA.into(),
    }
}

/// Topics of `slew help` in addition to the commands, with their texts: the conventions, the
/// glossary, and how to replay a plan.
const TOPICS: [(&str, &str); 3] = [
    ("conventions", include_str!("conventions.md")),
    ("glossary", include_str!("glossary.md")),
    ("replay", include_str!("replay.md")),
];

/// Explanations of all codes of errors and warnings. Each consists of a line with the code and its
/// title, a paragraph, and a blank line.
const EXPLANATIONS: &str = include_str!("explanations.txt");

/// Returns the title and the explanation of a code, ignoring upper and lower case; `None` if the
/// code is unknown.
pub fn explanation(code: &str) -> Option<String> {
    let code = code.trim().to_ascii_uppercase();
    let found = EXPLANATIONS.split("\n\n").find(|entry| entry.split(' ').next() == Some(&code))?;
    Some(format!("{}\n", found.trim_end()))
}

/// Returns a list of all codes with their titles, one line each.
pub fn codes() -> String {
    let titles = EXPLANATIONS.split("\n\n").filter_map(|entry| entry.trim().lines().next());
    titles.map(|title| format!("{title}\n")).collect()
}

/// Returns the manual page of the program or of one of its commands.
pub fn manual(program: clap::Command, command: Option<&str>) -> Result<Vec<u8>, Failure> {
    let page = match command {
        None => program,
        Some(name) => {
            let known = || program.get_subcommands().map(|command| command.get_name()).collect::<Vec<_>>();
            let Some(found) = program.find_subcommand(name) else {
                let reason =
                    format!("no command {} exists; the commands are {}", escape(name), known().join(", "));
                return Err(Failure::Usage(reason));
            };
            let called: &'static str = String::leak(format!("slew-{}", found.get_name()));
            found.clone().name(called)
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).map_err(ExportError::from)?;
    Ok(text)
}

/// Returns the text of `slew help` for a command or a topic.
pub fn help(mut program: clap::Command, topic: &[String]) -> Result<String, Failure> {
    program.build();
    match topic {
        [] => Ok(program.render_long_help().to_string()),
        [name] => {
            if let Some((_, text)) = TOPICS.iter().find(|(topic, _)| topic == name) {
                return Ok((*text).into());
            }
            let Some(command) = program.find_subcommand_mut(name) else {
                let topics = TOPICS.map(|(topic, _)| topic).join(", ");
                return Err(Failure::Usage(format!(
                    "no command or topic {} exists; topics are {topics}, the commands are those of \
                    `slew --help`",
                    escape(name)
                )));
            };
            Ok(command.render_long_help().to_string())
        }
        _ => Err(Failure::Usage("name one command or topic".into())),
    }
}

/// Returns the starter spec that the arguments request.
pub fn template(args: &InitArgs) -> String {
    match args.purpose {
        Some(Purpose::Wheels) => include_str!("templates/wheels.toml"),
        Some(Purpose::Thrusters) => include_str!("templates/thrusters.toml"),
        Some(Purpose::Time) => include_str!("templates/time.toml"),
        None if args.simulation => slewkit_files::spec::simulation_template(),
        None => slewkit_files::spec::template(),
    }
    .into()
}

/// Writes `text` to the file that the arguments name, or to stdout.
pub fn run(args: &Args, text: &str, console: &mut Console) -> Result<Exit, Failure> {
    match &args.output {
        Some(path) if path.as_os_str() != "-" => {
            let target = Target::new(path, args.force)?;
            target.write(|output| Ok(output.write_all(text.as_bytes())?))?;
            console.say(&summary::line("wrote", &escape(&path.to_string_lossy())));
        }
        _ => console::to_stdout(|output| Ok(output.write_all(text.as_bytes())?))?,
    }
    Ok(Exit::Solved)
}
