//! Random cases: each case is one draw of the quantities in `[dispersion]` of the spec.
//!
//! The draw of quantity k in case i is a function of the seed, i and k, which are the key and the
//! counter of a counter-based random number generator. A case is therefore identical if it is
//! planned alone, in any shard, or in a run of more cases.

use crate::batch::{BatchError, Case};
use crate::spec::{Dispersion, Distribution, Override, Varied};
use nalgebra::DVector;
use slewkit::numerics::random::Stream;

/// Source of random cases, which draws values from the distributions of a spec.
#[derive(Debug)]
pub(super) struct Draws(pub Dispersion);

impl Draws {
    pub fn keys(&self) -> Vec<String> {
        self.0.varied.iter().map(|varied| varied.key.clone()).collect()
    }

    /// Returns the case with this number.
    pub fn case(&self, number: u64) -> Result<Case, BatchError> {
        let Dispersion { seed, varied, .. } = &self.0;
        let draw = |(index, varied): (usize, &Varied)| {
            let mut stream = Stream::new(*seed, number, index as u32);
            let value = varied.nominal.moved(&offset(varied, &mut stream));
            Override::new(&varied.key, &value)
                .map_err(|reason| BatchError::argument("E0160", reason, "shorten the key"))
        };
        let set = varied.iter().enumerate().map(draw).collect::<Result<_, _>>()?;
        Ok(Case { number, name: None, set, spec: None })
    }
}

/// Draws the deviation of a quantity from its nominal value, one number for each component.
fn offset(varied: &Varied, stream: &mut Stream) -> Vec<f64> {
    let count = varied.map.ncols();
    let standard = match varied.distribution {
        Distribution::Normal => (0..count).map(|_| stream.normal()).collect(),
        Distribution::Uniform => (0..count).map(|_| 2.0 * stream.unit() - 1.0).collect(),
        Distribution::Ball => stream.in_ball(count),
    };
    (&varied.map * DVector::from_vec(standard)).as_slice().to_vec()
}
