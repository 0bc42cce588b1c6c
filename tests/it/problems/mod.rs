//! Everything that is shipped to be run: problems and examples.
//!
//! It proves that a user who runs them gets the results of `[expect]`: numbers from independent
//! sources, each with its source in the file.

mod course;
mod found;
mod maneuvers;
mod published;
mod sequences;
mod simulations;
mod told;
