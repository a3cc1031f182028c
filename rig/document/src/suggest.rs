//! Which word was meant.

/// Most candidates that are looked at: bounds the time for files with thousands of names.
const MAX_CANDIDATES: usize = 1_000;

/// The candidate that a misspelt `word` most likely means, `None` when none is near. Ties go to the first.
pub fn suggest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Words longer than any name are no misspelling; comparing them would only take time.
    if word.len() > 64 {
        return None;
    }
    let lower = word.to_lowercase();
    let allowed = (word.chars().count() / 3).clamp(1, 3);
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates.into_iter().take(MAX_CANDIDATES).filter(|one| one.len() <= 64) {
        let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
        if distance <= allowed && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// How many letters have to be changed, added, left out or exchanged with their neighbours to make one word of another;
/// `None` for words longer than any name.
pub fn distance(one: &str, other: &str) -> Option<usize> {
    (one.len().max(other.len()) <= 64).then(|| strsim::damerau_levenshtein(one, other))
}

#[cfg(test)]
mod tests {
    use super::suggest;

    #[test]
    fn the_nearest_word_is_meant() {
        assert_eq!(suggest("sginal", ["signal", "is"]), Some("signal"));
        assert_eq!(suggest("outputs_in_stop", ["outputs-in-stop"]), Some("outputs-in-stop"));
        assert_eq!(suggest("xyz", ["signal"]), None);
        assert_eq!(suggest(&"x".repeat(100_000), ["signal"]), None);
    }
}
