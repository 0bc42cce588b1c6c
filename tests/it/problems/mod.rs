//! Everything that is shipped to be run: problems and examples.

mod maneuvers;
mod simulations;
