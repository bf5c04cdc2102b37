//! Positions of fields in the text of a scene.
//!
//! A walk over the tokens of RON that keeps the path of the value it stands at. The text has been
//! parsed before, so the walk need not judge it: it only matches brackets and skips comments,
//! strings and names of variants.

use std::ops::Range;

/// Range of bytes of the value at `path`; of its nearest ancestor that is written in the text if it
/// is a default; of the whole text if there is none.
pub(crate) fn span(text: &str, path: &str) -> Range<usize> {
    let wanted: Vec<&str> = path.split(['.', '[', ']']).filter(|p| !p.is_empty()).collect();
    let mut walk =
        TextWalk { text, at: 0, path: Vec::new(), wanted: &wanted, best: (0, 0..text.len()) };
    walk.value();
    walk.best.1
}

/// Largest depth of the walk: deeper than the parser of RON.
const DEEPEST: usize = 200;

struct TextWalk<'a> {
    text: &'a str,
    at: usize,
    path: Vec<String>,
    wanted: &'a [&'a str],
    /// Number of parts of the path that matched, and the range of bytes there.
    best: (usize, Range<usize>),
}

impl TextWalk<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// Skips white space, comments and attributes.
    fn skip(&mut self) {
        loop {
            let rest = self.rest();
            let skipped = if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else if rest.starts_with("/*") {
                rest.find("*/").map_or(rest.len(), |i| i + 2)
            } else if rest.starts_with("#![") {
                rest.find(']').map_or(rest.len(), |i| i + 1)
            } else {
                rest.len() - rest.trim_start().len()
            };
            if skipped == 0 {
                return;
            }
            self.at += skipped;
        }
    }

    /// Takes characters up to the next one that ends a word.
    fn word(&mut self) -> &str {
        let start = self.at;
        let ends = |c: char| c.is_whitespace() || "()[]{},:\"/".contains(c);
        self.at += self.rest().find(ends).unwrap_or(self.rest().len());
        &self.text[start..self.at]
    }

    fn string(&mut self) {
        let mut escaped = false;
        let end = self.rest()[1..].find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        self.at += end.map_or(self.rest().len(), |i| i + 2);
    }

    /// Walks one value, and records it if it is on the wanted path.
    fn value(&mut self) {
        self.skip();
        let start = self.at;
        if self.rest().starts_with('"') {
            self.string();
        } else {
            self.word();
            let end = self.at;
            self.skip();
            match self.rest().chars().next() {
                // What was not parsed, behind an error, may be deeper than the stack.
                Some('(' | '[' | '{') if self.path.len() == DEEPEST => self.at = self.text.len(),
                Some(open @ ('(' | '[' | '{')) => self.list(open),
                _ => self.at = end,
            }
        }
        let depth = self.path.len();
        if depth >= self.best.0 && depth <= self.wanted.len() && self.path == self.wanted[..depth] {
            self.best = (depth, start..self.at);
        }
    }

    /// Walks the entries between brackets: named, or counted from 0.
    fn list(&mut self, open: char) {
        let close = match open {
            '(' => ')',
            '[' => ']',
            _ => '}',
        };
        self.at += 1;
        for index in 0.. {
            self.skip();
            if self.rest().is_empty() {
                return;
            }
            if self.rest().starts_with(close) {
                self.at += 1;
                return;
            }
            let before = self.at;
            let name = self.word().to_owned();
            self.skip();
            if !name.is_empty() && self.rest().starts_with(':') {
                self.at += 1;
                self.path.push(name);
            } else {
                self.at = before;
                self.path.push(index.to_string());
            }
            self.value();
            self.path.pop();
            self.skip();
            if self.rest().starts_with(',') {
                self.at += 1;
            } else if self.at == before {
                // Not RON; leave rather than stand still.
                self.at = self.text.len();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::span;

    const SCENE: &str = r#"
        // fibers: [(length: 9)]
        (
            name: "a \" (quoted, [name])",
            fibers: [
                (length: 1, root: (position: (1, 2, /* z: */ 3))),
                Bundle(length: 2, section: Circle(radius: -4e-5)), // last
            ],
            tip: Free, end: Some(7),
        )"#;

    fn found(path: &str) -> &'static str {
        &SCENE[span(SCENE, path)]
    }

    #[test]
    fn values_are_found() {
        assert_eq!(found("fibers[0].length"), "1");
        assert_eq!(found("fibers[1].section.radius"), "-4e-5");
        assert_eq!(found("fibers[0].root.position[2]"), "3");
        assert_eq!(found("tip"), "Free");
        assert_eq!(found("name"), r#""a \" (quoted, [name])""#);
    }

    #[test]
    fn a_default_points_at_its_parent() {
        assert_eq!(found("fibers[1].damping_time"), found("fibers[1]"));
        assert!(found("duration").starts_with('('), "the scene");
    }

    #[test]
    fn broken_text_does_not_stop_the_walk() {
        let deep = "(".repeat(1_000_000);
        for text in
            ["", "(", "(a: [", "\"", "(a: b c: d)", "]]]", "(a: \"x", "(,,)", "é(ü: 1)", &deep]
        {
            let found = span(text, "a.b");
            assert!(found.end <= text.len(), "{text}");
        }
    }
}
