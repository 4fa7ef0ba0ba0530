//! Conversion of contacts to `clearance_msgs/Contact`.

use clearance_checker::{Contact, LocalContact};
use clearance_monitor::ContactsOfPair;
use clearance_proximity::UnknownDepth;

use crate::messages::clearance_msgs;
use crate::messages::clearance_msgs::BodyPair;
use crate::messages::time_and_geometry::{point_message, vector_message};

/// Messages for the contacts of a pair, the deepest first.
pub fn contact_messages(
    pair: &BodyPair,
    of_pair: &ContactsOfPair,
) -> impl Iterator<Item = clearance_msgs::Contact> {
    let deepest = &of_pair.contacts.deepest;
    let others = of_pair.contacts.others.iter();
    std::iter::once(deepest_message(deepest, pair.clone()))
        .chain(others.map(|contact| local_message(contact, deepest, pair.clone())))
}

fn deepest_message(contact: &Contact, pair: BodyPair) -> clearance_msgs::Contact {
    clearance_msgs::Contact {
        pair,
        position: point_message(&contact.point),
        normal: vector_message(&contact.normal.unwrap_or_default()),
        depth_known: contact.depth.is_some(),
        depth_lower: contact.depth_lower,
        depth_upper: contact.depth.unwrap_or_default(),
        reason: contact.unknown.map_or_else(String::new, |why| why.code().to_owned()),
    }
}

fn local_message(contact: &LocalContact, deepest: &Contact, pair: BodyPair) -> clearance_msgs::Contact {
    let depth = contact.depth.unwrap_or_default();
    let reason = deepest.unknown.filter(|_| contact.depth.is_none());
    clearance_msgs::Contact {
        pair,
        position: point_message(&contact.point),
        normal: vector_message(&contact.normal),
        depth_known: contact.depth.is_some(),
        depth_lower: depth,
        depth_upper: depth,
        reason: reason.map_or_else(String::new, |why: UnknownDepth| why.code().to_owned()),
    }
}
