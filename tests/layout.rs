//! The imports between modules are those of the table in `lib.rs`, and that table has no cycle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

type Imports = BTreeMap<String, BTreeSet<String>>;

fn source() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The table of `lib.rs`: lines `module : imported imported`.
fn table() -> Imports {
    let text = fs::read_to_string(source().join("lib.rs")).unwrap();
    let begin = text.find("# Who may import whom").expect("the table's heading");
    let rows = text[begin..].lines().filter_map(|line| line.strip_prefix("//! ")?.split_once(" :"));
    rows.map(|(module, imports)| (module.trim().to_owned(), imports.split_whitespace().map(str::to_owned).collect()))
        .collect()
}

/// Names after `crate::` in all files of a module.
fn imports(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            imports(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            for line in code {
                for after in line.split("crate::").skip(1) {
                    let name: String = after.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                    found.insert(name);
                }
            }
        }
    }
}

#[test]
fn imports_are_those_of_the_table() {
    let table = table();
    let mut modules = BTreeSet::new();
    for entry in fs::read_dir(source()).unwrap() {
        let path = entry.unwrap().path();
        if !path.is_dir() {
            continue;
        }
        let module = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut found = BTreeSet::new();
        imports(&path, &mut found);
        found.remove(&module);
        let allowed = table.get(&module).unwrap_or_else(|| panic!("`{module}` is not in the table of lib.rs"));
        assert_eq!(&found, allowed, "imports of `{module}` (left) are not those of the table in lib.rs (right)");
        modules.insert(module);
    }
    assert_eq!(modules, table.into_keys().collect(), "modules of the table");
}

#[test]
fn the_table_has_no_cycle() {
    let mut left = table();
    while !left.is_empty() {
        let free: Vec<String> = left.iter().filter(|(_, on)| on.is_empty()).map(|(module, _)| module.clone()).collect();
        assert!(!free.is_empty(), "a cycle among {:?}", left.keys());
        for module in free {
            left.remove(&module);
            for on in left.values_mut() {
                on.remove(&module);
            }
        }
    }
}
