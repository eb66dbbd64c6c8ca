//! Paths of parameters, such as `hammer.left.supply_bar` or `casting.part.centre_m.0`.

use toml::Value;

/// Splits a path at its dots; a segment that contains dots stands in double or single quotes.
pub(crate) fn split(path: &str) -> Result<Vec<String>, String> {
    let mut segments = Vec::new();
    let mut rest = path.trim();
    loop {
        let quote = rest.chars().next().filter(|c| matches!(c, '"' | '\''));
        let (segment, tail) = match quote {
            Some(quote) => {
                let inner = rest.get(1..).unwrap_or("");
                let end = inner.find(quote).ok_or_else(|| format!("the path `{path}` has an unclosed quote"))?;
                (inner.get(..end).unwrap_or(""), inner.get(end + 1..).unwrap_or(""))
            }
            None => rest.split_at(rest.find('.').unwrap_or(rest.len())),
        };
        if segment.is_empty() {
            return Err(format!("the path `{path}` has an empty part; expected names separated by dots"));
        }
        segments.push(segment.to_string());
        rest = match tail.strip_prefix('.') {
            Some(more) => more,
            None if tail.is_empty() => return Ok(segments),
            None => {
                return Err(format!("the path `{path}` needs a dot after the quoted `{segment}`"));
            }
        };
    }
}

/// Joins segments; the inverse of [`split`].
pub(crate) fn join(segments: &[String]) -> String {
    let quoted = |segment: &String| {
        if segment.contains('.') { format!("\"{segment}\"") } else { segment.clone() }
    };
    segments.iter().map(quoted).collect::<Vec<_>>().join(".")
}

/// Puts a value at a path, making the tables above it. Fails if the path leads through another kind of value.
pub(crate) fn set(table: &mut toml::Table, path: &[String], value: Value) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        return Err("the path is empty".to_string());
    };
    if rest.is_empty() {
        table.insert(first.clone(), value);
        return Ok(());
    }
    let entry = table.entry(first.as_str()).or_insert_with(|| Value::Table(toml::Table::new()));
    match entry {
        Value::Table(inner) => set(inner, rest, value),
        Value::Array(entries) => set_entry(entries, first, rest, value),
        _ => Err(format!("`{first}` is no table")),
    }
}

fn set_entry(entries: &mut [Value], name: &str, rest: &[String], value: Value) -> Result<(), String> {
    let count = entries.len();
    let index = rest.first().and_then(|segment| segment.parse::<usize>().ok());
    match (index.and_then(|index| entries.get_mut(index)), rest.len()) {
        (Some(entry), 1) => {
            *entry = value;
            Ok(())
        }
        _ => Err(format!("`{name}` has the entries 0 to {}", count.saturating_sub(1))),
    }
}

/// The value at a path.
pub(crate) fn get<'a>(table: &'a toml::Table, path: &[String]) -> Option<&'a Value> {
    let (first, rest) = path.split_first()?;
    let mut value = table.get(first)?;
    for segment in rest {
        value = match value {
            Value::Table(inner) => inner.get(segment)?,
            Value::Array(entries) => entries.get(segment.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(value)
}

/// Paths of all values below a table; `at` is its own path.
pub(crate) fn leaves(table: &toml::Table, at: &mut Vec<String>, found: &mut Vec<String>) {
    for (key, value) in table {
        at.push(key.clone());
        match value {
            Value::Table(inner) => leaves(inner, at, found),
            _ => found.push(join(at)),
        }
        at.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_split_and_join() {
        assert_eq!(split("a.b.c").unwrap(), ["a", "b", "c"]);
        assert_eq!(split("a.\"b.c\".'d'").unwrap(), ["a", "b.c", "d"]);
        assert_eq!(join(&split("a.\"b.c\".d").unwrap()), "a.\"b.c\".d");
        for bad in ["", ".", "a.", ".a", "a..b", "a.\"b", "a.\"b\"c"] {
            assert!(split(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn values_are_set_in_tables_and_arrays() {
        let mut table: toml::Table = toml::from_str("a.b = 1\nc = [1.0, 2.0]").unwrap();
        set(&mut table, &split("a.d.e").unwrap(), Value::Boolean(true)).unwrap();
        set(&mut table, &split("c.1").unwrap(), Value::Float(3.0)).unwrap();
        assert_eq!(get(&table, &split("a.d.e").unwrap()), Some(&Value::Boolean(true)));
        assert_eq!(get(&table, &split("c.1").unwrap()), Some(&Value::Float(3.0)));
        assert!(set(&mut table, &split("c.2").unwrap(), Value::Float(3.0)).is_err());
        assert!(set(&mut table, &split("a.b.x").unwrap(), Value::Float(3.0)).is_err());
    }
}
