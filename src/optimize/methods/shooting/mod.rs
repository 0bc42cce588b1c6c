//! Newton shooting on the costate `λ_{−1}`, and what it starts from.

pub(crate) mod guess;
pub(crate) mod newton;
pub(crate) mod refine;
