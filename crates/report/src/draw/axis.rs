//! Axes of charts: their limits, ticks and labels.

/// Scale of an axis, linear or logarithmic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences of the values have equal lengths on the axis.
    Linear,
    /// Equal ratios of the values have equal lengths on the axis. Zero and negative values have no
    /// position.
    Logarithmic,
}

/// An axis of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name and unit of the quantity on the axis, such as "time, s".
    pub label: String,
    /// Scale of the axis, linear or logarithmic.
    pub scale: Scale,
    /// Smallest and largest value on the axis; `None` if the axis is to fit the data.
    pub limits: Option<(f64, f64)>,
}

impl Axis {
    /// Builds a linear axis that fits the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, limits: None }
    }

    /// Builds a logarithmic axis that fits the data.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic, limits: None }
    }
}

/// An axis with its position in the drawing, which extends from pixel `from` to pixel `to`.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    scale: Scale,
    /// Smallest value on the axis; on a logarithmic axis, its decimal logarithm.
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// A tick mark at pixel `at`; a tick without a label is drawn shorter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub label: Option<String>,
}

impl Laid {
    /// Places an axis between the pixels `from` and `to`. Its range covers `values`.
    pub fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logarithmic = axis.scale == Scale::Logarithmic;
        let place = |value: f64| if logarithmic { value.log10() } else { value };
        let mut limits = (f64::INFINITY, f64::NEG_INFINITY);
        // NaN and values without a logarithm are ignored here, as in the curves.
        for value in values.map(place).filter(|value| value.is_finite()) {
            limits = (limits.0.min(value), limits.1.max(value));
        }
        let given = axis.limits.map(|(low, high)| (place(low), place(high)));
        let (mut low, mut high) = given.filter(|(a, b)| a < b && (b - a).is_finite()).unwrap_or(limits);
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if given.is_none() {
            let least = if logarithmic { 0.2 } else { 1e-12 * low.abs().max(high.abs()).max(1e-300) };
            let margin = (0.04 * (high - low)).max(least);
            (low, high) = (low - margin, high + margin);
        }
        Self { scale: axis.scale, low, high, from, to }
    }

    /// Returns the pixel of a value; `None` if the value has no position, as zero on a logarithmic
    /// axis.
    pub fn place(&self, value: f64) -> Option<f64> {
        let value = if self.scale == Scale::Logarithmic { value.log10() } else { value };
        let part = (value - self.low) / (self.high - self.low);
        // Values far outside of the range are clamped, because viewers fail at very large
        // coordinates.
        part.is_finite().then(|| self.from + part.clamp(-10.0, 11.0) * (self.to - self.from))
    }

    /// Returns the pixel in the middle of the axis.
    pub fn middle(&self) -> f64 {
        0.5 * (self.from + self.to)
    }

    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Logarithmic => self.logarithmic_ticks(),
        }
    }

    fn pixel(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let length = (self.to - self.from).abs();
        let raw = (self.high - self.low) / (length / 65.0).clamp(2.0, 12.0);
        let power = 10_f64.powf(raw.log10().floor());
        let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * power >= raw).unwrap_or(10.0);
        let step = factor * power;
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        let largest = self.low.abs().max(self.high.abs());
        let tick = |index: i64| {
            let value = index as f64 * step;
            Tick { at: self.pixel(value), label: Some(linear_label(value, step, largest)) }
        };
        // The limit on the number of ticks is necessary if rounding makes the step too small.
        (first..=last).take(50).map(tick).collect()
    }

    fn logarithmic_ticks(&self) -> Vec<Tick> {
        let decades = self.high - self.low;
        let length = (self.to - self.from).abs();
        // A label takes about 40 pixels along the axis.
        let every = (decades / (length / 40.0)).ceil().max(1.0) as i64;
        let (first, last) = (self.low.floor() as i64, self.high.ceil() as i64);
        // All labels are decimal numbers, or all are powers of ten.
        let plain = self.low >= -2.3 && self.high < 4.0;
        let mut ticks = Vec::new();
        for decade in (first..=last).take(700) {
            let marked = decade.rem_euclid(every) == 0;
            for digit in 1..10 {
                let value = decade as f64 + f64::from(digit).log10();
                if !(self.low..=self.high).contains(&value) {
                    continue;
                }
                let spaced = decades < 1.6 && (decades < 0.8 || matches!(digit, 2 | 5));
                let label = match digit {
                    1 if marked => Some(power_of_ten(1, decade, plain)),
                    2.. if spaced => Some(power_of_ten(digit, decade, plain)),
                    _ => None,
                };
                if digit == 1 || (decades <= 8.0 && every == 1) {
                    ticks.push(Tick { at: self.pixel(value), label });
                }
            }
        }
        ticks
    }
}

fn power_of_ten(digit: u8, decade: i64, plain: bool) -> String {
    match (digit, decade) {
        (_, ..0) if plain => {
            format!("{:.*}", decade.unsigned_abs() as usize, f64::from(digit) * 10_f64.powi(decade as i32))
        }
        (_, 0..=3) if plain => format!("{}", i64::from(digit) * 10_i64.pow(decade as u32)),
        (1, _) => format!("10^{{{}}}", minus(&decade.to_string())),
        _ => format!("{digit}·10^{{{}}}", minus(&decade.to_string())),
    }
}

fn linear_label(value: f64, step: f64, largest: f64) -> String {
    if value.abs() < 0.5 * step {
        return "0".into();
    }
    let decimals = (-step.log10()).ceil().max(0.0) as usize;
    if !(1e-3..1e6).contains(&largest) {
        let power = largest.log10().floor();
        let unit = 10_f64.powf(power);
        let decimals = (-(step / unit).log10()).ceil().clamp(0.0, 15.0) as usize;
        return minus(&format!("{:.decimals$}·10^{{{power}}}", value / unit));
    }
    minus(&format!("{value:.*}", decimals.min(15)))
}

/// Replaces the hyphen by the minus sign, which is as wide as a plus sign.
fn minus(text: &str) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, values: &[f64]) -> Vec<String> {
        let laid = Laid::new(axis, values.iter().copied(), 0.0, 400.0);
        laid.ticks().into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        assert_eq!(labels(&Axis::linear(""), &[0.0, 10.0]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&Axis::linear(""), &[-0.3, 0.3]), ["−0.2", "0", "0.2"]);
        assert_eq!(labels(&Axis::logarithmic(""), &[1e-3, 1.0]), ["10^{−3}", "10^{−2}", "10^{−1}", "10^{0}"]);
        assert_eq!(labels(&Axis::logarithmic(""), &[0.02, 4.0]), ["0.1", "1"]);
        for axis in [Axis::linear(""), Axis::logarithmic("")] {
            let laid = Laid::new(&axis, [2.5e-4, 7.3].into_iter(), 50.0, 400.0);
            assert!(laid.ticks().iter().all(|tick| (50.0..=400.0).contains(&tick.at)));
        }
    }

    #[test]
    fn an_axis_survives_any_data() {
        let hostile = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e308, -1e308, 5e-324, 1e-300];
        for axis in [Axis::linear(""), Axis::logarithmic("")] {
            for a in hostile {
                for b in hostile {
                    let laid = Laid::new(&axis, [a, b].into_iter(), 0.0, 400.0);
                    assert!(laid.ticks().len() < 7000);
                    for value in hostile {
                        assert!(laid.place(value).is_none_or(f64::is_finite));
                    }
                }
            }
            assert!(!labels(&axis, &[]).is_empty());
            assert!(!labels(&axis, &[3.0, 3.0]).is_empty());
        }
    }
}
