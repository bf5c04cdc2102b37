//! A binary layer of USD with the strands of a frame, nothing packed that need not be.

use rapunzel_export::Frame;

/// Types of values, and how they are stored.
const INT: u64 = 3;
const FLOAT: u64 = 8;
const DOUBLE: u64 = 9;
const TOKEN: u64 = 11;
const VEC3F: u64 = 24;
const TOKENS: u64 = 41;
const SPECIFIER: u64 = 42;
const VARIABILITY: u64 = 44;
const ARRAY: u64 = 1 << 15;
const INLINED: u64 = 1 << 62;

const WORDS: [&str; 23] = [
    "",
    "BasisCurves",
    "Hair",
    "Z",
    "curveVertexCounts",
    "default",
    "float[]",
    "int[]",
    "interpolation",
    "linear",
    "metersPerUnit",
    "point3f[]",
    "points",
    "primChildren",
    "properties",
    "specifier",
    "token",
    "type",
    "typeName",
    "upAxis",
    "variability",
    "vertex",
    "widths",
];

/// Writes the file; z is up.
pub(crate) fn written(frame: &Frame) -> Vec<u8> {
    let mut file = b"PXR-USDC\0\x08\0\0\0\0\0\0".to_vec();
    file.resize(88, 0);
    // Values that lie in the file.
    let mut stored = |kind: u64, count: usize, bytes: Vec<u8>| {
        let place = file.len() as u64;
        file.extend((count as u64).to_le_bytes());
        file.extend(bytes);
        kind << 48 | place
    };
    let strands = || frame.strands.iter();
    let properties = ["curveVertexCounts", "points", "type", "widths"];
    let tokens = |words: &[&str]| words.iter().flat_map(|word| token(word).to_le_bytes()).collect();
    let counts = strands().map(|s| i32::try_from(s.points.len()).expect("few"));
    let points = strands().flat_map(|s| &s.points).flat_map(|p| [p.x, p.y, p.z]);
    let widths = strands().flat_map(|s| &s.radii).map(|radius| 2.0 * radius);
    let children = stored(TOKENS, 1, tokens(&["Hair"]));
    let own = stored(TOKENS, 4, tokens(&properties));
    let counts =
        stored(ARRAY | INT, frame.strands.len(), counts.flat_map(i32::to_le_bytes).collect());
    let points = stored(ARRAY | VEC3F, frame.points(), points.flat_map(single).collect());
    let widths = stored(ARRAY | FLOAT, frame.points(), widths.flat_map(single).collect());

    // Values in their own bytes.
    let inlined = |kind: u64, value: u32| kind << 48 | INLINED | u64::from(value);
    let word = |word: &str| inlined(TOKEN, token(word));
    let unit = inlined(DOUBLE, u32::from_le_bytes(single(1.0)));
    let lists = [
        vec![("primChildren", children), ("metersPerUnit", unit), ("upAxis", word("Z"))],
        vec![
            ("specifier", inlined(SPECIFIER, 0)),
            ("typeName", word("BasisCurves")),
            ("properties", own),
        ],
        vec![("typeName", word("int[]")), ("default", counts)],
        vec![("typeName", word("point3f[]")), ("default", points)],
        vec![
            ("typeName", word("token")),
            ("variability", inlined(VARIABILITY, 1)),
            ("default", word("linear")),
        ],
        vec![("typeName", word("float[]")), ("default", widths), ("interpolation", word("vertex"))],
    ];
    let fields = lists.concat();
    let (mut sets, mut starts, mut next) = (Vec::new(), Vec::new(), 0);
    for list in &lists {
        starts.push(u32::try_from(sets.len()).expect("few"));
        sets.extend((0..).take(list.len()).map(|k: u32| next + k));
        next += u32::try_from(list.len()).expect("few");
        sets.push(u32::MAX);
    }
    let count = |n: usize| (n as u64).to_le_bytes().to_vec();
    let packed = |bytes: Vec<u8>| {
        let block = literals(&bytes);
        [count(block.len()), block].concat()
    };
    let text: Vec<u8> = WORDS.iter().flat_map(|word| [word.as_bytes(), b"\0"].concat()).collect();
    let names: Vec<_> = fields.iter().map(|(name, _)| token(name)).collect();
    let reps: Vec<u8> = fields.iter().flat_map(|(_, rep)| rep.to_le_bytes()).collect();
    // The root, the prim, and its properties, which are negative.
    let elements = properties.map(|name| 0_u32.wrapping_sub(token(name)));
    let elements = [&[0, token("Hair")], &elements[..]].concat();
    let paths = integers(&[0, 1, 2, 3, 4, 5]);
    let jumps = [-1_i32, -1, 0, 0, 0, -2].map(i32::cast_unsigned);
    let sections = [
        ("TOKENS", [count(WORDS.len()), count(text.len()), packed(text)].concat()),
        ("STRINGS", count(0)),
        ("FIELDS", [count(fields.len()), packed(integers(&names)), packed(reps)].concat()),
        ("FIELDSETS", [count(sets.len()), packed(integers(&sets))].concat()),
        (
            "PATHS",
            [
                count(6),
                count(6),
                packed(paths.clone()),
                packed(integers(&elements)),
                packed(integers(&jumps)),
            ]
            .concat(),
        ),
        (
            "SPECS",
            [
                count(6),
                packed(paths),
                packed(integers(&starts)),
                packed(integers(&[7, 6, 1, 1, 1, 1])),
            ]
            .concat(),
        ),
    ];
    let mut table = count(sections.len());
    for (name, bytes) in sections {
        let mut entry = name.as_bytes().to_vec();
        entry.resize(16, 0);
        table.extend([entry, count(file.len()), count(bytes.len())].concat());
        file.extend(bytes);
    }
    let place = count(file.len());
    file[16..24].copy_from_slice(&place);
    file.extend(table);
    file
}

fn token(word: &str) -> u32 {
    u32::try_from(WORDS.iter().position(|own| *own == word).expect("a word")).expect("few")
}

fn single(x: f64) -> [u8; 4] {
    #[expect(clippy::cast_possible_truncation, reason = "the schema is in single precision")]
    let x = x as f32;
    x.to_le_bytes()
}

/// One block of LZ4 without a match, after the number of chunks.
fn literals(bytes: &[u8]) -> Vec<u8> {
    let mut block = vec![0];
    match bytes.len().checked_sub(15) {
        None => block.push(u8::try_from(bytes.len() << 4).expect("below 15")),
        Some(mut more) => {
            block.push(0xf0);
            while more >= 255 {
                block.push(255);
                more -= 255;
            }
            block.push(u8::try_from(more).expect("below 255"));
        }
    }
    block.extend(bytes);
    block
}

/// Differences that all have four bytes.
fn integers(values: &[u32]) -> Vec<u8> {
    let mut bytes = vec![0; 4];
    bytes.resize(4 + values.len().div_ceil(4), 0xff);
    let mut last = 0_u32;
    for value in values {
        bytes.extend(value.wrapping_sub(last).to_le_bytes());
        last = *value;
    }
    bytes
}
