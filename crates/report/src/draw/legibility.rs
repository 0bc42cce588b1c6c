//! Remarks in the legend of a chart: that a curve is cut off because it diverges, or that a curve
//! is hidden behind another curve.

use super::axis::Scale;
use super::curve::{Curve, Shape};
use slewkit::numerics::figures::significant;

/// Growth beyond which a curve counts as diverged, relative to its typical size and to every other
/// curve. The second value applies to logarithmic axes, on which many decades are normal.
const DIVERGED: (f64, f64) = (1e6, 1e12);

/// Height up to which a diverged curve is drawn, relative to the other curves of the chart.
const FOLLOWED: f64 = 10.0;

/// Fraction of the largest value of a curve above which the last value shows that the curve has not
/// returned.
const ESCAPED: f64 = 1e-3;

/// The distance below which two points look like one point \[px\].
const APART: f64 = 0.7;

/// The position of a point in the drawing; `None` if the point cannot be drawn.
type Place = Option<(f64, f64)>;

/// Cuts off the diverging curves of a chart whose vertical axis has the scale `scale`. A curve is
/// cut off where it leaves the chart for good, or where its values are no longer finite. The name
/// of the curve states this.
pub(super) fn cut(curves: &[Curve], scale: Scale) -> Vec<Curve> {
    let threshold = if scale == Scale::Logarithmic { DIVERGED.1 } else { DIVERGED.0 };
    let reach = |curve: &Curve| -> f64 {
        let finite = curve.shape.points().into_iter().map(|point| point.1.abs());
        finite.filter(|value| value.is_finite()).fold(0.0, f64::max)
    };
    let reaches: Vec<f64> = curves.iter().map(reach).collect();
    // In the comparison with other curves, a diverging curve counts with its typical size and not
    // with its largest value.
    let standard = |(curve, reach): (&Curve, &f64)| match &curve.shape {
        Shape::Line(points) | Shape::Marked(points) => {
            let usual = share(points, 2);
            let escapes = usual > 0.0 && *reach > threshold * usual && ends_at(points) > ESCAPED * reach;
            if escapes { usual } else { *reach }
        }
        Shape::Band(_) => *reach,
    };
    let standards: Vec<f64> = curves.iter().zip(&reaches).map(standard).collect();
    let one = |(index, curve): (usize, &Curve)| {
        let mut curve = curve.clone();
        let (Shape::Line(points) | Shape::Marked(points)) = &mut curve.shape else { return curve };
        let others = standards.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.map(|(_, standard)| *standard).fold(0.0, f64::max);
        // The lowest tenth of the values may be small because the body is at rest, but not as small
        // as the start of a diverging curve is relative to its end.
        let usual = others.max(share(points, 10));
        let grown = reaches[index] > threshold * usual && usual > 0.0;
        let began = points.iter().map(|point| point.1.abs()).find(|size| *size > 0.0).unwrap_or(0.0);
        let beyond = |point: &(f64, f64)| {
            !point.1.is_finite() || (grown && point.1.abs() > FOLLOWED * others.max(began))
        };
        // A gap is no divergence. A curve is cut off only where it leaves the chart for good.
        let last = points.iter().rposition(|point| !beyond(point)).map_or(0, |last| last + 1);
        if let Some(&(x, _)) = points.get(last) {
            points.truncate(last);
            let name = significant(x, 3);
            let told = if grown {
                format!("cut at {name}\nreaches {}", significant(reaches[index], 1))
            } else {
                format!("not finite from {name} on")
            };
            curve.name = format!("{}\n{told}", curve.name);
        }
        curve
    };
    curves.iter().enumerate().map(one).collect()
}

/// Returns the absolute value of the last finite ordinate; 0 if no ordinate is finite.
fn ends_at(points: &[(f64, f64)]) -> f64 {
    points.iter().rev().map(|point| point.1.abs()).find(|size| size.is_finite()).unwrap_or(0.0)
}

/// Returns the quantile `1/of` of the absolute values of the ordinates.
fn share(points: &[(f64, f64)], of: usize) -> f64 {
    let mut sizes: Vec<f64> =
        points.iter().map(|point| point.1.abs()).filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / of).copied().unwrap_or(0.0)
}

/// Adds to the name of each hidden curve the name of the curve behind which it is hidden.
pub(super) fn name_hidden(curves: &mut [Curve], place: impl Fn((f64, f64)) -> Place) {
    let places: Vec<Vec<Place>> = curves
        .iter()
        .map(|curve| match &curve.shape {
            Shape::Line(points) | Shape::Marked(points) => points.iter().map(|point| place(*point)).collect(),
            Shape::Band(_) => Vec::new(),
        })
        .collect();
    for index in 1..curves.len() {
        let over = (0..index).find(|over| {
            let same = |(a, b): (&Place, &Place)| match (a, b) {
                (Some(a), Some(b)) => (a.0 - b.0).abs() < APART && (a.1 - b.1).abs() < APART,
                (None, None) => true,
                _ => false,
            };
            let (a, b) = (&places[*over], &places[index]);
            a.len() == b.len() && a.iter().flatten().next().is_some() && a.iter().zip(b).all(same)
        });
        if let Some(over) = over {
            let name = curves[over].name.lines().next().unwrap_or_default().to_string();
            curves[index].name.push_str(&format!("\nhidden under {name}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Axis, Chart};

    fn curve(name: &str, y: impl Fn(f64) -> f64) -> Curve {
        let points = (0..101).map(|k| (f64::from(k), y(f64::from(k)))).collect();
        Curve { name: name.into(), style: 0, shape: Shape::Line(points) }
    }

    #[test]
    fn a_diverged_curve_is_cut_and_named_and_no_other() {
        let curves = vec![
            curve("steady", |x| (0.1 * x).sin()),
            curve("diverges", |x| 1e-3 * (1.3 * x).exp()),
            curve("round-off", |x| 1e-16 * x.sin()),
        ];
        let chart = Chart::new("", Axis::linear("x"), Axis::linear("y"), curves);
        let svg = chart.svg();
        assert_eq!(svg.matches("cut at").count(), 1);
        assert!(svg.contains("reaches 3e+53") || svg.contains("reaches 3e53"), "{svg}");
        let drawn = chart.legible_curves();
        let largest = drawn[1].shape.points().iter().map(|point| point.1).fold(0.0, f64::max);
        assert!(largest <= 10.0, "{largest}");
        assert_eq!(drawn[2], chart.curves[2]);
    }

    #[test]
    fn curves_that_diverge_together_are_all_cut_and_those_that_come_back_are_not() {
        let away = |from: f64| move |x: f64| from * (if x < 50.0 { x.cos() } else { (x - 50.0).exp() });
        let curves = vec![curve("a", away(1.0)), curve("b", away(-2.0)), curve("c", away(0.5))];
        let chart = Chart::new("", Axis::linear("x"), Axis::linear("y"), curves);
        for drawn in chart.legible_curves() {
            assert!(drawn.name.contains("reaches"), "{}", drawn.name);
            assert!(drawn.shape.points().iter().all(|point| point.1.abs() < 100.0));
        }
        // The curve is zero up to round-off for most of the time, then differs from zero, and ends
        // at zero.
        let moves = |from: f64| {
            move |x: f64| from * (1e-17 + if x > 80.0 { (x * 0.1).sin().powi(2) * (100.0 - x) } else { 0.0 })
        };
        let curves = vec![curve("a", moves(1.0)), curve("b", moves(2.0))];
        let chart = Chart::new("", Axis::linear("x"), Axis::linear("y"), curves);
        assert_eq!(chart.legible_curves(), chart.curves);
    }

    #[test]
    fn what_becomes_nan_is_named_and_a_gap_is_none() {
        let end = curve("ends", |x| if x < 60.0 { x } else { f64::NAN });
        let gap = curve("gap", |x| if (40.0..60.0).contains(&x) { f64::NAN } else { x });
        let chart = Chart::new("", Axis::linear("x"), Axis::linear("y"), vec![end, gap]);
        let drawn = chart.legible_curves();
        assert_eq!(drawn[0].name, "ends\nnot finite from 60.0 on");
        assert_eq!(drawn[1].name, "gap");
    }

    #[test]
    fn a_hidden_curve_says_under_which() {
        let curves =
            vec![curve("above", f64::sqrt), curve("below", |x| x.sqrt() + 1e-9), curve("beside", |x| x)];
        let svg = Chart::new("", Axis::linear("x"), Axis::linear("y"), curves).svg();
        assert_eq!(svg.matches("hidden under above").count(), 1);
    }
}
