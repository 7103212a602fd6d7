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

/// A page is first offered this share of its texels, and each time it cannot take them this factor less.
const OFFER: f64 = 0.98;

/// Places every shape, each of its group's page: a group is split only where a page of its own cannot hold it. `groups`
/// has the group of each shape; those of a group stand together. `None` where the pages do not suffice.
pub(crate) fn spread(shapes: &[Shape], groups: &[u32], how: Spread) -> Option<Packed> {
    let areas: Vec<u64> = shapes
        .iter()
        .map(|s| s[0].grown_area(how.frame.gutter))
        .collect();
    let frame = how.frame;
    let capacity = f64::from(frame.width) * f64::from(frame.height);
    let whole: u64 = areas.iter().sum();
    if whole as f64 > capacity * f64::from(how.pages) {
        return None;
    }
    let all: Vec<usize> = (0..shapes.len()).collect();
    if whole as f64 <= capacity
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
    let mut waiting: Vec<(u64, Vec<usize>)> = Vec::new();
    for members in all.chunk_by(|&a, &b| groups[a] == groups[b]) {
        waiting.push((members.iter().map(|&i| areas[i]).sum(), members.to_vec()));
    }
    waiting.sort_by_key(|(area, members)| (std::cmp::Reverse(*area), members[0]));
    let mut spots = vec![Spot::default(); shapes.len()];
    let mut page = 0;
    while !waiting.is_empty() {
        if page == how.pages {
            return None;
        }
        let mut put = |chosen: &[usize], placed: Vec<Spot>| {
            for (&i, spot) in chosen.iter().zip(placed) {
                spots[i] = Spot { page, ..spot };
            }
        };
        let mut offer = capacity;
        loop {
            let (mut taken, mut left) = (Vec::new(), Vec::new());
            let mut area = 0.0;
            for (g, (size, members)) in waiting.iter().enumerate() {
                if taken.is_empty() || area + *size as f64 <= offer {
                    area += *size as f64;
                    taken.extend_from_slice(members);
                } else {
                    left.push(g);
                }
            }
            match pack(shapes, &taken, frame) {
                Ok(placed) => {
                    put(&taken, placed);
                    waiting = left
                        .into_iter()
                        .map(|g| std::mem::take(&mut waiting[g]))
                        .collect();
                    break;
                }
                Err(_) if left.len() + 1 < waiting.len() => offer = OFFER * offer.min(area),
                Err(_) if how.together => return None,
                // The largest group alone is too much: its largest shapes go here, the others wait.
                Err(_) => {
                    let (_, mut members) = waiting.remove(0);
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
                    put(&members[..some], placed);
                    let rest = members.split_off(some);
                    let area = rest.iter().map(|&i| areas[i]).sum();
                    let at = waiting.partition_point(|(other, _)| *other > area);
                    waiting.insert(at, (area, rest));
                    break;
                }
            }
        }
        page += 1;
    }
    Some(Packed { spots, pages: page })
}

/// Shapes that are each a group: what finds no room on a page waits for the next.
fn one_by_one(shapes: &[Shape], areas: &[u64], how: Spread) -> Option<Packed> {
    let capacity = u64::from(how.frame.width) * u64::from(how.frame.height);
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
