//! Options of a texture statement in a material library.

/// The options of a texture statement that change where it is read; the others are skipped with their arguments.
pub(super) struct Options<'a> {
    /// The file name, with its spaces.
    pub file: &'a str,
    /// Clamped to the edge rather than repeated.
    pub clamp: bool,
    /// Factors of u and v; v grows upward.
    pub scale: [f32; 2],
    /// Added to u and v after scaling.
    pub offset: [f32; 2],
    /// Multiplier of a bump map.
    pub bump: f32,
}

impl Options<'_> {
    /// The options and the file name of a statement such as `-s 2 2 -clamp on wall.png`.
    pub fn of(statement: &str) -> Options<'_> {
        let mut options = Options {
            file: statement.trim(),
            clamp: false,
            scale: [1.0; 2],
            offset: [0.0; 2],
            bump: 1.0,
        };
        while options.file.starts_with('-') {
            let (name, mut rest) = word(options.file);
            // At most so many arguments follow; of -o, -s and -t as many as are numbers.
            let most = match name {
                "-o" | "-s" | "-t" => 3,
                "-mm" => 2,
                "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan"
                | "-texres" | "-type" => 1,
                _ => break,
            };
            for i in 0..most {
                let (argument, after) = word(rest);
                let number = argument.parse::<f32>().ok().filter(|n| n.is_finite());
                match (name, number) {
                    ("-o", Some(n)) if i < 2 => options.offset[i] = n,
                    ("-s", Some(n)) if i < 2 => options.scale[i] = n,
                    ("-o" | "-s" | "-t", None) => break,
                    ("-bm", Some(n)) => options.bump = n,
                    ("-clamp", _) => options.clamp = argument == "on",
                    _ => {}
                }
                rest = after;
            }
            options.file = rest;
        }
        options
    }
}

/// The first word and what follows it.
fn word(text: &str) -> (&str, &str) {
    let text = text.trim_start();
    text.split_once(char::is_whitespace)
        .map_or((text, ""), |(first, rest)| (first, rest.trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_are_told_from_the_file_name() {
        let options = Options::of("-s 2 3 1 -blendu off -o 0.5 -clamp on -bm 0.2 my wall -1.png");
        assert_eq!(options.file, "my wall -1.png");
        assert_eq!(
            (options.scale, options.offset, options.clamp, options.bump),
            ([2.0, 3.0], [0.5, 0.0], true, 0.2)
        );
        assert_eq!(Options::of("-strange.png").file, "-strange.png");
    }
}
