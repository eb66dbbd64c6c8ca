//! Thins curves of many points to the resolution of a picture.

/// Visible points of a curve: the first, smallest, largest and last point in each of `columns` equal parts of the abscissa. Peaks stay.
pub fn thinned(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    if points.len() <= 4 * columns || last.0 <= first.0 {
        return points.to_vec();
    }
    let column = |point: &(f64, f64)| ((point.0 - first.0) / (last.0 - first.0) * columns as f64) as usize;
    let mut kept = Vec::with_capacity(4 * columns);
    for part in points.chunk_by(|a, b| column(a) == column(b)) {
        let extreme = |largest: bool| {
            let order = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
            if largest { part.iter().max_by(order) } else { part.iter().min_by(order) }
        };
        let mut seen: Vec<(f64, f64)> =
            [part.first(), extreme(false), extreme(true), part.last()].into_iter().flatten().copied().collect();
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        seen.dedup();
        kept.extend(seen);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::thinned;

    #[test]
    fn peaks_and_ends_stay() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        points[54_321].1 = 99.0;
        points[12_345].1 = -99.0;
        let kept = thinned(&points, 100);
        assert!(kept.len() <= 404, "{}", kept.len());
        for point in [points[0], points[54_321], points[12_345], points[99_999]] {
            assert!(kept.contains(&point), "{point:?}");
        }
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0));
    }
}
