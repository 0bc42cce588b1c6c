//! The tests of the laws of the library that need nothing but the library: `cargo test -p slewkit`
//! runs them.
//!
//! | module | what it shows |
//! |---|---|
//! | `every` | what holds for every Lie kernel and every environment |
//! | `bodies` | shapes and mutual gravity: closed forms, finite differences, conservation |
//! | `witnesses` | each witness against closed forms and the others, and its verdicts on plans |
//! | `infeasible` | proofs that no plan exists: never against one that does |
//!
//! `every` has identities, derivatives and reference vectors. `witnesses` has margins, and the
//! verdict on right and wrong plans. `infeasible` is sharp where the figure is known. Tests that
//! read specs, or that run the program, stand in `tests/it`.

mod bodies;
mod every;
mod evidence;
mod infeasible;
mod witnesses;
