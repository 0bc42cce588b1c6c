//! Many maneuvers: tables of cases, folders of specs, grids and random draws, planned on several
//! threads.
//!
//! ```text
//! base spec + table | folder | grid | [dispersion] ──▶ Batch ──▶ Case ──▶ plan ──▶ CaseResult ──▶ Journal
//! ```
//!
//! A case is a spec with keys set, from any source: the batch plans it as
//! `slew plan --set key=value` does, to the last bit. Cases are independent, no guess passes from
//! one to another, and their results are written in the order of the cases. The bytes are equal
//! on any number of threads, after any interruption, and from merged shards ([`merge()`]). The
//! only exception is a time limit of the solver.
//!
//! [`Batch`] holds the cases, [`run`] plans them, [`Journal`] keeps the results and continues an
//! incomplete file, [`Tally`] counts the results.
//!
//! ```
//! use slewkit_files::batch::{run, Axis, Batch, Options, Shard};
//! use slewkit_files::spec::{Base, Format};
//!
//! let text = r#"
//! format = 1
//! body = { inertia_kg_m2 = [2, 3, 4] }
//! start = { attitude = { axis = [0, 0, 1], angle_deg = 0 } }
//! end = { attitude = { axis = [1, 1, 0], angle_deg = 60 } }
//! maneuver = { duration_s = 10, steps = 40 }
//! "#;
//! let base = Base::from_reader(text.as_bytes(), "slew.toml", Format::Toml, &[])?;
//! let batch = Batch::of_grid(base, vec![Axis::parse("maneuver.duration_s=10:20:3")?])?;
//! let mut costs = vec![];
//! run(&batch, Shard::ALL, 0, &Options::default(), &|| false, &mut |result, _line| {
//!     costs.extend(result.cost);
//!     Ok(())
//! }, &mut || {})?;
//! assert!(costs.len() == 3 && costs[0] > costs[2]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How can the file of results be the same on any number of threads?
//!
//! Cases are independent, and lines are written in their order. A worker may be ahead of the
//! slowest by at most 4096 cases, which bounds the memory. A kill loses the cases that were
//! finished early, and they are planned again. A line holds no time, path or address. Results
//! depend on the machine only with `solver.time_limit_s`, and with `--times`.
//!
//! Flights of a plan ([`FlightCase`]) are kept in such files as well. Their first line holds no
//! number of cases, because a case of a seed does not depend on the others: a run of a thousand
//! cases can be enlarged to a hundred thousand.
//!
//! # Why does a shard take every n-th case?
//!
//! The hard cases of a sweep lie side by side, and contiguous parts would give them all to one
//! process.
//!
//! # What of a draw that is no body?
//!
//! It is a failed case, with its error. Drawing until a valid one appears would change the
//! distribution of the spec, and would hide that the spread does not fit the body. Negative
//! limits and ends within cones are treated in this way too.
//!
//! # Why is everything in memory that the quantiles need?
//!
//! Eight bytes a case that was solved: exact quantiles of ten million cases, the most that there
//! may be, are 80 MB. All other figures of the summary are counted line by line; a continued file
//! is counted while it is read.
//!
//! # Why do batches not write Parquet at once?
//!
//! A Parquet file has its table of contents at its end. If the run is killed, the file can neither
//! be read nor continued. Results must be lines: appended, checked, continued after any kill,
//! merged from shards. `slew merge` reads and checks all of them anyway and makes one file of many,
//! so it also makes the table, of one file or of all shards. It reads them twice, because a column
//! of a key is numeric only if all its values are; it holds 65,536 rows.

mod case;
mod cases;
mod columns;
mod comma;
mod error;
mod flights;
mod journal;
mod merge;
mod options;
mod result;
mod results;
mod run;
mod shard;
mod solve;
#[cfg(feature = "parquet")]
mod tabulated;
mod tally;

pub use case::{Case, Kind};
pub use cases::{Axis, Batch, MAX_CASES, Stream};
pub use comma::CommaTable;
pub use error::BatchError;
pub use flights::{FlightCase, FlightHeader};
pub use journal::{Entry, Found, Journal};
pub use merge::{merge, merge_to_csv, merge_to_parquet};
pub use options::{MAX_THREADS, Options};
pub use result::{CaseError, CaseResult, Header, Verdict};
pub use results::Results;
pub use run::{Ended, run};
pub use shard::Shard;
pub use solve::plan_case;
pub use tally::{Costs, Quantiles, Tally, Worst};
