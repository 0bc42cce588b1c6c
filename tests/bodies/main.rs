//! Bodies and their mutual gravity: reference vectors, finite differences, limits, conservation.

#[path = "../common/mod.rs"]
mod common;

mod conservation;
mod gradients;
mod limits;
mod reference;
mod rejected;
mod systems;
mod verlet;
