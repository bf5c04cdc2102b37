//! The reference of all that a scene and a case can say, written from the types that read them.

use crate::root;
use anyhow::{Context, Result};
use quote::ToTokens;
use std::fmt::Write;
use syn::{Attribute, Fields, Item, Meta};
use xshell::Shell;

/// Where the types are, in the order of the reference.
const SOURCES: [&str; 25] = [
    "lib",
    "environment",
    "fibers",
    "groom",
    "arrangement",
    "material",
    "taper",
    "tip",
    "freedom",
    "load",
    "feed",
    "gripper",
    "motion",
    "object",
    "grip",
    "joint",
    "contact",
    "charging",
    "mass_spring",
    "stepper",
    "output",
    "case",
    "case_end",
    "case_contact",
    "asked",
];
/// Where the reference is.
pub(crate) const REFERENCE: &str = "docs/scene.md";

/// Writes the reference.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    Ok(sh.write_file(REFERENCE, text(&sh)?)?)
}

/// The reference as the types have it.
pub(crate) fn text(sh: &Shell) -> Result<String> {
    let mut text = String::from(
        "# What a scene and a case can say\n\nWritten by `cargo xtask reference` from the types that \
         read them; `cargo xtask tidy` fails where it is not. A field with a default may be left \
         out. `Option` may be left out too, and `Some` is not written.\n",
    );
    for source in SOURCES {
        let file = format!("crates/scene/src/{source}.rs");
        let parsed = syn::parse_file(&sh.read_file(&file)?);
        for item in &parsed.with_context(|| format!("{file} is no Rust"))?.items {
            text += &told(item);
        }
    }
    Ok(text)
}

/// What is told of a type that is read; nothing of any other item.
fn told(item: &Item) -> String {
    let mut text = String::new();
    match item {
        Item::Struct(own) if is_read(&own.attrs) => {
            text += &format!("\n## {}\n\n{}\n\n", own.ident, doc(&own.attrs));
            let all = serde(&own.attrs, "default").is_some();
            text += &fields(&own.fields, all, "");
        }
        Item::Enum(own) if is_read(&own.attrs) => {
            text += &format!("\n## {}\n\n{}\n\n", own.ident, doc(&own.attrs));
            for variant in &own.variants {
                let of = match &variant.fields {
                    Fields::Unnamed(own) => {
                        let types: Vec<_> = own.unnamed.iter().map(|f| kind(&f.ty)).collect();
                        format!("({})", types.join(", "))
                    }
                    Fields::Named(_) => "(...)".to_owned(),
                    Fields::Unit => String::new(),
                };
                let _ = writeln!(text, "- `{}{of}`: {}", variant.ident, doc(&variant.attrs));
                if let Fields::Named(_) = variant.fields {
                    text += &fields(&variant.fields, false, "  ");
                }
            }
        }
        _ => {}
    }
    text
}

/// A list of named fields, which may `all` have defaults.
fn fields(fields: &Fields, all: bool, indent: &str) -> String {
    let mut text = String::new();
    for field in fields {
        let Some(name) = &field.ident else { continue };
        let name = serde(&field.attrs, "rename").unwrap_or_else(|| name.to_string());
        let has = all || serde(&field.attrs, "default").is_some();
        let default = if has { ", has a default" } else { "" };
        let told = doc(&field.attrs);
        let _ = writeln!(text, "{indent}- `{name}`: `{}`{default}. {told}", kind(&field.ty));
    }
    text
}

/// A type as a user reads it.
fn kind(of: &syn::Type) -> String {
    of.to_token_stream().to_string().replace(' ', "").replace(',', ", ").replace(';', "; ")
}

/// The documentation of an item, in one line.
fn doc(attributes: &[Attribute]) -> String {
    let line = |attribute: &Attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    };
    let lines: Vec<_> = attributes.iter().filter_map(line).collect();
    lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ").trim().to_owned()
}

/// Whether a type is read from a text.
fn is_read(attributes: &[Attribute]) -> bool {
    let derives = |attribute: &Attribute| attribute.meta.to_token_stream().to_string();
    attributes.iter().any(|a| a.path().is_ident("derive") && derives(a).contains("Deserialize"))
}

/// A word that serde is told, with its value if it has one.
fn serde(attributes: &[Attribute], word: &str) -> Option<String> {
    let own = attributes.iter().filter(|a| a.path().is_ident("serde"));
    let mut found = None;
    for attribute in own {
        let _ = attribute.parse_nested_meta(|meta| {
            let value = match meta.value() {
                Ok(value) => value.parse::<syn::LitStr>()?.value(),
                Err(_) => String::new(),
            };
            if meta.path.is_ident(word) {
                found = Some(value);
            }
            Ok(())
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_told_with_their_names_types_and_defaults() {
        let source = "/// A hair.\n#[derive(Deserialize)]\npub struct Hair {\n/// Length, m.\n\
                      #[serde(default = \"long\", rename = \"len\")]\npub length: f64,\n}\n\
                      #[derive(Deserialize)]\n/// An end.\nenum End {\n/// Free.\nFree,\n/// Held at.\n\
                      At { /// Where, m.\nplace: [f64; 3] } }\nstruct Other;";
        let items = syn::parse_file(source).expect("Rust").items;
        let text: String = items.iter().map(told).collect();
        assert_eq!(
            text,
            "\n## Hair\n\nA hair.\n\n- `len`: `f64`, has a default. Length, m.\n\n## End\n\nAn end.\n\n\
             - `Free`: Free.\n- `At(...)`: Held at.\n  - `place`: `[f64; 3]`. Where, m.\n"
        );
    }
}
