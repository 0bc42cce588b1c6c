//! Numerical tools that do not involve attitudes: matrix factors, matrix inertia, polynomials,
//! random numbers, threads and the formatting of figures.

pub(crate) mod compensated;
pub(crate) mod cone;
pub(crate) mod eight;
pub mod encoding;
pub(crate) mod factor;
pub mod figures;
pub(crate) mod hermite;
pub(crate) mod least_squares;
pub(crate) mod matrix_inertia;
pub(crate) mod parallel;
pub mod polynomial;
pub mod random;
pub(crate) mod tableau;
pub(crate) mod three;
pub(crate) mod widest;
