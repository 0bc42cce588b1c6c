//! Reads the arguments of a command one by one, and reports wrong ones.

use std::error::Error;
use std::fmt;
use std::iter::Peekable;
use std::str::FromStr;
use std::vec::IntoIter;

/// The error of a wrong command line, for which `evidence` ends with exit code 2.
#[derive(Debug)]
pub struct Misuse(String);

impl Misuse {
    /// Creates the error with this description of the fault.
    pub fn new(what: impl Into<String>) -> Self {
        Self(what.into())
    }

    /// Creates the error for an unknown word.
    pub fn of(what: &str, word: &str, known: &[impl AsRef<str>]) -> Self {
        let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
        Self(format!("`{word}` is no {what}; known are {}", known.join(", ")))
    }
}

impl fmt::Display for Misuse {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for Misuse {}

/// The words of the command line that are not read yet.
pub struct Words(Peekable<IntoIter<String>>);

impl Words {
    /// Stores the words in their order.
    pub fn new(words: Vec<String>) -> Self {
        Self(words.into_iter().peekable())
    }

    /// Removes and returns the next word; `None` if no word is left.
    pub fn take(&mut self) -> Option<String> {
        self.0.next()
    }

    /// Removes the next word if it equals `word`, and returns whether it did.
    pub fn next_is(&mut self, word: &str) -> bool {
        self.0.next_if(|next| next == word).is_some()
    }

    /// Removes and returns the next word. Returns an error if no word is left.
    pub fn word(&mut self, what: &str) -> Result<String, Misuse> {
        self.take().ok_or_else(|| Misuse(format!("the {what} is missing")))
    }

    /// Removes the next word and returns it as a number; the default if no word is left.
    pub fn number<T: FromStr>(&mut self, what: &str, default: T) -> Result<T, Misuse> {
        self.take().map_or(Ok(default), |word| parsed(what, &word))
    }

    /// Removes the next word and returns it as a number. Returns an error if no word is left.
    pub fn required<T: FromStr>(&mut self, what: &str) -> Result<T, Misuse> {
        parsed(what, &self.word(what)?)
    }

    /// Removes all remaining words and returns them as numbers.
    pub fn numbers<T: FromStr>(&mut self, what: &str) -> Result<Vec<T>, Misuse> {
        self.rest().iter().map(|word| parsed(what, word)).collect()
    }

    /// Removes and returns the next word, which must be one of the known words; `None` if no word
    /// is left.
    pub fn one_of(&mut self, what: &str, known: &[&str]) -> Result<Option<String>, Misuse> {
        match self.take() {
            Some(word) if !known.contains(&word.as_str()) => Err(Misuse::of(what, &word, known)),
            word => Ok(word),
        }
    }

    /// Removes and returns the next word, which must be one of the known words. Returns an error if
    /// no word is left.
    pub fn required_one_of(&mut self, what: &str, known: &[&str]) -> Result<String, Misuse> {
        self.one_of(what, known)?.ok_or_else(|| Misuse(format!("the {what} is missing")))
    }

    /// Removes and returns all remaining words.
    pub fn rest(&mut self) -> Vec<String> {
        self.0.by_ref().collect()
    }

    /// Returns an error if a word is left.
    pub fn end(&mut self) -> Result<(), Misuse> {
        self.take().map_or(Ok(()), |word| Err(Misuse(format!("`{word}` is a word too many"))))
    }
}

/// Parses a number.
pub fn parsed<T: FromStr>(what: &str, word: &str) -> Result<T, Misuse> {
    word.parse().map_err(|_| Misuse(format!("`{word}` is no {what}")))
}
