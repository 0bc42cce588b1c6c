//! The motion between the rows of an attitude file, as the file defines it.
//!
//! Polynomials interpolate the four components of the quaternions, whose sign is consistent along
//! the rows. The result is normalised. Lagrange's go through attitudes, Hermite's through attitudes
//! and the derivatives `q' = ½ q (0, Ω)` that follow from their rates. No polynomial crosses the
//! end of a block.

use super::Attitudes;
use crate::spec::cut;
use slewkit::lie::interpolation::{Row, cubic, linear};
use slewkit::numerics::polynomial;
use slewkit::{Vector3, lie};

/// The interpolation between the rows of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// The file does not state the interpolation.
    #[default]
    Unsaid,
    /// One axis and one rate.
    OneRate,
    /// Lagrange's polynomial of this degree, two at least.
    Lagrange(usize),
    /// Hermite's of this degree, for which the file has rates.
    Hermite(usize),
}

/// The highest degree: beyond it polynomials on equal steps oscillate.
const HIGHEST: usize = 25;

impl Between {
    /// Returns the interpolation of this name and degree.
    ///
    /// # Errors
    /// Returns why the interpolation is not used.
    pub(super) fn named(name: &str, degree: Option<usize>) -> Result<Self, String> {
        let is = |word: &str| name.eq_ignore_ascii_case(word);
        let short = cut(name, 30);
        match degree {
            _ if is("LINEAR") => Ok(Self::OneRate),
            None => Err(format!("{short}: the file does not state its degree")),
            Some(0) => Err(format!("{short} of degree 0")),
            Some(degree) if degree > HIGHEST => {
                Err(format!("{short} of degree {degree}: {HIGHEST} is the highest supported degree"))
            }
            Some(1) => Ok(Self::OneRate),
            Some(degree) if is("LAGRANGE") => Ok(Self::Lagrange(degree)),
            Some(degree) if is("HERMITE") => Ok(Self::Hermite(degree)),
            Some(_) => Err(format!("{short}, which is not supported")),
        }
    }

    /// Returns the number of rows that the interpolation uses.
    pub fn rows(self) -> usize {
        match self {
            Self::Unsaid | Self::OneRate => 2,
            Self::Lagrange(degree) => degree + 1,
            Self::Hermite(degree) => (degree + 1).div_ceil(2),
        }
    }
}

/// The rows of one block. The last row may be the first row of the next block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// The first row of the block.
    pub first: usize,
    /// The last row of the block.
    pub last: usize,
    /// The interpolation between its rows.
    pub between: Between,
}

/// The attitudes that are inserted between the rows of a file.
#[derive(Clone, Debug, Default)]
pub struct Refined {
    /// Seconds from the first row of the file.
    pub time: Vec<f64>,
    /// The attitudes, as in [`Attitudes::quaternion`].
    pub quaternion: Vec<[f64; 4]>,
    /// The row of the file at each time, or the last one before it.
    pub row: Vec<usize>,
    /// The breaks, as in [`Attitudes::breaks`].
    pub breaks: Vec<usize>,
}

/// The largest number of halvings of an interval between two rows.
const MOST_HALVINGS: u32 = 6;
/// The largest number of rows of a refinement.
const MOST_ROWS: usize = 1 << 22;

impl Attitudes {
    /// Returns the attitude at `time` \[s\] from the first row, interpolated as the file states. If
    /// the file does not state the interpolation, it is the cubic through attitudes and rates, or a
    /// turn at one rate. `None` outside of all blocks.
    pub fn at(&self, time: f64) -> Option<[f64; 4]> {
        let inside = |block: &&Block| (self.time[block.first]..=self.time[block.last]).contains(&time);
        self.within(self.blocks.iter().find(inside)?, time)
    }

    fn within(&self, block: &Block, time: f64) -> Option<[f64; 4]> {
        let times = &self.time[block.first..=block.last];
        let count = block.between.rows().min(times.len());
        let from = block.first + polynomial::about(times, count, time);
        let rows = from..from + count;
        if let [only] = times {
            return (*only == time).then(|| self.quaternion[block.first]);
        }
        let slopes: Option<Vec<[f64; 4]>> = match block.between {
            Between::Unsaid | Between::OneRate => {
                let low = from.min(block.last - 1);
                return Some(self.between_two(low, time, block.between == Between::Unsaid));
            }
            Between::Lagrange(_) => None,
            Between::Hermite(_) => {
                Some(rows.clone().map(|k| moved(&self.quaternion[k], &self.rate[k])).collect())
            }
        };
        let nodes: Vec<f64> = self.time[rows.clone()].iter().map(|at| at - self.time[from]).collect();
        let found =
            polynomial::through(&nodes, &self.quaternion[rows], slopes.as_deref(), time - self.time[from])?;
        let length = found.iter().map(|part| part * part).sum::<f64>().sqrt();
        (length > 0.0).then(|| found.map(|part| part / length))
    }

    fn between_two(&self, low: usize, time: f64, by_rates: bool) -> [f64; 4] {
        let row = |k: usize| Row {
            attitude: lie::rotation_from_quaternion(&self.quaternion[k]),
            rate: self.rate.get(k).copied().unwrap_or_default(),
        };
        let h = self.time[low + 1] - self.time[low];
        let share = (time - self.time[low]) / h;
        let attitude = if by_rates && !self.rate.is_empty() {
            cubic(&row(low), &row(low + 1), h, share).attitude
        } else {
            linear(&row(low), &row(low + 1), share)
        };
        lie::quaternion_from_rotation(&attitude)
    }

    /// Returns additional attitudes, so many that the motion at one rate between them follows the
    /// motion of the file to a tenth of `tolerance` \[rad\]; `None` if no block of the file names
    /// another motion.
    pub fn refined(&self, tolerance: f64) -> Option<Refined> {
        let bent = |block: &Block| matches!(block.between, Between::Lagrange(_) | Between::Hermite(_));
        if !self.blocks.iter().any(bent) {
            return None;
        }
        let mut found = Refined::default();
        let mut breaks = self.breaks.iter().peekable();
        for (index, block) in self.blocks.iter().enumerate() {
            for k in block.first..=block.last {
                // The first row of a block that the one above shares is there already.
                if found.row.last() != Some(&k) {
                    if breaks.next_if(|row| **row == k).is_some() {
                        found.breaks.push(found.time.len());
                    }
                    found.add(self.time[k], self.quaternion[k], k);
                }
                if k == block.last || !bent(block) {
                    continue;
                }
                let mut inner = self.inner(block, k, tolerance);
                inner.sort_by(|one, other| one.0.total_cmp(&other.0));
                inner.into_iter().for_each(|(time, quaternion)| found.add(time, quaternion, k));
                if found.time.len() > MOST_ROWS {
                    return None;
                }
            }
            // Two blocks of a file can share one row, the last row of the first block.
            debug_assert!(self.blocks.get(index + 1).is_none_or(|next| next.first >= block.last));
        }
        Some(found)
    }

    /// Moments and attitudes between row `k` of a block and the next.
    fn inner(&self, block: &Block, k: usize, tolerance: f64) -> Vec<(f64, [f64; 4])> {
        let mut open = vec![(self.time[k], self.time[k + 1], 0)];
        let mut found = Vec::new();
        while let Some((from, to, depth)) = open.pop() {
            let middle = 0.5 * (from + to);
            let [start, here, end] = [from, middle, to].map(|time| self.within(block, time));
            let (Some(start), Some(here), Some(end)) = (start, here, end) else { continue };
            let at = |q| Row { attitude: lie::rotation_from_quaternion(q), rate: Vector3::zeros() };
            let straight = linear(&at(&start), &at(&end), 0.5);
            let off = lie::minus(&lie::rotation_from_quaternion(&here), &straight).norm();
            // Once at least: a motion may meet its chord in the middle.
            if (off > 0.1 * tolerance || depth == 0) && depth < MOST_HALVINGS && from < middle && middle < to
            {
                found.push((middle, here));
                open.extend([(from, middle, depth + 1), (middle, to, depth + 1)]);
            }
        }
        found
    }
}

impl Refined {
    fn add(&mut self, time: f64, quaternion: [f64; 4], row: usize) {
        self.time.push(time);
        self.quaternion.push(quaternion);
        self.row.push(row);
    }
}

/// Returns the derivative of a quaternion, scalar first, at a rate in body axes.
fn moved([w, x, y, z]: &[f64; 4], rate: &Vector3) -> [f64; 4] {
    let vector = Vector3::new(*x, *y, *z);
    let moved = 0.5 * (*w * rate + vector.cross(rate));
    [-0.5 * vector.dot(rate), moved.x, moved.y, moved.z]
}
