//! A shard: the part of a batch that is planned by one of several processes.

use super::BatchError;
use crate::spec::escape;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Shard number `index` of `of` shards, as in `3/40`. It consists of every `of`-th case, beginning
/// with case number `index`. Shards and cases are counted from 1.
///
/// Neighbouring cases belong to different shards. The hard cases of a sweep are neighbours, so
/// every shard gets a part of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    /// The shard that contains all cases: the only shard of an undivided batch.
    pub const ALL: Self = Self { index: 1, of: 1 };
    /// Largest number of shards. It is limited because a merge opens the files of all shards at
    /// once.
    pub const MOST: u64 = 900;

    /// Creates the shard number `index` of `of` shards; both numbers are at least 1.
    ///
    /// # Errors
    /// Returns an error if `index` is 0 or exceeds `of`, or if `of` exceeds [`Shard::MOST`].
    pub fn new(index: u64, of: u64) -> Result<Self, BatchError> {
        let wrong = |reason: String| {
            let remedy = format!("write --shard i/n with i from 1 to n, and n at most {}", Self::MOST);
            Err(BatchError::argument("E0111", reason, remedy))
        };
        match (index, of) {
            (_, 0) => wrong("--shard: the number of shards is 0".into()),
            (_, of) if of > Self::MOST => wrong(format!("--shard: {of} shards are too many")),
            (0, _) => wrong(format!("--shard: shard 0 of {of} does not exist: shards count from 1")),
            (index, of) if index > of => wrong(format!("--shard: shard {index} of {of} does not exist")),
            (index, of) => Ok(Self { index, of }),
        }
    }

    /// Parses a shard such as `3/40`.
    ///
    /// # Errors
    /// Returns an error if the text is not a shard.
    pub fn parse(text: &str) -> Result<Self, BatchError> {
        let parts =
            text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match parts {
            Some((index, of)) => Self::new(index, of),
            None => {
                let reason = format!("--shard: `{}` does not have the form i/n", escape(text));
                Err(BatchError::argument("E0111", reason, "write --shard i/n, as in --shard 3/40"))
            }
        }
    }

    /// Returns the index of the shard, counted from 1.
    pub fn index(self) -> u64 {
        self.index
    }

    /// Returns the number of shards.
    pub fn of(self) -> u64 {
        self.of
    }

    /// Returns whether case number `case` belongs to the shard.
    pub fn has(self, case: u64) -> bool {
        case >= self.index && (case - self.index).is_multiple_of(self.of)
    }

    /// Returns the number of cases that belong to the shard if the batch has `cases` cases.
    pub fn count(self, cases: u64) -> u64 {
        (cases + self.of).saturating_sub(self.index) / self.of
    }

    /// Returns the number of a case, counted from 1, from its index `place` in the shard, counted
    /// from 0.
    pub fn case(self, place: u64) -> u64 {
        self.index + place * self.of
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.of)
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl TryFrom<String> for Shard {
    type Error = BatchError;
    fn try_from(text: String) -> Result<Self, BatchError> {
        Self::parse(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_is_in_exactly_one_shard() {
        for (cases, of) in [(0, 3), (1, 3), (10, 3), (12, 4), (5, 7)] {
            let shards: Vec<Shard> = (1..=of).map(|index| Shard::new(index, of).unwrap()).collect();
            for case in 1..=cases {
                assert_eq!(shards.iter().filter(|shard| shard.has(case)).count(), 1, "{case} of {cases}");
            }
            for shard in &shards {
                let own: Vec<u64> = (1..=cases).filter(|case| shard.has(*case)).collect();
                assert_eq!(shard.count(cases), own.len() as u64, "{shard} of {cases}");
                assert!(own.iter().enumerate().all(|(place, case)| shard.case(place as u64) == *case));
            }
            assert_eq!(shards.iter().map(|shard| shard.count(cases)).sum::<u64>(), cases);
        }
    }

    #[test]
    fn impossible_shards_are_refused() {
        for text in
            ["5/4", "0/4", "0/0", "1/0", "1/901", "-1/4", "3", "a/b", "", "1/2/3", "18446744073709551616/2"]
        {
            assert!(Shard::parse(text).is_err(), "{text}");
        }
        assert_eq!(Shard::parse("3/40").unwrap().to_string(), "3/40");
    }
}
