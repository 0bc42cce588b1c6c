//! The real binary in a folder of its own: what it prints, writes and returns.

mod binary;
mod plan;
mod simulate;
