//! Keys of `[dispersion]`: uncertain numbers and their distributions.

use super::Kind::*;
use super::{Key, Kind, Table, q};

/// Largest number of cases, so that their records fit into memory.
pub(crate) const MOST_CASES: i64 = 10_000_000;
/// Largest number of uncertain quantities.
const MOST_VARIED: usize = 100;
const NORMAL: &[&str] = &["normal"];
const UNIFORM: &[&str] = &["uniform"];
const ELLIPSOID: &[&str] = &["ellipsoid"];
/// Keys for the width of a distribution.
pub(crate) const SPREADS: &[&str] =
    &["sigma", "sigma_relative", "covariance", "half_width", "half_width_relative", "semi_axes"];

tables! {
    pub(crate) static DISPERSION {
        /// Seed of the random numbers. The draws of a case depend only on the seed and the number
        /// of the case.
        "seed": Count(0, i64::MAX), needed "seed = 1";
        /// Number of cases.
        "cases": Count(1, MOST_CASES), needed "cases = 1000";
        /// The varied numbers and their distributions. Every entry is drawn independently.
        "vary": List(&VARY, MOST_VARIED), needed "[[dispersion.vary]]\nkey = \"body.inertia_kg_m2\"\n\
            kind = \"normal\"\nsigma_relative = 0.02";
    }

    static VARY[
        selector: Some("kind"),
        exclusive: &[SPREADS],
        one_of: &[
            (&["sigma", "sigma_relative", "covariance"], "sigma = 0.1"),
            (&["half_width", "half_width_relative"], "half_width = 0.1"),
        ],
    ] {
        /// Dotted key of this spec, as for --set, that holds numbers; the numbers below have its
        /// unit. For an attitude: end.attitude.rotation_vector_deg or _rad, also start.attitude
        /// and end.rotation_from_start. A rotation vector δ is then drawn, in body axes, and the
        /// attitude is R exp(δ), for every notation of R.
        "key": Text(200), needed "key = \"actuators.torque_limit_n_m\"";
        /// Distribution about the value of the key: normal, uniform between bounds, uniform within
        /// an ellipsoid.
        "kind": Choice(&["normal", "uniform", "ellipsoid"], &[]), needed "kind = \"normal\"";
        /// Standard deviation in the unit of the key: one for all its numbers, or one for each,
        /// independent. For an inertia one for all, three for its diagonal, or six: xx, yy, zz, xy,
        /// xz, yz.
        "sigma": Spread(q::SPREAD), only NORMAL;
        /// Standard deviation relative to the number that varies.
        "sigma_relative": Spread(q::SPREAD), only NORMAL;
        /// Covariance in the unit of the key squared, rows, or a diagonal; as many numbers as for
        /// sigma.
        "covariance": Square(q::COVARIANCE), only NORMAL;
        /// Half the distance between the bounds, in the unit of the key; as many numbers as for
        /// sigma.
        "half_width": Spread(q::SPREAD), only UNIFORM;
        /// Half the distance between the bounds relative to the number that varies.
        "half_width_relative": Spread(q::SPREAD), only UNIFORM;
        /// Semi-axes in the unit of the key: their lengths along the numbers of the key, or
        /// vectors, one in each row.
        "semi_axes": Square(q::SEMI_AXIS), only ELLIPSOID, needed "semi_axes = [0.1, 0.1, 0.2]";
    }
}
