//! Batches of maneuvers: tables of cases, folders of specs, grids and random draws, planned on
//! several threads.
//!
//! ```text
//! base spec + table | folder | grid | [dispersion] ──▶ Batch ──▶ Case ──▶ plan ──▶ CaseResult ──▶ Journal
//! ```
//!
//! A case is a spec with some keys set, from any source. The batch plans it as
//! `slew plan --set key=value` does, to the last bit. Cases are independent: no initial guess
//! passes from one to another. Their results are written in the order of the cases. The file has
//! the same bytes for any number of threads, after any interruption, and when merged from shards
//! ([`merge()`]). The only exception is a time limit of the solver.
//!
//! [`Batch`] holds the cases, [`run`] plans them, [`Journal`] stores the results and continues an
//! incomplete file, and [`Tally`] counts the results.
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
//! # How can the file of results be equal for any number of threads?
//!
//! Cases are independent, and their lines are written in the order of the cases. A worker may be at
//! most 4096 cases ahead of the slowest worker, which bounds the memory. If the process is killed,
//! results that wait for an earlier case are lost, and these cases are planned again. A line holds
//! no time, path or address. Results depend on the machine only with `solver.time_limit_s` and with
//! `--times`.
//!
//! Flights of a plan ([`FlightCase`]) are stored in such files as well. Their first line does not
//! hold the number of cases, because a case does not depend on the others: a run of a thousand
//! cases can be extended to a hundred thousand.
//!
//! # Why does a shard take every n-th case?
//!
//! The hard cases of a sweep are neighbours, and contiguous parts would give them all to one
//! process.
//!
//! # What happens to a draw with an impossible inertia?
//!
//! The draw is a failed case, with its error. Repeating the draw until it is valid would change the
//! distribution of the spec, and would hide that the spread does not fit the body. Negative limits
//! and ends within cones are treated in the same way.
//!
//! # Why are all costs kept in memory?
//!
//! Exact quantiles need the cost of each solved case, which takes eight bytes. For ten million
//! cases, the largest number, this is 80 MB. All other figures of the summary are counted line by
//! line; when a file is continued, they are counted while it is read.
//!
//! # Why do batches not write Parquet directly?
//!
//! A Parquet file has its index at its end. If the run is killed, the file can be neither read nor
//! continued. Results must therefore be lines, which can be appended, checked, continued after an
//! interruption and merged from shards. `slew merge` reads and checks all lines anyway and makes
//! one file of many. It therefore also writes the Parquet table, from one file or from all shards.
//! It reads the results twice, because the column of a key is numeric only if all its values are;
//! it holds 65,536 rows in memory.

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
