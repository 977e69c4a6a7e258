//! A list that is cheap to clone and to change in a few places: clones share all chunks that neither has changed.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Things in one chunk: the first change after a clone copies as many, and a reference to each chunk.
const CHUNK: usize = 64;

/// Things by number, all as they are by default but for those that were changed.
#[derive(Debug, Clone)]
pub struct Chunks<T> {
    /// Each with its number, in their order. Where all of a chunk are as by default it may be absent.
    chunks: Arc<Vec<(usize, Arc<Vec<T>>)>>,
    default: Arc<T>,
}

impl<T: Clone + Default + PartialEq> Chunks<T> {
    /// The place of a chunk, or where it would be.
    fn find(&self, chunk: usize) -> Result<usize, usize> {
        // Where none is absent, each stands at its number.
        match self.chunks.get(chunk) {
            Some((number, _)) if *number == chunk => Ok(chunk),
            Some(_) | None => self.chunks.binary_search_by_key(&chunk, |(number, _)| *number),
        }
    }

    /// One of them.
    pub fn get(&self, index: usize) -> &T {
        self.find(index / CHUNK).map_or(&self.default, |place| &self.chunks[place].1[index % CHUNK])
    }

    /// One of them, to be changed.
    pub fn get_mut(&mut self, index: usize) -> &mut T {
        let (chunk, place) = (index / CHUNK, self.find(index / CHUNK));
        let chunks = Arc::make_mut(&mut self.chunks);
        let place = place.unwrap_or_else(|place| {
            chunks.insert(place, (chunk, Arc::new(vec![T::default(); CHUNK])));
            place
        });
        &mut Arc::make_mut(&mut chunks[place].1)[index % CHUNK]
    }

    /// Some are as by default, for good: what nobody asks for any more takes no room.
    pub fn forget(&mut self, range: Range<usize>) {
        let Range { start, end } = range;
        for chunk in start / CHUNK..end.div_ceil(CHUNK) {
            let Ok(place) = self.find(chunk) else { continue };
            let chunks = Arc::make_mut(&mut self.chunks);
            let things = Arc::make_mut(&mut chunks[place].1);
            let first = chunk * CHUNK;
            things[start.max(first) - first..end.min(first + CHUNK) - first].fill(T::default());
            if things.iter().all(|thing| *thing == T::default()) {
                chunks.remove(place);
            }
        }
    }
}

impl<T: Default> Default for Chunks<T> {
    fn default() -> Self {
        Self { chunks: Arc::default(), default: Arc::default() }
    }
}

/// A chunk that is absent is one in which all are as by default.
impl<T: Clone + Default + PartialEq> PartialEq for Chunks<T> {
    fn eq(&self, other: &Self) -> bool {
        let numbers = self.chunks.iter().chain(other.chunks.iter()).map(|(number, _)| number * CHUNK);
        numbers.into_iter().all(|from| (from..from + CHUNK).all(|index| self.get(index) == other.get(index)))
    }
}

/// Those that are not as by default, with their numbers.
impl<T: Clone + Default + PartialEq + Serialize> Serialize for Chunks<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let all = self.chunks.iter().flat_map(|(number, things)| {
            let first = number * CHUNK;
            things.iter().enumerate().map(move |(index, thing)| (first + index, thing))
        });
        serializer.collect_seq(all.filter(|(_, thing)| **thing != *self.default))
    }
}

impl<'de, T: Clone + Default + PartialEq + Deserialize<'de>> Deserialize<'de> for Chunks<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut chunks = Self::default();
        for (index, thing) in Vec::<(u32, T)>::deserialize(deserializer)? {
            *chunks.get_mut(index as usize) = thing;
        }
        Ok(chunks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clone_keeps_what_it_was() {
        let mut list: Chunks<u32> = Chunks::default();
        *list.get_mut(129) = 7;
        *list.get_mut(64) = 3;
        let before = list.clone();
        *list.get_mut(129) = 8;
        *list.get_mut(0) = 1;
        assert_eq!((*list.get(0), *list.get(129), *list.get(500)), (1, 8, 0));
        assert_eq!((*before.get(0), *before.get(129)), (0, 7));
        assert!(Arc::ptr_eq(&list.chunks[1].1, &before.chunks[0].1), "what neither changed is shared");
    }

    #[test]
    fn what_is_forgotten_takes_no_room() {
        let mut list: Chunks<u32> = Chunks::default();
        (0..200).for_each(|index| *list.get_mut(index) = 1);
        list.forget(10..130);
        assert_eq!(list.chunks.len(), 3, "of the second chunk nothing is left: {list:?}");
        assert_eq!((*list.get(9), *list.get(10), *list.get(129), *list.get(130)), (1, 0, 0, 1));
        list.forget(0..10);
        list.forget(130..500);
        assert!(list.chunks.is_empty());
        assert_eq!(list, Chunks::default());
    }
}
