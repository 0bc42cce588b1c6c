//! Columns of a table of results with one row for each case: their paths in a result and their
//! types.

/// Type of the cells of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Integer,
    Flag,
    Text,
}

/// Columns before the columns of the set keys, each with the path of its value in a result and its
/// type. The column heading is the path with `/` replaced by `_`.
pub(super) const BEFORE: [(&str, Kind); 2] = [("case", Kind::Integer), ("name", Kind::Text)];
/// Columns after the columns of the set keys, in the notation of [`BEFORE`].
pub(super) const AFTER: [(&str, Kind); 36] = [
    ("status", Kind::Text),
    ("exit_code", Kind::Integer),
    ("error/code", Kind::Text),
    ("error/key", Kind::Text),
    ("error/reason", Kind::Text),
    ("error/remedy", Kind::Text),
    ("error/more", Kind::Integer),
    ("objective", Kind::Text),
    ("cost", Kind::Number),
    ("duration_s", Kind::Number),
    ("stops", Kind::Text),
    ("late_s", Kind::Number),
    ("steps", Kind::Integer),
    ("method", Kind::Text),
    ("outcome", Kind::Text),
    ("iterations", Kind::Integer),
    ("sense", Kind::Text),
    ("turned_deg", Kind::Number),
    ("terminal/attitude_rad", Kind::Number),
    ("terminal/momentum_relative", Kind::Number),
    ("terminal/position_relative", Kind::Number),
    ("terminal/linear_momentum_relative", Kind::Number),
    ("proof", Kind::Text),
    ("second_order", Kind::Text),
    ("gap", Kind::Number),
    ("verified/passed", Kind::Flag),
    ("verified/failed", Kind::Text),
    ("verified/discrete_attitude_rad", Kind::Number),
    ("verified/continuous_attitude_deg", Kind::Number),
    ("verified/order", Kind::Number),
    ("verified/peak_torque_n_m", Kind::Number),
    ("verified/peak_rate_deg_s", Kind::Number),
    ("obstruction", Kind::Text),
    ("shortest_duration_s", Kind::Number),
    ("shortfall", Kind::Text),
    ("solve_time_s", Kind::Number),
];
