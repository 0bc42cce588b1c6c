//! The nearest known word.

/// The known word that `word` was probably meant to be.
pub(crate) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // A long word is no typo of a short one, and the distance costs the product of the lengths.
    if word.is_empty() || word.chars().count() > 64 {
        return None;
    }
    let word = word.to_ascii_lowercase().replace('-', "_");
    let limit = (word.chars().count() / 3).max(1);
    known
        .filter_map(|candidate| {
            // `inertia` for `inertia_kg_m2`: the unit left out, or another one.
            let stem = candidate.starts_with(&format!("{word}_"));
            let distance =
                if stem { 1 } else { distance(&word, candidate).min(tail_changed(&word, candidate)) };
            (distance <= limit && distance < candidate.chars().count()).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// A small distance when both start with the same words, at least six letters of them.
fn tail_changed(word: &str, candidate: &str) -> usize {
    let common = word.bytes().zip(candidate.bytes()).take_while(|(a, b)| a == b).count();
    let whole_words = word[..floor(word, common)].rfind('_').is_some_and(|at| at >= 6);
    if whole_words { 2 } else { usize::MAX }
}

fn floor(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Edit distance: insertions, deletions, replacements, and swaps of neighbours.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut previous: Vec<usize> = vec![0; b.len() + 1];
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut next = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replaced = row[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            next[j] = replaced.min(row[j] + 1).min(next[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                next[j] = next[j].min(previous[j - 2] + 1);
            }
        }
        (previous, row) = (row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_edits() {
        let cases =
            [("", "", 0), ("abc", "abc", 0), ("abc", "acb", 1), ("kitten", "sitting", 3), ("", "ab", 2)];
        for (a, b, expected) in cases {
            assert_eq!(distance(a, b), expected, "{a} {b}");
        }
    }

    #[test]
    fn typos_and_missing_units_find_the_key() {
        let known = ["inertia_kg_m2", "mass_kg", "duration_s", "angular_velocity_deg_s", "steps"];
        let cases = [
            ("inertia", Some("inertia_kg_m2")),
            ("inertia_kgm2", Some("inertia_kg_m2")),
            ("Duration-s", Some("duration_s")),
            ("angular_velocity_rpm", Some("angular_velocity_deg_s")),
            ("stpes", Some("steps")),
            ("colour", None),
            ("é", None),
        ];
        for (word, expected) in cases {
            assert_eq!(nearest(word, known.into_iter()), expected, "{word}");
        }
    }
}
