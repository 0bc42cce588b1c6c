//! Many legs of one spacecraft from rest to rest: bounds of a leg, and tables of all legs.

pub mod leg_bound;
pub mod symmetry;
pub mod table;

pub use leg_bound::LegBound;
pub use symmetry::Symmetry;
pub use table::{Making, Quantity, SlewTable, TableError, TableOptions};
