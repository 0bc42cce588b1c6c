//! Feedback gains and covariances along a plan, and simulated flights of the plan: the records in
//! plan files, and the results of `slew fly`.

mod campaign;
mod plan;
mod runs;
mod whole;

pub use campaign::{
    CampaignRecord, Flight, LoopRecord, MarkRecord, RunRecord, input_rooms, write_cases, write_trace,
};
pub use plan::{
    ArcRecord, ChanceRecord, FeedbackRecord, HeldRecord, LoopUncertainty, MarginsRecord, Part,
    PointingRecord, UncertaintyRecord, boresights, gains_alone, is_posed, unit,
};
pub use runs::Runs;
pub use whole::{Mark, NotFlown, WholeFlight};
