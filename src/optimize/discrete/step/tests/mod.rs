//! The discrete dynamics compared with reference values, with an independent implementation in dual
//! numbers, and with its identities.

mod first_order;
mod identities;
mod implicit;
mod momentum;
mod reference;
mod second_order;
mod twin;
