//! Layers as text, `.usda`.

use super::layer::{UsdAttribute, UsdLayer, UsdValue, is_kept};
use super::lexer::{Lexer, Token};
use crate::StrandsError;

/// Reads a layer; of samples those around `time`, or the first.
pub(super) fn read(bytes: &[u8], time: Option<f64>) -> Result<UsdLayer, StrandsError> {
    let mut parser = Parser { lexer: Lexer::new(bytes), layer: UsdLayer::default(), time };
    if parser.lexer.next_is(b'(') {
        for (key, value) in parser.metadata(&["metersPerUnit", "upAxis", "subLayers"])? {
            parser.layer.take_metadata(&key, &value);
        }
    }
    parser.prims()?;
    Ok(parser.layer)
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    layer: UsdLayer,
    time: Option<f64>,
}

impl<'a> Parser<'a> {
    /// All prims, with what is in them.
    fn prims(&mut self) -> Result<(), StrandsError> {
        // The prims whose braces are open, the innermost last.
        let mut open: Vec<usize> = Vec::new();
        loop {
            match self.lexer.token()? {
                Token::End if open.is_empty() => return Ok(()),
                Token::Symbol(b'}') if open.pop().is_some() => {}
                Token::Symbol(b';') => {}
                Token::Word(word @ (b"def" | b"over" | b"class")) => {
                    open.push(self.prim(word == b"def", open.last().copied())?);
                }
                Token::Word(b"variantSet") => {
                    self.lexer.string()?;
                    self.lexer.expect(b'=')?;
                    self.lexer.skip()?;
                    if let Some(&prim) = open.last() {
                        self.layer.note_arc("variantSet", prim);
                    }
                }
                Token::Word(b"reorder") => {
                    self.lexer.token()?;
                    self.lexer.expect(b'=')?;
                    self.lexer.skip()?;
                }
                Token::Word(word) => match open.last() {
                    Some(&prim) => self.attribute(word, prim)?,
                    None => return Err(self.lexer.refuse("a prim should begin with def or over")),
                },
                Token::End => return Err(self.lexer.refuse("it ends before all prims are closed")),
                _ => return Err(self.lexer.refuse("a prim or an attribute is expected")),
            }
        }
    }

    /// A prim up to its opening brace, after its specifier.
    fn prim(&mut self, is_def: bool, parent: Option<usize>) -> Result<usize, StrandsError> {
        let (kind, name) = match self.lexer.token()? {
            Token::Word(kind) => (lossy(kind), self.lexer.string()?),
            Token::Text(name) => (String::new(), lossy(name)),
            _ => return Err(self.lexer.refuse("a prim should have a name in quotes")),
        };
        let prim = self.layer.add(parent, name, kind, is_def);
        if self.lexer.next_is(b'(') {
            for (key, value) in self.metadata(&["active"])? {
                if key == "active" && value == UsdValue::Numbers(vec![0.0]) {
                    self.layer.prims[prim].is_shown = false;
                }
                self.layer.note_arc(&key, prim);
            }
        }
        self.lexer.expect(b'{')?;
        Ok(prim)
    }

    /// An attribute or relationship, whose first word has been read.
    fn attribute(&mut self, mut word: &'a [u8], prim: usize) -> Result<(), StrandsError> {
        const MODIFIERS: [&[u8]; 9] = [
            b"custom", b"uniform", b"varying", b"config", b"add", b"prepend", b"append", b"delete",
            b"reorder",
        ];
        while MODIFIERS.contains(&word) {
            word = self.lexer.word()?;
        }
        // What remains is the type and the name.
        if self.lexer.next_is(b'[') {
            self.lexer.skip()?;
        }
        let full = lossy(self.lexer.word()?);
        let (name, part) = full.split_once('.').unwrap_or((&full, ""));
        let is_kept = word != b"rel" && is_kept(&self.layer.prims[prim].kind, name);
        if self.lexer.next_is(b'=') {
            self.lexer.expect(b'=')?;
            match part {
                "" if is_kept => {
                    let value = self.lexer.value()?;
                    self.of(prim, name).default = Some(value);
                }
                "timeSamples" if is_kept => self.samples(prim, name)?,
                _ => self.lexer.skip()?,
            }
        }
        if self.lexer.next_is(b'(') {
            let own = self.metadata(&["interpolation"])?;
            if let Some((_, UsdValue::Words(words))) =
                own.into_iter().find(|e| e.0 == "interpolation")
                && is_kept
            {
                self.of(prim, name).interpolation = words.into_iter().next();
            }
        }
        Ok(())
    }

    /// The attribute of a prim, made if it is new.
    fn of(&mut self, prim: usize, name: &str) -> &mut UsdAttribute {
        let time = self.time;
        let attributes = &mut self.layer.prims[prim].attributes;
        attributes.entry(name.to_owned()).or_insert_with(|| UsdAttribute::new(time))
    }

    /// Samples in braces, after the equals sign.
    fn samples(&mut self, prim: usize, name: &str) -> Result<(), StrandsError> {
        self.lexer.expect(b'{')?;
        while let Some(at) = self.lexer.time()? {
            if self.of(prim, name).samples.wants(at) {
                let value = self.lexer.value()?;
                self.of(prim, name).samples.put(at, value);
            } else {
                self.lexer.skip()?;
            }
        }
        Ok(())
    }

    /// Metadata in parentheses as keys with their values, which are read of `wanted` keys alone.
    fn metadata(&mut self, wanted: &[&str]) -> Result<Vec<(String, UsdValue)>, StrandsError> {
        self.lexer.expect(b'(')?;
        let mut entries = Vec::new();
        loop {
            match self.lexer.token()? {
                Token::Symbol(b')') => return Ok(entries),
                Token::Text(_) | Token::Symbol(b';' | b',') => {}
                Token::Word(b"add" | b"prepend" | b"append" | b"delete" | b"reorder") => {}
                Token::Word(key) => {
                    let key = lossy(key);
                    self.lexer.expect(b'=')?;
                    let value = if wanted.contains(&&*key) {
                        self.lexer.value()?
                    } else {
                        self.lexer.skip()?;
                        UsdValue::Other
                    };
                    entries.push((key, value));
                }
                _ => return Err(self.lexer.refuse("metadata should be keys with values")),
            }
        }
    }
}

fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
