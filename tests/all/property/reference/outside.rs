//! What others say of the world (`semantics` 8).

use ambidex::model::{Change, Location, Objection, Origin, Uptake};

use super::{Model, Step};

impl Model<'_> {
    /// Somebody says that the world is different; true if a round follows.
    pub fn hear(&mut self, change: Change, origin: Origin) -> bool {
        let objection = self.objection(change).filter(|_| matches!(origin, Origin::Operator | Origin::Controller(_)));
        let Some(why) = objection else {
            let is_different = self.world(change);
            if is_different {
                self.denied.clear();
            }
            self.answer(change, origin, if is_different { Uptake::Changed } else { Uptake::Same });
            return is_different;
        };
        let is_told_again = matches!(origin, Origin::Controller(_)) && self.denied.contains(&(change, origin, why));
        if !is_told_again {
            self.denied.push((change, origin, why));
            self.log.push(Step::Denied { change, origin, why });
        }
        self.answer(change, origin, Uptake::Refused(why));
        false
    }

    fn answer(&mut self, change: Change, origin: Origin, uptake: Uptake) {
        if origin == Origin::Operator {
            self.taken_up.push((change, uptake));
        }
    }

    /// Why nobody but a file of what goes wrong on purpose may say so.
    fn objection(&self, change: Change) -> Option<Objection> {
        match change {
            Change::Fact(fact, _) if self.mission.world.is_outside(fact) => None,
            Change::Fact(..) => Some(Objection::NotOutside),
            Change::Object(object, to) => match self.world_state.objects[object.index()] {
                Location::In(by) => Some(Objection::Held { by }),
                Location::At(_) | Location::Unknown if !to.holders().is_empty() => Some(Objection::NotTheirs),
                Location::At(_) | Location::Unknown => None,
            },
            Change::Base(_) | Change::Laid(..) | Change::Taken(..) | Change::Emptied(_) => Some(Objection::NotTheirs),
            Change::Blocked(_) | Change::Cleared(_) => None,
        }
    }
}
