//! The imports between modules are those of the table in `lib.rs`, and that table has no cycle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

type Imports = BTreeMap<String, BTreeSet<String>>;

fn source() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Folders of the packages below, whose modules stand in the same table.
fn below() -> [std::path::PathBuf; 4] {
    ["core", "ground", "numerics", "tables"].map(|package| source().join(package))
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
    for entry in below().into_iter().chain([source()]).flat_map(|folder| fs::read_dir(folder).unwrap()) {
        let path = entry.unwrap().path();
        // Files that are compiled in are no module.
        if !path.join("mod.rs").exists() {
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

/// Who imports whom among the files of `src`: paths such as `structure/import/read.rs`.
struct Files {
    /// File of every module, by its path of names.
    modules: BTreeMap<Vec<String>, String>,
    /// Code of every file, without comments and tests.
    code: BTreeMap<String, String>,
    /// What a module hands on: its `pub use`, by the last name.
    handed_on: BTreeMap<Vec<String>, BTreeMap<String, Vec<String>>>,
}

impl Files {
    fn read() -> Self {
        let mut files = Self { modules: BTreeMap::new(), code: BTreeMap::new(), handed_on: BTreeMap::new() };
        files.add(&source(), &[]);
        for (module, file) in &files.modules {
            let uses = use_paths(&files.code[file]).into_iter().filter(|(public, _)| *public);
            let named = uses.filter_map(|(_, path)| Some((path.last()?.clone(), files.absolute(module, &path))));
            files.handed_on.insert(module.clone(), named.collect());
        }
        files
    }

    fn add(&mut self, folder: &Path, module: &[String]) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            let mut own = module.to_vec();
            if !matches!(stem.as_str(), "mod" | "lib") && !below().contains(&path) {
                own.push(stem);
            }
            if path.is_dir() {
                self.add(&path, &own);
            } else if path.extension().is_some_and(|extension| extension == "rs")
                && !path.ends_with("main.rs")
                && below().iter().all(|package| path != package.join("lib.rs"))
            {
                let text = fs::read_to_string(&path).unwrap();
                let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
                let code: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
                let name = path.strip_prefix(source()).unwrap().to_string_lossy().into_owned();
                self.code.insert(name.clone(), code.join("\n"));
                self.modules.insert(own, name);
            }
        }
    }

    /// A path as written in a module, from the root of the crate on; names of other crates stay as they are.
    fn absolute(&self, module: &[String], path: &[String]) -> Vec<String> {
        let mut from = module.to_vec();
        let mut names = path.iter().peekable();
        match names.peek().map(|name| name.as_str()) {
            Some("crate") => from.clear(),
            Some("self" | "super") => {}
            Some(child) if self.modules.contains_key(&[module, &[child.to_owned()]].concat()) => {}
            _ => return vec!["::".to_owned()],
        }
        for name in names {
            match name.as_str() {
                "crate" | "self" => {}
                "super" => drop(from.pop()),
                name => from.push(name.to_owned()),
            }
        }
        from
    }

    /// The file that defines what a path from the root names.
    fn definer(&self, path: &[String]) -> Option<&String> {
        let depth = (1..=path.len()).rev().find(|depth| self.modules.contains_key(&path[..*depth]))?;
        let module = &path[..depth];
        match path.get(depth).and_then(|item| self.handed_on[module].get(item)) {
            Some(further) => self.definer(further),
            None => self.modules.get(module),
        }
    }

    /// Files that a file imports from, or names by a path in its code.
    fn imports(&self, module: &[String]) -> BTreeSet<String> {
        let file = &self.modules[module];
        let code = &self.code[file];
        let mut paths: Vec<Vec<String>> = Vec::new();
        let body: String = statements(code).filter(|text| use_of(text).is_none() && !declares(text)).collect();
        // Where an item may be seen from is no import.
        let body = body.replace("(in crate", "(in ");
        for (public, path) in use_paths(code) {
            let named = |name: &String| words(&body).any(|word| word == name);
            // What is handed on is imported only where the module names it itself.
            if !public || path.last().is_some_and(named) {
                paths.push(path);
            }
        }
        paths.extend(inline_paths(&body));
        let files = paths.iter().filter_map(|path| self.definer(&self.absolute(module, path)));
        files.filter(|other| *other != file).cloned().collect()
    }
}

/// Code cut after every `;`, `{` and `}` but for those of a `use`.
fn statements(code: &str) -> impl Iterator<Item = &str> {
    let mut rest = code;
    std::iter::from_fn(move || {
        let is_use = use_of(rest).is_some();
        let end = rest.find(|c| c == ';' || (!is_use && (c == '{' || c == '}'))).map_or(rest.len(), |at| at + 1);
        let (statement, after) = rest.split_at(end);
        rest = after;
        (!statement.is_empty()).then_some(statement)
    })
}

/// Whether a statement is `mod name;`.
fn declares(statement: &str) -> bool {
    let mut words = statement.trim().trim_end_matches(';').split(' ').skip_while(|word| word.starts_with("pub"));
    words.next() == Some("mod") && words.count() == 1
}

/// Whether a statement is a public `use`, and its tree; `None` if it is none.
fn use_of(statement: &str) -> Option<(bool, &str)> {
    let text = statement.trim_start();
    let public = text.starts_with("pub");
    let text = if public { text.trim_start_matches(|c| c != ' ').trim_start() } else { text };
    // `pub(in a::b) use` has a blank inside its brackets.
    let text = text.split_once(") ").filter(|(scope, _)| !scope.contains(' ')).map_or(text, |(_, after)| after);
    text.strip_prefix("use ").map(|tree| (public, tree))
}

/// All paths of the `use` statements, and whether each is public.
fn use_paths(code: &str) -> Vec<(bool, Vec<String>)> {
    let uses = statements(code).filter_map(use_of);
    uses.flat_map(|(public, tree)| branches(tree.trim_end_matches(';')).into_iter().map(move |path| (public, path)))
        .collect()
}

/// The paths of a tree such as `a::{b, c::d}`.
fn branches(tree: &str) -> Vec<Vec<String>> {
    let tree = tree.trim();
    let Some((stem, inner)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        return vec![path.split("::").map(|name| name.trim().to_owned()).collect()];
    };
    let stem: Vec<String> = stem.split("::").map(|name| name.trim().to_owned()).filter(|n| !n.is_empty()).collect();
    let inner = &inner[..inner.rfind('}').unwrap_or(inner.len())];
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inner.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().unwrap().push(c),
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| branches(part)).map(|path| [stem.clone(), path].concat()).collect()
}

fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !(c.is_alphanumeric() || c == '_'))
}

/// Paths in code, `a::b::c`, each as far as it has names.
fn inline_paths(code: &str) -> Vec<Vec<String>> {
    let tokens = code.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    let paths = tokens.map(|token| token.trim_end_matches("::")).filter(|token| token.contains("::"));
    paths.map(|path| path.split("::").map(str::to_owned).collect()).collect()
}

#[test]
fn no_files_of_a_room_import_each_other_in_a_circle() {
    let files = Files::read();
    let imports: Imports = files.modules.iter().map(|(module, file)| (file.clone(), files.imports(module))).collect();
    let reaches_itself = |file: &String| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![file]);
        while let Some(file) = next.pop() {
            next.extend(imports[file].iter().filter(|other| reached.insert(*other)));
        }
        reached.contains(file)
    };
    let circles = imports.keys().filter(|file| *file != "lib.rs" && reaches_itself(file));
    let circles: Vec<&String> = circles.collect();
    assert!(circles.is_empty(), "files that import themselves by way of others: {circles:#?}");
}
