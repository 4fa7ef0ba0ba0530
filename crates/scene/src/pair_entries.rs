//! Entries of an allowed collision matrix: compact storage of one value for pairs of names.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Number of pairs in one word of a row.
const PAIRS_PER_WORD: usize = 32;

/// Bits of a pair: whether it has an entry, and the value of the entry.
const HAS_ENTRY: u64 = 0b01;
const IS_ALLOWED: u64 = 0b10;
const BOTH: u64 = HAS_ENTRY | IS_ALLOWED;

/// For pairs of names: whether they may touch, if the pair has an entry.
///
/// Each name is stored once and has an index; an entry takes two bits. Matrices of planning scenes have entries for nearly all pairs of
/// their names.
#[derive(Clone, Debug, Default)]
pub(super) struct PairEntries {
    /// By index. Each name has an entry.
    names: Vec<Arc<str>>,
    index_by_name: HashMap<Arc<str>, usize>,
    /// For each name, its pairs with the names up to itself, by their indices. A row ends with its last entry.
    rows: Vec<Vec<u64>>,
    /// Number of entries.
    count: usize,
}

/// Place of the bits of a pair.
struct Place {
    row: usize,
    /// Index of the word in the row.
    word: usize,
    /// Number of lower bits in the word.
    shift: usize,
}

impl Place {
    fn of(a: usize, b: usize) -> Self {
        let (row, column) = (a.max(b), a.min(b));
        Self { row, word: column / PAIRS_PER_WORD, shift: 2 * (column % PAIRS_PER_WORD) }
    }
}

impl PairEntries {
    /// The index of a name, which is added if it is new. An entry for it has to follow.
    pub fn add(&mut self, name: &str) -> usize {
        if let Some(index) = self.index(name) {
            return index;
        }
        let (index, name) = (self.names.len(), Arc::<str>::from(name));
        self.names.push(Arc::clone(&name));
        self.index_by_name.insert(name, index);
        self.rows.push(Vec::new());
        index
    }

    /// The index of a name that has entries.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.index_by_name.get(name).copied()
    }

    /// The names that have entries, in the order of their indices.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(AsRef::as_ref)
    }

    /// The entry of two names, which are given by their indices.
    pub fn get(&self, a: usize, b: usize) -> Option<bool> {
        let Place { row, word, shift } = Place::of(a, b);
        let bits = self.rows[row].get(word)? >> shift;
        (bits & HAS_ENTRY != 0).then_some(bits & IS_ALLOWED != 0)
    }

    /// Sets the entry of two names, which are given by their indices.
    pub fn set(&mut self, a: usize, b: usize, allowed: bool) {
        let Place { row, word, shift } = Place::of(a, b);
        let row = &mut self.rows[row];
        if row.len() <= word {
            row.resize(word + 1, 0);
        }
        self.count += usize::from((row[word] >> shift) & HAS_ENTRY == 0);
        let bits = if allowed { BOTH } else { HAS_ENTRY };
        row[word] = (row[word] & !(BOTH << shift)) | (bits << shift);
    }

    /// The entries that are left without those of some names.
    pub fn without(&self, names: &HashSet<&str>) -> Self {
        let is_left: Vec<bool> = self.names().map(|name| !names.contains(name)).collect();
        let mut left = Self::default();
        let mut indices = vec![None; self.names.len()];
        for (a, b, allowed) in self.iter().filter(|&(a, b, _)| is_left[a] && is_left[b]) {
            let [a, b] = [a, b].map(|i| *indices[i].get_or_insert_with(|| left.add(&self.names[i])));
            left.set(a, b, allowed);
        }
        left
    }

    /// All entries: the indices of the names, and the value.
    fn iter(&self) -> impl Iterator<Item = (usize, usize, bool)> {
        let of_row = move |(row, words): (usize, &Vec<u64>)| {
            let length = (words.len() * PAIRS_PER_WORD).min(row + 1);
            (0..length).filter_map(move |column| Some((row, column, self.get(row, column)?)))
        };
        self.rows.iter().enumerate().flat_map(of_row)
    }
}

/// Equal if they have the same entries, in whatever order they were set.
impl PartialEq for PairEntries {
    fn eq(&self, other: &Self) -> bool {
        let indices: Option<Vec<usize>> = self.names().map(|name| other.index(name)).collect();
        indices.is_some_and(|indices| {
            let is_same =
                |(a, b, allowed): (usize, usize, bool)| other.get(indices[a], indices[b]) == Some(allowed);
            self.count == other.count && self.iter().all(is_same)
        })
    }
}

impl Eq for PairEntries {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Pairs = HashMap<[usize; 2], bool>;

    /// The entries in the order of the list; later ones replace earlier ones.
    fn entries(list: &[(usize, usize, bool)]) -> PairEntries {
        let mut entries = PairEntries::default();
        for (a, b, allowed) in list {
            let [a, b] = [a, b].map(|i| entries.add(&format!("n{i}")));
            entries.set(a, b, *allowed);
        }
        entries
    }

    fn pairs(list: &[(usize, usize, bool)]) -> Pairs {
        list.iter().map(|&(a, b, allowed)| ([a.min(b), a.max(b)], allowed)).collect()
    }

    fn entry(entries: &PairEntries, a: usize, b: usize) -> Option<bool> {
        let index = |i: usize| entries.index(&format!("n{i}"));
        entries.get(index(a)?, index(b)?)
    }

    proptest! {
        #[test]
        fn entries_are_those_of_a_map(
            list in prop::collection::vec((0usize..70, 0usize..70, any::<bool>()), 0..300),
            gone in prop::collection::vec(0usize..70, 0..5),
        ) {
            let (entries, mut pairs) = (entries(&list), pairs(&list));
            for (a, b) in (0..70).flat_map(|a| (0..70).map(move |b| (a, b))) {
                prop_assert_eq!(entry(&entries, a, b), pairs.get(&[a.min(b), a.max(b)]).copied());
            }
            prop_assert_eq!(entries.iter().count(), pairs.len());
            let names: Vec<String> = gone.iter().map(|i| format!("n{i}")).collect();
            let left = entries.without(&names.iter().map(String::as_str).collect());
            pairs.retain(|pair, _| !pair.iter().any(|i| gone.contains(i)));
            for (a, b) in (0..70).flat_map(|a| (0..70).map(move |b| (a, b))) {
                prop_assert_eq!(entry(&left, a, b), pairs.get(&[a.min(b), a.max(b)]).copied());
            }
            let named: HashSet<&str> = left.names().collect();
            let expected: HashSet<String> = pairs.keys().flatten().map(|i| format!("n{i}")).collect();
            prop_assert_eq!(named, expected.iter().map(String::as_str).collect::<HashSet<_>>());
        }

        #[test]
        fn the_order_of_entries_does_not_matter(
            list in prop::collection::vec((0usize..40, 0usize..40, any::<bool>()), 1..60),
        ) {
            // the last entry of each pair
            let last: Vec<_> = pairs(&list).into_iter().map(|([a, b], allowed)| (b, a, allowed)).collect();
            prop_assert_eq!(&entries(&last), &entries(&list));
            prop_assert_ne!(&entries(&last[1..]), &entries(&list));
            let mut other = last.clone();
            other[0].2 = !other[0].2;
            prop_assert_ne!(&entries(&other), &entries(&list));
        }
    }

    #[test]
    fn an_entry_takes_two_bits() {
        let mut entries = PairEntries::default();
        let indices: Vec<usize> = (0..2500).map(|i| entries.add(&format!("object {i}"))).collect();
        for (i, &a) in indices.iter().enumerate() {
            for &b in &indices[..=i] {
                entries.set(a, b, true);
            }
        }
        let bytes: usize = entries.rows.iter().map(|row| 8 * row.capacity()).sum();
        assert!(bytes < 2_000_000, "{bytes}");
    }
}
