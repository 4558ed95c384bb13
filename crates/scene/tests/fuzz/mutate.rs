//! Damage to files: changes of bytes, numbers, lines and lengths, from a generator with a fixed seed.

use super::corpus::Input;

/// Longest input, bytes.
const LONGEST: usize = 1 << 17;
/// Texts in place of numbers.
const NUMBERS: [&str; 16] = [
    "0",
    "-1",
    "1",
    "2147483647",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "-9223372036854775808",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "99999999999999999999999",
    "0.1",
    "1000000007",
];
/// Bytes in place of binary numbers.
const WORDS: [u32; 8] = [0, 1, 0xffff_ffff, 0x7fff_ffff, 0x8000_0000, 0x7fc0_0000, 0x7f80_0000, 0x0010_0000];

/// A source of changed inputs.
pub struct Mutator {
    state: u64,
}

impl Mutator {
    /// A source that depends on the name only.
    pub fn new(name: &str) -> Self {
        let seed = name
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |h: u64, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        Self { state: seed | 1 }
    }

    /// A number below `end`, 0 for an empty range (xorshift).
    fn below(&mut self, end: usize) -> usize {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        if end == 0 { 0 } else { (self.state % end as u64) as usize }
    }

    /// One of the inputs with one to four changes.
    pub fn change(&mut self, inputs: &[Input]) -> Input {
        let mut input = inputs[self.below(inputs.len())].clone();
        for _ in 0..=self.below(4) {
            let other = self.below(inputs.len());
            self.damage(&mut input.bytes, &inputs[other].bytes);
        }
        input.bytes.truncate(LONGEST);
        input
    }

    fn damage(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        let at = self.below(bytes.len());
        let end = (at + 1 + self.below(64)).min(bytes.len());
        match self.below(11) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
            1 if !bytes.is_empty() => bytes[at] = self.below(256) as u8,
            2 => drop(bytes.drain(at.min(end)..end)),
            3 => {
                let copy = bytes[at.min(end)..end].to_vec();
                let to = self.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            4 => bytes.truncate(at),
            5 => {
                let word = WORDS[self.below(WORDS.len())].to_le_bytes();
                bytes.iter_mut().skip(at).zip(word).for_each(|(to, from)| *to = from);
            }
            6 => {
                let start = self.below(other.len());
                let piece = &other[start..(start + self.below(200)).min(other.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
            7 => self.swap_lines(bytes),
            _ => self.change_number(bytes),
        }
    }

    /// Replaces a decimal number of a text.
    fn change_number(&mut self, bytes: &mut Vec<u8>) {
        let from = self.below(bytes.len());
        let is_part = |b: &u8| b.is_ascii_digit() || b".+-eE".contains(b);
        let Some(start) = bytes.iter().skip(from).position(|b| b.is_ascii_digit()).map(|k| from + k) else {
            return;
        };
        let length = bytes[start..].iter().take_while(|b| is_part(b)).count();
        let number = NUMBERS[self.below(NUMBERS.len())];
        bytes.splice(start..start + length, number.bytes());
    }

    fn swap_lines(&mut self, bytes: &mut Vec<u8>) {
        let mut lines: Vec<&[u8]> = bytes.split_inclusive(|b| *b == b'\n').collect();
        let (a, b) = (self.below(lines.len()), self.below(lines.len()));
        if a < lines.len() && b < lines.len() {
            lines.swap(a, b);
        }
        *bytes = lines.concat();
    }
}
