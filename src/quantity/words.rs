//! Names that users mistype, and names as columns have them.

/// Least share of letters that a name has in common with the one meant.
const ALIKE: f64 = 0.5;
/// Letters from which on the beginning of a name stands for it.
const LEAST_PREFIX: usize = 3;
/// Longest name that is compared: the effort is the product of both lengths.
const LONGEST: usize = 200;

/// The known name that was most likely meant by `wanted`; `None` where none is near, and for names of more than 200
/// bytes.
///
/// A name that begins with a `wanted` of at least three letters comes first, the shortest of several. Else the one with the least edits (insertions, deletions, exchanges, swaps of neighbours; Damerau 1964) over the longer of both
/// names, small and capital letters alike; the first in the alphabet of several.
pub fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let wanted = wanted.to_lowercase();
    let alike = |name: &str| strsim::normalized_damerau_levenshtein(&wanted, &name.to_lowercase());
    let short = |name: &str| name.len().max(wanted.len()) <= LONGEST;
    let known: Vec<&str> = known.into_iter().filter(|name| short(name)).collect();
    let begins = |name: &&&str| wanted.len() >= LEAST_PREFIX && name.to_lowercase().starts_with(&wanted);
    if let Some(name) = known.iter().filter(begins).min_by_key(|name| (name.len(), **name)) {
        return Some((*name).to_owned());
    }
    let all = known.into_iter().map(|name| (alike(name), name)).filter(|(share, _)| *share >= ALIKE);
    all.max_by(|a, b| a.0.total_cmp(&b.0).then_with(|| b.1.cmp(a.1))).map(|(_, name)| name.to_owned())
}

/// A name that may have been meant, as the end of a message: `; did you mean ..?`, or nothing.
pub fn did_you_mean(nearest: Option<String>) -> String {
    nearest.map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

/// A name of a study as a part of a column's name: letters, digits and underscores, and a letter in front.
pub fn identifier(name: &str, prefix_before_digit: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if safe.starts_with(|c: char| c.is_ascii_alphabetic()) { safe } else { format!("{prefix_before_digit}_{safe}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_with_the_least_edits_if_one_is_near() {
        let points = ["R1", "R10", "R5", "T5"];
        assert_eq!(nearest("R55", points).as_deref(), Some("R5"));
        assert_eq!(nearest("t5", points).as_deref(), Some("T5"));
        assert_eq!(nearest("R6", points).as_deref(), Some("R1"), "the first of several");
        assert_eq!(nearest("rial", ["part", "rail"]).as_deref(), Some("rail"), "a swap is one edit");
        assert_eq!(nearest("hammer", points), None);
        assert_eq!(
            nearest("latin", ["halton", "latin_hypercube"]).as_deref(),
            Some("latin_hypercube"),
            "its beginning"
        );
    }
}
