//! What is said of what hands do not reach.

use super::{Names, ObjectId, PlaceId};

pub(super) fn unreachable(names: &Names, object: ObjectId, place: Option<PlaceId>, is_shut: bool) -> String {
    let (object, place) = (names.thing(object), place.map(|place| names.place(place)));
    match (place, is_shut) {
        (None, false) => format!("no hand reaches {object} from where it could be taken"),
        (None, true) => format!("no free path leads to where {object} can be taken"),
        (Some(place), false) => format!("no hand that can take {object} reaches {place}"),
        (Some(place), true) => format!("no free path leads to where {object} can be put at {place}"),
    }
}

pub(super) fn no_spot(place: &str, is_taken: bool) -> String {
    match is_taken {
        true => format!("every spot of {place} within reach is taken"),
        false => format!("the hand reaches no spot of {place} from here"),
    }
}
