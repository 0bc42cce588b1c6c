//! The reasons why no plan was found, with their figures, and the sentences that report them.

use crate::maneuver::problem::ProblemError;
use crate::numerics::figures::{short, significant};
use std::fmt;

/// The reason why no plan was found. It does not prove that no plan exists. `Display` writes it as
/// a sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shortfall {
    /// The nearest iterate violates limits, constraints or the end condition.
    Violated {
        /// The number of iterations or subproblems after which the iteration limit ended the
        /// search; `None` if the search ended for another reason.
        cut_short_after: Option<usize>,
        /// The remaining violations.
        violations: Vec<Violation>,
        /// Whether the path of the iterate reaches the end.
        reaches_end: bool,
    },
    /// The conditions of the optimum hold, but the inputs replayed from the start miss the end.
    Missed {
        /// The largest terminal error, scaled.
        error: f64,
        /// The tolerance on the terminal error, scaled.
        tolerance: f64,
    },
    /// No optimum was found in the requested homotopy class.
    OtherWay {
        /// Whether the nearest optimum turns the short way.
        short: bool,
        /// The rotation angle of the nearest optimum \[deg\].
        turned_deg: f64,
    },
    /// No extremal of the smoothed bang-bang control law was found.
    NoSmoothedExtremal,
    /// The grid has too few steps for the arcs of the extremal that was found.
    FewSteps {
        /// Number of arcs of the extremal.
        arcs: usize,
        /// The smallest number of steps that suffices.
        steps: usize,
    },
    /// An extremal was found in continuous time, but no optimum on the grid.
    NoDiscreteOptimum {
        /// The number of steps of the grid.
        steps: usize,
    },
    /// A plan exists without a minimum pulse width, but no plan was found with it.
    NoPulses {
        /// The minimum pulse width \[s\].
        shortest: f64,
    },
    /// The grid has too few steps for the pulses that were found.
    FewStepsForPulses {
        /// The smallest number of steps that suffices.
        steps: usize,
    },
    /// Pulses were found in continuous time, but no optimum on the grid.
    NoDiscretePulses {
        /// The number of steps of the grid.
        steps: usize,
    },
    /// The requested duration is shorter than the shortest duration that was found.
    TooShort {
        /// The requested duration \[s\].
        asked: f64,
        /// The shortest duration that was found, a local minimum \[s\].
        shortest: f64,
    },
    /// The maneuver is invalid with the first duration that the search tries.
    Unusable(ProblemError),
    /// No plan was found for the requested duration; the results for other durations are included.
    InOtherTime {
        /// The reason why no plan of the requested duration was found.
        missing: Box<Shortfall>,
        /// The requested duration \[s\].
        asked: f64,
        /// The shortest duration that was found, a local minimum \[s\]; `None` if none was found.
        shortest: Option<f64>,
        /// A longer duration for which a plan was found \[s\].
        longer: Option<f64>,
    },
    /// The reason as a sentence, as read from a plan file.
    Told(String),
}

/// A limit or constraint that stays violated.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The name of the limit or constraint.
    pub name: String,
    /// The size of the violation.
    pub excess: Excess,
}

/// The amount by which a limit or constraint is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excess {
    /// The violation of a cone, as an angle \[rad\].
    Angle(f64),
    /// The violation of a limit, as a fraction of the limit.
    Share(f64),
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Violated { cut_short_after, violations, reaches_end } => {
                f.write_str(&violated(*cut_short_after, violations, *reaches_end))
            }
            Self::Missed { error, tolerance } => write!(
                f,
                "the conditions of the optimum hold, but the inputs replayed from the start miss the \
                end by {error:.1e}, scaled; the tolerance is {tolerance:.1e}"
            ),
            Self::OtherWay { short, turned_deg } => {
                let way = if *short { "short" } else { "long" };
                write!(
                    f,
                    "no optimum of the requested homotopy class was found; the nearest goes the \
                    {way} way and turns by {turned_deg:.1}°"
                )
            }
            Self::NoSmoothedExtremal => f.write_str("no smoothed extremal was found"),
            Self::FewSteps { arcs, steps } => write!(f, "{arcs} arcs need at least {steps} steps"),
            Self::NoDiscreteOptimum { steps } => write!(f, "no discrete optimum was found on {steps} steps"),
            Self::NoPulses { shortest } => write!(
                f,
                "no pulses of at least {} s that meet the end were found; a plan without a shortest \
                pulse exists",
                short(*shortest)
            ),
            Self::FewStepsForPulses { steps } => write!(f, "the pulses need at least {steps} steps"),
            Self::NoDiscretePulses { steps } => {
                write!(f, "no discrete optimum of the pulses was found on {steps} steps")
            }
            Self::TooShort { asked, shortest } => write!(
                f,
                "no plan of {} s was found; the shortest duration found is {} s (locally minimal)",
                short(*asked),
                significant(*shortest, 6)
            ),
            Self::Unusable(error) => error.fmt(f),
            Self::InOtherTime { missing, asked, shortest, longer } => {
                write!(f, "{missing}; ")?;
                let figures = |shortest: f64| (short(*asked), significant(shortest, 6));
                match (*shortest, longer) {
                    (Some(shortest), _) if shortest < *asked => {
                        let (asked, shortest) = figures(shortest);
                        write!(f, "no plan of {asked} s was found, although a plan of {shortest} s exists")
                    }
                    (Some(shortest), _) => {
                        let (asked, shortest) = figures(shortest);
                        write!(
                            f,
                            "no plan of {asked} s was found, the shortest duration found is {shortest} s \
                                (locally minimal)"
                        )
                    }
                    (None, Some(longer)) => write!(f, "a plan of {longer} s was found"),
                    (None, None) => {
                        f.write_str("no plan was found for up to three times the duration either")
                    }
                }
            }
            Self::Told(text) => f.write_str(text),
        }
    }
}

/// Describes the remaining violations at the last iterate.
fn violated(cut_short_after: Option<usize>, violations: &[Violation], reaches_end: bool) -> String {
    let cut = cut_short_after
        .map(|iterations| format!("the iteration limit ended the search, after {iterations} iterations"));
    let of_one = |Violation { name, excess }: &Violation| match excess {
        Excess::Angle(angle) => format!("\"{name}\" remains violated by {:.3} deg", angle.to_degrees()),
        Excess::Share(share) => format!("{name} remains exceeded by {:.2} %", 100.0 * share),
    };
    let open = (!reaches_end).then(|| match cut_short_after {
        Some(_) => "the path does not yet reach the end".to_string(),
        None => "no path within limits and constraints that reaches the end was found".to_string(),
    });
    let parts: Vec<String> = cut.into_iter().chain(violations.iter().map(of_one)).chain(open).collect();
    if parts.is_empty() {
        "the search approached the end but did not converge".into()
    } else {
        parts.join("; ")
    }
}
