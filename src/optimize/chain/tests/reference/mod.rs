//! An independent method for the optimum of a chain, which shares only the chain's first
//! derivatives with the product. It assembles the KKT matrix on a set of active rows, with finite
//! differences as second derivatives, and applies Newton's method on that set. Tests compare the
//! interior-point method and its counts of descent directions with it.

mod banded;
pub(crate) mod curvature;
pub(crate) mod evaluated;
pub(crate) mod kkt;
pub(crate) mod newton;
pub(crate) mod rows;
pub(crate) mod step;
