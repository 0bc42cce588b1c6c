//! Texts from which a spec is read: the file, and the value of each `--set` on the command line.

/// A range of bytes in one of the texts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    /// Index of the text: 0 for the file, `i` for the override number `i`, counted from 1.
    pub source: usize,
    /// Index of the first byte of the range.
    pub start: usize,
    /// Index of the byte after the range.
    pub end: usize,
}

/// Position in a file other than the spec, such as a table of cases, for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Name of the file, as the user wrote it.
    pub file: String,
    /// Line number, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
}

/// A text, with the positions at which its lines begin.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// Name of the text in messages.
    pub name: String,
    /// Contents of the text.
    pub text: String,
    lines: Vec<usize>,
    /// Line and column of the file at which the text begins, both counted from 1.
    begins: (usize, usize),
}

impl Source {
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let newlines = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(newlines).collect();
        Self { name: name.into(), text, lines, begins: (1, 1) }
    }

    /// Marks the text as a part of a longer file, beginning at this line and column.
    pub fn within(mut self, line: usize, column: usize) -> Self {
        self.begins = (line, column);
        self
    }

    /// Converts a line and column of this text to a line and column of the whole file.
    pub fn in_file(&self, line: usize, column: usize) -> (usize, usize) {
        let (first, indent) = self.begins;
        (line + first - 1, if line == 1 { column + indent - 1 } else { column })
    }

    /// Returns the index of the line that contains the byte `at`, counted from 0.
    fn line_index(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at).saturating_sub(1)
    }

    /// Returns the line and the column of the byte `at`. The column is in characters; both are
    /// counted from 1.
    pub fn position(&self, at: usize) -> (usize, usize) {
        let at = self.boundary(at);
        let line = self.line_index(at);
        (line + 1, self.text[self.lines[line]..at].chars().count() + 1)
    }

    /// Returns the number of the line that contains the byte `at`, counted from 1.
    pub fn line_number(&self, at: usize) -> usize {
        self.line_index(self.boundary(at)) + 1
    }

    /// Returns the line with the number `number`, counted from 1, without its line break, and the
    /// index of its first byte.
    pub fn line(&self, number: usize) -> (&str, usize) {
        let start = self.lines[number - 1];
        let end = self.lines.get(number).map_or(self.text.len(), |next| next - 1);
        (self.text[start..end].trim_end_matches('\r'), start)
    }

    /// Returns the part of the text in the range `span`.
    pub fn slice(&self, span: Span) -> &str {
        let (start, end) = (self.boundary(span.start), self.boundary(span.end));
        &self.text[start..end.max(start)]
    }

    /// Returns the index of the last character boundary at or before the byte `at`.
    pub fn boundary(&self, at: usize) -> usize {
        let mut at = at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}
