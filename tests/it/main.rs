//! The tests of the public interface, in one binary: a crate of its own for each would be linked
//! eighteen times.
//!
//! A module holds one kind of evidence. A new test goes where its claim belongs:
//!
//! | module | what it shows |
//! |---|---|
//! | `documents` | commands of README and `docs/` print what stands under them |
//! | `imports` | the import law of `DESIGN.md` |
//! | `maneuvers` | the planner as a whole: order, costs, units, symmetries, limits, honesty |
//! | `problems` | every file of `problems/` and every example comes to what it says |
//! | `files` | specs and plan files: what they mean, what is refused and in which words, what reads back |
//! | `command_line` | the real binary in a folder of its own: what it prints, writes and returns |
//!
//! The crate `evidence` holds the shared code (reference files, random numbers, random specs).
//! Tests that need nothing but the library are in `tests/laws`. The test that counts allocations
//! needs an allocator of its own, and is `tests/allocation.rs`. Unit tests of private parts stand
//! beside them in `src`.

mod command_line;
mod documents;
mod files;
mod imports;
mod maneuvers;
mod problems;
