//! The explicit Runge-Kutta pair of order 5(4) by Tsitouras (2011) with its free interpolant of order 4.
//!
//! Source of the coefficients: Ch. Tsitouras, Computers and Mathematics with Applications 62 (2011) 770-775. Seven stages,
//! the last one being the first of the next step.

/// Number of stages.
pub const STAGES: usize = 7;
/// Order of the error estimate plus one: the exponent of step size control.
pub const CONTROL_ORDER: f64 = 5.0;

/// Nodes.
pub const C: [f64; STAGES] = [0.0, 0.161, 0.327, 0.9, 0.980_025_540_904_509_7, 1.0, 1.0];

/// Rows of the Runge-Kutta matrix; the last row holds the weights of order 5.
pub const A: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 6],
    [0.161, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.008_480_655_492_356_989, 0.335_480_655_492_357, 0.0, 0.0, 0.0, 0.0],
    [2.897_153_057_105_493_5, -6.359_448_489_975_075, 4.362_295_432_869_581_5, 0.0, 0.0, 0.0],
    [5.325_864_828_439_257, -11.748_883_564_062_828, 7.495_539_342_889_836_5, -0.092_495_066_361_755_25, 0.0, 0.0],
    [
        5.861_455_442_946_42,
        -12.920_969_317_847_11,
        8.159_367_898_576_159,
        -0.071_584_973_281_401,
        -0.028_269_050_394_068_383,
        0.0,
    ],
    [
        0.096_460_766_818_065_23,
        0.01,
        0.479_889_650_414_499_6,
        1.379_008_574_103_742,
        -3.290_069_515_436_081,
        2.324_710_524_099_774,
    ],
];

/// Weights of the error estimate (order 5 minus order 4).
pub const ERROR: [f64; STAGES] = [
    -0.001_780_011_052_225_777,
    -0.000_816_434_459_656_746_9,
    0.007_880_878_010_261_995,
    -0.144_711_007_173_262_9,
    0.582_357_165_452_555_2,
    -0.458_082_105_929_186_97,
    1.0 / 66.0,
];

/// Coefficients of the weights of the interpolant, by powers of the fraction from 1 on.
pub const INTERPOLANT: [[f64; 4]; STAGES] = [
    [1.0, -2.763_706_197_274_826, 2.913_255_461_821_912_6, -1.053_088_497_729_021_6],
    [0.0, 0.131_7, -0.223_4, 0.101_7],
    [0.0, 3.930_296_236_894_751_6, -5.941_033_872_131_505, 2.490_627_285_651_253],
    [0.0, -12.411_077_166_933_676, 30.338_188_630_282_32, -16.548_102_889_244_902],
    [0.0, 37.509_313_416_511_04, -88.178_904_894_766_4, 47.379_521_962_819_28],
    [0.0, -27.896_526_289_197_286, 65.091_894_674_793_66, -34.870_657_861_496_61],
    [0.0, 1.5, -4.0, 2.5],
];

/// Weights of the interpolant at fraction `theta` of the step: `y(t + theta h) = y + h sum b_i(theta) k_i`.
pub fn interpolant(theta: f64) -> [f64; STAGES] {
    INTERPOLANT.map(|[first, a, b, c]| first * theta + theta * theta * (a + theta * (b + theta * c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Vector = [f64; STAGES];

    /// `A v`.
    fn product(v: &Vector) -> Vector {
        std::array::from_fn(|i| A[i].iter().zip(v).map(|(a, v)| a * v).sum())
    }

    fn times(a: &Vector, b: &Vector) -> Vector {
        std::array::from_fn(|i| a[i] * b[i])
    }

    /// Elementary weights of all trees up to order 5 with the required value of `sum b w`.
    fn trees() -> Vec<(u32, Vector, f64)> {
        let one = [1.0; STAGES];
        let c = C;
        let c2 = times(&c, &c);
        let c3 = times(&c2, &c);
        let (ac, ac2, ac3) = (product(&c), product(&c2), product(&c3));
        let aac = product(&ac);
        vec![
            (1, one, 1.0),
            (2, c, 1.0 / 2.0),
            (3, c2, 1.0 / 3.0),
            (3, ac, 1.0 / 6.0),
            (4, c3, 1.0 / 4.0),
            (4, times(&c, &ac), 1.0 / 8.0),
            (4, ac2, 1.0 / 12.0),
            (4, aac, 1.0 / 24.0),
            (5, times(&c2, &c2), 1.0 / 5.0),
            (5, times(&c2, &ac), 1.0 / 10.0),
            (5, times(&ac, &ac), 1.0 / 20.0),
            (5, times(&c, &ac2), 1.0 / 15.0),
            (5, times(&c, &aac), 1.0 / 30.0),
            (5, ac3, 1.0 / 20.0),
            (5, product(&times(&c, &ac)), 1.0 / 40.0),
            (5, product(&ac2), 1.0 / 60.0),
            (5, product(&aac), 1.0 / 120.0),
        ]
    }

    fn sum(weights: &[f64], values: &Vector) -> f64 {
        weights.iter().zip(values).map(|(w, v)| w * v).sum()
    }

    /// All seventeen conditions of order 5; the coefficients are published to sixteen digits.
    #[test]
    fn analytic_order_conditions() {
        for (row, node) in A.iter().zip(C) {
            assert!((row.iter().sum::<f64>() - node).abs() < 5e-15, "row of node {node}");
        }
        for (order, weight, expected) in trees() {
            let found = sum(&A[STAGES - 1], &weight);
            assert!((found - expected).abs() < 1e-14, "order {order}: {found} instead of {expected}");
        }
    }

    /// The error weights vanish on all trees up to order 4 and on none of order 5 together: an estimate of order 4.
    #[test]
    fn analytic_error_weights() {
        let (low, high): (Vec<_>, Vec<_>) = trees().into_iter().partition(|tree| tree.0 <= 4);
        assert!(low.iter().all(|(_, weight, _)| sum(&ERROR, weight).abs() < 1e-14));
        assert!(high.iter().any(|(_, weight, _)| sum(&ERROR, weight).abs() > 1e-5));
    }

    /// The interpolant satisfies the conditions of order 4 at every fraction, `sum b_i(theta) w_i = theta^order expected`, and
    /// ends in the step's own weights.
    #[test]
    fn analytic_interpolant() {
        for theta in [0.1, 0.37, 0.5, 0.81, 1.0] {
            let weights = interpolant(theta);
            for (order, weight, expected) in trees().into_iter().filter(|tree| tree.0 <= 4) {
                let found = sum(&weights, &weight);
                let wanted = theta.powi(order as i32) * expected;
                assert!((found - wanted).abs() < 1e-13, "theta {theta}, order {order}: {found} instead of {wanted}");
            }
        }
        assert_eq!(interpolant(0.0), [0.0; STAGES]);
        let end = interpolant(1.0);
        assert!(end.iter().zip(A[STAGES - 1]).all(|(found, weight)| (found - weight).abs() < 1e-13));
        assert!(end[STAGES - 1].abs() < 1e-13);
    }
}
