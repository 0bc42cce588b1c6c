//! Directions as functions of time: fixed, turning with the reference frame, or to something that moves.
//!
//! A [`Track`] is a vector as a function of time, of any length: from the spacecraft to the Sun, to a station on the ground, its
//! own velocity. On each piece of time it is a sum of Chebyshev polynomials, and its derivatives are those of the polynomial, so
//! that all of them belong to one function. With `ρ` the vector, `r = |ρ|` and `P = I − ddᵀ`,
//!
//! ```text
//! d = ρ/r ,   ḋ = Pρ̇/r ,   d̈ = Pρ̈/r − 2 (d·ρ̇/r) ḋ − |ḋ|² d
//! ```

use crate::lie;
use crate::{Matrix3, Vector3};
use std::sync::Arc;
use thiserror::Error;

/// A direction in space as a function of the time since the maneuver began.
#[derive(Clone, Debug, PartialEq)]
pub enum Direction {
    /// Fixed in inertial space: a unit vector, axes of the reference frame at `t = 0`.
    Fixed(Vector3),
    /// Fixed in the reference frame, and turning with it: a unit vector, its axes.
    InFrame(Vector3),
    /// Along a vector that moves, inertial axes: those of the reference frame at `t = 0`.
    Moving(Track),
    /// To the limb of a sphere whose centre is at the end of a vector that moves: cones about it begin at its limb.
    Disc {
        /// The vector to the centre, in the unit of the radius.
        centre: Track,
        /// Radius of the sphere.
        radius: f64,
    },
}

/// A direction with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSight {
    /// The unit vector d.
    pub direction: Vector3,
    /// `ḋ` \[1/s\].
    pub rate: Vector3,
    /// `d̈` \[1/s²\].
    pub acceleration: Vector3,
}

/// A vector as a function of time, piece by piece a sum of Chebyshev polynomials. Beyond its span it goes on as its last piece does.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Pieces of equal length, shared by copies.
    pieces: Arc<[Vec<Vector3>]>,
    /// When it begins, and how long a piece is \[s\].
    from: f64,
    piece: f64,
}

/// Why there is no track.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum TrackError {
    /// The span is not positive and finite.
    #[error("a track needs a span of time that is positive and finite")]
    Span,
    /// A coefficient, or a value of what is to be fitted, is not finite.
    #[error("a track needs finite numbers")]
    NotFinite,
    /// What turns does so too often: every quarter of a turn is a piece.
    #[error("it turns more than 2500 times in that span of time")]
    Turns,
    /// The vector vanishes: it has no direction.
    #[error("the vector of a track vanishes: it has no direction then")]
    Vanishes,
}

/// Most quarters of a turn of what turns: five megabytes of coefficients.
const MOST_QUARTERS: f64 = 1e4;

/// Most pieces of a track: a million hours of ten seconds each would fill the memory before.
const MOST_PIECES: f64 = 1e6;

impl Track {
    /// The track of coefficients `Σ c_k T_k(x)`, `x` from −1 to 1 over `from … to` \[s\].
    ///
    /// # Errors
    /// A [`TrackError`] that says what is wrong.
    pub fn of_coefficients(from: f64, to: f64, coefficients: Vec<Vector3>) -> Result<Self, TrackError> {
        Self::of_pieces(from, to - from, vec![coefficients])
    }

    /// The track of pieces of equal length \[s\], one after another.
    ///
    /// # Errors
    /// A [`TrackError`] that says what is wrong.
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

    /// The track through a function at the Chebyshev nodes of pieces of at most `piece` \[s\], of degree `degree`.
    ///
    /// # Errors
    /// What `position` fails with, or a [`TrackError`].
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

    /// When it begins, how long a piece is \[s\], and the coefficients of each.
    pub fn pieces(&self) -> (f64, f64, &[Vec<Vector3>]) {
        (self.from, self.piece, &self.pieces)
    }

    /// When it begins and ends \[s\].
    pub fn span(&self) -> (f64, f64) {
        (self.from, self.from + self.piece * self.pieces.len() as f64)
    }

    /// The vector and its first three derivatives at `time` \[s\].
    pub fn at(&self, time: f64) -> [Vector3; 4] {
        let after = (time - self.from) / self.piece;
        let index = (after.max(0.0) as usize).min(self.pieces.len() - 1);
        let x = 2.0 * (after - index as f64) - 1.0;
        let mut values = chebyshev(&self.pieces[index], x);
        let mut scale = 1.0;
        for value in &mut values {
            *value *= scale;
            scale *= 2.0 / self.piece;
        }
        values
    }

    /// The track of its derivative: of a position the velocity.
    ///
    /// # Errors
    /// [`TrackError::Vanishes`] where it stands still.
    pub fn derivative(&self) -> Result<Self, TrackError> {
        let pieces = self.pieces.iter().map(|piece| derivative(piece, 2.0 / self.piece)).collect();
        Self::of_pieces(self.from, self.piece, pieces)
    }

    /// The opposite vector.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| -c).collect()).collect();
        Self { pieces, ..*self }
    }

    /// The vector times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| c * factor).collect()).collect();
        Self { pieces, ..*self }
    }

    /// The vector in other axes.
    fn turned(&self, rotation: &Matrix3) -> Self {
        let pieces = self.pieces.iter().map(|piece| piece.iter().map(|c| rotation * c).collect()).collect();
        Self { pieces, ..*self }
    }

    /// The unit vector with its derivatives.
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

/// A sum of Chebyshev polynomials and its first three derivatives in x, by Clenshaw's recurrence and its derivatives.
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

/// Coefficients of the derivative, times a factor.
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

impl Direction {
    /// Along a vector that moves, of any length, inertial axes, over `from … to` \[s\]: fitted by Chebyshev polynomials of degree `degree`
    /// on pieces of at most `piece` \[s\], whose derivatives it has.
    ///
    /// # Errors
    /// A [`TrackError`]: of a span that is none, or a vector that is not finite or vanishes.
    pub fn along(
        from: f64,
        to: f64,
        piece: f64,
        degree: usize,
        mut vector: impl FnMut(f64) -> Vector3,
    ) -> Result<Self, TrackError> {
        Track::fitted(from, to, piece, degree, |time| Ok(vector(time))).map(Self::Moving)
    }

    /// Fixed in something that turns at a constant rate \[rad/s\], inertial axes, over `0 … to` \[s\]: along `vector` at time zero.
    ///
    /// # Errors
    /// A [`TrackError`]: of a vector that is none, or a span that is.
    pub fn turning(vector: Vector3, rate: Vector3, to: f64) -> Result<Self, TrackError> {
        // On a quarter of a turn polynomials of this degree leave round-off.
        const DEGREE: usize = 18;
        let piece = (0.25 * std::f64::consts::TAU / rate.norm()).min(to);
        if to / piece > MOST_QUARTERS {
            return Err(TrackError::Turns);
        }
        Self::along(0.0, to, piece, DEGREE, |time| lie::exp(&(rate * time)) * vector)
    }

    /// The unit vector in axes of the reference frame at `time` \[s\]; the frame turns at `frame_rate` \[rad/s\].
    pub fn at(&self, time: f64, frame_rate: &Vector3) -> Vector3 {
        match self {
            Self::InFrame(vector) => *vector,
            Self::Fixed(vector) if *frame_rate == Vector3::zeros() => *vector,
            Self::Fixed(_) | Self::Moving(_) | Self::Disc { .. } => {
                lie::exp(&(frame_rate * -time)) * self.in_space(time, frame_rate).direction
            }
        }
    }

    /// The unit vector with its derivatives in inertial space, axes of the reference frame at `t = 0`.
    pub fn in_space(&self, time: f64, frame_rate: &Vector3) -> LineOfSight {
        let zero = Vector3::zeros();
        match self {
            Self::Fixed(vector) => LineOfSight { direction: *vector, rate: zero, acceleration: zero },
            Self::InFrame(vector) => {
                let direction = lie::exp(&(frame_rate * time)) * vector;
                let rate = frame_rate.cross(&direction);
                LineOfSight { direction, rate, acceleration: frame_rate.cross(&rate) }
            }
            Self::Moving(track) | Self::Disc { centre: track, .. } => track.pointing(time),
        }
    }

    /// This direction in other axes: turned by a rotation from the old axes to the new ones.
    #[must_use]
    pub fn turned(&self, rotation: &Matrix3) -> Self {
        match self {
            Self::Fixed(vector) => Self::Fixed(rotation * vector),
            Self::InFrame(vector) => Self::InFrame(rotation * vector),
            Self::Moving(track) => Self::Moving(track.turned(rotation)),
            Self::Disc { centre, radius } => Self::Disc { centre: centre.turned(rotation), radius: *radius },
        }
    }

    /// Angle between the centre and the limb of what it leads to \[rad\]: 0 where that is a point. Inside of a sphere all around is limb.
    pub fn angular_radius(&self, time: f64) -> f64 {
        match self {
            Self::Disc { centre, radius } => (radius / centre.at(time)[0].norm()).min(1.0).asin(),
            Self::Fixed(_) | Self::InFrame(_) | Self::Moving(_) => 0.0,
        }
    }

    /// Length of the vector that it leads along, in its unit; `None` of one that is only a direction.
    pub fn distance(&self, time: f64) -> Option<f64> {
        match self {
            Self::Moving(track) | Self::Disc { centre: track, .. } => Some(track.at(time)[0].norm()),
            Self::Fixed(_) | Self::InFrame(_) => None,
        }
    }

    /// Whether it stands still in axes of the reference frame, which turns at `frame_rate`.
    pub fn is_still(&self, frame_rate: &Vector3) -> bool {
        match self {
            Self::InFrame(_) => true,
            Self::Fixed(_) => *frame_rate == Vector3::zeros(),
            Self::Moving(_) | Self::Disc { .. } => false,
        }
    }

    /// The vector where it is one number for all times, in either frame.
    pub fn constant(&self) -> Option<&Vector3> {
        match self {
            Self::Fixed(vector) | Self::InFrame(vector) => Some(vector),
            Self::Moving(_) | Self::Disc { .. } => None,
        }
    }

    /// A length that is none of a direction: of a vector that is not of length 1, or a radius that is not positive and finite. `None`
    /// where all is well.
    pub fn length_defect(&self) -> Option<f64> {
        match self {
            Self::Fixed(vector) | Self::InFrame(vector) => {
                let length = vector.norm();
                let is_unit = (length - 1.0).abs() <= 1e-9;
                (!is_unit).then_some(length)
            }
            Self::Moving(_) => None,
            Self::Disc { radius, .. } => (!(*radius > 0.0 && radius.is_finite())).then_some(*radius),
        }
    }
}

/// The attitude that points one body axis along a direction and a second one as well as it can towards another, with the rate
/// and the angular acceleration of the frame that keeps doing so, axes of the directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignedFrame {
    /// Body → axes of the directions: `Σ tᵢsᵢᵀ`.
    pub attitude: Matrix3,
    /// ω \[rad/s\].
    pub rate: Vector3,
    /// ω̇ \[rad/s²\].
    pub acceleration: Vector3,
}

impl AlignedFrame {
    /// With `t₁ = d₁`, `t₂ = N/n`, `N = d₁ × d₂`, `n = |N|`, `t₃ = t₁ × t₂`, and s the same of the body axes:
    ///
    /// ```text
    /// σ = t₃·Ṅ/n ,   ω = d₁ × ḋ₁ + σd₁ ,   σ̇ = (t₃·N̈ + (ω × t₃)·Ṅ − σ t₂·Ṅ)/n ,   ω̇ = d₁ × d̈₁ + σ̇d₁ + σḋ₁
    /// ```
    ///
    /// Not finite where the directions, or the axes, are parallel.
    pub fn of(axes: [&Vector3; 2], directions: [&LineOfSight; 2]) -> Self {
        let triad = |first: &Vector3, second: &Vector3| {
            let t2 = first.cross(second).normalize();
            Matrix3::from_columns(&[*first, t2, first.cross(&t2)])
        };
        let [a, b] = directions;
        let body = triad(axes[0], axes[1]);
        let space = triad(&a.direction, &b.direction);
        let (t2, t3) = (space.column(1).into_owned(), space.column(2).into_owned());
        let n = a.direction.cross(&b.direction).norm();
        let first = a.rate.cross(&b.direction) + a.direction.cross(&b.rate);
        let second = a.acceleration.cross(&b.direction)
            + 2.0 * a.rate.cross(&b.rate)
            + a.direction.cross(&b.acceleration);
        let roll = t3.dot(&first) / n;
        let rate = a.direction.cross(&a.rate) + a.direction * roll;
        let change = (t3.dot(&second) + rate.cross(&t3).dot(&first) - roll * t2.dot(&first)) / n;
        let acceleration = a.direction.cross(&a.acceleration) + a.direction * change + a.rate * roll;
        Self { attitude: space * body.transpose(), rate, acceleration }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A station that goes by at 550 km.
    fn passing() -> Track {
        Track::fitted(-20.0, 140.0, 80.0, 20, |t| {
            let along = 7.6e3 * (t - 60.0);
            Ok::<_, TrackError>(Vector3::new(along, 1e5 + 20.0 * t, -5.5e5 + 4.0 * (t - 60.0) * (t - 60.0)))
        })
        .expect("a track")
    }

    /// The function through which a track is fitted comes back, with its derivatives.
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
    fn derivatives_of_a_direction_are_those_of_differences() {
        let direction = Direction::Moving(passing());
        let (zero, h) = (Vector3::zeros(), 1e-3);
        for t in [5.0, 58.0, 61.0, 120.0] {
            let at = |t: f64| direction.in_space(t, &zero);
            let (before, here, after) = (at(t - h), at(t), at(t + h));
            let rate = (after.direction - before.direction) / (2.0 * h);
            let acceleration = (after.rate - before.rate) / (2.0 * h);
            assert!((here.rate - rate).amax() < 1e-9, "{t}");
            assert!((here.acceleration - acceleration).amax() < 1e-9, "{t}");
        }
    }

    #[test]
    fn an_aligned_frame_moves_as_it_says() {
        let (sun, station) =
            (Direction::Fixed(Vector3::new(0.2, 0.9, -0.3).normalize()), Direction::Moving(passing()));
        let (axes, h, zero) = ([Vector3::z(), Vector3::new(0.6, 0.0, 0.8)], 1e-3, Vector3::zeros());
        let at = |t: f64| {
            AlignedFrame::of([&axes[0], &axes[1]], [&station.in_space(t, &zero), &sun.in_space(t, &zero)])
        };
        for t in [5.0, 58.0, 61.0, 120.0] {
            let (before, here, after) = (at(t - h), at(t), at(t + h));
            let rate = lie::log(&(after.attitude * before.attitude.transpose())) / (2.0 * h);
            let acceleration = (after.rate - before.rate) / (2.0 * h);
            assert!((here.attitude * axes[0] - station.at(t, &zero)).amax() < 1e-14);
            assert!((here.rate - rate).amax() < 1e-8, "{t} {} {rate}", here.rate);
            assert!((here.acceleration - acceleration).amax() < 1e-8, "{t}");
        }
    }

    #[test]
    fn what_turns_has_the_derivatives_of_a_rotation() {
        let (vector, rate) = (Vector3::new(0.6, -0.64, 0.48), Vector3::new(0.0, 0.2, 0.1));
        let direction = Direction::turning(vector, rate, 60.0).expect("it turns");
        for t in [0.0, 3.7, 31.0, 60.0] {
            let seen = direction.in_space(t, &Vector3::zeros());
            let wanted = lie::exp(&(rate * t)) * vector;
            let first = rate.cross(&wanted);
            assert!((seen.direction - wanted).amax() < 1e-14, "{t}");
            assert!((seen.rate - first).amax() < 1e-13, "{t} {:e}", (seen.rate - first).amax());
            assert!((seen.acceleration - rate.cross(&first)).amax() < 1e-12, "{t}");
        }
        assert!(Direction::turning(Vector3::zeros(), rate, 60.0).is_err());
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
