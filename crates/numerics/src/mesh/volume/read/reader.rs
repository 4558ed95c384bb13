//! Words, lines and numbers of a file that is text, binary, or one within the other.

use std::str::FromStr;

/// What is wrong with a file.
pub(super) enum ReadFault {
    /// Something cannot be understood.
    Content { place: String, what: String },
    /// An element that cannot be used.
    Element { element: u64, what: String },
    /// An element with a vertex that does not exist.
    Vertex { element: u64 },
}

/// A place in a file.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Lines that begin with it are passed over.
    comment: Option<u8>,
    /// Whether numbers are binary, and if so whether the highest byte comes first.
    pub binary: bool,
    pub big_endian: bool,
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8], comment: Option<u8>) -> Self {
        Self { bytes, at: 0, comment, binary: false, big_endian: false }
    }

    /// Something wrong at this place.
    pub fn fault(&self, what: impl Into<String>) -> ReadFault {
        let place = if self.binary {
            format!("byte {}", self.at)
        } else {
            let passed = self.bytes.get(..self.at.saturating_sub(1)).unwrap_or(self.bytes);
            format!("line {}", 1 + passed.iter().filter(|b| **b == b'\n').count())
        };
        ReadFault::Content { place, what: what.into() }
    }

    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Whether nothing follows.
    pub fn ended(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// The next word, if there is one.
    pub fn word(&mut self) -> Option<&'a str> {
        loop {
            while self.peek().is_some_and(|b| b.is_ascii_whitespace()) {
                self.at += 1;
            }
            if self.peek().is_none() || self.peek() != self.comment {
                break;
            }
            self.line();
        }
        let start = self.at;
        while self.peek().is_some_and(|b| !b.is_ascii_whitespace()) {
            self.at += 1;
        }
        std::str::from_utf8(&self.bytes[start..self.at]).ok().filter(|w| !w.is_empty())
    }

    /// The rest of this line.
    pub fn line(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|b| b != b'\n') {
            self.at += 1;
        }
        let line = String::from_utf8_lossy(&self.bytes[start..self.at]).trim().to_owned();
        self.at = (self.at + 1).min(self.bytes.len());
        line
    }

    /// Passes over everything up to the end of the next place where `text` stands.
    pub fn skip_past(&mut self, text: &str) -> Result<(), ReadFault> {
        let found = self.bytes[self.at..].windows(text.len()).position(|w| w == text.as_bytes());
        let Some(by) = found else { return Err(self.fault(format!("`{text}` is missing"))) };
        self.at += by + text.len();
        Ok(())
    }

    /// The next word as a number of the text.
    pub fn number<T: FromStr>(&mut self, what: &str) -> Result<T, ReadFault> {
        let Some(word) = self.word() else { return Err(self.fault(format!("{what} is missing"))) };
        word.parse().map_err(|_| self.fault(format!("`{}` where {what} should be", word.escape_debug())))
    }

    /// A count, not more than the file could hold.
    pub fn count(&mut self, what: &str) -> Result<usize, ReadFault> {
        let count: u64 = self.number(what)?;
        self.checked_count(count, what)
    }

    /// A count, if the file can hold as many things.
    pub fn checked_count(&self, count: u64, what: &str) -> Result<usize, ReadFault> {
        let fits = usize::try_from(count).ok().filter(|n| *n <= self.bytes.len());
        fits.ok_or_else(|| self.fault(format!("{what} is {count}, more than the file can hold")))
    }

    /// Passes over so many bytes.
    pub fn skip(&mut self, bytes: usize) -> Result<(), ReadFault> {
        if bytes > self.bytes.len() - self.at {
            return Err(self.fault("the file ends too early"));
        }
        self.at += bytes;
        Ok(())
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], ReadFault> {
        let found = self.bytes.get(self.at..self.at + N).and_then(|b| <[u8; N]>::try_from(b).ok());
        let Some(mut bytes) = found else { return Err(self.fault("the file ends too early")) };
        self.at += N;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A 32-bit integer of a binary part, or a number of the text.
    pub fn i32(&mut self, what: &str) -> Result<i32, ReadFault> {
        if self.binary { self.take().map(i32::from_le_bytes) } else { self.number(what) }
    }

    /// A 64-bit integer of a binary part, or a number of the text.
    pub fn u64(&mut self, what: &str) -> Result<u64, ReadFault> {
        if self.binary { self.take().map(u64::from_le_bytes) } else { self.number(what) }
    }

    /// A double of a binary part, or a number of the text; finite.
    pub fn f64(&mut self, what: &str) -> Result<f64, ReadFault> {
        let x = if self.binary { self.take().map(f64::from_le_bytes)? } else { self.number(what)? };
        if x.is_finite() { Ok(x) } else { Err(self.fault(format!("{what} is {x}"))) }
    }

    /// A float of a binary part, or a number of the text; finite.
    pub fn f32(&mut self, what: &str) -> Result<f64, ReadFault> {
        if !self.binary {
            return self.f64(what);
        }
        let x = f64::from(self.take().map(f32::from_le_bytes)?);
        if x.is_finite() { Ok(x) } else { Err(self.fault(format!("{what} is {x}"))) }
    }
}
