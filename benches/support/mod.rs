//! Results of the benches: one file, a section per bench.

use std::path::Path;

/// Replaces the section `name` of `benches/RESULTS.md` by `text`, or appends it.
///
/// A section stands between `<!-- name -->` and `<!-- end of name -->`; all else in the file is left as it is.
pub fn write_section(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/RESULTS.md");
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    let (begin, end) = (format!("<!-- {name} -->"), format!("<!-- end of {name} -->"));
    let section = format!("{begin}\n{}\n{end}", text.trim_end());
    let new = match (old.find(&begin), old.find(&end)) {
        (Some(start), Some(stop)) => format!("{}{section}{}", &old[..start], &old[stop + end.len()..]),
        _ if old.is_empty() => format!("{section}\n"),
        _ => format!("{}\n\n{section}\n", old.trim_end()),
    };
    if let Err(error) = std::fs::write(&path, new) {
        eprintln!("failed to write {}: {error}", path.display());
    }
}
