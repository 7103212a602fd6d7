//! Gutters: texels outside every chart take the mean of filled neighbours, ring by ring, so that bilinear and bicubic
//! look-ups near a chart's border never read void.

/// Rings that a bake fills at least. Bicubic look-up reads 2; the rest helps kept layouts on their first mip levels.
pub const RINGS: u32 = 4;

/// Which void texels of a page are filled, from which texels: found once, applied to every layer.
#[derive(Debug, Clone)]
pub struct Dilation {
    texels: usize,
    targets: Vec<u32>,
    /// Where each target's sources begin, one more than `targets`.
    starts: Vec<u32>,
    sources: Vec<u32>,
}

/// Ring number of a texel that stays void.
const VOID: u8 = u8::MAX;

impl Dilation {
    /// The fills of a square page of `size` texels an edge, where coverage above 0 means filled.
    ///
    /// Ring k takes every void texel with a filled texel among its 8 neighbours after ring k - 1.
    ///
    /// # Panics
    ///
    /// If `coverage` does not hold `size * size` values, or `rings` is above 250.
    pub fn new(coverage: &[f32], size: u32, rings: u32) -> Dilation {
        let edge = size as usize;
        assert_eq!(
            coverage.len(),
            edge * edge,
            "coverage of a page of {size} texels an edge"
        );
        assert!(rings <= 250, "{rings} rings");
        let mut ring: Vec<u8> = coverage
            .iter()
            .map(|&c| if c > 0.0 { 0 } else { VOID })
            .collect();
        let mut fills = Dilation {
            texels: coverage.len(),
            targets: Vec::new(),
            starts: vec![0],
            sources: Vec::new(),
        };
        let mut last = 0..0;
        for k in 1..=rings as u8 {
            let mut found: Vec<u32> = Vec::new();
            let mut consider = |texel: usize, ring: &mut [u8]| {
                for n in neighbours(texel, edge) {
                    if ring[n] == VOID {
                        ring[n] = k;
                        found.push(n as u32);
                    }
                }
            };
            if k == 1 {
                for texel in 0..ring.len() {
                    if ring[texel] == 0 {
                        consider(texel, &mut ring);
                    }
                }
            } else {
                for t in last.clone() {
                    consider(fills.targets[t] as usize, &mut ring);
                }
            }
            found.sort_unstable();
            last = fills.targets.len()..fills.targets.len() + found.len();
            for target in found {
                fills.targets.push(target);
                fills.sources.extend(
                    neighbours(target as usize, edge)
                        .filter(|&n| ring[n] < k)
                        .map(|n| n as u32),
                );
                fills.starts.push(fills.sources.len() as u32);
            }
        }
        fills
    }

    /// Fills a layer of the page in place: every target becomes the mean of its sources. Filled texels stay as they
    /// are, void ones are not read. Unit vectors shorten in the mean; the caller renormalises [`Self::targets`].
    ///
    /// # Panics
    ///
    /// If the layer does not have the page's size.
    pub fn apply(&self, plane: &mut [f32]) {
        assert_eq!(plane.len(), self.texels, "texels of the layer");
        for (k, &target) in self.targets.iter().enumerate() {
            let sources = &self.sources[self.starts[k] as usize..self.starts[k + 1] as usize];
            let sum: f64 = sources.iter().map(|&s| f64::from(plane[s as usize])).sum();
            plane[target as usize] = (sum / sources.len() as f64) as f32;
        }
    }

    /// The texels that are filled (`row * size + column`), in the order of filling.
    pub fn targets(&self) -> &[u32] {
        &self.targets
    }
}

/// The up to 8 neighbours of a texel on the page, row-major.
fn neighbours(texel: usize, edge: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (texel % edge, texel / edge);
    let rows = y.saturating_sub(1)..(y + 2).min(edge);
    let columns = x.saturating_sub(1)..(x + 2).min(edge);
    rows.flat_map(move |r| columns.clone().map(move |c| r * edge + c))
        .filter(move |&n| n != texel)
}
