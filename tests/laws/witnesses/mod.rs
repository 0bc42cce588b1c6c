//! The witnesses against reference vectors and closed forms, and their verdict on right and wrong
//! plans.

mod agreement;
mod continuous;
mod discrete;
mod margins;
mod support;
mod wheels;
mod wrong_plans;
