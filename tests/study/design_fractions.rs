//! Two-level fractions against published tables of least aberration, and what they confuse.

use decore_statistics::design::{Design, Distribution, Factor, FractionalFactorial, Kind};

/// Factors, basic factors and number of words by length from 3 on of the fractions of least aberration: up to 32 rows Chen, Sun and
/// Wu (Int. Stat. Rev. 61, 1993); larger ones the catalogue of the R package FrF2 (Groemping, J. Stat. Softw. 56, 2014), counted from
/// its generators. For each number of factors the sizes at which a higher resolution can be had.
const PUBLISHED: [(usize, u32, &[usize]); 50] = [
    (3, 2, &[1]),
    (4, 3, &[0, 1]),
    (5, 3, &[2, 1]),
    (5, 4, &[0, 0, 1]),
    (6, 3, &[4, 3]),
    (6, 4, &[0, 3]),
    (6, 5, &[0, 0, 0, 1]),
    (7, 3, &[7, 7, 0, 0, 1]),
    (7, 4, &[0, 7]),
    (7, 6, &[0, 0, 0, 0, 1]),
    (8, 4, &[0, 14, 0, 0, 0, 1]),
    (8, 6, &[0, 0, 2, 1]),
    (8, 7, &[0, 0, 0, 0, 0, 1]),
    (9, 4, &[4, 14, 8, 0, 4, 1]),
    (9, 5, &[0, 6, 8, 0, 0, 1]),
    (9, 7, &[0, 0, 0, 3]),
    (9, 8, &[0, 0, 0, 0, 0, 0, 1]),
    (10, 4, &[8, 18, 16, 8, 8, 5]),
    (10, 5, &[0, 10, 16, 0, 0, 5]),
    (10, 7, &[0, 0, 3, 3, 1]),
    (10, 8, &[0, 0, 0, 1, 2]),
    (10, 9, &[0, 0, 0, 0, 0, 0, 0, 1]),
    (11, 4, &[12, 26, 28, 24, 20, 13, 4]),
    (11, 5, &[0, 25, 0, 27, 0, 10, 0, 1]),
    (11, 7, &[0, 0, 6, 6, 2, 1]),
    (11, 8, &[0, 0, 0, 6, 0, 1]),
    (11, 9, &[0, 0, 0, 0, 2, 1]),
    (11, 10, &[0, 0, 0, 0, 0, 0, 0, 0, 1]),
    (12, 4, &[16, 39, 48, 48, 48, 39, 16, 0, 0, 1]),
    (12, 5, &[0, 38, 0, 52, 0, 33, 0, 4]),
    (12, 8, &[0, 0, 0, 12, 0, 3]),
    (12, 10, &[0, 0, 0, 0, 0, 3]),
    (13, 4, &[22, 55, 72, 96, 116, 87, 40, 16, 6, 1]),
    (13, 5, &[0, 55, 0, 96, 0, 87, 0, 16, 0, 1]),
    (13, 8, &[0, 0, 3, 12, 12, 3, 0, 0, 0, 0, 1]),
    (13, 9, &[0, 0, 0, 4, 8, 3]),
    (13, 10, &[0, 0, 0, 0, 4, 3]),
    (13, 11, &[0, 0, 0, 0, 0, 1, 2]),
    (14, 4, &[28, 77, 112, 168, 232, 203, 112, 56, 28, 7]),
    (14, 5, &[0, 77, 0, 168, 0, 203, 0, 56, 0, 7]),
    (14, 8, &[0, 0, 9, 18, 16, 7, 6, 6, 0, 0, 1]),
    (14, 9, &[0, 0, 0, 7, 16, 7, 0, 0, 0, 0, 0, 1]),
    (14, 10, &[0, 0, 0, 0, 8, 7]),
    (14, 11, &[0, 0, 0, 0, 0, 7]),
    (15, 4, &[35, 105, 168, 280, 435, 435, 280, 168, 105, 35, 0, 0, 1]),
    (15, 5, &[0, 105, 0, 280, 0, 435, 0, 168, 0, 35]),
    (15, 8, &[0, 0, 15, 30, 26, 15, 16, 18, 6, 0, 1]),
    (15, 9, &[0, 0, 0, 25, 0, 30, 0, 3, 0, 5]),
    (15, 10, &[0, 0, 0, 0, 15, 15, 0, 0, 0, 0, 0, 0, 1]),
    (15, 11, &[0, 0, 0, 0, 0, 15]),
];

fn fraction(factors: usize, resolution: u32) -> Design {
    let unit = Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: None };
    Design::new(Kind::FractionalFactorial(FractionalFactorial { resolution }), vec![unit; factors], 0).unwrap()
}

/// Rows as words, a bit per factor at its upper level.
fn rows(design: &Design) -> Vec<u32> {
    let word = |row: usize| {
        let levels = design.unit_row(row).unwrap();
        levels.iter().enumerate().map(|(factor, level)| u32::from(*level > 0.5) << factor).sum()
    };
    (0..design.row_count()).map(word).collect()
}

/// Number of products of factors that are the same in every row, by their number of factors from 3 on.
fn lengths(design: &Design) -> Vec<usize> {
    let (rows, factors) = (rows(design), design.factors().len());
    let mut lengths = vec![0; factors + 1];
    for product in 1_u32..1 << factors {
        let parity = |row: &u32| (row & product).count_ones() % 2;
        if rows.iter().all(|row| parity(row) == parity(&rows[0])) {
            lengths[product.count_ones() as usize] += 1;
        }
    }
    assert_eq!(lengths[..3], [0; 3], "two factors are one");
    lengths.split_off(3)
}

fn padded(mut lengths: Vec<usize>, factors: usize) -> Vec<usize> {
    lengths.resize(factors - 2, 0);
    lengths
}

#[test]
fn val_fractions_have_the_published_word_lengths() {
    for factors in 3..=15 {
        for resolution in 3..=8 {
            let design = fraction(factors, resolution);
            let sound = |lengths: &[usize]| lengths.iter().take(resolution as usize - 3).all(|count| *count == 0);
            let published = PUBLISHED.iter().find(|(count, _, lengths)| *count == factors && sound(lengths));
            let (basic, known) = published.map_or((factors as u32, &[][..]), |(_, basic, lengths)| (*basic, *lengths));
            assert_eq!(design.row_count(), 1 << basic, "{factors} factors, resolution {resolution}");
            assert_eq!(lengths(&design), padded(known.to_vec(), factors), "{factors} factors, resolution {resolution}");
        }
    }
}

#[test]
fn aliases_are_those_of_the_rows() {
    for (factors, resolution) in [(5, 3), (7, 3), (8, 4), (9, 4), (11, 3), (11, 4), (8, 5), (15, 5), (20, 4)] {
        let design = fraction(factors, resolution);
        let aliases = design.aliases().unwrap();
        let rows = rows(&design);
        let high =
            |row: u32, effect: &[usize]| effect.iter().filter(|factor| row >> **factor & 1 == 0).count() % 2 == 0;
        for (factor, product) in &aliases.generators {
            assert!(rows.iter().all(|row| high(*row, &[*factor]) == high(*row, product)));
        }
        if factors <= 15 {
            let counted = aliases.word_lengths.clone().unwrap();
            assert_eq!(counted[3..], lengths(&design)[..]);
            assert_eq!(
                aliases.resolution(),
                counted.iter().skip(1).position(|count| *count > 0).map(|place| place + 1)
            );
        }
        // Effects of one or two factors by their column: those that share one are a chain.
        let mut columns: std::collections::BTreeMap<Vec<bool>, Vec<Vec<usize>>> = Default::default();
        let mains = (0..factors).map(|factor| vec![factor]);
        let pairs = (0..factors).flat_map(|b| (0..b).map(move |a| vec![a, b]));
        for effect in mains.chain(pairs) {
            columns.entry(rows.iter().map(|row| high(*row, &effect)).collect()).or_default().push(effect);
        }
        let mut known: Vec<Vec<Vec<usize>>> = columns.into_values().filter(|chain| chain.len() > 1).collect();
        known.iter_mut().for_each(|chain| chain.sort_by_key(|effect| (effect.len(), effect.clone())));
        known.sort_by_key(|chain| (chain[0].len(), chain[0].clone()));
        assert_eq!(aliases.chains, known, "{factors} factors, resolution {resolution}");
    }
    let whole = fraction(3, 8).aliases().unwrap();
    assert!(whole.generators.is_empty() && whole.chains.is_empty() && whole.resolution().is_none());
}
