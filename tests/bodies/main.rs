//! Bodies and their mutual gravity: reference vectors, finite differences, limits, conservation.

#[path = "../common/mod.rs"]
mod common;

mod conservation;
mod field;
mod gradients;
mod limits;
mod obj;
mod reference;
mod rejected;
mod relative;
mod shapes;
mod systems;
mod verlet;
