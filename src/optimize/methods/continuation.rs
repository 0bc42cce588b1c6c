//! Continuation: a solution of one problem is carried to another problem through intermediate ones.
//! The solution of each is the initial guess for the next.
//!
//! The step size in the parameter adapts: smaller after a failed step, larger after an easy one.

/// Step sizes of a continuation, in units of its parameter.
pub(crate) struct Pace {
    pub first: f64,
    pub least: f64,
    pub most: f64,
    /// Factor on the step size after an easy step.
    pub longer: f64,
    /// Factor on the step size after a failed step.
    pub shorter: f64,
}

/// Result of one step of a continuation.
pub(crate) enum Step<T> {
    /// The step reached a solution; `easily` allows a larger next step.
    Solved { at: T, easily: bool },
    /// The step found no solution.
    Failed,
    /// A stop was requested.
    Stopped,
}

impl<T> From<Option<T>> for Step<T> {
    /// Converts a solution to an easy step, and `None` to a failed one.
    fn from(found: Option<T>) -> Self {
        found.map_or(Self::Failed, |at| Self::Solved { at, easily: true })
    }
}

/// Continues from a solution until `arrived` is true; the error holds the last solution that was
/// reached.
pub(crate) fn follow<T>(
    pace: &Pace,
    mut at: T,
    arrived: impl Fn(&T) -> bool,
    mut step: impl FnMut(&T, f64) -> Step<T>,
) -> Result<T, T> {
    let mut length = pace.first;
    while !arrived(&at) {
        match step(&at, length) {
            Step::Solved { at: next, easily } => {
                at = next;
                if easily {
                    length = (pace.longer * length).min(pace.most);
                }
            }
            Step::Failed => {
                length *= pace.shorter;
                if length < pace.least {
                    return Err(at);
                }
            }
            Step::Stopped => return Err(at),
        }
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Claim: if steps up to some length succeed, a continuation finds this length and arrives; if
    /// no further step succeeds, it returns the last solution.
    #[test]
    fn steps_adapt_to_what_succeeds() {
        let pace = Pace { first: 0.5, least: 0.01, most: 0.5, longer: 2.0, shorter: 0.5 };
        let walk = |longest: f64, wall: f64| {
            let mut tried = 0;
            let step = |at: &f64, length: f64| {
                tried += 1;
                Some(at + length).filter(|next| length <= longest && *next <= wall).into()
            };
            (follow(&pace, 0.0, |at| *at >= 1.0, step), tried)
        };
        assert_eq!(walk(1.0, 9.0), (Ok(1.0), 2));
        let (reached, tried) = walk(0.1, 9.0);
        assert!(reached.is_ok_and(|at| at >= 1.0) && tried < 40, "{tried}");
        let (reached, _) = walk(1.0, 0.7);
        assert!(reached.is_err_and(|at| 0.7 - at < 0.02));
    }
}
