//! Rules about names and modules, which take a look into the sources: a type has one definition in
//! the workspace, a numeric constant one value in a crate, and the files of a folder depend on each
//! other in one direction.

use anyhow::{Context, Result};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemConst, ItemMod, ItemUse, UseTree, Visibility};

/// Names that may be defined more than once: those of `#[derive]`s' kind, which name a role.
const SHARED: [&str; 1] = ["Error"];

/// A source file of a crate, without its tests.
#[derive(Debug)]
struct Module {
    file: String,
    /// Path of the module in its crate; empty for the root.
    path: Vec<String>,
    types: Vec<String>,
    /// Numeric constants: name and value.
    constants: Vec<(String, String)>,
    /// Modules declared in it.
    children: BTreeSet<String>,
    /// What names stand for: those brought in by `use`.
    imports: BTreeMap<String, Vec<String>>,
    /// Paths that it depends on.
    paths: Vec<Vec<String>>,
}

/// Checks all sources of the library and program crates: pairs of a path from the root of the
/// repository and a text.
///
/// # Errors
/// A file that cannot be parsed.
pub(crate) fn broken_structure(sources: &[(String, String)]) -> Result<Vec<String>> {
    let mut crates: BTreeMap<String, Vec<Module>> = BTreeMap::new();
    for (file, text) in sources {
        let Some((name, inside)) = file.split_once("/src/") else { continue };
        let is_test = inside.contains("tests/") || inside.ends_with("tests.rs");
        if !inside.ends_with(".rs") || is_test || !name.starts_with("crates/") {
            continue;
        }
        let module = Module::parse(file, inside, text)?;
        crates.entry(name.to_owned()).or_default().push(module);
    }
    let mut broken = twice_defined(crates.values().flatten());
    for modules in crates.values() {
        broken.extend(of_two_values(modules));
        broken.extend(circles(modules));
    }
    Ok(broken)
}

/// Types that are defined in more than one place.
fn twice_defined<'a>(modules: impl Iterator<Item = &'a Module>) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for module in modules {
        for name in &module.types {
            places.entry(name).or_default().push(&module.file);
        }
    }
    let twice = places.iter().filter(|(name, files)| files.len() > 1 && !SHARED.contains(name));
    twice.map(|(name, files)| format!("{name} is defined in {}", files.join(" and in "))).collect()
}

/// Numeric constants of a crate that have one name and two values.
fn of_two_values(modules: &[Module]) -> Vec<String> {
    let mut known: BTreeMap<&str, (&str, &str)> = BTreeMap::new();
    let mut broken = Vec::new();
    for module in modules {
        for (name, value) in &module.constants {
            let (other, file) = known.entry(name).or_insert((value, &module.file));
            if other != value {
                let here = &module.file;
                broken.push(format!("{name} is {value} in {here} and {other} in {file}"));
            }
        }
    }
    broken
}

/// Circles among the files and subfolders of each folder of a crate.
fn circles(modules: &[Module]) -> Vec<String> {
    let known: BTreeMap<&[String], &Module> = modules.iter().map(|m| (&m.path[..], m)).collect();
    let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for module in modules {
        let targets = module.paths.iter().filter_map(|path| resolved(&known, module, path, 0));
        edges.entry(&module.file).or_default().extend(targets);
    }
    // Within a folder a subfolder is one thing.
    let mut folders: BTreeMap<&str, BTreeMap<&str, BTreeSet<&str>>> = BTreeMap::new();
    for (from, targets) in &edges {
        for to in targets {
            let shared = from.bytes().zip(to.bytes()).take_while(|(a, b)| a == b).count();
            let Some(end) = from[..shared].rfind('/') else { continue };
            let entry =
                |file: &'_ str| file[end + 1..].find('/').map_or(file.len(), |n| end + 1 + n);
            let (a, b) = (&from[..entry(from)], &to[..entry(to)]);
            if a != b {
                folders.entry(&from[..end]).or_default().entry(a).or_default().insert(b);
            }
        }
    }
    let circles = folders.values().flat_map(components);
    circles.map(|files| format!("a circle of modules: {}", files.join(", "))).collect()
}

/// Sets of more than one thing each of which reaches all others.
fn components<'a>(edges: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> Vec<Vec<&'a str>> {
    let reached = |from: &'a str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(next) = open.pop() {
            for to in edges.get(next).into_iter().flatten() {
                if seen.insert(*to) {
                    open.push(to);
                }
            }
        }
        seen
    };
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        edges.keys().map(|from| (*from, reached(from))).collect();
    let mut found = BTreeSet::new();
    for (from, to) in &reach {
        let back = |other: &&&'a str| reach.get(*other).is_some_and(|r| r.contains(from));
        let mut circle: Vec<&str> = to.iter().filter(back).copied().collect();
        circle.sort_unstable();
        if circle.len() > 1 {
            found.insert(circle);
        }
    }
    found.into_iter().collect()
}

/// The file in which the thing at a path is defined, as seen from a module; `None` if that is
/// elsewhere.
fn resolved<'a>(
    known: &BTreeMap<&[String], &'a Module>,
    from: &Module,
    path: &[String],
    depth: usize,
) -> Option<&'a str> {
    let mut here = from.path.clone();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => {
            here.clear();
            rest = &path[1..];
        }
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                here.pop()?;
                rest = &rest[1..];
            }
        }
        first => {
            if !from.children.contains(first) {
                return None;
            }
        }
    }
    loop {
        let module = *known.get(&here[..])?;
        let Some(name) = rest.first() else { return Some(&module.file) };
        let below = [&here[..], std::slice::from_ref(name)].concat();
        if module.children.contains(name) && known.contains_key(&below[..]) {
            here = below;
            rest = &rest[1..];
            continue;
        }
        // A name that the module passes on is defined where it comes from.
        return match module.imports.get(name) {
            Some(other) if depth < 8 => resolved(known, module, other, depth + 1),
            _ => Some(&module.file),
        };
    }
}

impl Module {
    fn parse(file: &str, inside: &str, text: &str) -> Result<Self> {
        let parsed = syn::parse_file(text).with_context(|| format!("{file} is no Rust"))?;
        let parts = inside.trim_end_matches(".rs").split('/').map(str::to_owned);
        let mut path: Vec<String> = parts.collect();
        if path.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
            path.pop();
        }
        let mut module = Self {
            file: file.to_owned(),
            path,
            types: Vec::new(),
            constants: Vec::new(),
            children: BTreeSet::new(),
            imports: BTreeMap::new(),
            paths: Vec::new(),
        };
        module.visit_file(&parsed);
        Ok(module)
    }

    fn take_use(&mut self, prefix: &[String], tree: &UseTree, passed_on: bool) {
        let with = |name: &dyn ToString| [prefix, &[name.to_string()]].concat();
        match tree {
            UseTree::Path(path) => self.take_use(&with(&path.ident), &path.tree, passed_on),
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.take_use(prefix, tree, passed_on));
            }
            UseTree::Name(name) if name.ident == "self" => {
                self.take_import(prefix.to_vec(), None, passed_on);
            }
            UseTree::Name(name) => self.take_import(with(&name.ident), None, passed_on),
            UseTree::Rename(name) => {
                self.take_import(with(&name.ident), Some(name.rename.to_string()), passed_on);
            }
            UseTree::Glob(_) => self.paths.push(prefix.to_vec()),
        }
    }

    fn take_import(&mut self, path: Vec<String>, alias: Option<String>, passed_on: bool) {
        let name = alias.or_else(|| path.last().cloned()).unwrap_or_default();
        if !passed_on {
            self.paths.push(path.clone());
        }
        self.imports.insert(name, path);
    }
}

/// Whether something is only there in tests.
fn is_test(attributes: &[Attribute]) -> bool {
    let is = |attribute: &Attribute| {
        let words = attribute.meta.to_token_stream().to_string();
        attribute.path().is_ident("cfg")
            && words.split(|c: char| !c.is_alphanumeric()).any(|w| w == "test")
    };
    attributes.iter().any(is)
}

impl Visit<'_> for Module {
    fn visit_item(&mut self, item: &Item) {
        match item {
            Item::Struct(own) => self.types.push(own.ident.to_string()),
            Item::Enum(own) => self.types.push(own.ident.to_string()),
            Item::Trait(own) => self.types.push(own.ident.to_string()),
            Item::Type(own) => self.types.push(own.ident.to_string()),
            _ => {}
        }
        visit::visit_item(self, item);
    }

    fn visit_item_mod(&mut self, own: &ItemMod) {
        if is_test(&own.attrs) {
            return;
        }
        if own.content.is_none() {
            self.children.insert(own.ident.to_string());
        }
        visit::visit_item_mod(self, own);
    }

    fn visit_item_const(&mut self, own: &ItemConst) {
        let text = |tokens: &dyn ToTokens| tokens.to_token_stream().to_string();
        const NUMBERS: [&str; 8] = ["f64", "f32", "usize", "u64", "u32", "i32", "u8", "i64"];
        if NUMBERS.contains(&text(&own.ty).as_str()) && own.ident != "_" {
            self.constants.push((own.ident.to_string(), text(&own.expr)));
        }
        visit::visit_item_const(self, own);
    }

    fn visit_item_use(&mut self, own: &ItemUse) {
        if !is_test(&own.attrs) {
            let passed_on = !matches!(own.vis, Visibility::Inherited);
            self.take_use(&[], &own.tree, passed_on);
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let parts: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if parts.len() > 1 {
            self.paths.push(parts);
        }
        visit::visit_path(self, path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(sources: &[(&str, &str)]) -> Vec<String> {
        let sources: Vec<_> =
            sources.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
        broken_structure(&sources).expect("they are Rust")
    }

    #[test]
    fn a_second_definition_is_found_and_tests_may_have_their_own() {
        let one = ("crates/a/src/lib.rs", "pub struct Load; pub enum Error {}");
        let tests = ("crates/b/src/lib.rs", "#[cfg(test)] mod tests { struct Load; }");
        assert_eq!(broken(&[one, tests]), [""; 0]);
        let two = ("crates/b/src/x.rs", "trait Load {} enum Error {}");
        assert_eq!(
            broken(&[one, two]),
            ["Load is defined in crates/a/src/lib.rs and in crates/b/src/x.rs"]
        );
    }

    #[test]
    fn a_constant_has_one_value_in_a_crate() {
        let one = ("crates/a/src/lib.rs", "const MOST: usize = 8;");
        let same = ("crates/a/src/b.rs", "const MOST: usize = 8;");
        let elsewhere = ("crates/b/src/lib.rs", "const MOST: usize = 9;");
        assert_eq!(broken(&[one, same, elsewhere]), [""; 0]);
        let other = ("crates/a/src/c.rs", "const MOST: usize = 9;");
        assert_eq!(broken(&[one, other]).len(), 1);
    }

    #[test]
    fn a_circle_is_found_also_through_what_is_passed_on() {
        let root =
            ("crates/a/src/lib.rs", "mod b; mod c; pub use b::B; pub use c::{self as d, C};");
        let b = ("crates/a/src/b.rs", "use crate::C; pub struct B;");
        let c = ("crates/a/src/c.rs", "pub struct C;");
        assert_eq!(broken(&[root, b, c]), [""; 0]);
        for back in ["use super::b::B; pub struct C;", "pub struct C(crate::B);"] {
            let found = broken(&[root, b, ("crates/a/src/c.rs", back)]);
            assert_eq!(found, ["a circle of modules: crates/a/src/b.rs, crates/a/src/c.rs"]);
        }
        let child = ("crates/a/src/b/mod.rs", "mod e; pub struct B(e::E);");
        let parent = ("crates/a/src/b/e.rs", "use super::B; pub struct E;");
        assert_eq!(broken(&[root, child, parent, c]).len(), 1);
    }
}
