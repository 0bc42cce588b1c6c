//! The witnesses against reference vectors and closed forms, and their verdict on right and wrong plans.

#[path = "verify/agreement.rs"]
mod agreement;
mod common;
#[path = "verify/continuous.rs"]
mod continuous;
#[path = "verify/discrete.rs"]
mod discrete;
#[path = "verify/support.rs"]
mod support;
#[path = "verify/wrong_plans.rs"]
mod wrong_plans;
