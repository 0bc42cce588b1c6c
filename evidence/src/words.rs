//! The arguments of a command, read one by one, and the errors that describe a wrong one.

use std::error::Error;
use std::fmt;
use std::iter::Peekable;
use std::str::FromStr;
use std::vec::IntoIter;

/// A wrong command line: `evidence` ends with 2.
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

/// Words of the command line, taken one by one.
pub struct Words(Peekable<IntoIter<String>>);

impl Words {
    /// Takes the words in their order.
    pub fn new(words: Vec<String>) -> Self {
        Self(words.into_iter().peekable())
    }

    /// Takes the next word, if there is one.
    pub fn take(&mut self) -> Option<String> {
        self.0.next()
    }

    /// Takes the next word if it equals `word`, and returns whether it does.
    pub fn next_is(&mut self, word: &str) -> bool {
        self.0.next_if(|next| next == word).is_some()
    }

    /// Takes a word that must be there.
    pub fn word(&mut self, what: &str) -> Result<String, Misuse> {
        self.take().ok_or_else(|| Misuse(format!("the {what} is missing")))
    }

    /// Takes a number, or the default if no word is left.
    pub fn number<T: FromStr>(&mut self, what: &str, default: T) -> Result<T, Misuse> {
        self.take().map_or(Ok(default), |word| parsed(what, &word))
    }

    /// Takes a number that must be there.
    pub fn required<T: FromStr>(&mut self, what: &str) -> Result<T, Misuse> {
        parsed(what, &self.word(what)?)
    }

    /// Takes all words that are left, each a number.
    pub fn numbers<T: FromStr>(&mut self, what: &str) -> Result<Vec<T>, Misuse> {
        self.rest().iter().map(|word| parsed(what, word)).collect()
    }

    /// Takes one of the known words, if there is a word at all.
    pub fn one_of(&mut self, what: &str, known: &[&str]) -> Result<Option<String>, Misuse> {
        match self.take() {
            Some(word) if !known.contains(&word.as_str()) => Err(Misuse::of(what, &word, known)),
            word => Ok(word),
        }
    }

    /// Takes one of the known words, which must be there.
    pub fn required_one_of(&mut self, what: &str, known: &[&str]) -> Result<String, Misuse> {
        self.one_of(what, known)?.ok_or_else(|| Misuse(format!("the {what} is missing")))
    }

    /// Takes all words that are left.
    pub fn rest(&mut self) -> Vec<String> {
        self.0.by_ref().collect()
    }

    /// Refuses words that no command has taken.
    pub fn end(&mut self) -> Result<(), Misuse> {
        self.take().map_or(Ok(()), |word| Err(Misuse(format!("`{word}` is a word too many"))))
    }
}

/// Reads a number.
pub fn parsed<T: FromStr>(what: &str, word: &str) -> Result<T, Misuse> {
    word.parse().map_err(|_| Misuse(format!("`{word}` is no {what}")))
}
