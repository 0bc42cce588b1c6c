//! The planner as a whole, through the public interface: order, costs, units, symmetries, honesty.

#[path = "planner/bounds.rs"]
mod bounds;
#[path = "planner/common.rs"]
mod common;
#[path = "planner/costs.rs"]
mod costs;
#[path = "planner/dense.rs"]
mod dense;
#[path = "planner/invariance.rs"]
mod invariance;
#[path = "planner/limits.rs"]
mod limits;
#[path = "planner/order.rs"]
mod order;
