//! Rectangles packed in shelves: one for each object whose own charts are kept.

/// Where a rectangle went.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Spot {
    pub page: u32,
    pub x: u32,
    pub y: u32,
}

/// Packs rectangles (width and height in texels, gutters included) on square pages, tallest first, left to right in
/// shelves. The spots in the order given and the number of pages; `None` if one is larger than a page.
pub(crate) fn shelves(sizes: &[[u32; 2]], page: u32) -> Option<(Vec<Spot>, u32)> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), i));
    let mut spots = vec![Spot::default(); sizes.len()];
    let mut next = Spot::default();
    let mut shelf = 0;
    for i in order {
        let [width, height] = sizes[i];
        if width > page || height > page {
            return None;
        }
        if next.x + width > page {
            (next.x, next.y, shelf) = (0, next.y + shelf, 0);
        }
        if next.y + height > page {
            (next, shelf) = (
                Spot {
                    page: next.page + 1,
                    ..Spot::default()
                },
                0,
            );
        }
        spots[i] = next;
        next.x += width;
        shelf = shelf.max(height);
    }
    Some((spots, next.page + 1))
}
