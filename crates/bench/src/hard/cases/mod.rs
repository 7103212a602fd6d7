//! The cases, one file a topic: how each scene is built, its exact value and what bounds the difference.

mod closed;
mod lobes;
mod overhead;
mod round;
mod scales;
mod tilted;
mod walls;

use super::case::Case;

/// Every case, in the order of the table.
pub fn cases() -> Vec<Case> {
    let topics = [
        walls::cases,
        overhead::cases,
        closed::cases,
        round::cases,
        scales::cases,
        lobes::cases,
        tilted::cases,
    ];
    topics.iter().flat_map(|topic| topic()).collect()
}
