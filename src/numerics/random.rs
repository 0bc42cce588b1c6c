//! Counter-based random numbers: Philox 4×32 with ten rounds (Salmon, Moraes, Dror, Shaw, *Parallel
//! Random Numbers: As Easy as 1, 2, 3*, SC 2011).
//!
//! A number is a function of only a key and a counter. Any case of a million therefore has its own
//! numbers, independent of the cases before it, of the machine and of the order. The paper defines
//! the function, and tests compare it with the vectors of its authors: no release will change a
//! stream.
//!
//! # Which random numbers?
//!
//! Philox 4×32 of ten rounds is a function and not a sequence. The key is the seed, and the counter
//! is (quantity, case). Case 17 of seed 1 is equal alone, in a shard, in a run of more cases and in
//! every release. The tests contain the vectors of the authors. The code is thirty lines of this
//! crate, because a dependency may change its stream with a major version, and the paper does not.

use std::f64::consts::TAU;

const MULTIPLIERS: [u32; 2] = [0xd251_1f53, 0xcd9e_8d57];
/// The fractional parts of the golden ratio and of √3, times 2³², which advance the key from round
/// to round.
const WEYL: [u32; 2] = [0x9e37_79b9, 0xbb67_ae85];
const ROUNDS: usize = 10;

/// Returns the four random words of a key and a counter.
fn philox(mut key: [u32; 2], mut counter: [u32; 4]) -> [u32; 4] {
    for round in 0..ROUNDS {
        if round > 0 {
            key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
        }
        let product = |index: usize| {
            let product = u64::from(MULTIPLIERS[index]) * u64::from(counter[2 * index]);
            ((product >> 32) as u32, product as u32)
        };
        let ((high_0, low_0), (high_1, low_1)) = (product(0), product(1));
        counter = [high_1 ^ counter[1] ^ key[0], low_1, high_0 ^ counter[3] ^ key[1], low_0];
    }
    counter
}

/// The random numbers of one quantity in one case.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u32; 2],
    /// Counter words: block, quantity, low word of the case, high word of the case.
    counter: [u32; 4],
    words: [u32; 4],
    used: usize,
    /// The second number of a pair of normal numbers, if it is not yet used.
    spare: Option<f64>,
}

impl Stream {
    /// Builds the stream of random numbers for a seed, a case and one of its quantities.
    pub fn new(seed: u64, case: u64, quantity: u32) -> Self {
        let counter = [0, quantity, case as u32, (case >> 32) as u32];
        Self { key: [seed as u32, (seed >> 32) as u32], counter, words: [0; 4], used: 4, spare: None }
    }

    fn word(&mut self) -> u32 {
        if self.used == 4 {
            self.words = philox(self.key, self.counter);
            self.counter[0] = self.counter[0].wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// Returns a number uniformly distributed in (0, 1): a midpoint of 2⁵² equal intervals, so that
    /// neither 0 nor 1 occurs.
    pub fn unit(&mut self) -> f64 {
        let bits = (u64::from(self.word()) << 32 | u64::from(self.word())) >> 12;
        (bits as f64 + 0.5) * 2.0_f64.powi(-52)
    }

    /// Returns a normally distributed number of mean 0 and variance 1 (Box, Muller 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.unit().ln()).sqrt();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Returns a point uniformly distributed in the unit ball of a number of dimensions. Its
    /// direction is from normal numbers, and its radius is a root of a uniform number.
    pub fn in_ball(&mut self, dimensions: usize) -> Vec<f64> {
        let direction: Vec<f64> = (0..dimensions).map(|_| self.normal()).collect();
        let norm = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
        let radius = self.unit().powf(1.0 / dimensions as f64);
        direction.into_iter().map(|part| part / norm * radius).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors are from `kat_vectors` of Random123 1.14, lines "philox4x32 10".
    #[test]
    fn words_are_those_of_the_authors() {
        let cases = [
            ([0; 2], [0; 4], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 2], [u32::MAX; 4], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0xa409_3822, 0x299f_31d0],
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (key, counter, words) in cases {
            assert_eq!(philox(key, counter), words);
        }
    }

    /// Compares means of powers with the moments of the distributions, within five standard errors.
    #[test]
    fn numbers_have_the_moments_of_their_distributions() {
        const COUNT: u64 = 200_000;
        let mean = |of: &mut dyn FnMut(&mut Stream) -> f64| {
            (1..=COUNT).map(|case| of(&mut Stream::new(7, case, 3))).sum::<f64>() / COUNT as f64
        };
        let within = |found: f64, expected: f64, deviation: f64| {
            let error = 5.0 * deviation / (COUNT as f64).sqrt();
            assert!((found - expected).abs() < error, "{found} for {expected} ± {error}");
        };
        // Uniform in (0, 1): E u = 1/2, E u² = 1/3, var u = 1/12, var u² = 1/5 − 1/9.
        within(mean(&mut |s| s.unit()), 0.5, 12.0_f64.recip().sqrt());
        within(mean(&mut |s| s.unit().powi(2)), 1.0 / 3.0, (4.0 / 45.0_f64).sqrt());
        // Normal: 0, 1, 0, 3 with variances 1, 2, 15, 96. Both numbers of a pair are checked, and
        // that they are independent of each other.
        for skip in 0..2 {
            for (power, expected, variance) in
                [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0_f64)]
            {
                let mut of = |s: &mut Stream| {
                    (0..skip).for_each(|_| _ = s.normal());
                    s.normal().powi(power)
                };
                within(mean(&mut of), expected, variance.sqrt());
            }
        }
        within(mean(&mut |s| s.normal() * s.normal()), 0.0, 1.0);
        // The 97.5 % quantile of the normal distribution.
        let quantile = 1.959_963_984_540_054;
        within(mean(&mut |s| f64::from(u8::from(s.normal() < quantile))), 0.975, (0.975 * 0.025_f64).sqrt());
        // Unit ball of n dimensions: E r² = n/(n + 2), E x² = 1/(n + 2), and r ≤ 1.
        for n in [1, 2, 3, 6] {
            let mut of = |s: &mut Stream| s.in_ball(n)[0].powi(2);
            within(mean(&mut of), 1.0 / (n as f64 + 2.0), 1.0);
            let mut of = |s: &mut Stream| s.in_ball(n).iter().map(|x| x * x).sum::<f64>();
            within(mean(&mut of), n as f64 / (n as f64 + 2.0), 0.5);
        }
    }

    #[test]
    fn cases_and_quantities_have_streams_of_their_own() {
        let mut seen = std::collections::BTreeSet::new();
        for (seed, case, quantity) in
            (0..8).flat_map(|a| (0..8).flat_map(move |b| (0..8).map(move |c| (a, b, c))))
        {
            let mut stream = Stream::new(seed, case, quantity);
            for _ in 0..8 {
                assert!(seen.insert(stream.unit().to_bits()));
            }
        }
        assert_ne!(Stream::new(1 << 32, 1, 0).unit(), Stream::new(0, 1, 0).unit());
        assert_ne!(Stream::new(0, 1 << 32, 0).unit(), Stream::new(0, 0, 0).unit());
    }
}
