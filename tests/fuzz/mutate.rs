//! Changes inputs the way broken programs and hostile people do. The same seed makes the same change.

/// A small generator (SplitMix64): good enough to wander with, and the same everywhere.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// For the `case`th input of a run.
    pub(crate) fn of_case(seed: u64, case: u64) -> Self {
        Self::new(seed.wrapping_mul(0x1_0000_0001).wrapping_add(case))
    }

    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 to `n` − 1; 0 for an `n` of 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.roll() % (n.max(1) as u64)).unwrap_or(0)
    }

    fn pick<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.below(choices.len())]
    }
}

/// Numbers that break things.
const NUMBERS: [&str; 28] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "4",
    "5",
    "6",
    "7",
    "255",
    "256",
    "5120",
    "5121",
    "5123",
    "5125",
    "5126",
    "65535",
    "2147483647",
    "4294967295",
    "4294967296",
    "1000000000",
    "18446744073709551615",
    "9223372036854775807",
    "0.5",
    "1e-40",
    "1e39",
    "-1e308",
];
/// Words that mean something to one of the readers.
const WORDS: [&str; 40] = [
    "\"SCALAR\"",
    "\"VEC2\"",
    "\"VEC3\"",
    "\"VEC4\"",
    "\"MAT4\"",
    "\"LINEAR\"",
    "\"STEP\"",
    "\"CUBICSPLINE\"",
    "\"translation\"",
    "\"rotation\"",
    "\"scale\"",
    "\"weights\"",
    "\"POSITION\"",
    "\"NORMAL\"",
    "\"JOINTS_0\"",
    "\"WEIGHTS_0\"",
    "\"TEXCOORD_0\"",
    "\"BLEND\"",
    "\"MASK\"",
    "\"\"",
    "null",
    "true",
    "false",
    "[]",
    "{}",
    "nan",
    "inf",
    "-inf",
    "\"*\"",
    "\"sphere\"",
    "\"box\"",
    "\"plane\"",
    "\"torus\"",
    "\"perspective\"",
    "\"world\"",
    "\"point\"",
    "\"spot\"",
    "\"twist\"",
    "\"wave\"",
    "\"..\"",
];
/// What TOML is made of, whole and torn.
const PIECES: [&str; 24] = [
    "[[",
    "]]",
    "[",
    "{",
    "}",
    "\"",
    "\"\"\"",
    "'''",
    "=",
    ".",
    ",",
    "#",
    "\n",
    "\r\n",
    "\0",
    "\u{feff}",
    "é",
    "🐟",
    "[[model]]\n",
    "[[model.material]]\n",
    "[[model.deformer]]\n",
    "{ shape = \"box\" }",
    "1979-05-27T07:32:00Z",
    "0x7fffffff",
];
/// Steps of an assignment's path.
const STEPS: [&str; 12] =
    ["model", "light", "camera", "effect", "grid", "material", "deformer", "0", "1", "99", "eye", "name"];
/// Starts the line of an assignment; a comment to TOML.
pub(crate) const ASSIGNMENT: &str = "#set ";
/// Bit patterns of single-precision numbers that break things.
const FLOATS: [f32; 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 0.0, 1e-40, 1e20];

/// One to three changes of a model file: of its JSON, its numbers, or its bytes.
pub(crate) fn model(dice: &mut Dice, input: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=dice.below(3) {
        match dice.below(12) {
            0 => flip(dice, &mut bytes),
            1 => truncate(dice, &mut bytes),
            2 => overwrite_float(dice, &mut bytes),
            3 => overwrite_chunk_length(dice, &mut bytes),
            _ => with_json(dice, &mut bytes),
        }
    }
    bytes
}

/// One to three changes of a scene's text; sometimes an assignment (see `check::scene`) is among them.
pub(crate) fn scene(dice: &mut Dice, input: &[u8]) -> Vec<u8> {
    let mut text = input.to_vec();
    for _ in 0..=dice.below(3) {
        match dice.below(20) {
            0 => flip(dice, &mut text),
            1 => truncate(dice, &mut text),
            2 => move_line(dice, &mut text),
            3 | 4 => insert_piece(dice, &mut text),
            5 | 6 => assign(dice, &mut text),
            _ => change_token(dice, &mut text),
        }
    }
    text
}

/// Puts a piece of TOML in the place of a few bytes, anywhere.
fn insert_piece(dice: &mut Dice, text: &mut Vec<u8>) {
    let at = dice.below(text.len() + 1);
    let end = (at + dice.below(3) * dice.below(20)).min(text.len());
    text.splice(at..end, dice.pick(&PIECES).bytes());
}

/// Appends an assignment as `--set` takes them.
fn assign(dice: &mut Dice, text: &mut Vec<u8>) {
    let mut path: Vec<&str> = (0..=dice.below(4)).map(|_| dice.pick(&STEPS)).collect();
    if dice.below(8) == 0 {
        path.push(dice.pick(&WORDS));
    }
    let value = if dice.below(2) == 0 { dice.pick(&WORDS) } else { dice.pick(&NUMBERS) };
    text.extend(format!("\n{ASSIGNMENT}{}={value}", path.join(".")).bytes());
}

fn flip(dice: &mut Dice, bytes: &mut [u8]) {
    let at = dice.below(bytes.len());
    if let Some(byte) = bytes.get_mut(at) {
        *byte ^= 1 << dice.below(8);
    }
}

fn truncate(dice: &mut Dice, bytes: &mut Vec<u8>) {
    bytes.truncate(dice.below(bytes.len() + 1));
}

/// Anywhere in the second half, where binary chunks lie.
fn overwrite_float(dice: &mut Dice, bytes: &mut [u8]) {
    let words = bytes.len() / 4;
    let at = (words / 2 + dice.below(words / 2)) * 4;
    let value = FLOATS[dice.below(FLOATS.len())];
    if let Some(slot) = bytes.get_mut(at..at + 4) {
        slot.copy_from_slice(&value.to_le_bytes());
    }
}

/// The length of the whole or of a chunk of a binary container.
fn overwrite_chunk_length(dice: &mut Dice, bytes: &mut [u8]) {
    let lengths: [u32; 6] = [0, 1, 4, 0x7FFF_FFFF, 0xFFFF_FFFF, u32::try_from(dice.below(4096)).unwrap_or(0)];
    let length = lengths[dice.below(lengths.len())];
    let mut at = [8, 12].get(dice.below(3)).copied();
    if at.is_none() {
        // The second chunk follows the first.
        let first = bytes.get(12..16).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        at = first.and_then(|n| usize::try_from(n).ok()).map(|n| n.saturating_add(20));
    }
    if let Some(slot) = at.and_then(|at| bytes.get_mut(at..at.saturating_add(4))) {
        slot.copy_from_slice(&length.to_le_bytes());
    }
}

/// Changes the JSON of a model and mends the container around it, so that the change itself is what is tried.
fn with_json(dice: &mut Dice, bytes: &mut Vec<u8>) {
    let length = bytes.get(12..16).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let end = length.and_then(|n| usize::try_from(n).ok()).and_then(|n| n.checked_add(20));
    let Some(json) = end.filter(|_| bytes.starts_with(b"glTF")).and_then(|end| bytes.get(20..end)) else {
        change_token(dice, bytes);
        return;
    };
    let mut json = json.to_vec();
    change_token(dice, &mut json);
    json.resize(json.len().next_multiple_of(4), b' ');
    let rest = bytes.split_off(json_end(bytes));
    bytes.truncate(12);
    bytes.extend(u32::try_from(json.len()).unwrap_or(0).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend(rest);
    let whole = u32::try_from(bytes.len()).unwrap_or(0);
    bytes[8..12].copy_from_slice(&whole.to_le_bytes());
}

fn json_end(bytes: &[u8]) -> usize {
    let length = bytes.get(12..16).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    bytes.len().min(usize::try_from(length).unwrap_or(0).saturating_add(20))
}

/// Replaces, removes, doubles or swaps a number, a string or a word.
fn change_token(dice: &mut Dice, text: &mut Vec<u8>) {
    let tokens = tokens(text);
    if tokens.is_empty() {
        return;
    }
    let mut token = tokens[dice.below(tokens.len())].clone();
    for _ in 0..4 {
        // A changed key is mostly an unknown one: values lead further.
        let next = text[token.end..].iter().find(|b| !b.is_ascii_whitespace());
        if !matches!(next, Some(b':' | b'=')) {
            break;
        }
        token = tokens[dice.below(tokens.len())].clone();
    }
    let is_number = text[token.start].is_ascii_digit() || text[token.start] == b'-';
    let replacement = match dice.below(10) {
        0 => Vec::new(),
        1 => [&text[token.clone()], b",", &text[token.clone()]].concat(),
        2 => text[tokens[dice.below(tokens.len())].clone()].to_vec(),
        3 => dice.pick(&WORDS).as_bytes().to_vec(),
        4 if !is_number => dice.pick(&NUMBERS).as_bytes().to_vec(),
        _ if is_number => dice.pick(&NUMBERS).as_bytes().to_vec(),
        _ => dice.pick(&WORDS).as_bytes().to_vec(),
    };
    text.splice(token, replacement);
}

/// Where the strings, numbers and words of JSON or TOML lie.
fn tokens(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let in_word = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'+' | b'.');
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let start = at;
        if text[at] == b'"' {
            at += 1;
            while at < text.len() && text[at] != b'"' {
                at += 1;
            }
            at = (at + 1).min(text.len());
            found.push(start..at);
        } else if in_word(text[at]) {
            while at < text.len() && in_word(text[at]) {
                at += 1;
            }
            found.push(start..at);
        } else {
            at += 1;
        }
    }
    found
}

/// Removes a line, or puts it somewhere else too.
fn move_line(dice: &mut Dice, text: &mut Vec<u8>) {
    let mut lines: Vec<Vec<u8>> = text.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
    let line = dice.below(lines.len());
    if dice.below(2) == 0 {
        lines.remove(line);
    } else {
        let to = dice.below(lines.len());
        lines.insert(to, lines[line].clone());
    }
    *text = lines.join(&b'\n');
}

/// Damages saved voxels: one array's head or numbers, packed again so that its sum is right; or the file's own bytes.
pub(crate) fn voxels(dice: &mut Dice, input: &[u8]) -> Vec<u8> {
    let whole = if dice.below(4) > 0 { arrays(input) } else { None };
    let Some(mut arrays) = whole.filter(|a| !a.is_empty()) else {
        let mut bytes = input.to_vec();
        for _ in 0..=dice.below(3) {
            damage(dice, &mut bytes, 0);
        }
        return bytes;
    };
    let which = dice.below(arrays.len());
    match dice.below(8) {
        0 => drop(arrays.remove(which)),
        1 | 2 => {
            let head = arrays[which].1.len().min(128);
            let mut text = arrays[which].1.drain(..head).collect::<Vec<u8>>();
            damage(dice, &mut text, 8);
            text.append(&mut arrays[which].1);
            arrays[which].1 = text;
        }
        _ => {
            for _ in 0..=dice.below(4) {
                damage(dice, &mut arrays[which].1, 128);
            }
        }
    }
    packed(&arrays)
}

/// Changes a byte from `first` on, to another or to one that means much in floats and heads.
fn damage(dice: &mut Dice, bytes: &mut Vec<u8>, first: usize) {
    if bytes.len() <= first {
        return;
    }
    let at = first + dice.below(bytes.len() - first);
    match dice.below(10) {
        0 => bytes.truncate(at),
        1 => bytes.insert(at, b'0'),
        2 => bytes[at] = 0xff,
        3 => bytes[at] = 0x7f,
        4 => bytes[at] = b"9-,'(>Of"[dice.below(8)],
        _ => bytes[at] ^= 1 << dice.below(8),
    }
}

fn arrays(input: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    use std::io::Read as _;
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(input)).ok()?;
    let mut arrays = Vec::new();
    for i in 0..zip.len().min(64) {
        let entry = zip.by_index(i).ok()?;
        let name = entry.name().to_owned();
        let mut bytes = Vec::new();
        entry.take(1 << 20).read_to_end(&mut bytes).ok()?;
        arrays.push((name, bytes));
    }
    Some(arrays)
}

fn packed(arrays: &[(String, Vec<u8>)]) -> Vec<u8> {
    use std::io::Write as _;
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in arrays {
        if zip.start_file(name.as_str(), stored).is_ok() {
            let _ = zip.write_all(bytes); // memory takes everything
        }
    }
    zip.finish().map(std::io::Cursor::into_inner).unwrap_or_default()
}
