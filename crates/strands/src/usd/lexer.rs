//! Tokens and values of USD as text.

use super::layer::UsdValue;
use super::marks::NAME;
use crate::StrandsError;

/// A text, read token by token.
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// A part of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    /// A name, number or keyword; it may have colons and points.
    Word(&'a [u8]),
    /// What is between quotes, with its escapes.
    Text(&'a [u8]),
    /// An asset, between its outermost `@`.
    Asset(&'a [u8]),
    /// A path in angle brackets.
    Path,
    /// A bracket or separator.
    Symbol(u8),
    End,
}

/// Bytes that are no part of a word though they are no space.
const DELIMITERS: &[u8] = b"()[]{}=,;\"'@<>#";

/// Whether a byte ends a word, by its value.
const ENDS: [bool; 256] = {
    let mut ends = [false; 256];
    let mut k = 0;
    while k < DELIMITERS.len() {
        ends[DELIMITERS[k] as usize] = true;
        k += 1;
    }
    let mut byte = 0;
    while byte < 128_u8 {
        ends[byte as usize] |= byte.is_ascii_whitespace();
        byte += 1;
    }
    ends
};

impl<'a> Lexer<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// An error at the line that was read last.
    pub(super) fn refuse(&self, problem: &str) -> StrandsError {
        let line = self.bytes[..self.at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        let (place, problem) = (format!("line {line}"), problem.to_owned());
        StrandsError::Read { format: NAME, place, problem }
    }

    /// Goes past spaces and comments.
    fn pass_blanks(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'#' {
                let rest = &self.bytes[self.at..];
                self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            } else if byte.is_ascii_whitespace() {
                self.at += 1;
            } else {
                break;
            }
        }
    }

    /// Whether this byte comes next; it is not taken.
    pub(super) fn next_is(&mut self, byte: u8) -> bool {
        self.pass_blanks();
        self.bytes.get(self.at) == Some(&byte)
    }

    pub(super) fn token(&mut self) -> Result<Token<'a>, StrandsError> {
        self.pass_blanks();
        let rest = &self.bytes[self.at..];
        let Some(&first) = rest.first() else { return Ok(Token::End) };
        match first {
            b'"' | b'\'' | b'@' => {
                let mark = if rest.starts_with(&[first; 3]) { &rest[..3] } else { &rest[..1] };
                let inside = self.quoted(mark)?;
                Ok(if first == b'@' { Token::Asset(inside) } else { Token::Text(inside) })
            }
            b'<' => self.quoted(b">").map(|_| Token::Path),
            _ if ENDS[usize::from(first)] => {
                self.at += 1;
                Ok(Token::Symbol(first))
            }
            _ => {
                let ends = |b: &u8| ENDS[usize::from(*b)];
                let length = rest.iter().position(ends).unwrap_or(rest.len());
                self.at += length;
                Ok(Token::Word(&rest[..length]))
            }
        }
    }

    /// What is between a mark of as many bytes as `mark` and `mark`.
    fn quoted(&mut self, mark: &[u8]) -> Result<&'a [u8], StrandsError> {
        let start = self.at + mark.len();
        let mut end = start;
        while let Some(rest) = self.bytes.get(end..).filter(|rest| !rest.is_empty()) {
            if rest.starts_with(mark) {
                self.at = end + mark.len();
                return Ok(&self.bytes[start..end]);
            }
            end += if rest[0] == b'\\' && mark[0] != b'@' { 2 } else { 1 };
        }
        Err(self.refuse("quotes that begin here do not end"))
    }

    pub(super) fn word(&mut self) -> Result<&'a [u8], StrandsError> {
        match self.token()? {
            Token::Word(word) => Ok(word),
            _ => Err(self.refuse("a name is expected")),
        }
    }

    pub(super) fn string(&mut self) -> Result<String, StrandsError> {
        match self.token()? {
            Token::Text(text) => Ok(String::from_utf8_lossy(text).into_owned()),
            _ => Err(self.refuse("a name in quotes is expected")),
        }
    }

    pub(super) fn expect(&mut self, symbol: u8) -> Result<(), StrandsError> {
        if self.token()? == Token::Symbol(symbol) {
            return Ok(());
        }
        Err(self.refuse(&format!("`{}` is expected", char::from(symbol))))
    }

    /// Goes past a value of any type.
    pub(super) fn skip(&mut self) -> Result<(), StrandsError> {
        let mut depth = 0_usize;
        loop {
            if depth > 0 {
                // Past numbers, names and commas, of which there may be millions.
                let rest = &self.bytes[self.at..];
                let is_plain = |b: &u8| !ENDS[usize::from(*b)] || *b == b',' || *b == b' ';
                self.at += rest.iter().position(|b| !is_plain(b)).unwrap_or(rest.len());
            }
            let token = self.token()?;
            match token {
                Token::Symbol(b'(' | b'[' | b'{') => depth += 1,
                Token::Symbol(b')' | b']' | b'}') if depth > 0 => depth -= 1,
                Token::End => return Err(self.refuse("it ends within a value")),
                Token::Symbol(_) if depth == 0 => return Err(self.refuse("a value is expected")),
                _ => {}
            }
            // A reference is an asset with a path, and either may have a change of times.
            let goes_on = match token {
                Token::Asset(_) => self.next_is(b'<') || self.next_is(b'('),
                Token::Path => self.next_is(b'('),
                _ => false,
            };
            if depth == 0 && !goes_on {
                return Ok(());
            }
        }
    }

    /// The time of a sample with its colon; none at the closing brace.
    pub(super) fn time(&mut self) -> Result<Option<f64>, StrandsError> {
        loop {
            match self.token()? {
                Token::Symbol(b'}') => return Ok(None),
                Token::Symbol(b',') => {}
                Token::Word(word) => {
                    // The value may follow without a space.
                    let colon = word.iter().position(|&byte| byte == b':');
                    match colon {
                        Some(colon) => self.at -= word.len() - colon - 1,
                        None if self.word()? == b":" => {}
                        None => return Err(self.refuse("a time should have a colon")),
                    }
                    let time = number(&word[..colon.unwrap_or(word.len())]);
                    return time
                        .ok_or_else(|| self.refuse("the time of a sample should be a number"))
                        .map(Some);
                }
                _ => return Err(self.refuse("a sample should begin with its time")),
            }
        }
    }

    /// A value of numbers or of words, without its structure.
    pub(super) fn value(&mut self) -> Result<UsdValue, StrandsError> {
        let (mut numbers, mut words, mut depth) = (Vec::new(), Vec::new(), 0_usize);
        loop {
            match self.token()? {
                Token::Symbol(b'(' | b'[') => depth += 1,
                Token::Symbol(b')' | b']') if depth > 0 => depth -= 1,
                Token::Symbol(b',' | b';' | b'=') if depth > 0 => {}
                Token::Word(word) => match number(word) {
                    Some(number) => numbers.push(number),
                    None => words.push(String::from_utf8_lossy(word).into_owned()),
                },
                Token::Text(text) | Token::Asset(text) => {
                    words.push(String::from_utf8_lossy(text).into_owned());
                }
                Token::Path => {}
                Token::Symbol(_) => return Err(self.refuse("a value is expected")),
                Token::End => return Err(self.refuse("it ends within a value")),
            }
            if depth == 0 {
                break;
            }
        }
        Ok(match &words[..] {
            [] => UsdValue::Numbers(numbers),
            [word] if word == "None" => UsdValue::Other,
            [word] if word == "true" || word == "false" => {
                UsdValue::Numbers(vec![f64::from(word == "true")])
            }
            _ => UsdValue::Words(words),
        })
    }
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
