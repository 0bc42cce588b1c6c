//! A vector as a function of time, by Chebyshev polynomials, and the direction along the vector.
//!
//! The vector of a [`Track`] may have any length. Examples are the vector from the spacecraft to
//! the Sun or to a ground station, and the velocity of the spacecraft. On each piece of the time
//! span it is a sum of Chebyshev polynomials. Its derivatives are the derivatives of the
//! polynomials, so vector and derivatives are consistent. With `ρ` the vector, `r = |ρ|` and
//! `P = I − ddᵀ`,
//!
//! ```text
//! d = ρ/r ,   ḋ = Pρ̇/r ,   d̈ = Pρ̈/r − 2 (d·ρ̇/r) ḋ − |ḋ|² d
//! ```

use crate::{Matrix3, Vector3};
use std::sync::Arc;
use thiserror::Error;

/// A direction and its first two time derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSight {
    /// The direction, a unit vector `d`.
    pub direction: Vector3,
    /// First derivative `ḋ` \[1/s\].
    pub rate: Vector3,
    /// Second derivative `d̈` \[1/s²\].
    pub acceleration: Vector3,
}

/// A vector as a function of time: on each piece of time a sum of Chebyshev polynomials. Before and
/// after the time span, the polynomials of the first and last piece continue.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Coefficients of the pieces, which are of equal length; copies of the track share them.
    pieces: Arc<[Vec<Vector3>]>,
    /// Start time of the track \[s\].
    from: f64,
    /// Length of a piece \[s\].
    piece: f64,
}

/// The reason why a track cannot be built.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum TrackError {
    /// The time span is not positive and finite.
    #[error("a track needs a span of time that is positive and finite")]
    Span,
    /// A coefficient or a function value is not finite.
    #[error("a track needs finite numbers")]
    NotFinite,
    /// The vector turns too often: every quarter of a turn needs a piece of its own.
    #[error("the track turns more than 2500 times in that span of time")]
    Turns,
    /// The vector is zero at some time, so that it has no direction.
    #[error("the vector of a track vanishes: it then has no direction")]
    Vanishes,
}

/// The largest number of pieces of a track, so that a long span does not fill the memory.
const MOST_PIECES: f64 = 1e6;

impl Track {
    /// Builds a track of one piece with the coefficients `c_k` in `Σ c_k T_k(x)`, where `x` runs
    /// from −1 to 1 over `from … to` \[s\].
    ///
    /// # Errors
    /// Returns a [`TrackError`] that states the reason.
    pub fn of_coefficients(from: f64, to: f64, coefficients: Vec<Vector3>) -> Result<Self, TrackError> {
        Self::of_pieces(from, to - from, vec![coefficients])
    }

    /// Builds a track of consecutive pieces, each `piece` \[s\] long, from their coefficients.
    ///
    /// # Errors
    /// Returns a [`TrackError`] that states the reason.
    pub fn of_pieces(from: f64, piece: f64, pieces: Vec<Vec<Vector3>>) -> Result<Self, TrackError> {
        if !(piece > 0.0 && piece.is_finite() && from.is_finite() && !pieces.is_empty()) {
            return Err(TrackError::Span);
        }
        if pieces.iter().any(Vec::is_empty)
            || pieces.iter().flatten().flat_map(|c| c.iter()).any(|c| !c.is_finite())
        {
            return Err(TrackError::NotFinite);
        }
        let track = Self { pieces: pieces.into(), from, piece };
        let middle = |index: usize| track.from + track.piece * (index as f64 + 0.5);
        if (0..track.pieces.len()).any(|index| track.at(middle(index))[0] == Vector3::zeros()) {
            return Err(TrackError::Vanishes);
        }
        Ok(track)
    }

    /// Builds a track that interpolates a function at the Chebyshev nodes of pieces of at most
    /// `piece` \[s\], with polynomials of degree `degree`.
    ///
    /// # Errors
    /// Returns the error of `position`, or a [`TrackError`].
    pub fn fitted<E: From<TrackError>>(
        from: f64,
        to: f64,
        piece: f64,
        degree: usize,
        mut position: impl FnMut(f64) -> Result<Vector3, E>,
    ) -> Result<Self, E> {
        let (span, count) = (to - from, ((to - from) / piece).ceil().max(1.0));
        if !(span > 0.0 && span.is_finite() && count <= MOST_PIECES) {
            return Err(TrackError::Span.into());
        }
        let (length, nodes) = (span / count, degree + 1);
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / nodes as f64;
        let mut pieces = Vec::with_capacity(count as usize);
        for index in 0..count as usize {
            let middle = from + length * (index as f64 + 0.5);
            let values = (0..nodes)
                .map(|node| position(middle + 0.5 * length * angle(node).cos()))
                .collect::<Result<Vec<_>, E>>()?;
            let coefficient = |k: usize| {
                let sum = values.iter().enumerate().fold(Vector3::zeros(), |sum, (node, value)| {
                    sum + value * (k as f64 * angle(node)).cos()
                });
                sum * (if k == 0 { 1.0 } else { 2.0 } / nodes as f64)
            };
            pieces.push((0..nodes).map(coefficient).collect());
        }
        Ok(Self::of_pieces(from, length, pieces)?)
    }

    /// Returns the start and the length of a piece \[s\], and the coefficients of each piece.
    pub fn pieces(&self) -> (f64, f64, &[Vec<Vector3>]) {
        (self.from, self.piece, &self.pieces)
    }

    /// Returns the start and the end of the time span \[s\].
    pub fn span(&self) -> (f64, f64) {
        (self.from, self.from + self.piece * self.pieces.len() as f64)
    }

    /// Returns the track for a clock that starts `by` \[s\] later.
    #[must_use]
    pub fn later(&self, by: f64) -> Self {
        Self { from: self.from - by, ..self.clone() }
    }

    /// Returns the track with only the pieces that overlap `from … to` \[s\].
    #[must_use]
    pub fn within(&self, [from, to]: [f64; 2]) -> Self {
        let [first, last] = [from, to].map(|time| self.piece_at(time));
        let pieces = self.pieces[first..=last.max(first)].into();
        Self { pieces, from: self.from + first as f64 * self.piece, ..*self }
    }

    /// Returns the index of the piece that contains `time` \[s\]; outside of the time span, the
    /// index of the nearest piece.
    fn piece_at(&self, time: f64) -> usize {
        (((time - self.from) / self.piece).max(0.0) as usize).min(self.pieces.len() - 1)
    }

    /// Returns the vector and its first three derivatives at `time` \[s\].
    pub fn at(&self, time: f64) -> [Vector3; 4] {
        let after = (time - self.from) / self.piece;
        let index = self.piece_at(time);
        let x = 2.0 * (after - index as f64) - 1.0;
        let mut values = chebyshev(&self.pieces[index], x);
        let mut scale = 1.0;
        for value in &mut values {
            *value *= scale;
            scale *= 2.0 / self.piece;
        }
        values
    }

    /// Builds the track of the derivative of the vector: the velocity for a position.
    ///
    /// # Errors
    /// Returns [`TrackError::Vanishes`] if the derivative is zero at a checked time.
    pub fn derivative(&self) -> Result<Self, TrackError> {
        let pieces = self.pieces.iter().map(|piece| derivative(piece, 2.0 / self.piece)).collect();
        Self::of_pieces(self.from, self.piece, pieces)
    }

    /// Returns the track of the opposite vector.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| -c).collect()).collect();
        Self { pieces, ..*self }
    }

    /// Returns the track of the vector multiplied by `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| c * factor).collect()).collect();
        Self { pieces, ..*self }
    }

    /// Returns the track of the vector in other axes.
    pub(super) fn turned(&self, rotation: &Matrix3) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| rotation * c).collect()).collect();
        Self { pieces, ..*self }
    }

    /// Returns the unit vector along the vector, with its derivatives.
    pub fn pointing(&self, time: f64) -> LineOfSight {
        let [rho, first, second, _] = self.at(time);
        let r = rho.norm();
        let d = rho / r;
        let across = |v: &Vector3| (v - d * d.dot(v)) / r;
        let rate = across(&first);
        let acceleration = across(&second) - rate * (2.0 * d.dot(&first) / r) - d * rate.norm_squared();
        LineOfSight { direction: d, rate, acceleration }
    }
}

/// Returns a sum of Chebyshev polynomials and its first three derivatives in x, by Clenshaw's
/// recurrence and its derivatives.
fn chebyshev(coefficients: &[Vector3], x: f64) -> [Vector3; 4] {
    let zero = [Vector3::zeros(); 4];
    let (mut b1, mut b2) = (zero, zero);
    for c in coefficients.iter().skip(1).rev() {
        let mut b = zero;
        b[0] = c + b1[0] * (2.0 * x) - b2[0];
        for n in 1..4 {
            b[n] = b1[n] * (2.0 * x) + b1[n - 1] * (2.0 * n as f64) - b2[n];
        }
        (b2, b1) = (b1, b);
    }
    let mut value = zero;
    value[0] = coefficients[0] + b1[0] * x - b2[0];
    for n in 1..4 {
        value[n] = b1[n] * x + b1[n - 1] * n as f64 - b2[n];
    }
    value
}

/// Returns the Chebyshev coefficients of the derivative of a sum of Chebyshev polynomials in x,
/// multiplied by `factor`.
fn derivative(coefficients: &[Vector3], factor: f64) -> Vec<Vector3> {
    let count = coefficients.len();
    let mut found = vec![Vector3::zeros(); count.max(2)];
    for k in (1..count).rev() {
        let above = found.get(k + 1).copied().unwrap_or_else(Vector3::zeros);
        found[k - 1] = above + coefficients[k] * (2.0 * k as f64);
    }
    found[0] *= 0.5;
    found.truncate(count.saturating_sub(1).max(1));
    found.iter().map(|c| c * factor).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::{Track, TrackError};
    use crate::Vector3;

    /// Returns the track of a ground station seen from a satellite that passes at 550 km.
    pub fn passing() -> Track {
        Track::fitted(-20.0, 140.0, 80.0, 20, |t| {
            let along = 7.6e3 * (t - 60.0);
            Ok::<_, TrackError>(Vector3::new(along, 1e5 + 20.0 * t, -5.5e5 + 4.0 * (t - 60.0) * (t - 60.0)))
        })
        .expect("a track")
    }

    /// Checks that the track returns the function from which it was built, and its derivatives.
    #[test]
    fn a_track_is_what_it_was_fitted_through() {
        let track = passing();
        for t in [-20.0, 0.0, 59.9, 60.1, 139.0, 140.0] {
            let [x, v, a, j] = track.at(t);
            let along = 7.6e3 * (t - 60.0);
            let wanted = Vector3::new(along, 1e5 + 20.0 * t, -5.5e5 + 4.0 * (t - 60.0) * (t - 60.0));
            assert!((x - wanted).amax() < 1e-7, "{t} {x}");
            assert!((v - Vector3::new(7.6e3, 20.0, 8.0 * (t - 60.0))).amax() < 1e-6, "{t} {v}");
            assert!((a - Vector3::new(0.0, 0.0, 8.0)).amax() < 1e-6 && j.amax() < 1e-6, "{t} {a} {j}");
        }
        let velocity = track.derivative().expect("it moves");
        assert!((velocity.at(33.0)[0] - track.at(33.0)[1]).amax() < 1e-7);
    }

    #[test]
    fn what_cannot_be_a_track_is_refused() {
        let x = Vector3::x();
        assert_eq!(Track::of_coefficients(0.0, 0.0, vec![x]), Err(TrackError::Span));
        assert_eq!(Track::of_coefficients(0.0, f64::NAN, vec![x]), Err(TrackError::Span));
        assert_eq!(Track::of_coefficients(0.0, 1.0, vec![x * f64::NAN]), Err(TrackError::NotFinite));
        assert_eq!(Track::of_coefficients(0.0, 1.0, vec![]), Err(TrackError::NotFinite));
        assert_eq!(Track::of_coefficients(0.0, 1.0, vec![x * 0.0]), Err(TrackError::Vanishes));
    }
}
