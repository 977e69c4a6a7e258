//! A list that is cheap to clone and to change in a few places: clones share all chunks that neither has changed.

use std::sync::Arc;

/// Things in one chunk: the first change after a clone copies as many, and a reference to each chunk.
const CHUNK: usize = 64;

/// A list of fixed length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunks<T> {
    chunks: Arc<Vec<Arc<Vec<T>>>>,
}

impl<T: Clone + Default> Chunks<T> {
    /// So many things, all as they are by default.
    pub fn new(count: usize) -> Self {
        let chunk = |from| Arc::new(vec![T::default(); CHUNK.min(count - from)]);
        Self { chunks: Arc::new((0..count).step_by(CHUNK).map(chunk).collect()) }
    }

    /// One of them.
    pub fn get(&self, index: usize) -> &T {
        &self.chunks[index / CHUNK][index % CHUNK]
    }

    /// One of them, to be changed.
    pub fn get_mut(&mut self, index: usize) -> &mut T {
        let chunks = Arc::make_mut(&mut self.chunks);
        &mut Arc::make_mut(&mut chunks[index / CHUNK])[index % CHUNK]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clone_keeps_what_it_was() {
        let mut list: Chunks<u32> = Chunks::new(130);
        *list.get_mut(129) = 7;
        let before = list.clone();
        *list.get_mut(129) = 8;
        *list.get_mut(0) = 1;
        assert_eq!((*list.get(0), *list.get(129)), (1, 8));
        assert_eq!((*before.get(0), *before.get(129)), (0, 7));
        assert!(Arc::ptr_eq(&list.chunks[1], &before.chunks[1]));
    }
}
