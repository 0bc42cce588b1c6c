//! Search for the most similar known word, by insertions, deletions, replacements and
//! transpositions of letters.

use strsim::osa_distance;

/// Returns the known word that the user probably meant by `word`; `None` if no known word is
/// similar.
pub(crate) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // A long word is not a misspelling of a known word, and the computing time grows with the
    // product of the lengths.
    if word.is_empty() || word.chars().count() > 64 {
        return None;
    }
    let word = word.to_ascii_lowercase().replace('-', "_");
    let limit = (word.chars().count() / 3).max(1);
    known
        .filter_map(|candidate| {
            // The unit may be missing or wrong, as in `inertia` for `inertia_kg_m2`.
            let stem = candidate.starts_with(&format!("{word}_"));
            let edits = || osa_distance(&word, candidate).min(tail_changed(&word, candidate));
            let distance = if stem { 1 } else { edits() };
            (distance <= limit && distance < candidate.chars().count()).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Returns a small distance if the two words begin with the same parts, which have at least six
/// letters in total.
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

#[cfg(test)]
mod tests {
    use super::*;

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
