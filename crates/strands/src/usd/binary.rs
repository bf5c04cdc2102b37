//! Layers in the binary form, `.usdc`, of versions 0.4 to 0.12 ("crate files").
//!
//! The file is a table of parts: strings, the tree of paths, and for each path (a "spec") a list of
//! fields, whose values lie anywhere and are read when they are wanted. Nothing is believed: every
//! index is looked up, and no memory is taken beyond what the bytes can unpack to.

use super::layer::{UsdAttribute, UsdLayer, UsdValue, is_kept};
use super::marks::NAME;
use super::packed::{integers, unpacked};
use super::rep::{Rep, TIME_SAMPLES, Values};
use crate::StrandsError;
use crate::bytes::ByteReader;
use std::collections::BTreeMap;

/// Kinds of specs that are looked at.
const ATTRIBUTE: u32 = 1;
const PRIM: u32 = 6;

/// Index that ends a list of fields.
const END: u32 = u32::MAX;

/// Most fields of a spec; there are a dozen.
const MOST_FIELDS: usize = 1000;

/// Reads a layer; of samples those around `time`, or the first.
pub(super) fn read(bytes: &[u8], time: Option<f64>) -> Result<UsdLayer, StrandsError> {
    let mut file = Crate::open(bytes)?;
    let mut layer = UsdLayer::default();
    for (key, rep) in file.fields(file.root)? {
        if ["metersPerUnit", "upAxis", "subLayers"].contains(&key) {
            layer.take_metadata(key, &file.values.value(rep)?);
        }
    }
    // Prims still to be read, the next one last.
    let mut open = file.children(file.root, None)?;
    while let Some(node) = open.pop() {
        let prim = file.prim(&node, time, &mut layer)?;
        open.extend(file.children(node.path, Some(prim))?);
    }
    Ok(layer)
}

/// A prim that is still to be read.
struct PrimNode {
    path: u32,
    /// Token of its name.
    name: u32,
    /// Index of its parent in the layer.
    parent: Option<usize>,
}

/// A file whose tables have been read.
struct Crate<'a> {
    values: Values<'a>,
    /// Token and value of every field.
    fields: Vec<(u32, Rep)>,
    /// Lists of fields, each with an end.
    lists: Vec<u32>,
    /// Path of the root of all.
    root: u32,
    /// Kind of each path that has a spec, and the start of its list of fields.
    specs: BTreeMap<u32, (u32, u32)>,
    /// Paths of prims by their parent and the token of their name.
    prims: BTreeMap<(u32, u32), u32>,
    /// Paths of properties, with the token of their name, by their parent.
    properties: BTreeMap<u32, Vec<(u32, u32)>>,
}

impl<'a> Crate<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, StrandsError> {
        let mut head = ByteReader::new(NAME, bytes);
        head.take("mark", 1, super::marks::BINARY_MARK.len())?;
        let [major, minor, ..] = head.array::<8>("version")?;
        if major != 0 || !(4..=12).contains(&minor) {
            let problem = format!("its version is {major}.{minor}, but 0.4 to 0.12 are read");
            return Err(head.refuse(problem));
        }
        let mut table = head.seek(head.clone().u64("place of the table of sections")?)?;
        let count = table.u64("number of sections")?;
        let sections = table.take("table of sections", count, 32)?;
        let section = |name: &str| {
            let mut all = sections.as_chunks::<32>().0.iter();
            let is_it = |s: &&[u8; 32]| s[..16].split(|&b| b == 0).next() == Some(name.as_bytes());
            let place = all.find(is_it).and_then(|s| s[16..].first_chunk::<8>());
            let place = place.ok_or_else(|| head.refuse(format!("there is no section {name}")))?;
            head.seek(u64::from_le_bytes(*place))
        };

        let mut at = section("TOKENS")?;
        let count = at.u64("number of tokens")?;
        let size = at.u64("size of the tokens")?;
        let text = unpacked(&mut at, size)?;
        let tokens: Vec<_> = text.split(|&byte| byte == 0).map(lossy).collect();
        // Behind the last end there is an empty one more.
        if tokens.len() as u64 != count + 1 && count != 0 {
            return Err(at.refuse(format!("{count} tokens are told of, but others are there")));
        }

        let mut at = section("STRINGS")?;
        let count = at.u64("number of strings")?;
        let strings = at.take("strings", count, 4)?.as_chunks().0;
        let strings = strings.iter().map(|&four| u32::from_le_bytes(four)).collect();

        let mut at = section("FIELDS")?;
        let count = at.u64("number of fields")?;
        let names = integers(&mut at, count)?;
        let reps = unpacked(&mut at, count.saturating_mul(8))?;
        let reps = reps.as_chunks().0.iter().map(|&eight| Rep(u64::from_le_bytes(eight)));
        let fields: Vec<_> = names.into_iter().zip(reps).collect();
        if fields.len() as u64 != count {
            return Err(at.refuse("the values of its fields are not as many as their names"));
        }

        let mut at = section("FIELDSETS")?;
        let count = at.u64("number of lists of fields")?;
        let lists = integers(&mut at, count)?;

        let mut at = section("SPECS")?;
        let count = at.u64("number of specs")?;
        let [paths, starts, kinds] =
            [integers(&mut at, count)?, integers(&mut at, count)?, integers(&mut at, count)?];
        let specs = paths.into_iter().zip(kinds.into_iter().zip(starts)).collect();

        let at = section("PATHS")?;
        let values = Values { bytes: head, minor, tokens, strings };
        let (root, prims, properties) = (0, BTreeMap::new(), BTreeMap::new());
        let mut file = Self { values, fields, lists, root, specs, prims, properties };
        file.read_paths(at)?;
        Ok(file)
    }

    /// Reads the tree of paths: of every node the index of its path, the token of its name
    /// (negative for properties), and where its sibling is. A node is followed by its first child;
    /// `jump` is the distance to the sibling, 0 if that is next for want of children, -1 if there
    /// are children alone, -2 if there is neither.
    fn read_paths(&mut self, mut at: ByteReader<'_>) -> Result<(), StrandsError> {
        at.u64("number of paths")?;
        let count = at.u64("number of nodes of paths")?;
        let [paths, names, jumps] =
            [integers(&mut at, count)?, integers(&mut at, count)?, integers(&mut at, count)?];
        let mut is_seen = vec![false; paths.len()];
        // Nodes whose siblings are still to be read, with their parents.
        let mut open = vec![(0_usize, None)];
        while let Some((mut node, mut parent)) = open.pop() {
            loop {
                match is_seen.get_mut(node) {
                    Some(seen) if !*seen => *seen = true,
                    _ => return Err(at.refuse("its tree of paths leads nowhere or in a circle")),
                }
                let (path, name, jump) =
                    (paths[node], names[node].cast_signed(), jumps[node].cast_signed());
                match parent {
                    None => self.root = path,
                    Some(parent) if name < 0 => {
                        let own = (path, name.unsigned_abs());
                        self.properties.entry(parent).or_default().push(own);
                    }
                    Some(parent) => {
                        self.prims.insert((parent, name.unsigned_abs()), path);
                    }
                }
                let distance = usize::try_from(jump).unwrap_or(0);
                match (jump, parent) {
                    // The root of all has no sibling.
                    (-1, _) | (1.., None) => {
                        node += 1;
                        parent = Some(path);
                    }
                    (1.., Some(_)) => {
                        open.push((node + distance, parent));
                        node += 1;
                        parent = Some(path);
                    }
                    (0, Some(_)) => node += 1,
                    _ => break,
                }
            }
        }
        Ok(())
    }

    /// Adds a prim with its attributes to the layer.
    fn prim(
        &self,
        node: &PrimNode,
        time: Option<f64>,
        layer: &mut UsdLayer,
    ) -> Result<usize, StrandsError> {
        let fields = self.fields(node.path)?;
        let (mut kind, mut is_shown, mut is_active) = (String::new(), false, true);
        for &(key, rep) in &fields {
            if !["specifier", "active", "typeName"].contains(&key) {
                continue;
            }
            match (key, self.values.value(rep)?) {
                // Of definitions, overrides and classes the first are shown.
                ("specifier", UsdValue::Numbers(number)) => is_shown = number == [0.0],
                ("active", UsdValue::Numbers(number)) => is_active = number != [0.0],
                ("typeName", UsdValue::Words(words)) => kind = words.concat(),
                _ => {}
            }
        }
        let name = self.values.token(node.name)?.to_owned();
        let prim = layer.add(node.parent, name, kind, is_shown && is_active);
        for (key, _) in fields {
            layer.note_arc(key, prim);
        }
        for &(path, name) in self.properties.get(&node.path).map_or(&[][..], Vec::as_slice) {
            let name = self.values.token(name)?;
            let is_attribute = self.specs.get(&path).is_some_and(|(kind, _)| *kind == ATTRIBUTE);
            if !is_attribute || !is_kept(&layer.prims[prim].kind, name) {
                continue;
            }
            let mut attribute = UsdAttribute::new(time);
            for (key, rep) in self.fields(path)? {
                match key {
                    "default" => attribute.default = Some(self.values.value(rep)?),
                    "timeSamples" if rep.kind() == TIME_SAMPLES => {
                        self.values.samples(rep, &mut attribute.samples)?;
                    }
                    "interpolation" => {
                        if let UsdValue::Words(words) = self.values.value(rep)? {
                            attribute.interpolation = words.into_iter().next();
                        }
                    }
                    _ => {}
                }
            }
            layer.prims[prim].attributes.insert(name.to_owned(), attribute);
        }
        Ok(prim)
    }

    /// Names and values of the fields of a path.
    fn fields(&self, path: u32) -> Result<Vec<(&str, Rep)>, StrandsError> {
        let Some(&(_, start)) = self.specs.get(&path) else { return Ok(Vec::new()) };
        let list = self.lists.get(start as usize..).unwrap_or_default();
        let list = list.iter().take(MOST_FIELDS).take_while(|&&field| field != END);
        list.map(|&field| {
            let Some(&(name, rep)) = self.fields.get(field as usize) else {
                let problem = format!("it refers to field {field}, which is not there");
                return Err(self.values.bytes.refuse(problem));
            };
            Ok((self.values.token(name)?, rep))
        })
        .collect()
    }

    /// The prims below a path in their order, the first one last, each of them only once.
    fn children(
        &mut self,
        path: u32,
        parent: Option<usize>,
    ) -> Result<Vec<PrimNode>, StrandsError> {
        let Some(&(_, rep)) = self.fields(path)?.iter().find(|(key, _)| *key == "primChildren")
        else {
            return Ok(Vec::new());
        };
        let names = self.values.token_indices(rep)?;
        let mut nodes = Vec::new();
        for name in names.into_iter().rev() {
            if let Some(path) = self.prims.remove(&(path, name))
                && self.specs.get(&path).is_some_and(|(kind, _)| *kind == PRIM)
            {
                nodes.push(PrimNode { path, name, parent });
            }
        }
        Ok(nodes)
    }
}

fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
