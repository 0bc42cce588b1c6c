//! The output, files and exit codes of the real binary in a temporary folder.
//!
//! It proves that users see the results of the library: exit codes, words, files and pages, also
//! after an interruption. Whether the library is right is proved elsewhere.

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
mod table;
mod timeline;
