//! Continuation: from a solution of one problem by way of neighbours, each solved from the one
//! before, to that of another.
//!
//! How far the parameter goes at once adapts: less where a neighbour is not found, more where it is
//! found easily.

/// How far a continuation goes at once, in the measure of its parameter.
pub(crate) struct Pace {
    pub first: f64,
    pub least: f64,
    pub most: f64,
    /// Times this after a step that was easy, and after one that failed.
    pub longer: f64,
    pub shorter: f64,
}

/// Where a step led.
pub(crate) enum Step<T> {
    /// To a solution; one that was found easily is a reason to go further at once.
    Solved { at: T, easily: bool },
    /// Nowhere.
    Failed,
    /// Somebody asked to stop.
    Stopped,
}

impl<T> From<Option<T>> for Step<T> {
    /// What is found at all is found easily.
    fn from(found: Option<T>) -> Self {
        found.map_or(Self::Failed, |at| Self::Solved { at, easily: true })
    }
}

/// Goes on from a solution until it has arrived; where it does not get there, how far it came.
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

    /// Claim: where steps of one length are the longest that succeed, a continuation finds that
    /// length and arrives; where none do it ends where it is.
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
