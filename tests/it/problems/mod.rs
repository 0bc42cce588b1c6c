//! Everything that is shipped to be run: problems and examples.
//!
//! It proves that a user who runs them gets what `[expect]` says: numbers from elsewhere, each with
//! its source in the file.

mod course;
mod found;
mod maneuvers;
mod published;
mod sequences;
mod simulations;
mod told;
