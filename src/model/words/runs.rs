//! Things by id, of which some are gone: ids are given in runs and never again, and runs come and go.

use std::ops::{Index, IndexMut, Range};
use std::sync::Arc;

use serde::de::Error;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Things by id, in runs that came together. A clone shares all runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Runs<T> {
    /// Each with its first id, in their order; none is empty.
    runs: Vec<(u32, Arc<Vec<T>>)>,
}

impl<T> Runs<T> {
    /// One behind the last id.
    pub fn len(&self) -> usize {
        self.runs.last().map_or(0, |(from, run)| *from as usize + run.len())
    }

    /// Whether nothing is there.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.runs.iter().map(|(_, run)| run.len()).sum()
    }

    /// The thing of an id.
    pub fn get(&self, index: usize) -> Option<&T> {
        let (from, run) = &self.runs[self.run_of(index)?];
        run.get(index - *from as usize)
    }

    /// The run with an id, if it is in one.
    fn run_of(&self, index: usize) -> Option<usize> {
        let before = match self.runs.len() {
            // As in all that never changes.
            1 => usize::from(self.runs[0].0 as usize <= index),
            _ => self.runs.partition_point(|(from, _)| *from as usize <= index),
        };
        let run = before.checked_sub(1)?;
        let (from, things) = &self.runs[run];
        (index < *from as usize + things.len()).then_some(run)
    }

    /// All in the order of their ids.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + Clone {
        self.runs.iter().flat_map(|(_, run)| run.iter())
    }

    /// All with their ids.
    pub fn entries(&self) -> impl DoubleEndedIterator<Item = (usize, &T)> + Clone {
        let with_ids = |(from, run): &'_ (u32, Arc<Vec<T>>)| *from as usize..*from as usize + run.len();
        self.runs.iter().flat_map(move |entry| std::iter::zip(with_ids(entry), entry.1.iter()))
    }

    /// The ids of each run.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.runs.iter().map(|(from, run)| *from as usize..*from as usize + run.len())
    }

    /// Something of each.
    pub fn map<U>(&self, of: impl Fn(&T) -> U) -> Runs<U> {
        let run = |(from, run): &(u32, Arc<Vec<T>>)| (*from, Arc::new(run.iter().map(&of).collect()));
        Runs { runs: self.runs.iter().map(run).collect() }
    }

    /// A further run, which begins at an id that was never given.
    ///
    /// # Panics
    /// When the id is that of something, or lies before something.
    pub fn add(&mut self, from: usize, run: Vec<T>) {
        assert!(self.len() <= from, "ids are given once");
        if !run.is_empty() {
            let from = u32::try_from(from).expect("fewer than 2^32 things in a mission");
            self.runs.push((from, Arc::new(run)));
        }
    }

    /// Runs of which all ids are in a range are gone; what else is in it stays.
    pub fn remove(&mut self, range: Range<usize>) {
        self.runs.retain(|(from, run)| {
            let from = *from as usize;
            from < range.start || range.end < from + run.len()
        });
    }
}

impl<T: Clone> Runs<T> {
    /// The thing of an id, to be changed.
    pub fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        let run = self.run_of(index)?;
        let (from, things) = &mut self.runs[run];
        Arc::make_mut(things).get_mut(index - *from as usize)
    }

    /// All in the order of their ids.
    pub fn to_vec(&self) -> Vec<T> {
        self.iter().cloned().collect()
    }

    /// All, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.runs.iter_mut().flat_map(|(_, run)| Arc::make_mut(run).iter_mut())
    }
}

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self { runs: Vec::new() }
    }
}

impl<T> From<Vec<T>> for Runs<T> {
    fn from(run: Vec<T>) -> Self {
        let mut runs = Self::default();
        runs.add(0, run);
        runs
    }
}

impl<T> FromIterator<T> for Runs<T> {
    fn from_iter<I: IntoIterator<Item = T>>(things: I) -> Self {
        things.into_iter().collect::<Vec<_>>().into()
    }
}

impl<T> Index<usize> for Runs<T> {
    type Output = T;

    fn index(&self, index: usize) -> &T {
        self.get(index).expect("what has the id is there")
    }
}

impl<T: Clone> IndexMut<usize> for Runs<T> {
    fn index_mut(&mut self, index: usize) -> &mut T {
        self.get_mut(index).expect("what has the id is there")
    }
}

/// A list, where all came together; else its runs, each with its first id.
impl<T: Serialize> Serialize for Runs<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.runs.len() < 2 && self.runs.first().is_none_or(|(from, _)| *from == 0) {
            return serializer.collect_seq(self.iter());
        }
        let mut written = serializer.serialize_struct("Runs", 1)?;
        written.serialize_field("runs", &self.runs)?;
        written.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Runs<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written<T> {
            List(Vec<T>),
            Runs { runs: Vec<(u32, Vec<T>)> },
        }
        match Written::deserialize(deserializer)? {
            Written::List(list) => Ok(list.into()),
            Written::Runs { runs } => {
                let mut read = Self::default();
                for (from, run) in runs {
                    if (from as usize) < read.len() {
                        return Err(D::Error::custom("an id is given twice"));
                    }
                    read.add(from as usize, run);
                }
                Ok(read)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_come_and_go_and_ids_stay() {
        let mut runs: Runs<&str> = vec!["root", "tasks"].into();
        runs.add(2, vec!["a", "b"]);
        runs.add(4, vec!["c"]);
        let before = runs.clone();
        runs.remove(2..4);
        runs.add(5, vec!["d"]);
        let entries: Vec<_> = runs.entries().map(|(id, name)| (id, *name)).collect();
        assert_eq!(entries, [(0, "root"), (1, "tasks"), (4, "c"), (5, "d")]);
        assert_eq!((runs.get(2), runs.get(3), runs.get(6)), (None, None, None));
        assert_eq!((runs.len(), runs.count()), (6, 4));
        assert_eq!(before.iter().copied().collect::<Vec<_>>(), ["root", "tasks", "a", "b", "c"]);
        *runs.get_mut(5).unwrap() = "e";
        assert_eq!((runs[5], before.len()), ("e", 5));
    }

    #[test]
    #[should_panic(expected = "ids are given once")]
    fn no_id_is_given_twice() {
        let mut runs: Runs<u8> = vec![0, 1].into();
        runs.add(1, vec![2]);
    }
}
