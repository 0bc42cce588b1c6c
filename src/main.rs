//! `slew`: plan, check and verify attitude maneuvers from the command line.

fn main() {}
