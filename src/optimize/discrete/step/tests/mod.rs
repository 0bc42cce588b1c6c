//! The discrete dynamics against reference values, an independent twin in dual numbers, and its
//! laws.

mod first_order;
mod identities;
mod implicit;
mod momentum;
mod reference;
mod second_order;
mod twin;
