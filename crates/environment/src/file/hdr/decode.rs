//! Reads RGBE and XYZE, run-length coded (both ways) or flat, in all eight orders of scanlines.

use crate::Image;
use crate::file::image_file::{ImageFile, Labels, Reason, check_size};

/// The picture in the bytes of a `.hdr` file. EXPOSURE and COLORCORR are divided out; XYZE becomes RGB with Radiance's
/// primaries, and what lies outside them is cut off at 0.
pub(crate) fn decode(bytes: &[u8]) -> Result<ImageFile, Reason> {
    // Editors put a byte order mark before the text that the file begins with.
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let header = Header::read(&mut rest)?;
    let (axes, lines, length) = resolution(&line(&mut rest)?)?;
    let (width, height) = if axes.columns {
        (lines, length)
    } else {
        (length, lines)
    };
    check_size(width, height)?;
    let mut scanline = vec![[0u8; 4]; length];
    // Rows are filled as they are read: a header that lies about its size costs no memory.
    let mut values = Vec::new();
    for number in 0..lines {
        read_scanline(&mut rest, &mut scanline).map_err(|problem| {
            format!(
                "{problem} in scanline {number} of {lines}; the file is damaged, export it again"
            )
        })?;
        values.extend(scanline.iter().map(|p| header.value(*p)));
    }
    let mut image = Image::filled(width, height, [0.0; 3]);
    for (at, value) in values.into_iter().enumerate() {
        let (slow, fast) = (at / length, at % length);
        let (x, y) = if axes.columns {
            (slow, fast)
        } else {
            (fast, slow)
        };
        let x = if axes.leftward { width - 1 - x } else { x };
        let y = if axes.upward { height - 1 - y } else { y };
        image.pixels[y * width + x] = value;
    }
    Ok(ImageFile {
        image,
        labels: header.labels,
    })
}

/// What the text before the pixels says.
struct Header {
    labels: Labels,
    xyz: bool,
    /// Divides a stored channel.
    scale: [f64; 3],
}

impl Header {
    fn read(rest: &mut &[u8]) -> Result<Header, Reason> {
        if !line(rest)?.starts_with("#?") {
            return Err("it does not begin with #?; it is no Radiance picture".into());
        }
        let mut header = Header {
            labels: Labels::new(),
            xyz: false,
            scale: [1.0; 3],
        };
        let mut format = false;
        loop {
            let text = line(rest)?;
            if text.is_empty() {
                break;
            }
            let Some((name, value)) = text.split_once('=').filter(|_| !text.starts_with('#'))
            else {
                continue;
            };
            let (name, value) = (name.trim(), value.trim());
            match name {
                "FORMAT" => {
                    format = true;
                    header.xyz = match value {
                        "32-bit_rle_rgbe" => false,
                        "32-bit_rle_xyze" => true,
                        other => return Err(format!("its FORMAT {other} is not known")),
                    };
                }
                "EXPOSURE" => {
                    let factor = numbers::<1>(name, value)?[0];
                    header.scale = header.scale.map(|s| s * factor);
                }
                "COLORCORR" => {
                    let factors = numbers::<3>(name, value)?;
                    header.scale = std::array::from_fn(|c| header.scale[c] * factors[c]);
                }
                "GAMMA" if numbers::<1>(name, value)? != [1.0] => {
                    return Err(format!(
                        "its GAMMA is {value}; export it with linear values"
                    ));
                }
                _ => drop(header.labels.insert(name.into(), value.into())),
            }
        }
        if !format {
            return Err("its header has no FORMAT; it is no Radiance picture".into());
        }
        Ok(header)
    }

    fn value(&self, [r, g, b, e]: [u8; 4]) -> [f32; 3] {
        if e == 0 {
            return [0.0; 3];
        }
        let unit = 2f64.powi(i32::from(e) - 136);
        let stored = [r, g, b].map(|m| f64::from(m) * unit);
        let corrected: [f64; 3] = std::array::from_fn(|c| stored[c] / self.scale[c]);
        if self.xyz {
            let rgb = |row: [f64; 3]| (0..3).map(|c| row[c] * corrected[c]).sum::<f64>();
            RGB_OF_XYZ.map(|row| rgb(row).max(0.0) as f32)
        } else {
            corrected.map(|v| v as f32)
        }
    }
}

/// RGB of XYZ for Radiance's primaries (0.640, 0.330), (0.290, 0.600), (0.150, 0.060) and a white of equal energy.
/// The inverse of the matrix whose columns are the primaries' (x, y, z), each scaled so that they add up to (1, 1, 1).
const RGB_OF_XYZ: [[f64; 3]; 3] = [
    [
        2.565_312_843_029_637_7,
        -1.166_849_615_806_805_8,
        -0.398_463_227_222_832_06,
    ],
    [
        -1.022_108_172_127_911_5,
        1.978_286_616_660_086_8,
        0.043_821_555_467_824_715,
    ],
    [
        0.074_724_377_296_855_85,
        -0.251_939_567_170_273_6,
        1.177_215_189_873_417_8,
    ],
];

/// Numbers above 0.
fn numbers<const N: usize>(name: &str, text: &str) -> Result<[f64; N], Reason> {
    let values: Vec<f64> = text
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .filter(|v: &f64| v.is_finite() && *v > 0.0)
        .collect();
    values
        .try_into()
        .map_err(|_| format!("its {name} is `{text}`; {N} numbers above 0 belong there"))
}

/// The next line without its end.
fn line(rest: &mut &[u8]) -> Result<String, Reason> {
    let end = rest
        .iter()
        .take(1 << 16)
        .position(|b| *b == b'\n')
        .ok_or("its header is cut short; the file is damaged, export it again")?;
    let text = String::from_utf8_lossy(&rest[..end]);
    let text = text.trim_end_matches('\r').into();
    *rest = &rest[end + 1..];
    Ok(text)
}

/// How scanlines follow each other.
struct Axes {
    /// A scanline is a column.
    columns: bool,
    /// Stored from right to left.
    leftward: bool,
    /// Stored from bottom to top.
    upward: bool,
}

/// `-Y 512 +X 1024` and its seven siblings: axes, count of scanlines, pixels in one.
fn resolution(text: &str) -> Result<(Axes, usize, usize), Reason> {
    let unreadable = || format!("its resolution `{text}` is none");
    let words: Vec<&str> = text.split_whitespace().collect();
    let &[slow, lines, fast, length] = words.as_slice() else {
        return Err(unreadable());
    };
    let columns = match (slow, fast) {
        ("-Y" | "+Y", "-X" | "+X") => false,
        ("-X" | "+X", "-Y" | "+Y") => true,
        _ => return Err(unreadable()),
    };
    let axes = Axes {
        columns,
        leftward: [slow, fast].contains(&"-X"),
        upward: [slow, fast].contains(&"+Y"),
    };
    let count = |word: &str| word.parse().map_err(|_| unreadable());
    Ok((axes, count(lines)?, count(length)?))
}

/// Fills one scanline.
fn read_scanline(rest: &mut &[u8], line: &mut [[u8; 4]]) -> Result<(), Reason> {
    let length = line.len();
    let marked = rest.len() >= 4 && rest[..2] == [2, 2] && rest[2] < 128;
    if !marked || !(8..1 << 15).contains(&length) {
        return read_flat(rest, line);
    }
    let stated = usize::from(rest[2]) << 8 | usize::from(rest[3]);
    if stated != length {
        return Err(format!("{stated} pixels instead of {length}"));
    }
    *rest = &rest[4..];
    for channel in 0..4 {
        let mut at = 0;
        while at < length {
            let count = usize::from(take(rest)?);
            let (count, run) = if count > 128 {
                (count - 128, Some(take(rest)?))
            } else {
                (count, None)
            };
            if count == 0 || at + count > length {
                return Err("a run of a wrong length".into());
            }
            for pixel in &mut line[at..at + count] {
                pixel[channel] = match run {
                    Some(value) => value,
                    None => take(rest)?,
                };
            }
            at += count;
        }
    }
    Ok(())
}

/// Pixels one by one; mantissas of 1, 1, 1 repeat the last pixel, several such in a row count in base 256.
fn read_flat(rest: &mut &[u8], line: &mut [[u8; 4]]) -> Result<(), Reason> {
    let (mut at, mut shift) = (0, 0);
    while at < line.len() {
        let pixel = [take(rest)?, take(rest)?, take(rest)?, take(rest)?];
        if pixel[..3] == [1, 1, 1] {
            let count = usize::from(pixel[3]) << shift;
            if at == 0 || at + count > line.len() || shift > 16 {
                return Err("a run of a wrong length".into());
            }
            let last = line[at - 1];
            line[at..at + count].fill(last);
            at += count;
            shift += 8;
        } else {
            line[at] = pixel;
            at += 1;
            shift = 0;
        }
    }
    Ok(())
}

fn take(rest: &mut &[u8]) -> Result<u8, Reason> {
    let (&first, tail) = rest.split_first().ok_or("cut short")?;
    *rest = tail;
    Ok(first)
}
