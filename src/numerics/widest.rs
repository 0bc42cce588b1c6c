//! Selection of the widest vector registers of the machine.
//!
//! A program is compiled for every machine of its architecture, with registers of two numbers; most
//! machines have registers of four or eight. Code that is called through [`widest`] is compiled for
//! each width, and the width of the machine is selected at run time. Sums and products are not
//! contracted and keep their order, so that every width gives the same bits.

/// Runs `work` with the widest registers. Functions that `work` calls also use them if they are
/// marked `#[inline(always)]`.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(feature = "wide")]
    return pulp::Arch::new().dispatch(work);
    #[cfg(not(feature = "wide"))]
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns chaotic products and sums over lanes, in which a contraction or another order would
    /// be visible.
    #[inline(always)]
    fn chaotic(start: &[f64; 16]) -> [f64; 16] {
        let mut lanes = *start;
        for step in 0..200 {
            let total: f64 = lanes.iter().sum();
            for lane in &mut lanes {
                *lane = 3.9 * *lane * (1.0 - *lane) + 1e-3 * total / (1.0 + step as f64);
                *lane -= lane.floor();
            }
        }
        lanes
    }

    #[test]
    fn every_width_gives_the_same_bits() {
        let start = std::array::from_fn(|lane| 0.3 + 0.04 * lane as f64);
        let wide = widest(
            #[inline(always)]
            || chaotic(&start),
        );
        assert_eq!(wide.map(f64::to_bits), chaotic(&start).map(f64::to_bits));
    }
}
