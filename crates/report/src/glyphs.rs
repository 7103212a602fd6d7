//! Letters of 5 by 7 dots for titles and legends, so that a picture's numbers need no font file.

/// Dots from one letter's left edge to the next one's.
pub const ADVANCE: usize = 6;
/// Dots from top to bottom.
pub const HEIGHT: usize = 7;

/// Width of a line of text in dots.
pub fn width(text: &str) -> usize {
    (text.chars().count() * ADVANCE).saturating_sub(1)
}

/// Calls `dot` with column and row of every dot that is set. Capitals are drawn small, strange characters as a box.
pub fn draw(text: &str, mut dot: impl FnMut(usize, usize)) {
    for (place, letter) in text.chars().enumerate() {
        for (y, row) in rows(letter.to_ascii_lowercase()).into_iter().enumerate() {
            for x in (0..5).filter(|x| row & (0b10000 >> x) != 0) {
                dot(place * ADVANCE + x, y);
            }
        }
    }
}

/// The rows of a letter from the top; bit 4 is the left dot.
fn rows(letter: char) -> [u8; HEIGHT] {
    match letter {
        ' ' => [0; HEIGHT],
        '0' => [14, 17, 17, 21, 17, 17, 14],
        '1' => [4, 12, 20, 4, 4, 4, 31],
        '2' => [14, 17, 1, 6, 8, 16, 31],
        '3' => [14, 17, 1, 6, 1, 17, 14],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 2, 4, 4, 4],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        '+' => [0, 4, 4, 31, 4, 4, 0],
        '-' => [0, 0, 0, 31, 0, 0, 0],
        '.' => [0, 0, 0, 0, 0, 12, 12],
        ',' => [0, 0, 0, 0, 12, 4, 8],
        ':' => [0, 12, 12, 0, 12, 12, 0],
        '_' => [0, 0, 0, 0, 0, 0, 31],
        '/' => [1, 1, 2, 4, 8, 16, 16],
        '(' => [2, 4, 8, 8, 8, 4, 2],
        ')' => [8, 4, 2, 2, 2, 4, 8],
        'a' => [0, 0, 14, 1, 15, 17, 15],
        'b' => [16, 16, 30, 17, 17, 17, 30],
        'c' => [0, 0, 14, 17, 16, 17, 14],
        'd' => [1, 1, 15, 17, 17, 17, 15],
        'e' => [0, 0, 14, 17, 31, 16, 14],
        'f' => [6, 9, 8, 28, 8, 8, 8],
        'g' => [0, 0, 15, 17, 15, 1, 14],
        'h' => [16, 16, 22, 25, 17, 17, 17],
        'i' => [4, 0, 12, 4, 4, 4, 14],
        'j' => [2, 0, 6, 2, 2, 18, 12],
        'k' => [16, 16, 18, 20, 24, 20, 18],
        'l' => [12, 4, 4, 4, 4, 4, 14],
        'm' => [0, 0, 26, 21, 21, 21, 21],
        'n' => [0, 0, 22, 25, 17, 17, 17],
        'o' => [0, 0, 14, 17, 17, 17, 14],
        'p' => [0, 0, 30, 17, 30, 16, 16],
        'q' => [0, 0, 15, 17, 15, 1, 1],
        'r' => [0, 0, 22, 25, 16, 16, 16],
        's' => [0, 0, 15, 16, 14, 1, 30],
        't' => [8, 8, 28, 8, 8, 9, 6],
        'u' => [0, 0, 17, 17, 17, 19, 13],
        'v' => [0, 0, 17, 17, 17, 10, 4],
        'w' => [0, 0, 17, 17, 21, 21, 10],
        'x' => [0, 0, 17, 10, 4, 10, 17],
        'y' => [0, 0, 17, 17, 15, 1, 14],
        'z' => [0, 0, 31, 2, 4, 8, 31],
        _ => [31, 17, 17, 17, 17, 17, 31],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_letter_has_its_own_shape_within_five_dots() {
        let letters = "0123456789+-.,:_/()abcdefghijklmnopqrstuvwxyz\u{fffd}";
        let shapes: HashSet<_> = letters.chars().map(rows).collect();
        assert_eq!(shapes.len(), letters.chars().count());
        assert!(shapes.iter().flatten().all(|&row| row < 32));
        assert_eq!((width(""), width("0"), width("-0.5")), (0, 5, 23));
        let mut dots = Vec::new();
        draw(" .", |x, y| dots.push((x, y)));
        assert_eq!(dots, [(7, 5), (8, 5), (7, 6), (8, 6)]);
    }
}
