use crate::reference::{self, REFERENCE};
use crate::root;
use crate::structure::broken_structure;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use xshell::{Shell, cmd};

/// What each crate may depend on within the workspace: the arrows of ARCHITECTURE.md, which run
/// down only; `*` stands for all crates in the lines above. A new crate gets its line here and a
/// place there.
const ARROWS: [(&str, &[&str]); 26] = [
    ("fiber", &[]),
    ("lanes", &[]),
    ("linalg", &[]),
    ("plot", &[]),
    // For examples and for tests only, wherever an arrow runs to them.
    ("repro", &["plot"]),
    ("oracles", &[]),
    // The rods are for its tests only, which put simulated hairs into its instruments.
    ("keratin", &["fiber", "rod-static", "rod-dynamic", "repro"]),
    ("rod-static", &["fiber", "oracles", "repro"]),
    ("rod-dynamic", &["fiber", "lanes", "linalg", "rod-static", "oracles"]),
    ("scattering", &["fiber", "oracles"]),
    ("render", &["fiber", "lanes", "scattering", "repro"]),
    ("collision", &["fiber", "lanes", "oracles", "repro"]),
    ("contact", &["fiber", "lanes", "collision", "oracles"]),
    ("electrostatics", &["fiber", "lanes", "collision"]),
    // The fibres are for its tests only.
    ("export", &["fiber", "collision"]),
    ("studio", &["fiber", "collision", "export", "render", "scattering"]),
    ("mass-spring", &["fiber", "linalg", "collision", "oracles"]),
    ("hairgen", &["fiber", "linalg", "collision", "rod-static", "oracles", "repro"]),
    (
        "scene",
        &["fiber", "hairgen", "keratin", "rod-dynamic", "electrostatics", "mass-spring", "export"],
    ),
    (
        "coupling",
        &["fiber", "lanes", "linalg", "keratin", "rod-dynamic", "collision", "contact", "scene"],
    ),
    (
        "charging",
        &["fiber", "keratin", "rod-static", "rod-dynamic", "collision", "electrostatics", "scene"],
    ),
    // The writers are for its tests only.
    ("strands", &["collision", "export", "oracles"]),
    ("sim", &["*"]),
    ("view", &["export", "render", "scene", "studio", "sim"]),
    ("rapunzel", &["*"]),
    ("xtask", &["*"]),
];

/// Widest comment, characters; rustfmt sees to the code.
const WIDEST: usize = 100;

/// Longest source file, lines.
const LONGEST: usize = 400;

/// Checks the house rules that no other tool checks, and lists all that is broken.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    let metadata =
        cmd!(sh, "cargo metadata --locked --no-deps --format-version 1").quiet().read()?;
    let mut broken = Vec::new();
    for package in packages(&serde_json::from_str(&metadata)?)? {
        broken.extend(package.broken_rules());
        let text = sh.read_file(&package.manifest)?;
        broken.extend(lints_missing(&package.name, &text));
        let folder = package.manifest.trim_end_matches("Cargo.toml");
        if package.name != "xtask" && !sh.path_exists(format!("{folder}README.md")) {
            broken.push(format!("{}: write a README.md of 5 to 15 lines", package.name));
        }
    }
    let mut sources = Vec::new();
    for file in
        cmd!(sh, "git ls-files --cached --others --exclude-standard").quiet().read()?.lines()
    {
        // What is no text, and what is deleted but not yet committed, has no lines to check.
        if let Ok(text) = sh.read_file(file) {
            broken.extend(broken_lines(file, &text));
            sources.push((file.to_owned(), text));
        }
    }
    broken.extend(broken_structure(&sources)?);
    if sh.read_file(REFERENCE).ok() != Some(reference::text(&sh)?) {
        broken.push(format!("{REFERENCE} is not what the types say: run cargo xtask reference"));
    }
    if broken.is_empty() {
        return Ok(());
    }
    bail!("the house rules are broken:\n  {}", broken.join("\n  "))
}

/// A crate of the workspace as `cargo metadata` tells it.
struct Package {
    name: String,
    manifest: String,
    /// Crates of the workspace that it depends on, also for tests.
    depends_on: Vec<String>,
}

fn packages(metadata: &Value) -> Result<Vec<Package>> {
    let list = |value: &Value| value.as_array().cloned().context("not what cargo metadata prints");
    let text = |value: &Value| value.as_str().map(str::to_owned).context("no text");
    let package = |p: &Value| {
        let dependencies = list(&p["dependencies"])?;
        let own = dependencies.iter().filter(|d| d["path"].is_string());
        Ok(Package {
            name: text(&p["name"])?,
            manifest: text(&p["manifest_path"])?,
            depends_on: own.map(|d| text(&d["name"])).collect::<Result<_>>()?,
        })
    };
    list(&metadata["packages"])?.iter().map(package).collect()
}

impl Package {
    /// Names and arrows.
    fn broken_rules(&self) -> Vec<String> {
        let name = &self.name;
        let short = |name: &str| name.trim_start_matches("rapunzel-").to_owned();
        let folder = self.manifest.rsplit(['/', '\\']).nth(1).unwrap_or_default();
        let expected = match folder {
            "rapunzel" | "xtask" => folder.to_owned(),
            _ => format!("rapunzel-{folder}"),
        };
        let mut broken = Vec::new();
        if *name != expected {
            broken.push(format!("{name}: the crate in {folder}/ is called {expected}"));
        }
        let line = |name: &str| ARROWS.iter().position(|(of, _)| *of == name);
        let Some(own) = line(&short(name)) else {
            broken.push(format!("{name}: give it a line in ARROWS (xtask) and ARCHITECTURE.md"));
            return broken;
        };
        let allowed = ARROWS[own].1;
        for other in self.depends_on.iter().map(|d| short(d)) {
            let above = allowed.contains(&"*") && line(&other).is_some_and(|l| l < own);
            // A crate may ask for its own features in its tests.
            let itself = other == short(name);
            if !itself && !above && !allowed.contains(&other.as_str()) {
                broken
                    .push(format!("{name}: no arrow runs to {other}; turn it round or move code"));
            }
        }
        broken
    }
}

/// A crate without the lints of the workspace.
fn lints_missing(name: &str, manifest: &str) -> Option<String> {
    let has = manifest.split("\n[").any(|section| {
        section.starts_with("lints]")
            && section.lines().any(|line| line.trim() == "workspace = true")
    });
    (!has).then(|| format!("{name}: write [lints] workspace = true into its Cargo.toml"))
}

/// A file that is too long, a library that looks at a clock, a module of another crate, and
/// absolute paths.
fn broken_lines(file: &str, text: &str) -> Vec<String> {
    let mut broken = Vec::new();
    let lines = text.lines().count();
    let source = file.ends_with(".rs") || file.ends_with(".py");
    if source && lines > LONGEST {
        broken.push(format!("{file}: {lines} lines; which two things is it?"));
    }
    // The live page has to follow the clock on the wall.
    let of = |name: &str| file.starts_with(&format!("crates/{name}/"));
    let timeless = source && file.starts_with("crates/") && !of("rapunzel") && !of("view");
    for (number, line) in text.lines().enumerate() {
        if timeless && file.contains("/src/") && line.contains("Instant::now") {
            broken.push(format!("{file}:{}: only the program looks at a clock", number + 1));
        }
        if source && let Some(path) = foreign_module(file, line) {
            broken
                .push(format!("{file}:{}: {path} is of another crate; make one of it", number + 1));
        }
        let comment = source && line.trim_start().starts_with("//");
        if comment && line.chars().count() > WIDEST {
            broken.push(format!("{file}:{}: a comment wider than {WIDEST}", number + 1));
        }
        // Those of a stage are names of prims.
        if !file.ends_with(".usda")
            && let Some(path) = absolute_path(line)
        {
            broken.push(format!("{file}:{}: absolute path {path}", number + 1));
        }
    }
    broken
}

/// The path of a module's file that leads out of the crate of `file`.
fn foreign_module<'a>(file: &str, line: &'a str) -> Option<&'a str> {
    let attribute = line.trim_start();
    let (_, path) = attribute.starts_with("#[").then(|| attribute.split_once("path = \""))??;
    let path = path.split('"').next()?;
    // How many folders the file is below that of its crate.
    let crates = if file.starts_with("crates/") { 2 } else { 1 };
    let mut depth = file.matches('/').count().checked_sub(crates)?;
    for part in path.split('/') {
        match part {
            ".." if depth == 0 => return Some(path),
            ".." => depth -= 1,
            "." => {}
            _ => depth += 1,
        }
    }
    path.starts_with('/').then_some(path)
}

/// A folder of somebody's own machine, named from the root.
fn absolute_path(line: &str) -> Option<&str> {
    ["home", "root", "work", "Users", "tmp"].into_iter().find_map(|top| {
        let start = line.find(&format!("/{top}/"))?;
        // Inside of an address or a relative path it is not absolute.
        let before = line[..start].chars().next_back();
        let inside = before.is_some_and(|c| c.is_alphanumeric() || "./_-}*".contains(c));
        let end = line[start..].find([' ', '"', '\'', ')', '`']).map_or(line.len(), |n| start + n);
        (!inside).then(|| &line[start..end])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn package(folder: &str, name: &str, depends_on: &[&str]) -> Package {
        let dependencies: Vec<Value> = depends_on
            .iter()
            .map(|d| json!({ "name": d, "path": "somewhere", "kind": null }))
            .chain([json!({ "name": "nalgebra", "kind": null })])
            .collect();
        let manifest = format!("crates/{folder}/Cargo.toml");
        let metadata = json!({ "packages": [
            { "name": name, "manifest_path": manifest, "dependencies": dependencies },
        ] });
        packages(&metadata).expect("metadata").remove(0)
    }

    #[test]
    fn arrows_run_down_only() {
        let good =
            package("contact", "rapunzel-contact", &["rapunzel-collision", "rapunzel-fiber"]);
        assert!(good.broken_rules().is_empty());
        let up = package("fiber", "rapunzel-fiber", &["rapunzel-sim"]).broken_rules();
        assert_eq!(up, ["rapunzel-fiber: no arrow runs to sim; turn it round or move code"]);
        let across = package("contact", "rapunzel-contact", &["rapunzel-rod-dynamic"]);
        assert_eq!(across.broken_rules().len(), 1);
        let program = package("rapunzel", "rapunzel", &["rapunzel-sim", "rapunzel-fiber"]);
        assert!(program.broken_rules().is_empty());
        assert_eq!(package("sim", "rapunzel-sim", &["rapunzel"]).broken_rules().len(), 1);
    }

    #[test]
    fn crates_are_called_after_their_folders() {
        let wrong = package("collision", "collision", &[]).broken_rules();
        assert_eq!(wrong, ["collision: the crate in collision/ is called rapunzel-collision"]);
        let unknown = package("misc", "rapunzel-misc", &[]).broken_rules();
        assert!(unknown[0].contains("give it a line"), "{unknown:?}");
    }

    #[test]
    fn every_crate_takes_the_lints() {
        assert_eq!(
            lints_missing("a", "[package]\nname = \"a\"\n\n[lints]\nworkspace = true\n"),
            None
        );
        assert!(lints_missing("a", "[package]\nversion.workspace = true\n").is_some());
        assert!(lints_missing("a", "[lints]\n\n[package.x]\nworkspace = true\n").is_some());
    }

    #[test]
    fn long_files_clocks_and_paths_out_of_a_crate_are_found() {
        let clock = ["let start = Instant", "now();"].join("::");
        assert_eq!(broken_lines("crates/sim/src/a.rs", &clock).len(), 1);
        assert_eq!(broken_lines("crates/rapunzel/src/a.rs", &clock), [""; 0]);
        assert_eq!(broken_lines("crates/sim/tests/a.rs", &clock), [""; 0]);
        assert_eq!(broken_lines("a.rs", &"x\n".repeat(LONGEST)), [""; 0]);
        assert_eq!(broken_lines("a.rs", &"x\n".repeat(LONGEST + 1)).len(), 1);
        assert_eq!(broken_lines("data.csv", &"x\n".repeat(LONGEST + 1)), [""; 0]);
        let bad = ["", "home", "me", "scene.ron"].join("/");
        assert_eq!(
            broken_lines("b.md", &format!("fine\nsee `{bad}` there")),
            [format!("b.md:2: absolute path {bad}")]
        );
        for (path, foreign) in [
            ("../../../sim/examples/a.rs", 1),
            ("../../tests/a.rs", 0),
            ("b/../../../../sim/a.rs", 1),
        ] {
            let planted = format!("#[path = \"{path}\"]\nmod a;");
            let broken = broken_lines("crates/keratin/examples/ch2/main.rs", &planted);
            assert_eq!(broken.len(), foreign, "{broken:?}");
        }
        let wide = format!("// {}", "x ".repeat(WIDEST / 2));
        assert_eq!(broken_lines("a.rs", &wide).len(), 1);
        let address = ["https://example.org", "home", "x"].join("/");
        assert_eq!(broken_lines("b.md", &address), [""; 0]);
    }
}
