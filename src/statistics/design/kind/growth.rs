//! Growth of a design, by the key of its study that contains the number of rows.

/// Smallest and largest growth at a time: the number of rows for narrow intervals is uncertain when few rows exist.
const FACTORS: [f64; 2] = [1.25, 4.0];

/// The number by which a design grows, its first rows unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Growth {
    /// The number's key in `[design]`.
    pub key: &'static str,
    /// The number.
    pub count: usize,
    /// Whether powers of two are best.
    pub doubles: bool,
}

impl Growth {
    /// The number for `wanted` times as many rows, as far as is gone at a time (1.25 to 4 times).
    pub fn next(self, wanted: f64) -> usize {
        let [least, most] = FACTORS;
        let next = (self.count as f64 * wanted.clamp(least, most)).ceil() as usize;
        if self.doubles { next.next_power_of_two() } else { next }
    }
}

#[cfg(test)]
mod tests {
    use super::Growth;

    #[test]
    fn designs_grow_by_what_is_wanted() {
        let saltelli = Growth { key: "base_points", count: 64, doubles: true };
        assert_eq!([1.01, 1.9, 2.1, 100.0].map(|wanted| saltelli.next(wanted)), [128, 128, 256, 256]);
        let morris = Growth { doubles: false, count: 10, ..saltelli };
        assert_eq!([1.01, 1.9, 100.0].map(|wanted| morris.next(wanted)), [13, 19, 40]);
    }
}
