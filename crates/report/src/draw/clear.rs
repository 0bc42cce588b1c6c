//! Test whether a curve passes through the rectangle of a text.

/// Returns whether the polyline through `points` passes through the rectangle with the given left,
/// top, right and bottom edges.
///
/// The part of a segment within the rectangle is computed axis by axis (Liang and Barsky 1984).
pub(super) fn crosses(points: &[(f64, f64)], [left, top, right, bottom]: [f64; 4]) -> bool {
    points.windows(2).any(|pair| {
        let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (from, to, least, most) in [(ax, bx, left, right), (ay, by, top, bottom)] {
            let step = to - from;
            if !step.is_finite() {
                return false;
            }
            if step == 0.0 {
                if from < least || from > most {
                    return false;
                }
                continue;
            }
            let (one, other) = ((least - from) / step, (most - from) / step);
            (first, last) = (first.max(one.min(other)), last.min(one.max(other)));
        }
        first <= last
    })
}

#[cfg(test)]
mod tests {
    use super::crosses;

    #[test]
    fn a_line_crosses_a_box_that_none_of_its_points_is_in() {
        let frame = [10.0, 10.0, 20.0, 14.0];
        assert!(crosses(&[(0.0, 12.0), (30.0, 12.0)], frame));
        assert!(crosses(&[(15.0, 0.0), (15.0, 30.0)], frame));
        assert!(crosses(&[(12.0, 11.0), (13.0, 12.0)], frame));
        // These lines pass beside a corner of the rectangle, pass above it, or meet it only if a
        // segment is extended.
        assert!(!crosses(&[(0.0, 16.0), (16.0, 32.0)], frame));
        assert!(!crosses(&[(0.0, 5.0), (30.0, 5.0)], frame));
        assert!(!crosses(&[(0.0, 12.0), (9.0, 12.0)], frame));
        assert!(!crosses(&[(15.0, 12.0)], frame) && !crosses(&[(0.0, f64::NAN), (30.0, f64::NAN)], frame));
    }
}
