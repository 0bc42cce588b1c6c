//! What holds for every Lie kernel and every environment.

mod environments;
mod kernels;
