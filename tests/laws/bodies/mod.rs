//! Bodies and their mutual gravity: reference vectors, finite differences, limits, conservation.

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
