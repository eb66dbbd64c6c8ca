//! Rows that belong together are in one group and in one part of the splits, for all kinds of design.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::synthetic::{described, info};
use decore_dataset::{DatasetInfo, DatasetReader, DatasetWriter, Existing, FactorColumn, RowRecord};
use decore_lab::features::{FeatureColumn, FeatureSettings, Features, FeaturesError, GroupBy, Splits, features};
use decore_model::run::RowOutcome;
use decore_quantity::{Kind as ValueKind, Value};
use decore_statistics::design::{
    Axial, BoxBehnken, CentralComposite, Constraints, Design, Distribution, Factor, FractionalFactorial, FullFactorial,
    Halton, HypercubeKind, Kind, LatinHypercube, Level, Morris, OneAtATime, PlackettBurman, Product, ProductPart,
    Random, Saltelli, Sobol, Table, Union,
};
use proptest::prelude::*;
use tempfile::TempDir;

/// Factors of a part.
const FACTORS: usize = 3;
/// Kinds of [`part`].
const KINDS: usize = 14;

/// A kind of design of [`FACTORS`] factors, and the rows of its trajectories or blocks.
fn part(which: usize, size: usize) -> (Kind, Option<usize>) {
    let hypercube = LatinHypercube { rows: 6 * size, ..LatinHypercube::default() };
    match which {
        0 => (Kind::Morris(Morris { trajectories: size, levels: 4 }), Some(FACTORS + 1)),
        1 => (Kind::Saltelli(Saltelli { base: size, second_order: false }), Some(FACTORS + 2)),
        2 => (Kind::Saltelli(Saltelli { base: size, second_order: true }), Some(2 * FACTORS + 2)),
        3 => (Kind::LatinHypercube(hypercube), None),
        4 => (Kind::LatinHypercube(LatinHypercube { grown_from: vec![size, 2 * size], ..hypercube }), None),
        5 => (Kind::LatinHypercube(LatinHypercube { kind: HypercubeKind::Maximin, ..hypercube }), None),
        6 => (Kind::Random(Random { rows: 5 * size }), None),
        7 => (Kind::Sobol(Sobol { rows: 4 * size, scramble: true }), None),
        8 => (Kind::Halton(Halton { rows: 4 * size, scramble: false }), None),
        9 => (Kind::FullFactorial(FullFactorial), None),
        10 => (Kind::OneAtATime(OneAtATime), None),
        11 => (Kind::CentralComposite(CentralComposite { axial: Axial::Faces, centres: size }), None),
        12 => (Kind::BoxBehnken(BoxBehnken { centres: size }), None),
        _ => match size {
            1 => (Kind::FractionalFactorial(FractionalFactorial { resolution: 3 }), None),
            2 => (Kind::PlackettBurman(PlackettBurman), None),
            _ => (Kind::Table(Table { rows: Arc::new(vec![vec![Level::Real(0.25); FACTORS]; 2]) }), None),
        },
    }
}

fn factors(count: usize) -> Vec<Factor> {
    vec![Factor { distribution: Distribution::Uniform { low: 0.0, high: 1.0 }, levels: Some(2) }; count]
}

fn rows_of(kind: &Kind) -> usize {
    Design::new(kind.clone(), factors(FACTORS), 0).expect("a design").row_count()
}

/// What each row shares with others: trajectories and blocks by their part and number, and the values of the factors.
fn shared(design: &Design, of_row: impl Fn(usize) -> Vec<String>) -> Vec<Vec<String>> {
    let tokens = |row: usize| {
        let values = design.row(row).expect("a row");
        of_row(row).into_iter().chain([format!("{values:?}")]).collect()
    };
    (0..design.row_count()).map(tokens).collect()
}

/// The least row that each row is linked to, step by step.
fn linked(tokens: &[Vec<String>]) -> Vec<usize> {
    let mut least: Vec<usize> = (0..tokens.len()).collect();
    loop {
        let mut of_token: BTreeMap<&String, usize> = BTreeMap::new();
        for (row, tokens) in tokens.iter().enumerate() {
            for token in tokens {
                let known = of_token.entry(token).or_insert(row);
                *known = least[row].min(*known);
            }
        }
        let next: Vec<usize> = (tokens.iter().enumerate())
            .map(|(row, tokens)| tokens.iter().map(|token| of_token[token]).fold(least[row], usize::min))
            .collect();
        if next == least {
            return least;
        }
        least = next;
    }
}

/// A dataset of a design all of whose rows failed: only their factors matter here.
fn dataset(folder: &Path, design: &Design) -> DatasetReader {
    let factor = |index: usize| FactorColumn {
        name: format!("f{index}"),
        kind: ValueKind::Real,
        unit: "1".to_owned(),
        description: "a factor".to_owned(),
    };
    let info = described(DatasetInfo {
        factors: (0..design.factors().len()).map(factor).collect(),
        rows: design.row_count() as u64,
        rows_per_part: 4096,
        row_groups: Some(design.groups()),
        ..info()
    });
    let mut writer = DatasetWriter::create(folder, &info, Existing::Replace).expect("created");
    for row in 0..design.row_count() {
        let values = design.row(row).expect("a row").into_iter().map(|level| match level {
            Level::Real(value) => Value::Real(value),
            other => panic!("{other:?}"),
        });
        let record =
            RowRecord { row: row as u64, factors: values.collect(), outcome: RowOutcome::invalid("none".to_owned()) };
        writer.write(&record).expect("written");
    }
    writer.finish().expect("finished");
    DatasetReader::open(folder).expect("opened")
}

fn column<'a>(features: &'a Features, name: &str) -> Option<&'a FeatureColumn> {
    features.columns.iter().find(|column| column.name == name)
}

fn texts(features: &Features, name: &str) -> Vec<String> {
    let values = &column(features, name).unwrap_or_else(|| panic!("no column {name}")).values;
    (0..values.count).map(|row| values.text(row)).collect()
}

fn split(shares: &[f64], seed: u64) -> FeatureSettings {
    FeatureSettings { splits: Some(Splits::new(shares, seed).expect("shares")), ..FeatureSettings::default() }
}

/// Holds the groups of a design to what its rows share, and the splits to the groups.
fn check(design: &Design, tokens: &[Vec<String>], seed: u64) {
    let scratch = TempDir::new().expect("scratch folder");
    let reader = dataset(&scratch.path().join("sweep"), design);
    let expected = linked(tokens);
    let table = features(&reader, &FeatureSettings::default()).expect("features");
    let found = texts(&table, "group_id");
    // The same rows together: the first row of a group of one kind is that of the other.
    let first: Vec<usize> =
        found.iter().map(|own| found.iter().position(|other| other == own).expect("itself")).collect();
    assert_eq!(first, expected, "{:?}: {found:?}", design.kind());
    let groups = expected.iter().enumerate().filter(|(row, least)| row == *least).count();
    match features(&reader, &split(&[0.5, 0.5], seed)) {
        Ok(table) => {
            let parts = texts(&table, "split");
            assert!(parts.iter().zip(&expected).all(|(part, least)| *part == parts[*least]), "{parts:?}");
        }
        // All groups on one side, once in 2^(groups - 1).
        Err(FeaturesError::EmptyPart { groups: told, .. }) => assert!(told == groups && groups < 30, "{told} {groups}"),
        Err(error) => panic!("{error}"),
    }
}

/// The trajectory or block of a row of a part, as a word.
fn token(index: usize, row: usize, block: Option<usize>) -> Option<String> {
    block.map(|block| format!("part {index}, group {}", row / block))
}

#[test]
fn every_kind_keeps_its_trajectories_and_blocks_together() {
    for which in 0..KINDS {
        for size in [1, 2, 3] {
            let (kind, block) = part(which, size);
            let design = Design::new(kind, factors(FACTORS), 7).expect("a design");
            let tokens = shared(&design, |row| token(0, row, block).into_iter().collect());
            check(&design, &tokens, 1);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Rows of a union: its parts one after the other, of which a constraint may leave out some.
    #[test]
    fn unions_keep_the_groups_of_their_parts(
        parts in prop::collection::vec((0..KINDS, 1..4_usize), 1..4),
        seed in 0..1000_u64,
        least in prop::option::of(0.0..0.5),
    ) {
        let parts: Vec<_> = parts.into_iter().map(|(which, size)| part(which, size)).collect();
        let kind = Kind::Union(Union { parts: parts.iter().map(|(kind, _)| kind.clone()).collect() });
        let whole = Design::new(kind, factors(FACTORS), seed).expect("a design");
        let counts: Vec<usize> = parts.iter().map(|(kind, _)| rows_of(kind)).collect();
        let token_of = |row: usize| {
            let mut rest = row;
            for (index, ((_, block), rows)) in parts.iter().zip(&counts).enumerate() {
                if rest < *rows {
                    return token(index, rest, *block);
                }
                rest -= *rows;
            }
            None
        };
        let passes = |levels: &[Level]| matches!(levels[0], Level::Real(value) if value >= least.unwrap_or(0.0));
        let kept: Vec<usize> = (0..whole.row_count()).filter(|row| passes(&whole.row(*row).expect("a row"))).collect();
        prop_assume!(!kept.is_empty());
        let design = match least {
            None => whole,
            Some(_) => {
                let mut met = |levels: &[Level], _: &[usize]| Ok(usize::from(passes(levels)));
                whole.constrained(Constraints { factors: vec![vec![0]], met: &mut met }).expect("rows")
            }
        };
        prop_assert_eq!(design.row_count(), kept.len());
        check(&design, &shared(&design, |row| token_of(kept[row]).into_iter().collect()), seed);
    }

    /// Rows of a product share what the rows of one of its parts share.
    #[test]
    fn products_keep_the_groups_of_their_parts(
        parts in prop::collection::vec((0..KINDS, 1..3_usize), 2..3),
        seed in 0..1000_u64,
    ) {
        let parts: Vec<_> = parts.into_iter().map(|(which, size)| part(which, size)).collect();
        let own = |index: usize| (index * FACTORS..(index + 1) * FACTORS).collect();
        let product = parts.iter().enumerate().map(|(index, (kind, _))| ProductPart { kind: kind.clone(), factors: own(index) });
        let kind = Kind::Product(Product { parts: product.collect() });
        let design = Design::new(kind, factors(2 * FACTORS), seed).expect("a design");
        let inner = rows_of(&parts[1].0);
        let tokens = |row: usize| {
            let rows = [row / inner, row % inner];
            rows.into_iter().enumerate().filter_map(|(index, row)| token(index, row, parts[index].1)).collect()
        };
        check(&design, &shared(&design, tokens), seed);
    }
}

/// A hypercube that grew: its parts carry a key, which binds on request.
#[test]
fn grown_parts_and_machines_bind_on_request() {
    let scratch = TempDir::new().expect("scratch folder");
    let design = Design::new(part(4, 3).0, factors(FACTORS), 0).expect("a design");
    let reader = dataset(&scratch.path().join("sweep"), &design);
    let free = features(&reader, &FeatureSettings::default()).expect("features");
    let parts: Vec<usize> = texts(&free, "group_grown_part").iter().map(|text| text.parse().expect("number")).collect();
    assert_eq!(parts, [[0; 3].as_slice(), &[1; 3], &[2; 12]].concat());
    assert_eq!(texts(&free, "group_id"), (0..18).map(|row| row.to_string()).collect::<Vec<_>>());
    assert_eq!(column(&free, "group_id").expect("group").derived_from, ["group_point"]);
    let bound =
        |group_by| features(&reader, &FeatureSettings { group_by: vec![group_by], ..FeatureSettings::default() });
    let grown = bound(GroupBy::GrownPart).expect("features");
    assert_eq!(texts(&grown, "group_id"), texts(&free, "group_grown_part"));
    // One machine: one group, which no split divides.
    let machine = bound(GroupBy::Machine).expect("features");
    assert_eq!(texts(&machine, "group_id"), vec!["0"; 18]);
    let settings = FeatureSettings { group_by: vec![GroupBy::Machine], ..split(&[0.8, 0.2], 0) };
    assert!(matches!(features(&reader, &settings), Err(FeaturesError::EmptyPart { groups: 1, .. })));
}

/// Shares are met, another seed gives other parts, and rows that come later leave the earlier ones where they are.
#[test]
fn parts_follow_from_seed_and_group() {
    let scratch = TempDir::new().expect("scratch folder");
    let [few, many] = [300, 600].map(|rows| {
        let design = Design::new(Kind::Random(Random { rows }), factors(FACTORS), 5).expect("a design");
        dataset(&scratch.path().join(rows.to_string()), &design)
    });
    let parts = |reader: &DatasetReader, seed| {
        texts(&features(reader, &split(&[0.7, 0.15, 0.15], seed)).expect("features"), "split")
    };
    let all = parts(&many, 3);
    assert_eq!(parts(&few, 3), all[..300]);
    assert_ne!(parts(&few, 4), all[..300]);
    for (name, share) in [("train", 0.7), ("validation", 0.15), ("test", 0.15)] {
        let found = all.iter().filter(|part| *part == name).count() as f64 / 600.0;
        // Four standard deviations of 600 draws.
        assert!((found - share).abs() < 4.0 * (share * (1.0 - share) / 600.0_f64).sqrt(), "{name}: {found}");
    }
    for shares in [&[0.5, 0.6][..], &[1.0], &[0.5, 0.5, 0.0], &[f64::NAN, 0.5], &[0.25; 4]] {
        assert!(matches!(Splits::new(shares, 0), Err(FeaturesError::Shares { .. })), "{shares:?}");
    }
}
