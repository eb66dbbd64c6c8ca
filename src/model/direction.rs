//! Directions in world axes: x forward, y lateral, z up.

use nalgebra::Vector3;

/// Straight down.
pub const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
/// Share of a unit vector along x from which the first direction across it follows y.
const ALONG_X: f64 = 0.9;

/// Whether a direction is straight down, the default.
pub fn is_down(direction: &[f64; 3]) -> bool {
    unit(*direction) == DOWN
}

/// Unit vector along a direction; straight down if it has no length.
pub fn unit(direction: [f64; 3]) -> [f64; 3] {
    let length = Vector3::from(direction).norm();
    if length.is_finite() && length > 0.0 { direction.map(|value| value / length) } else { DOWN }
}

/// Two unit vectors across a direction: x and y across a vertical one. Across another one the first is x without its share along it, or
/// y if the direction is close to x; the second is the cross product of the first and the direction.
pub fn across(direction: [f64; 3]) -> [[f64; 3]; 2] {
    let along = Vector3::from(unit(direction));
    let seed = if along.x.abs() < ALONG_X { Vector3::x() } else { Vector3::y() };
    let first = (seed - along * along.dot(&seed)).normalize();
    [first.into(), first.cross(&along).into()]
}

/// The part of a vector across a direction.
pub fn perpendicular(vector: [f64; 3], direction: [f64; 3]) -> [f64; 3] {
    let along = Vector3::from(unit(direction));
    let vector = Vector3::from(vector);
    (vector - along * along.dot(&vector)).into()
}

/// Scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_and_y_lie_across_the_vertical() {
        assert_eq!(across(DOWN), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        for direction in [[1.0, 0.0, 0.0], [0.3, -2.0, 0.1], [0.0, 0.0, 5.0]] {
            let [first, second] = across(direction);
            let all = [first, second, unit(direction)];
            for (i, a) in all.iter().enumerate() {
                for (j, b) in all.iter().enumerate() {
                    assert!((dot(*a, *b) - f64::from(u8::from(i == j))).abs() < 1e-15, "{direction:?}");
                }
            }
        }
    }
}
