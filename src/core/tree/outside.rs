//! What others say of the world: whether they may, and what comes of it (`semantics` 8).

use std::sync::Arc;

use super::{Effect, Outbox, Root};
use crate::world::FreeSpace;
use ambidex_model::state::Stage;
use ambidex_model::{Change, Location, OBSTACLES_MAX, Objection, Origin, Record, Time, Told, Uptake};

impl Root {
    /// Whether it need not even be recorded: a controller reports once more what is known, or what was refused.
    pub(super) fn is_no_news(&self, told: &Told) -> bool {
        // What came before it may make it news.
        let is_next = self.told.is_empty();
        match told {
            Told::World { change, origin: origin @ Origin::Controller(_) } if is_next => {
                match self.objection(*change, *origin) {
                    Some(why) => self.denied.contains(&(*change, *origin, why)),
                    None => !self.makes_different(*change),
                }
            }
            Told::World { .. } | Told::Begin { .. } | Told::Resumed | Told::Ended { .. } => false,
            Told::Service { .. } | Told::Woke | Told::Work { .. } | Told::End { .. } => false,
        }
    }

    /// Takes up what somebody says of the world who does not move it.
    pub(super) fn hear(&mut self, now: Time, change: Change, origin: Origin, out: &mut Outbox) {
        let uptake = match self.objection(change, origin) {
            Some(why) => {
                self.denied.push((change, origin, why));
                out.push(Effect::Record(Box::new(Record::Denied { at: now, change, origin, why })));
                Uptake::Refused(why)
            }
            None if self.change_world(now, change, origin, out) => Uptake::Changed,
            None => Uptake::Same,
        };
        answer(change, origin, uptake, out);
    }

    /// The mission is over: whoever asks is told so.
    pub(super) fn turn_away(&mut self, told: &Told, out: &mut Outbox) {
        match *told {
            Told::World { change, origin } => answer(change, origin, Uptake::Refused(Objection::Over), out),
            Told::Work { .. } => self.decline(out),
            Told::Begin { .. } | Told::Resumed | Told::Ended { .. } => {}
            Told::Service { .. } | Told::Woke | Told::End { .. } => {}
        }
    }

    /// Changes the world; false where it was so already.
    pub(super) fn change_world(&mut self, now: Time, change: Change, origin: Origin, out: &mut Outbox) -> bool {
        let is_different = self.makes_different(change);
        if is_different {
            self.is_wanted = true;
            self.denied.clear();
            self.edit(Record::World { at: now, change, origin }, out);
            if let Change::Blocked(_) | Change::Cleared(_) = change {
                self.look_around();
            }
        }
        is_different
    }

    /// Where the base can drive has become different.
    pub(super) fn look_around(&mut self) {
        let obstacles = &self.state.world().obstacles;
        self.free_space = Arc::new(FreeSpace::with(&self.mission, obstacles));
        self.came = FreeSpace::new(obstacles, self.mission.robot.radius_m);
    }

    fn makes_different(&self, change: Change) -> bool {
        let mut after = self.state.clone();
        after.apply(&Record::World { at: Time::ZERO, change, origin: Origin::Script });
        // A lease may say of a gripper that it is full when nobody knows with what.
        after.world() != self.state.world() || after.table() != self.state.table()
    }

    /// Why somebody may not make this change; none if they may.
    fn objection(&self, change: Change, origin: Origin) -> Option<Objection> {
        if !origin.is_bound() {
            return None;
        }
        if self.state.stage() == Stage::Waiting || self.is_suspended {
            return Some(Objection::NotBegun);
        }
        match change {
            Change::Base(_) | Change::Taken(..) | Change::Emptied(_) | Change::Laid(..) => Some(Objection::NotTheirs),
            Change::Blocked(_) => (self.state.world().obstacles.len() >= OBSTACLES_MAX).then_some(Objection::Full),
            Change::Cleared(_) => None,
            Change::Fact(fact, _) => (!self.mission.world.is_outside(fact)).then_some(Objection::NotOutside),
            Change::Object(object, to) => match (self.state.world().objects[object.index()], to) {
                (Location::In(by), _) => Some(Objection::Held { by }),
                (Location::At(_) | Location::Unknown, Location::In(_)) => Some(Objection::NotTheirs),
                (Location::At(_) | Location::Unknown, Location::At(_) | Location::Unknown) => None,
            },
        }
    }
}

/// Who asked is told what came of it; controllers and files do not ask.
fn answer(change: Change, origin: Origin, uptake: Uptake, out: &mut Outbox) {
    match origin {
        Origin::Operator => out.push(Effect::TakenUp(change, uptake)),
        Origin::Controller(_) | Origin::Script | Origin::Dropped | Origin::Resumed => {}
    }
}
