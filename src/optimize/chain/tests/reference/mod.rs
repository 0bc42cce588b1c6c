//! A second way to an optimum of a chain, which shares the chain's first derivatives alone with the
//! product: the matrix of all conditions on a set of acting rows, with differences for second
//! derivatives, and Newton on that set. Tests compare the interior point and its counts with it.

mod banded;
pub(crate) mod curvature;
pub(crate) mod evaluated;
pub(crate) mod kkt;
pub(crate) mod newton;
pub(crate) mod rows;
pub(crate) mod step;
