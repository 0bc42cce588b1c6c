//! Regula falsi between two places where a function has different signs; the weight of an end that
//! stays is halved (Illinois).

/// The ends of the bracket, by the values there.
pub struct Illinois {
    weights: [f64; 2],
    last_moved: Option<usize>,
}

impl Illinois {
    /// With the values at both ends.
    pub fn new(values: [f64; 2]) -> Self {
        Self { weights: values, last_moved: None }
    }

    /// Where to look next, as a part of the way from the first end to the second.
    pub fn part(&self) -> f64 {
        self.weights[0] / (self.weights[0] - self.weights[1])
    }

    /// Moves an end there, where the value is this.
    pub fn moved(&mut self, end: usize, value: f64) {
        if self.last_moved == Some(end) {
            self.weights[1 - end] *= 0.5;
        }
        (self.weights[end], self.last_moved) = (value, Some(end));
    }
}
