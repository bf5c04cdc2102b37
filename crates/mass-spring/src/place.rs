use crate::SpringError;

/// The place matrix of the second text: springs and supports of every node of a lattice, K rows of
/// N letters.
///
/// | letter | node |
/// |---|---|
/// | `f` | fixed |
/// | `m` | pulled from all sides |
/// | `t` `b` `l` `r` | not pulled from the top, bottom, left, right |
/// | `1` `2` `3` `4` | corner: top left, top right, bottom right, bottom left |
/// | `h` | moves up and down only, together with all others of its kind |
/// | `v` | moves left and right only, together with all others of its kind |
///
/// Between neighbors there is a spring where both letters have it: `f`, `h` and `v` take whatever
/// the neighbor wants. So letters also cut: a row of `b` over a row of `t` is a slit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlaceMatrix {
    rows: Vec<Vec<char>>,
}

/// Directions up, down, left and right, with the letters that have no spring there.
const SIDES: [(&str, [isize; 2], &str); 4] = [
    ("above", [-1, 0], "t12"),
    ("below", [1, 0], "b34"),
    ("to the left", [0, -1], "l14"),
    ("to the right", [0, 1], "r23"),
];

impl PlaceMatrix {
    /// Reads the matrix, one string per row, from the top.
    ///
    /// # Errors
    /// [`SpringError::PlaceShape`], [`SpringError::PlaceLetter`], and
    /// [`SpringError::PlaceNeighbor`] for a letter whose neighbor is not there or does not pull
    /// back.
    pub fn new(rows: &[&str]) -> Result<Self, SpringError> {
        let rows: Vec<Vec<char>> = rows.iter().map(|row| row.chars().collect()).collect();
        let expected = rows.first().map_or(0, Vec::len).max(2);
        let wrong = rows.iter().position(|row| row.len() != expected);
        if let Some(row) = wrong.or((rows.len() < 2).then_some(rows.len())) {
            let found = rows.get(row).map_or(0, Vec::len);
            return Err(SpringError::PlaceShape { row, found, expected });
        }
        let place = Self { rows };
        for (row, column, letter) in place.letters() {
            if !"fmtblr1234hv".contains(letter) {
                return Err(SpringError::PlaceLetter { row, column, letter });
            }
        }
        for (row, column, letter) in place.letters() {
            for (side, [down, right], _) in SIDES {
                let wants = !"fhv".contains(letter) && place.pulls(row, column, down, right);
                if wants && !place.connected(row, column, down, right) {
                    return Err(SpringError::PlaceNeighbor { row, column, letter, side });
                }
            }
        }
        Ok(place)
    }

    /// A free lattice of `rows` and `columns`, each at least two: the flying net.
    ///
    /// # Errors
    /// [`SpringError::PlaceShape`].
    pub fn free(rows: usize, columns: usize) -> Result<Self, SpringError> {
        let row = |left: char, middle: char, right: char| {
            let mut row = vec![middle; columns];
            if let [first, .., last] = row.as_mut_slice() {
                (*first, *last) = (left, right);
            }
            row.into_iter().collect::<String>()
        };
        let mut letters = vec![row('l', 'm', 'r'); rows];
        if let [first, .., last] = letters.as_mut_slice() {
            (*first, *last) = (row('1', 't', '2'), row('4', 'b', '3'));
        }
        Self::new(&letters.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// A cloth on a line: fixed at the top, at every third node and the corners.
    ///
    /// # Errors
    /// [`SpringError::PlaceShape`].
    pub fn line(rows: usize, columns: usize) -> Result<Self, SpringError> {
        let pegged = |row, column| row == 0 && (column % 3 == 0 || column + 1 == columns);
        Ok(Self::free(rows, columns)?.with('f', pegged))
    }

    /// A flag on its pole: fixed at the left.
    ///
    /// # Errors
    /// [`SpringError::PlaceShape`].
    pub fn flag(rows: usize, columns: usize) -> Result<Self, SpringError> {
        Ok(Self::free(rows, columns)?.with('f', |_, column| column == 0))
    }

    /// Fixes or guides nodes: `letter` is `f`, `h` or `v`, which agree with all neighbors.
    pub(crate) fn with(mut self, letter: char, which: impl Fn(usize, usize) -> bool) -> Self {
        for (row, letters) in self.rows.iter_mut().enumerate() {
            for (column, old) in letters.iter_mut().enumerate() {
                if which(row, column) {
                    *old = letter;
                }
            }
        }
        self
    }

    /// Number of rows, at least two.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Number of columns, at least two.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.rows[0].len()
    }

    /// The letter in a row, from the top, and a column, from the left.
    ///
    /// # Panics
    /// If there is no such place, as indexing does.
    #[must_use]
    pub fn letter(&self, row: usize, column: usize) -> char {
        self.rows[row][column]
    }

    /// All nodes with the given letter, as row and column.
    pub(crate) fn all(&self, letter: char) -> impl Iterator<Item = (usize, usize)> {
        self.letters().filter(move |l| l.2 == letter).map(|(row, column, _)| (row, column))
    }

    fn letters(&self) -> impl Iterator<Item = (usize, usize, char)> {
        let row = |(row, letters): (usize, &Vec<char>)| {
            letters.clone().into_iter().enumerate().map(move |(column, l)| (row, column, l))
        };
        self.rows.iter().enumerate().flat_map(row)
    }

    /// Whether there is a spring from a node to the one that lies `down` and `right` of it.
    pub(crate) fn connected(&self, row: usize, column: usize, down: isize, right: isize) -> bool {
        let there = (row.checked_add_signed(down), column.checked_add_signed(right));
        match there {
            (Some(r), Some(c)) if r < self.rows() && c < self.columns() => {
                self.pulls(row, column, down, right) && self.pulls(r, c, -down, -right)
            }
            _ => false,
        }
    }

    /// Whether the letter of a node has a spring in a direction.
    fn pulls(&self, row: usize, column: usize, down: isize, right: isize) -> bool {
        let letter = self.rows[row][column];
        SIDES.iter().all(|(_, side, without)| *side != [down, right] || !without.contains(letter))
    }
}
