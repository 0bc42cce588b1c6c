//! The texts of a spec: the file, and each `--set` of the command line.

/// A range of bytes in one of the sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    /// The index of the source: 0 is the file, `i` the i-th override.
    pub source: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// The place of a value that is not on the command line, for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The file, as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// One text, with the starts of its lines.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// Name of the text for the user.
    pub name: String,
    /// The text.
    pub text: String,
    lines: Vec<usize>,
    /// Line and column of the file at which the text begins, both from 1.
    begins: (usize, usize),
}

impl Source {
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let newlines = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(newlines).collect();
        Self { name: name.into(), text, lines, begins: (1, 1) }
    }

    /// Builds the source as a part of a longer file, which begins at this line and column.
    pub fn within(mut self, line: usize, column: usize) -> Self {
        self.begins = (line, column);
        self
    }

    /// Returns the line and column in the whole file of a place in this text.
    pub fn in_file(&self, line: usize, column: usize) -> (usize, usize) {
        let (first, indent) = self.begins;
        (line + first - 1, if line == 1 { column + indent - 1 } else { column })
    }

    /// Returns the index of the line that holds byte `at`, from 0.
    fn line_index(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at).saturating_sub(1)
    }

    /// Returns the line and column of byte `at`, both from 1, the column in characters.
    pub fn position(&self, at: usize) -> (usize, usize) {
        let at = self.boundary(at);
        let line = self.line_index(at);
        (line + 1, self.text[self.lines[line]..at].chars().count() + 1)
    }

    /// Returns the line number of byte `at`, from 1.
    pub fn line_number(&self, at: usize) -> usize {
        self.line_index(self.boundary(at)) + 1
    }

    /// Returns the line `number` (from 1) without its line break, and the byte at which it starts.
    pub fn line(&self, number: usize) -> (&str, usize) {
        let start = self.lines[number - 1];
        let end = self.lines.get(number).map_or(self.text.len(), |next| next - 1);
        (self.text[start..end].trim_end_matches('\r'), start)
    }

    /// Returns the text of a span.
    pub fn slice(&self, span: Span) -> &str {
        let (start, end) = (self.boundary(span.start), self.boundary(span.end));
        &self.text[start..end.max(start)]
    }

    /// Returns the nearest character boundary at or before `at`, within the text.
    pub fn boundary(&self, at: usize) -> usize {
        let mut at = at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}
