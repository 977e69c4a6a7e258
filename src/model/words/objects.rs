//! Objects that come into the world of a mission and go out of it. Ids are given once: an object that came before stays what
//! it is whatever comes later, and nothing that was bound earlier knows how many there are.

use super::{Location, Misnamed, MissionSpec, ObjectId, ObjectSpec};

impl MissionSpec {
    /// The object of a name that is there.
    pub fn object(&self, name: &str) -> Option<ObjectId> {
        let found = self.names.objects.iter().position(|known| known == name && !name.is_empty());
        found.map(ObjectId::from)
    }

    /// Whether an object is there.
    pub fn has_object(&self, object: ObjectId) -> bool {
        self.names.objects.get(object.index()).is_some_and(|name| !name.is_empty())
    }

    /// Why no further object can be called so; none where one can.
    pub fn misnamed(&self, name: &str) -> Option<Misnamed> {
        let misnamed = Misnamed::by_letters(name).or_else(|| Misnamed::by_arguments(name));
        misnamed.or_else(|| self.object(name).map(|_| Misnamed::Taken))
    }

    /// One more object, whose id is the next one, and where it is.
    ///
    /// # Errors
    /// When nothing can be called so, or another object is.
    pub fn add_object(&mut self, name: &str, spec: ObjectSpec, at: Location) -> Result<ObjectId, Misnamed> {
        if let Some(misnamed) = self.misnamed(name) {
            return Err(misnamed);
        }
        let object = ObjectId::from(self.names.objects.len());
        self.names.objects.push(name.to_owned());
        self.world.objects.push(spec);
        self.start.objects.push(at);
        Ok(object)
    }

    /// An object is gone: its name is free for another, its id is not.
    pub fn remove_object(&mut self, object: ObjectId) {
        self.names.objects.get_mut(object.index()).into_iter().for_each(String::clear);
        self.start.objects.get_mut(object.index()).into_iter().for_each(|at| *at = Location::Unknown);
    }
}
