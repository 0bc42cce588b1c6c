//! The real binary in a folder of its own: what it prints, writes and returns.
//!
//! It proves that what users see is what the library found: exit codes, words, files and pages,
//! after interruption too. Whether the library is right is proved elsewhere.

mod batches;
mod batches_refused;
mod batches_shown;
pub(crate) mod binary;
mod browser;
mod check;
mod compare;
mod convert;
mod export;
mod first_time;
mod fly;
mod monte_carlo;
mod page;
mod plan;
mod report;
mod report_optimality;
mod report_studies;
mod sequences;
mod simulate;
mod sky;
mod streams;
mod timeline;
