//! The tests of the public interface, in one binary: a crate of its own for each would be linked eighteen times.
//!
//! A module holds one kind of evidence. A new test goes where its claim belongs:
//!
//! | module | what it shows |
//! |---|---|
//! | `documents` | commands of README and `docs/` print what stands under them |
//! | `imports` | the import law of `DESIGN.md` |
//! | `laws` | what holds for every Lie kernel and every environment: identities, derivatives, reference vectors |
//! | `bodies` | shapes and mutual gravity: closed forms, finite differences, conservation |
//! | `witnesses` | each witness against closed forms and the others, margins, and the verdict on right and wrong plans |
//! | `infeasible` | proofs that no plan exists: never against one that does, sharp where the figure is known |
//! | `maneuvers` | the planner as a whole: order, costs, units, symmetries, limits, honesty |
//! | `problems` | every file of `problems/` and every example comes to what it says |
//! | `files` | specs and plan files: what they mean, what is refused and in which words, what reads back |
//! | `command_line` | the real binary in a folder of its own: what it prints, writes and returns |
//!
//! Shared: the crate `evidence` (reference files, random numbers, random specs). What counts allocations needs an allocator of
//! its own and is the other binary, `tests/allocation.rs`. Unit tests of private parts stand beside them in `src`.

mod bodies;
mod command_line;
mod documents;
mod files;
mod imports;
mod infeasible;
mod laws;
mod maneuvers;
mod problems;
mod witnesses;
