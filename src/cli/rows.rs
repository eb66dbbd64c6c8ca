//! `3,17-20`: rows of a design on the command line.

use std::str::FromStr;

use decore_dataset::RowSpan;

/// Rows, ascending and each once; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RowList(Vec<RowSpan>);

impl FromStr for RowList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut spans = Vec::new();
        for word in text.split(',') {
            let (first, last) = word.split_once('-').unwrap_or((word, word));
            let rows = first.trim().parse::<u64>().ok().zip(last.trim().parse::<u64>().ok());
            let rows = rows.filter(|(first, last)| first <= last && *last < u64::MAX);
            let (first, last) = rows.ok_or_else(|| {
                format!("`{}`: expected rows and ranges of rows from 0, such as 3,17-20", word.trim())
            })?;
            spans.push(RowSpan { first, end: last + 1 });
        }
        spans.sort_unstable_by_key(|span| span.first);
        let mut merged: Vec<RowSpan> = Vec::new();
        for span in spans {
            match merged.last_mut() {
                Some(before) if span.first <= before.end => before.end = before.end.max(span.end),
                _ => merged.push(span),
            }
        }
        Ok(Self(merged))
    }
}

impl RowList {
    /// The rows as spans, ascending, with gaps between them.
    pub fn spans(&self) -> &[RowSpan] {
        &self.0
    }

    /// The last row.
    pub fn last(&self) -> Option<u64> {
        self.0.last().map(|span| span.end - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_put_in_order() {
        let spans = |text: &str| text.parse::<RowList>().map(|list| list.0);
        let span = |first, end| RowSpan { first, end };
        assert_eq!(spans("17-20,3"), Ok(vec![span(3, 4), span(17, 21)]));
        assert_eq!(spans(" 3, 4 ,2-3,9-9"), Ok(vec![span(2, 5), span(9, 10)]));
        for text in ["", "3,", "a", "5-3", "-1", "1-2-3", "18446744073709551615"] {
            assert!(spans(text).is_err(), "{text}");
        }
    }
}
