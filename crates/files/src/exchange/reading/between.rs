//! The motion between the rows of an attitude file, as the file defines it.
//!
//! Polynomials interpolate the four components of the quaternion, whose sign is consistent along
//! the rows; the result is normalised. Lagrange polynomials pass through the attitudes. Hermite
//! polynomials also have the derivatives `q' = ½ q (0, Ω)` that follow from the rates of the file.
//! No polynomial crosses the end of a block.

use super::Attitudes;
use crate::spec::cut;
use slewkit::lie::interpolation::{Row, cubic, linear};
use slewkit::numerics::polynomial;
use slewkit::{Vector3, lie};

/// Interpolation method between the rows of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// The file does not state an interpolation method.
    #[default]
    Unsaid,
    /// Rotation about one axis at a constant rate.
    OneRate,
    /// Lagrange polynomial of this degree, which is at least two.
    Lagrange(usize),
    /// Hermite polynomial of this degree, which uses the rates in the file.
    Hermite(usize),
}

/// Largest degree of a polynomial. Polynomials of higher degree on a uniform grid oscillate.
const HIGHEST: usize = 25;

impl Between {
    /// Returns the interpolation method with the name `name` and the degree `degree` in a file.
    ///
    /// # Errors
    /// Returns the reason why the program does not use the interpolation of the file.
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

    /// Returns the number of rows through which the interpolation passes.
    pub fn rows(self) -> usize {
        match self {
            Self::Unsaid | Self::OneRate => 2,
            Self::Lagrange(degree) => degree + 1,
            Self::Hermite(degree) => (degree + 1).div_ceil(2),
        }
    }
}

/// The rows of one block of a file. The last row may also be the first row of the next block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Index of the first row of the block.
    pub first: usize,
    /// Index of the last row of the block.
    pub last: usize,
    /// Interpolation method between the rows of the block.
    pub between: Between,
}

/// Attitudes of a file with additional attitudes between its rows.
#[derive(Clone, Debug, Default)]
pub struct Refined {
    /// Time since the first row of the file \[s\].
    pub time: Vec<f64>,
    /// Quaternion at each time, in the convention of [`Attitudes::quaternion`].
    pub quaternion: Vec<[f64; 4]>,
    /// Index of the row of the file at each time, or of the last row before this time.
    pub row: Vec<usize>,
    /// Indices of the times before which the motion must not be interpolated, as in
    /// [`Attitudes::breaks`].
    pub breaks: Vec<usize>,
}

/// Largest number of times that the interval between two rows is halved.
const MOST_HALVINGS: u32 = 6;
/// Largest number of attitudes that the refinement of a file may have.
const MOST_ROWS: usize = 1 << 22;

impl Attitudes {
    /// Returns the attitude at `time` \[s\] after the first row, interpolated by the method that
    /// the file states. If the file states no method, the interpolation is the cubic through
    /// attitudes and rates, or, without rates, a rotation at a constant rate. Returns `None`
    /// outside of all blocks.
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

    /// Inserts attitudes between the rows, so many that rotations at a constant rate between them
    /// differ from the motion of the file by at most a tenth of `tolerance` \[rad\]. Returns `None`
    /// if no block of the file states a polynomial, or if too many attitudes would be needed.
    pub fn refined(&self, tolerance: f64) -> Option<Refined> {
        let bent = |block: &Block| matches!(block.between, Between::Lagrange(_) | Between::Hermite(_));
        if !self.blocks.iter().any(bent) {
            return None;
        }
        let mut found = Refined::default();
        let mut breaks = self.breaks.iter().peekable();
        for (index, block) in self.blocks.iter().enumerate() {
            for k in block.first..=block.last {
                // If two blocks share this row, it has already been added.
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

    /// Returns the times and attitudes that are inserted between row `k` of a block and the next
    /// row.
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
            // Each interval is halved at least once, because the motion may cross its chord in the
            // middle.
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

/// Returns the derivative of a quaternion, scalar first, for the angular velocity `rate` in body
/// axes \[rad/s\].
fn moved([w, x, y, z]: &[f64; 4], rate: &Vector3) -> [f64; 4] {
    let vector = Vector3::new(*x, *y, *z);
    let moved = 0.5 * (*w * rate + vector.cross(rate));
    [-0.5 * vector.dot(rate), moved.x, moved.y, moved.z]
}
