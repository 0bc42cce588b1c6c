//! Reduction of the number of points of a curve without a visible change.

/// Returns at most `most` of the points of a curve; if it has no more points than this, all of
/// them. The inner points are divided into groups of equal size. The lowest and the highest point
/// of each group are kept, so that no peak is lost. The first and the last point are always kept.
pub fn thinned(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most.max(4) {
        return points.to_vec();
    }
    let stretches = (most.max(4) - 2) / 2;
    let inner = &points[1..points.len() - 1];
    let mut thin = vec![points[0]];
    for stretch in 0..stretches {
        let bounds = [stretch, stretch + 1].map(|edge| edge * inner.len() / stretches);
        let part = &inner[bounds[0]..bounds[1]];
        let by_height = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        if let (Some(low), Some(high)) = (part.iter().min_by(by_height), part.iter().max_by(by_height)) {
            let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
            thin.push(*first);
            if second != first {
                thin.push(*second);
            }
        }
    }
    thin.push(points[points.len() - 1]);
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_and_ends_survive() {
        let value = |k: usize| if k == 54_321 { 7.0 } else { (1e-3 * k as f64).sin() };
        let points: Vec<_> = (0..100_001).map(|k| (k as f64, value(k))).collect();
        let thin = thinned(&points, 2000);
        assert!(thin.len() <= 2000 && thin.len() > 1000);
        assert_eq!((thin[0], thin[thin.len() - 1]), (points[0], points[100_000]));
        assert!(thin.contains(&(54_321.0, 7.0)));
        let lowest = points.iter().map(|point| point.1).fold(0.0, f64::min);
        assert!(thin.iter().any(|point| point.1 == lowest));
        assert!(thin.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!(thinned(&points[..50], 100), points[..50]);
    }
}
