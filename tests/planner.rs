//! The planner as a whole, through the public interface: order, costs, units, symmetries, honesty.

#[path = "planner/bounds.rs"]
mod bounds;
#[path = "planner/common.rs"]
mod common;
#[path = "planner/costs.rs"]
mod costs;
#[path = "planner/invariance.rs"]
mod invariance;
#[path = "planner/order.rs"]
mod order;
