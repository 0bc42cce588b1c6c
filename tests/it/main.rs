//! The tests of the public interface, in one binary: separate crates would be linked eighteen
//! times.
//!
//! A module holds one kind of evidence. A new test belongs in the module of its claim:
//!
//! | module | what it shows |
//! |---|---|
//! | `documents` | commands of README and `docs/` print the output below them |
//! | `imports` | the import law of `DESIGN.md` |
//! | `maneuvers` | the planner as a whole: order, costs, units, symmetries, limits, honesty |
//! | `problems` | every file of `problems/` and every example gives the result that it states |
//! | `files` | specs and plan files: meaning, refusals and their words, reading back |
//! | `command_line` | the output, files and exit codes of the real binary |
//!
//! The crate `evidence` holds the shared code (reference files, random numbers, random specs).
//! Tests that need only the library are in `tests/laws`. The test that counts allocations needs its
//! own allocator, and is `tests/allocation.rs`. Unit tests of private parts are next to them in
//! `src`.

mod command_line;
mod documents;
mod files;
mod imports;
mod maneuvers;
mod problems;
