//! Names with wildcards, as `--density-of`, `--include` and `--exclude` take them.

/// True where `name` fits `pattern`: `*` stands for any characters, `?` for one; everything else for itself.
pub(crate) fn fits(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // The last star, and how much of the name it stands for so far.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => match star {
                Some((at, taken)) => {
                    star = Some((at, taken + 1));
                    (p, n) = (at + 1, taken + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn stars_and_question_marks_stand_for_characters() {
        for (pattern, name) in [
            ("wall", "wall"),
            ("*", ""),
            ("*", "anything at all"),
            ("wall_*", "wall_"),
            ("wall_*", "wall_north"),
            ("*_north", "wall_north_north"),
            ("w?ll*#2", "wall_north#2"),
            ("*a*b*", "xxaxxbxx"),
            ("tür?", "türe"),
        ] {
            assert!(fits(pattern, name), "{pattern} should fit {name}");
        }
        for (pattern, name) in [
            ("wall", "walls"),
            ("wall", "Wall"),
            ("wall_?", "wall_"),
            ("*a", "ab"),
            ("", "a"),
            ("a*b*c", "acb"),
        ] {
            assert!(!fits(pattern, name), "{pattern} should not fit {name}");
        }
    }
}
