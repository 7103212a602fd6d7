//! A KTX2 container of half floats, or of compressed blocks of 4 x 4 texels (Khronos, KTX File Format Specification
//! 2.0).

use super::{LightLevel, halves};

const IDENTIFIER: [u8; 12] = [
    0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, 13, 10, 26, 10,
];
/// Header, and where the other parts are.
const HEADER: usize = 80;
/// Offset, length and uncompressed length of a level.
const LEVEL_INDEX: usize = 24;

/// What the bytes of a level are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Texels {
    /// Half floats, red, green, blue and alpha.
    Half,
    /// Blocks of unsigned BC6H.
    Bc6h,
    /// Blocks of BC7, linear.
    Bc7,
}

impl Texels {
    /// Its number among Vulkan's formats.
    fn format(self) -> u32 {
        match self {
            Texels::Half => 97,  // VK_FORMAT_R16G16B16A16_SFLOAT
            Texels::Bc6h => 143, // VK_FORMAT_BC6H_UFLOAT_BLOCK
            Texels::Bc7 => 145,  // VK_FORMAT_BC7_UNORM_BLOCK
        }
    }

    /// Bytes of a texel or of a block, to whole multiples of which each level begins.
    fn bytes(self) -> usize {
        match self {
            Texels::Half => 8,
            Texels::Bc6h | Texels::Bc7 => 16,
        }
    }

    /// Bytes of the numbers that a processor of another byte order would turn; blocks have none.
    fn number(self) -> u32 {
        match self {
            Texels::Half => 2,
            Texels::Bc6h | Texels::Bc7 => 1,
        }
    }
}

/// What kind of picture a file holds.
pub struct Shape {
    /// Width, height and depth of the largest level; 0 deep for no volume.
    pub extent: [u32; 3],
    /// Pictures of an array; 0 for none.
    pub layers: u32,
    /// 6 for a cube, else 1.
    pub faces: u32,
    /// Where columns, rows and slices grow to, as the format's `KTXorientation` says it.
    pub orientation: &'static str,
}

/// The bytes of the file of a picture; of an array of several `layers` each level holds one after another.
pub fn encode(levels: &[LightLevel], layers: u32) -> Vec<u8> {
    let mut shape = square(levels[0].size);
    shape.layers = if layers == 1 { 0 } else { layers };
    let levels: Vec<&[[f32; 3]]> = levels.iter().map(|level| &level.pixels[..]).collect();
    encode_as(&shape, &levels)
}

/// The bytes of the file of a square picture whose levels are blocks, `size` texels along the edge of the largest.
pub fn encode_blocks(size: u32, texels: Texels, levels: &[Vec<u8>]) -> Vec<u8> {
    container(&square(size), texels, levels)
}

/// The bytes of a file of half floats; alpha is 1.
pub fn encode_as(shape: &Shape, levels: &[&[[f32; 3]]]) -> Vec<u8> {
    let bytes = |pixels: &&[[f32; 3]]| {
        halves(pixels)
            .flatten()
            .flat_map(u16::to_le_bytes)
            .collect()
    };
    let levels: Vec<Vec<u8>> = levels.iter().map(bytes).collect();
    container(shape, Texels::Half, &levels)
}

fn square(size: u32) -> Shape {
    Shape {
        extent: [size, size, 0],
        layers: 0,
        faces: 1,
        orientation: "rd",
    }
}

/// The bytes of a file. Levels stand from the largest in the index and from the smallest in the file, as the format
/// wants it.
fn container(shape: &Shape, texels: Texels, levels: &[Vec<u8>]) -> Vec<u8> {
    let (descriptor, values) = (descriptor(texels), key_values(shape.orientation));
    let descriptor_at = HEADER + LEVEL_INDEX * levels.len();
    let values_at = descriptor_at + descriptor.len();
    let data_at = (values_at + values.len()).next_multiple_of(texels.bytes());
    let [width, height, depth] = shape.extent;

    let mut file = IDENTIFIER.to_vec();
    let mut words = |words: &[u32]| file.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    // Format, bytes of a number, width, height, depth, layers, faces, levels, supercompression.
    words(&[texels.format(), texels.number(), width, height, depth]);
    words(&[shape.layers, shape.faces, levels.len() as u32, 0]);
    words(&[descriptor_at, descriptor.len(), values_at, values.len()].map(|at| at as u32));
    words(&[0; 4]); // no global data
    let lengths: Vec<usize> = levels.iter().map(Vec::len).collect();
    for i in 0..levels.len() {
        let at = data_at + lengths[i + 1..].iter().sum::<usize>();
        for number in [at, lengths[i], lengths[i]] {
            file.extend((number as u64).to_le_bytes());
        }
    }
    file.extend(descriptor);
    file.extend(values);
    file.resize(data_at, 0);
    for level in levels.iter().rev() {
        file.extend(level);
    }
    file
}

/// The data format descriptor: linear, with the primaries of BT.709; four signed 16-bit floats, or one sample that is
/// the whole block (Khronos Data Format Specification 1.3).
fn descriptor(texels: Texels) -> Vec<u8> {
    const FLOAT: u32 = 0x80;
    const SIGNED: u32 = 0x40;
    let one = 1.0f32.to_bits();
    // Colour model; edge of a block less one, across and down; first bit, bits less one, kind, least and most of a
    // sample.
    let (model, edge, samples) = match texels {
        Texels::Half => {
            let sample = |(i, channel): (usize, u32)| {
                let kind = FLOAT | SIGNED | channel;
                [16 * i as u32, 15, kind, (-1.0f32).to_bits(), one]
            };
            let channels = [0, 1, 2, 15].into_iter().enumerate();
            (1, 0, channels.map(sample).collect())
        }
        Texels::Bc6h => (133, 3 | 3 << 8, vec![[0, 127, FLOAT, 0, one]]),
        Texels::Bc7 => (134, 3 | 3 << 8, vec![[0, 127, 0, 0, u32::MAX]]),
    };
    let block = 24 + 16 * samples.len() as u32;
    let mut bytes = Vec::new();
    let mut words = |words: &[u32]| bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    words(&[4 + block, 0, 2 | block << 16]); // total length; basic block of Khronos; version 2
    words(&[model | 1 << 8 | 1 << 16, edge]); // BT.709, linear
    words(&[texels.bytes() as u32, 0]); // bytes of plane 0
    for [first, bits, kind, least, most] in samples {
        words(&[first | bits << 16 | kind << 24, 0, least, most]);
    }
    bytes
}

/// Where columns, rows and slices run to; who wrote the file.
fn key_values(orientation: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (key, value) in [("KTXorientation", orientation), ("KTXwriter", "ambake")] {
        let entry = format!("{key}\0{value}\0");
        bytes.extend((entry.len() as u32).to_le_bytes());
        bytes.extend(entry.bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    #[test]
    fn the_index_leads_to_each_level() {
        let level = |size: u32, value: f32| LightLevel {
            size,
            pixels: vec![[value, 2.0 * value, 0.0]; (size * size) as usize],
        };
        let file = encode(&[level(4, 1.0), level(2, 0.25)], 1);
        let number = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        for (i, value) in [1.0f32, 0.25].into_iter().enumerate() {
            let (at, length) = (number(HEADER + 24 * i), number(HEADER + 24 * i + 8));
            assert_eq!((at % 8, length), (0, [128, 32][i]));
            let half = |k: usize| f16::from_le_bytes([file[at + 2 * k], file[at + 2 * k + 1]]);
            let texel = [0, 1, 2, 3].map(|k| half(k).to_f32());
            assert_eq!(texel, [value, 2.0 * value, 0.0, 1.0]);
        }
        assert_eq!(file.len(), number(HEADER) + 128);
    }

    #[test]
    fn header_and_descriptor_are_those_of_the_specification() {
        let level = |size: u32| LightLevel {
            size,
            pixels: vec![[0.0; 3]; (size * size) as usize],
        };
        let file = encode(&[level(4), level(2)], 1);
        let words: Vec<u32> = (file[..220].as_chunks().0.iter())
            .map(|&word| u32::from_le_bytes(word))
            .collect();
        assert_eq!(words[3..12], [97, 2, 4, 4, 0, 0, 1, 2, 0]);
        // Descriptor and key values follow one another; there is no global data.
        assert_eq!(words[12..20], [128, 92, 220, 48, 0, 0, 0, 0]);
        // Of KTX File Format 2.0, section on VK_FORMAT_R16G16B16A16_SFLOAT: red, green, blue and alpha from -1 to 1.
        assert_eq!(words[32..39], [92, 0, 88 << 16 | 2, 0x0001_0101, 0, 8, 0]);
        let (low, high) = (0xbf80_0000, 0x3f80_0000);
        for (i, kind) in [0xc0, 0xc1, 0xc2, 0xcf].into_iter().enumerate() {
            let sample = [kind << 24 | 15 << 16 | (16 * i as u32), 0, low, high];
            assert_eq!(words[39 + 4 * i..][..4], sample);
        }
        let values = b"\x12\0\0\0KTXorientation\0rd\0\0\0\x11\0\0\0KTXwriter\0ambake\0\0\0\0";
        assert_eq!(file[220..268], *values);
    }

    #[test]
    fn blocks_are_described_as_the_specification_has_it_and_begin_at_multiples_of_sixteen() {
        let levels = [vec![1; 4 * 16], vec![2; 16], vec![3; 16]];
        for (texels, format, model, sample) in [
            (
                Texels::Bc6h,
                143,
                133,
                [0x80 << 24 | 127 << 16, 0, 0, 0x3f80_0000],
            ),
            (Texels::Bc7, 145, 134, [127 << 16, 0, 0, u32::MAX]),
        ] {
            let file = encode_blocks(8, texels, &levels);
            let words: Vec<u32> = (file[..file.len() / 4 * 4].as_chunks().0.iter())
                .map(|&word| u32::from_le_bytes(word))
                .collect();
            assert_eq!(words[3..12], [format, 1, 8, 8, 0, 0, 1, 3, 0]);
            let at = words[12] as usize / 4;
            let basic = [44, 0, 40 << 16 | 2, model | 0x0001_0100, 0x0303, 16, 0];
            assert_eq!(words[at..at + 7], basic);
            assert_eq!(words[at + 7..at + 11], sample);
            // The smallest level comes first.
            for (i, level) in levels.iter().enumerate() {
                let entry = &words[20 + 6 * i..][..6];
                let (begin, length) = (entry[0] as usize, level.len());
                assert_eq!((begin % 16, entry[1], entry[3]), (0, 0, 0));
                assert_eq!([entry[2], entry[4]], [length as u32; 2]);
                assert_eq!(file[begin..begin + length], level[..]);
                let after: usize = levels[i + 1..].iter().map(Vec::len).sum();
                assert_eq!(begin, words[20 + 12] as usize + after);
            }
            assert_eq!(file.len(), words[20] as usize + 64);
        }
    }
}
