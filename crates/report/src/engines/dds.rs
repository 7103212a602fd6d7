//! A DDS file of BC6H blocks (Microsoft, "Programming Guide for DDS"): three.js reads them by `DDSLoader`, while its
//! `KTX2Loader` has no BC6H.

const DXGI_FORMAT_BC6H_UF16: u32 = 95;

/// The bytes of a square picture, `size` texels along the edge of its largest level, which comes first.
pub fn encode(size: u32, levels: &[Vec<u8>]) -> Vec<u8> {
    let mut words = [0; 37];
    words[0] = u32::from_le_bytes(*b"DDS ");
    // Bytes of the header; what of it counts: caps, height, width, pixel format, levels, length of the largest.
    words[1] = 124;
    words[2] = 0x1 | 0x2 | 0x4 | 0x1000 | 0x2_0000 | 0x8_0000;
    words[3..6].copy_from_slice(&[size, size, levels[0].len() as u32]);
    words[7] = levels.len() as u32;
    // The pixel format: its bytes, and that the second header has it.
    words[19..22].copy_from_slice(&[32, 0x4, u32::from_le_bytes(*b"DX10")]);
    words[27] = match levels.len() {
        1 => 0x1000,
        _ => 0x1000 | 0x8 | 0x40_0000, // with levels
    };
    // Two dimensions, no cube, one picture, opaque.
    words[32..].copy_from_slice(&[DXGI_FORMAT_BC6H_UF16, 3, 0, 1, 3]);
    let header = words.iter().flat_map(|word| word.to_le_bytes());
    header.chain(levels.concat()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_say_what_follows() {
        let file = encode(8, &[vec![1; 64], vec![2; 16]]);
        assert_eq!((&file[..4], file.len()), (&b"DDS "[..], 148 + 64 + 16));
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        // Offsets of the guide: header of 124 bytes at 4, pixel format at 76, second header at 128.
        assert_eq!([4, 12, 16, 20, 28].map(word), [124, 8, 8, 64, 2]);
        assert_eq!((word(76), word(80), &file[84..88]), (32, 4, &b"DX10"[..]));
        assert_eq!([108, 128, 132, 140].map(word), [0x40_1008, 95, 3, 1]);
        assert_eq!((file[148], file[211], file[212]), (1, 1, 2));
        let one = encode(4, &[vec![0; 16]]);
        assert_eq!((one[28], one[108..112].to_vec()), (1, vec![0, 0x10, 0, 0]));
    }
}
