//! The tests of the laws of the library, which need only the library: `cargo test -p slewkit` runs
//! them.
//!
//! | module | what it shows |
//! |---|---|
//! | `every` | laws of every Lie kernel and every environment |
//! | `bodies` | shapes and mutual gravity: closed forms, finite differences, conservation |
//! | `witnesses` | each witness, compared with closed forms and the other witnesses, and its verdicts on plans |
//! | `infeasible` | proofs that no plan exists, which never deny an existing plan |
//!
//! `every` has identities, derivatives and reference vectors. `witnesses` has margins, and the
//! verdict on right and wrong plans. `infeasible` is sharp where the figure is known. Tests that
//! read specs, or that run the program, are in `tests/it`.

mod bodies;
mod every;
mod evidence;
mod infeasible;
mod sequences;
mod witnesses;
