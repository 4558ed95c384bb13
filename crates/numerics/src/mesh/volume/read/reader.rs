//! Reader of words, lines and numbers from files with text parts and binary parts.

use std::str::FromStr;

/// Error in the content of a file.
pub(super) enum ReadFault {
    /// Content that cannot be parsed.
    Content { place: String, what: String },
    /// An unsupported element.
    Element { element: u64, what: String },
    /// An element with a vertex that does not exist.
    Vertex { element: u64 },
}

/// Position in a file.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// First character of comment lines, which are skipped.
    comment: Option<u8>,
    /// Whether numbers are binary, and whether they are big-endian.
    pub binary: bool,
    pub big_endian: bool,
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8], comment: Option<u8>) -> Self {
        Self { bytes, at: 0, comment, binary: false, big_endian: false }
    }

    /// An error at this position.
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

    /// Whether the end of the file is reached.
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

    /// The rest of the current line.
    pub fn line(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|b| b != b'\n') {
            self.at += 1;
        }
        let line = String::from_utf8_lossy(&self.bytes[start..self.at]).trim().to_owned();
        self.at = (self.at + 1).min(self.bytes.len());
        line
    }

    /// Skips to the end of the next occurrence of `text`.
    pub fn skip_past(&mut self, text: &str) -> Result<(), ReadFault> {
        let found = self.bytes[self.at..].windows(text.len()).position(|w| w == text.as_bytes());
        let Some(by) = found else { return Err(self.fault(format!("`{text}` is missing"))) };
        self.at += by + text.len();
        Ok(())
    }

    /// The next word as a number in text form.
    pub fn number<T: FromStr>(&mut self, what: &str) -> Result<T, ReadFault> {
        let Some(word) = self.word() else { return Err(self.fault(format!("{what} is missing"))) };
        word.parse().map_err(|_| self.fault(format!("`{}` where {what} should be", word.escape_debug())))
    }

    /// A count in text form; an error if the file cannot hold as many items.
    pub fn count(&mut self, what: &str) -> Result<usize, ReadFault> {
        let count: u64 = self.number(what)?;
        self.checked_count(count, what)
    }

    /// Checks a count; an error if the file cannot hold as many items.
    pub fn checked_count(&self, count: u64, what: &str) -> Result<usize, ReadFault> {
        let fits = usize::try_from(count).ok().filter(|n| *n <= self.bytes.len());
        fits.ok_or_else(|| self.fault(format!("{what} is {count}, more than the file can hold")))
    }

    /// Skips a number of bytes.
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

    /// A 32-bit integer, binary or text.
    pub fn i32(&mut self, what: &str) -> Result<i32, ReadFault> {
        if self.binary { self.take().map(i32::from_le_bytes) } else { self.number(what) }
    }

    /// A 64-bit integer, binary or text.
    pub fn u64(&mut self, what: &str) -> Result<u64, ReadFault> {
        if self.binary { self.take().map(u64::from_le_bytes) } else { self.number(what) }
    }

    /// A finite double, binary or text.
    pub fn f64(&mut self, what: &str) -> Result<f64, ReadFault> {
        let x = if self.binary { self.take().map(f64::from_le_bytes)? } else { self.number(what)? };
        if x.is_finite() { Ok(x) } else { Err(self.fault(format!("{what} is {x}"))) }
    }

    /// A finite float, binary or text.
    pub fn f32(&mut self, what: &str) -> Result<f64, ReadFault> {
        if !self.binary {
            return self.f64(what);
        }
        let x = f64::from(self.take().map(f32::from_le_bytes)?);
        if x.is_finite() { Ok(x) } else { Err(self.fault(format!("{what} is {x}"))) }
    }
}
