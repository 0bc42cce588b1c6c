//! `slew`: plan, check and verify attitude maneuvers from the command line.

#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    slewkit_cli::run(std::env::args_os()).into()
}
