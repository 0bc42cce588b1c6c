//! Regula falsi on an interval in which a function changes its sign. The value at an end that is
//! retained twice is halved (Illinois variant).

/// State of the iteration: the weighted values at both ends of the bracket.
pub struct Illinois {
    weights: [f64; 2],
    last_moved: Option<usize>,
}

impl Illinois {
    /// Starts with the function values at both ends.
    pub fn new(values: [f64; 2]) -> Self {
        Self { weights: values, last_moved: None }
    }

    /// Returns the next point, as a fraction of the interval from the first end to the second.
    pub fn part(&self) -> f64 {
        self.weights[0] / (self.weights[0] - self.weights[1])
    }

    /// Moves the end `end` of the bracket to the last point, at which the function has the value
    /// `value`.
    pub fn moved(&mut self, end: usize, value: f64) {
        if self.last_moved == Some(end) {
            self.weights[1 - end] *= 0.5;
        }
        (self.weights[end], self.last_moved) = (value, Some(end));
    }
}
