//! Shapes on as many pages as they need.

use crate::mask::Mask;
use crate::pack::{Frame, Shape, Spot, pack, pack_some};

/// How shapes are spread.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    pub frame: Frame,
    /// Pages at most.
    pub pages: u32,
    /// A group that does not fit on a page is not split.
    pub together: bool,
}

/// Shapes on pages, and how many there are.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    pub spots: Vec<Spot>,
    pub pages: u32,
}

/// A page is first offered this share of its texels, and each time that it cannot take them this factor less.
const OFFER: f64 = 0.98;

/// Places every shape, each of its group's page: a group is split only where a page of its own cannot hold it. `groups`
/// has the group of each shape; those of a group stand together. `None` where the pages do not suffice.
pub(crate) fn spread(shapes: &[Shape], groups: &[u32], how: Spread) -> Option<Packed> {
    let areas: Vec<u64> = shapes
        .iter()
        .map(|s| s[0].grown_area(how.frame.gutter))
        .collect();
    let frame = how.frame;
    let capacity = frame.texels();
    let whole: u64 = areas.iter().sum();
    if whole > capacity * u64::from(how.pages) {
        return None;
    }
    let all: Vec<usize> = (0..shapes.len()).collect();
    if whole <= capacity
        && let Ok(spots) = pack(shapes, &all, frame)
    {
        return Some(Packed { spots, pages: 1 });
    }
    if how.pages <= 1 {
        return None;
    }
    if groups.windows(2).all(|pair| pair[0] != pair[1]) {
        return one_by_one(shapes, &areas, how);
    }
    // The shapes of each group and their area, the largest first.
    let of_group = all.chunk_by(|&a, &b| groups[a] == groups[b]);
    let mut waiting: Vec<Group> = of_group
        .map(|members| Group {
            area: members.iter().map(|&i| areas[i]).sum(),
            members: members.to_vec(),
        })
        .collect();
    waiting.sort_by_key(|group| (std::cmp::Reverse(group.area), group.members[0]));
    let mut spots = vec![Spot::default(); shapes.len()];
    let mut page = 0;
    while !waiting.is_empty() {
        let left: u64 = waiting.iter().map(|group| group.area).sum();
        if left > capacity * u64::from(how.pages - page) {
            return None;
        }
        let placed = match fill(shapes, &mut waiting, frame) {
            Some(placed) => placed,
            None if how.together => return None,
            None => split(shapes, &areas, &mut waiting, frame)?,
        };
        for (i, spot) in placed {
            spots[i] = Spot { page, ..spot };
        }
        page += 1;
    }
    Some(Packed { spots, pages: page })
}

/// The shapes of a group, and what they take with their gutters.
struct Group {
    area: u64,
    members: Vec<usize>,
}

/// Moves groups that find room on an empty page from those that wait, the largest first; `None` where the first alone
/// finds none. Shapes and their places.
fn fill(shapes: &[Shape], waiting: &mut Vec<Group>, frame: Frame) -> Option<Vec<(usize, Spot)>> {
    let mut offer = OFFER * frame.texels() as f64;
    loop {
        let (mut chosen, mut taken, mut area) = (Vec::new(), vec![false; waiting.len()], 0);
        for (group, taken) in waiting.iter().zip(&mut taken) {
            *taken = chosen.is_empty() || (area + group.area) as f64 <= offer;
            if *taken {
                area += group.area;
                chosen.extend_from_slice(&group.members);
            }
        }
        match pack(shapes, &chosen, frame) {
            Ok(spots) => {
                let mut taken = taken.into_iter();
                waiting.retain(|_| taken.next() == Some(false));
                return Some(chosen.into_iter().zip(spots).collect());
            }
            Err(_) if chosen.len() == waiting[0].members.len() => return None,
            Err(_) => offer = OFFER * offer.min(area as f64),
        }
    }
}

/// Moves the largest shapes of the first group that waits to an empty page; the others wait as a group of their own.
/// Shapes and their places, `None` where not even the largest finds room.
fn split(
    shapes: &[Shape],
    areas: &[u64],
    waiting: &mut Vec<Group>,
    frame: Frame,
) -> Option<Vec<(usize, Spot)>> {
    let Group { mut members, .. } = waiting.remove(0);
    members.sort_by_key(|&i| {
        let mask: &Mask = &shapes[i][0];
        (std::cmp::Reverse(mask.width + mask.height), i)
    });
    let mut some = members.len() - 1;
    let placed = loop {
        if some == 0 {
            return None;
        }
        match pack(shapes, &members[..some], frame) {
            Ok(placed) => break placed,
            Err(placed) => some = placed.min(some - 1),
        }
    };
    let rest = members.split_off(some);
    let area = rest.iter().map(|&i| areas[i]).sum();
    let at = waiting.partition_point(|other| other.area > area);
    waiting.insert(
        at,
        Group {
            area,
            members: rest,
        },
    );
    Some(members.into_iter().zip(placed).collect())
}

/// Shapes that are each a group: what finds no room on a page waits for the next.
fn one_by_one(shapes: &[Shape], areas: &[u64], how: Spread) -> Option<Packed> {
    let capacity = how.frame.texels();
    let mut spots = vec![Spot::default(); shapes.len()];
    let mut waiting: Vec<usize> = (0..shapes.len()).collect();
    for page in 0..how.pages {
        let area: u64 = waiting.iter().map(|&i| areas[i]).sum();
        if area > capacity * u64::from(how.pages - page) {
            return None;
        }
        let found = pack_some(shapes, &waiting, how.frame);
        let mut left = Vec::new();
        for (&i, spot) in waiting.iter().zip(found) {
            match spot {
                Some(spot) => spots[i] = Spot { page, ..spot },
                None => left.push(i),
            }
        }
        if left.is_empty() {
            return Some(Packed {
                spots,
                pages: page + 1,
            });
        }
        waiting = left;
    }
    None
}
