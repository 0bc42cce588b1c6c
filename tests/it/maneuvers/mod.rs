//! The planner as a whole, through the public interface: order, costs, units, symmetries, honesty.
//!
//! It proves that answers are right on single maneuvers of every kind, by closed forms, published
//! values, other optimisers and laws that every optimum obeys. How often they are right on random
//! maneuvers is counted by the commands of `evidence`.

mod any_attitude;
mod any_of;
mod best;
mod best_known;
mod bounds;
mod costs;
mod dense;
mod duration_within;
mod free_duration;
mod fuel_of_forces;
mod fuel_within;
mod held_cones;
mod in_plane;
mod invariance;
mod landing;
mod level;
mod limits;
mod metamorphic;
mod minimum_fuel;
mod minimum_time;
mod on_equal_steps;
mod order;
mod proof;
mod pulses;
mod pushing_thrusters;
mod shortest;
mod support;
mod targets;
