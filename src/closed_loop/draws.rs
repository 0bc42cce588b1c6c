//! The random draws of each case, and the square roots of the covariances that are sampled at every
//! step.
//!
//! Every quantity has its own stream of random numbers, determined by the seed, the case and the
//! purpose of the stream. Adding a sensor therefore does not change the numbers of another one.

use super::Lost;
use crate::Matrix3;
use crate::mechanics::body::Inertia;
use crate::numerics::random::Stream;
use crate::optimize::discrete::linear_plan::{Matrix6, Parameter, Vector6};
use crate::uncertainty::Uncertainty;
use nalgebra::{Const, DefaultAllocator, DimDiff, DimSub, SMatrix, ToTypenum, U1, allocator::Allocator};

/// The identifiers of the streams, one for each purpose.
pub(super) mod stream {
    pub const PARAMETERS: u32 = 1 << 16;
    pub const START: u32 = PARAMETERS + 1;
    pub const SENSORS: u32 = PARAMETERS + 2;
    pub const TORQUE: u32 = PARAMETERS + 3;
}

/// Maximum number of inertias that are drawn for one case. For a flat plate about half of the draws
/// are impossible.
const MOST_DRAWS: u32 = 64;

/// The random numbers of all cases of one seed.
#[derive(Clone, Debug)]
pub(super) struct Draws<'a> {
    uncertainty: &'a Uncertainty,
    nominal: Inertia,
    seed: u64,
    /// Square root of the covariance of the initial error.
    start: Matrix6,
    /// Square root of the covariance of the torque noise.
    pub torque: Matrix3,
    /// Square root of the covariance of the sensor noise.
    pub sensors: Matrix6,
}

/// The true craft of a case.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Drawn values of the uncertain parameters, in the order of [`Uncertainty::parameters`].
    pub parameters: Vec<f64>,
    pub inertia: Inertia,
    /// Number of drawn matrices that are not the inertia of a body.
    pub rejected: u32,
}

impl<'a> Draws<'a> {
    pub fn new(uncertainty: &'a Uncertainty, nominal: &Inertia, seed: u64) -> Self {
        Self {
            uncertainty,
            nominal: nominal.clone(),
            seed,
            start: root(&uncertainty.start),
            torque: root(&uncertainty.torque_noise),
            sensors: root(&uncertainty.sensor_noise),
        }
    }

    /// Draws the true craft of a case.
    ///
    /// # Errors
    /// [`Lost`] if no drawn matrix is the inertia of a body.
    pub fn craft(&self, case: u64) -> Result<Drawn, Lost> {
        let parameters = &self.uncertainty.parameters;
        let mut stream = Stream::new(self.seed, case, stream::PARAMETERS);
        let mut values: Vec<f64> = parameters.iter().map(|(_, _, sigma)| sigma * stream.normal()).collect();
        let mut rejected = 0;
        loop {
            let mut j = *self.nominal.j();
            for (value, (_, parameter, _)) in values.iter().zip(parameters) {
                if let Parameter::Inertia(delta) = parameter {
                    j += delta * *value;
                }
            }
            if let Ok(inertia) = Inertia::new(j) {
                return Ok(Drawn { parameters: values, inertia, rejected });
            }
            rejected += 1;
            if rejected >= MOST_DRAWS {
                return Err(Lost);
            }
            for (value, (_, parameter, sigma)) in values.iter_mut().zip(parameters) {
                if matches!(parameter, Parameter::Inertia(_)) {
                    *value = sigma * stream.normal();
                }
            }
        }
    }

    /// Draws the initial error `[ζ; δΩ]` of a case, rad and rad/s.
    pub fn start(&self, case: u64) -> Vector6 {
        let mut normal = Stream::new(self.seed, case, stream::START);
        self.start * Vector6::from_fn(|_, _| normal.normal())
    }

    /// Returns the streams that a case reads at every step: for the sensors, then for the torque.
    pub fn noise(&self, case: u64) -> [Stream; 2] {
        [stream::SENSORS, stream::TORQUE].map(|of| Stream::new(self.seed, case, of))
    }
}

/// Returns a square root of a covariance: a matrix `root` with `root rootᵀ` equal to it.
fn root<const N: usize>(covariance: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N>
where
    Const<N>: DimSub<U1> + ToTypenum,
    DefaultAllocator: Allocator<DimDiff<Const<N>, U1>>,
{
    let eigen = (0.5 * (covariance + covariance.transpose())).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    eigen.eigenvectors * SMatrix::<f64, N, N>::from_diagonal(&roots)
}
