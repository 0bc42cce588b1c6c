//! Everything that is shipped to be run: problems and examples.

mod examples;
mod maneuvers;
mod simulations;
