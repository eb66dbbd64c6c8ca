//! Names of columns.

/// A name of the study as the beginning of a column's name: letters, digits and underscores, no digit in front.
pub fn identifier(name: &str, prefix_before_digit: &str) -> String {
    let safe: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if safe.starts_with(|c: char| c.is_ascii_alphabetic()) { safe } else { format!("{prefix_before_digit}_{safe}") }
}
