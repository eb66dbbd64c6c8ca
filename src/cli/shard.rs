//! `i/n`: one of n machines' share of the rows.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use decore_dataset::RowSpan;

/// Shard `index` of `count`, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shard {
    pub index: u64,
    pub count: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("expected i/n with i from 1 to n, such as 2/7".to_owned()),
        }
    }
}

impl Shard {
    /// The shard's rows: consecutive, all shards' numbers of rows equal to within one.
    pub fn rows(self, rows: u64) -> RowSpan {
        // In 128 bits, where the product of two 64-bit numbers fits.
        let end = |index: u64| (u128::from(rows) * u128::from(index) / u128::from(self.count)) as u64;
        RowSpan { first: end(self.index - 1), end: end(self.index) }
    }

    /// The shard's folder, next to the folder of the whole dataset.
    pub fn folder(self, whole: &Path) -> PathBuf {
        let mut name = whole.as_os_str().to_owned();
        name.push(".shards");
        Path::new(&name).join(format!("shard-{}-of-{}", self.index, self.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_all_rows_once() {
        for (rows, count) in [(150, 7), (3, 7), (0, 2), (u64::MAX, 3)] {
            let spans: Vec<RowSpan> = (1..=count).map(|index| Shard { index, count }.rows(rows)).collect();
            assert_eq!((spans[0].first, spans[spans.len() - 1].end), (0, rows));
            assert!(spans.windows(2).all(|pair| pair[0].end == pair[1].first), "{spans:?}");
            let lengths = spans.iter().map(|span| span.len());
            assert!(lengths.clone().max() <= lengths.min().map(|least| least + 1), "{spans:?}");
        }
    }

    #[test]
    fn only_whole_shares_are_shards() {
        assert_eq!("2/7".parse(), Ok(Shard { index: 2, count: 7 }));
        for text in ["0/7", "8/7", "1", "a/b", "1/0", "-1/2", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
