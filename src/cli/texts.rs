//! `slew schema` and `slew init`: texts to start from.

use super::console;
use super::{Console, Exit, Failure, summary};
use slewkit::files::export::Target;
use slewkit::files::spec::escape;
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
    #[command(flatten)]
    pub output: Args,
}

/// The JSON Schema of specs.
pub fn schema() -> String {
    format!("{:#}\n", slewkit::files::spec::schema())
}

/// A commented spec.
pub fn template(simulation: bool) -> String {
    if simulation { slewkit::files::spec::simulation_template() } else { slewkit::files::spec::template() }
        .into()
}

/// Writes `text` where the arguments say.
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
