//! Looks textures up: transform, wrap, filter and transfer function.

use crate::{AlphaBlocks, Image, Scene, TextureRef, Wrap};
use glam::{Vec2, Vec3, Vec4};
use std::sync::LazyLock;

/// The sRGB transfer function of IEC 61966-2-1 for each 8-bit code, to linear.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| decoded(code as f64 / 255.0) as f32));

fn decoded(c: f64) -> f64 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

/// A channel in sRGB, to linear.
pub(crate) fn linear(channel: f32) -> f32 {
    decoded(f64::from(channel)) as f32
}

impl Scene {
    /// Linear RGB of a colour texture at a mesh's UV; texels are decoded from sRGB before they are filtered.
    ///
    /// Any `uv` is allowed: far outside 0..1 the wrap rule holds, and a non-finite coordinate counts as 0.
    ///
    /// # Panics
    /// If `texture` is not of this scene.
    pub fn color(&self, texture: &TextureRef, uv: Vec2) -> Vec3 {
        let decode = |p: [u8; 4]| {
            Vec4::new(
                LINEAR[p[0] as usize],
                LINEAR[p[1] as usize],
                LINEAR[p[2] as usize],
                0.0,
            )
        };
        self.image(texture).texel(texture, uv, decode).truncate()
    }

    /// Mean linear RGB of a colour texture over its image; black for one without pixels.
    ///
    /// # Panics
    /// If `texture` is not of this scene.
    pub fn mean_color(&self, texture: &TextureRef) -> Vec3 {
        let pixels = &self.image(texture).pixels;
        let decode = |p: &[u8; 4]| [0, 1, 2].map(|c: usize| f64::from(LINEAR[p[c] as usize]));
        let mut sum = [0.0; 3];
        for pixel in pixels {
            for (sum, value) in sum.iter_mut().zip(decode(pixel)) {
                *sum += value;
            }
        }
        Vec3::from_array(sum.map(|sum| (sum / pixels.len().max(1) as f64) as f32))
    }

    /// The red, green and blue of a texture that holds data, each code over 255, such as roughness in green and
    /// metallic in blue; `uv` as for [`Scene::color`].
    ///
    /// # Panics
    /// If `texture` is not of this scene.
    pub fn linear_texel(&self, texture: &TextureRef, uv: Vec2) -> Vec3 {
        texture.data(self.image(texture), uv)
    }

    /// The alpha of a texture, 0..=1; `uv` as for [`Scene::color`].
    ///
    /// # Panics
    /// If `texture` is not of this scene.
    pub fn alpha(&self, texture: &TextureRef, uv: Vec2) -> f32 {
        self.image(texture).texel(texture, uv, codes).w
    }

    /// [`Scene::alpha`], or where the least and the largest alpha of what lies about the place are enough, the least.
    ///
    /// * `blocks`: those of the texture's image.
    ///
    /// # Panics
    /// If `texture` is not of this scene, or `blocks` are of another image.
    pub fn alpha_unless(
        &self,
        texture: &TextureRef,
        uv: Vec2,
        blocks: &AlphaBlocks,
        are_enough: impl Fn([f32; 2]) -> bool,
    ) -> f32 {
        let image = self.image(texture);
        let place = image.place(texture, uv);
        let range = blocks.about(place.x[0], place.y[0]);
        match are_enough(range) {
            true => range[0],
            false => image.mean(&place, codes).w,
        }
    }

    fn image(&self, texture: &TextureRef) -> &Image {
        &self.images[texture.image as usize]
    }
}

impl TextureRef {
    /// The red, green and blue, each code over 255, of an image that is used so; `uv` as for [`Scene::color`].
    pub(crate) fn data(&self, image: &Image, uv: Vec2) -> Vec3 {
        image.texel(self, uv, codes).truncate()
    }
}

/// Where a look-up lies in an image: the columns and rows of the four texels about it, and the weights of the second.
struct Place {
    x: [u32; 2],
    y: [u32; 2],
    weights: [f32; 2],
}

impl Image {
    fn texel(&self, texture: &TextureRef, uv: Vec2, decode: impl Fn([u8; 4]) -> Vec4) -> Vec4 {
        self.mean(&self.place(texture, uv), decode)
    }

    fn place(&self, texture: &TextureRef, uv: Vec2) -> Place {
        let [u, v] = texture.transform.map(|[a, b, c]| {
            let t = a as f64 * uv.x as f64 + b as f64 * uv.y as f64 + c as f64;
            if t.is_finite() { t } else { 0.0 }
        });
        let [wrap_u, wrap_v] = texture.wrap;
        let along = if texture.linear { pair } else { nearest };
        let (x0, x1, fx) = along(u, self.width, wrap_u);
        let (y0, y1, fy) = along(v, self.height, wrap_v);
        Place {
            x: [x0, x1],
            y: [y0, y1],
            weights: [fx, fy],
        }
    }

    fn mean(&self, place: &Place, decode: impl Fn([u8; 4]) -> Vec4) -> Vec4 {
        let Place {
            x: [x0, x1],
            y: [y0, y1],
            weights: [fx, fy],
        } = *place;
        let row = |y| mix(decode(pixel(self, x0, y)), decode(pixel(self, x1, y)), fx);
        mix(row(y0), row(y1), fy)
    }
}

/// Linear interpolation that leaves equal values as they are, so that an alpha of exactly the cutoff is kept.
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

fn codes(p: [u8; 4]) -> Vec4 {
    Vec4::new(p[0] as f32, p[1] as f32, p[2] as f32, p[3] as f32) / 255.0
}

fn pixel(image: &Image, x: u32, y: u32) -> [u8; 4] {
    image.pixels[y as usize * image.width as usize + x as usize]
}

/// The largest whole number that is not above `t`; processors that have an instruction for it are not all there are.
fn floor(t: f64) -> f64 {
    // From here on every number is whole.
    const WHOLE: f64 = (1_i64 << 52) as f64;
    if t.abs() >= WHOLE {
        return t;
    }
    let whole = t as i64 as f64;
    if whole > t { whole - 1.0 } else { whole }
}

/// The coordinate brought near the image: 0..=1 for repeat and clamp, 0..=2 for mirror.
fn reduce(t: f64, wrap: Wrap) -> f64 {
    match wrap {
        Wrap::Repeat => t - floor(t),
        Wrap::Clamp => t.clamp(0.0, 1.0),
        Wrap::Mirror => t - 2.0 * floor(t / 2.0),
    }
}

/// Index of a texel of the image for one at most one beside it, -1 the first to the left; beside its mirror
/// image for mirror.
fn wrapped(i: i64, size: u32, wrap: Wrap) -> u32 {
    let n = i64::from(size);
    let around = |i: i64, n: i64| match i {
        _ if i < 0 => i + n,
        _ if i < n => i,
        _ => i - n,
    };
    let inside = match wrap {
        Wrap::Repeat => around(i, n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let j = around(i, 2 * n);
            if j < n { j } else { 2 * n - 1 - j }
        }
    };
    inside as u32
}

/// The texel that holds a coordinate, twice, and no weight of the second.
fn nearest(t: f64, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let i = floor(reduce(t, wrap) * f64::from(size)) as i64;
    let texel = wrapped(i, size, wrap);
    (texel, texel, 0.0)
}

/// The two texels whose centres (at half-integers) enclose a coordinate, and the weight of the second.
fn pair(t: f64, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let x = reduce(t, wrap) * f64::from(size) - 0.5;
    let i = floor(x);
    (
        wrapped(i as i64, size, wrap),
        wrapped(i as i64 + 1, size, wrap),
        (x - i) as f32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    /// Two by one texels: black with alpha 0 on the left, sRGB 188 with alpha 255 on the right.
    fn scene() -> Scene {
        let pixels = vec![[0, 0, 0, 0], [188, 188, 188, 255]];
        Scene {
            images: vec![Image {
                name: "two".into(),
                width: 2,
                height: 1,
                pixels,
            }],
            ..Scene::default()
        }
    }

    fn texture(wrap: Wrap, linear: bool) -> TextureRef {
        TextureRef {
            wrap: [wrap; 2],
            linear,
            ..TextureRef::new(0)
        }
    }

    #[test]
    fn texel_centres_lie_at_half_integers_and_filtering_is_linear_between_them() {
        let (scene, t) = (scene(), texture(Wrap::Clamp, true));
        let alphas = [0.0, 0.25, 0.375, 0.5, 0.75, 1.0].map(|u| scene.alpha(&t, Vec2::new(u, 0.5)));
        assert_eq!(alphas, [0.0, 0.0, 0.25, 0.5, 1.0, 1.0]);
        // At u = 0 a repeated image is half way between its last and its first texel, a mirrored one is not.
        assert_eq!(scene.alpha(&texture(Wrap::Repeat, true), Vec2::ZERO), 0.5);
        assert_eq!(scene.alpha(&texture(Wrap::Mirror, true), Vec2::ZERO), 0.0);
    }

    #[test]
    fn filtering_equal_texels_changes_nothing() {
        let mut scene = scene();
        scene.images[0].pixels = vec![[0, 0, 0, 127]; 2];
        let alpha = 127.0 / 255.0;
        for step in 0..1000 {
            let uv = Vec2::new(step as f32 * 0.01713, step as f32 * 0.007);
            let found = scene.alpha(&texture(Wrap::Mirror, true), uv);
            assert_eq!(found, alpha, "at {uv}");
        }
    }

    #[test]
    fn what_blocks_say_holds_of_every_look_up() {
        let mut scene = scene();
        let mut code = 1_u32;
        for [width, height] in [[1, 1], [2, 1], [3, 5], [4, 4], [9, 8], [17, 6]] {
            let mut alpha = |_| {
                code = code.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                [
                    0,
                    0,
                    0,
                    [0, 255, 255, (code >> 24) as u8][(code >> 16) as usize % 4],
                ]
            };
            scene.images[0] = Image {
                name: "noise".into(),
                width,
                height,
                pixels: (0..width * height).map(&mut alpha).collect(),
            };
            let blocks = AlphaBlocks::of(&scene.images[0]);
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                for linear in [false, true] {
                    let t = texture(wrap, linear);
                    for step in 0..2000 {
                        let uv = Vec2::new(step as f32 * 0.01713 - 3.0, step as f32 * 0.0071 - 2.0);
                        let exact = scene.alpha(&t, uv);
                        let range = std::cell::Cell::new([0.0; 2]);
                        let found = scene.alpha_unless(&t, uv, &blocks, |own| {
                            range.set(own);
                            own[0] == own[1]
                        });
                        assert_eq!(found, exact, "{width} x {height} {wrap:?} {linear} {uv}");
                        let [least, most] = range.get();
                        assert!(
                            least <= exact && exact <= most,
                            "{exact} of {least}..{most}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn wrap_rules_hold_far_outside() {
        let scene = scene();
        let at = |wrap, u: f32| scene.alpha(&texture(wrap, false), Vec2::new(u, 0.0));
        assert_eq!(
            [
                at(Wrap::Repeat, 7.75),
                at(Wrap::Repeat, -0.25),
                at(Wrap::Repeat, -7.75)
            ],
            [1.0, 1.0, 0.0]
        );
        assert_eq!(
            [
                at(Wrap::Mirror, 1.25),
                at(Wrap::Mirror, -0.25),
                at(Wrap::Mirror, 2.25)
            ],
            [1.0, 0.0, 0.0]
        );
        assert_eq!([at(Wrap::Clamp, 9.0), at(Wrap::Clamp, -9.0)], [1.0, 0.0]);
    }

    #[test]
    fn no_coordinate_panics() {
        let mut scene = scene();
        for (width, height) in [(2, 1), (1, 2)] {
            (scene.images[0].width, scene.images[0].height) = (width, height);
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                for linear in [false, true] {
                    let mut t = texture(wrap, linear);
                    t.transform[0][0] = 3e38;
                    for u in [
                        0.0,
                        -0.0,
                        1.0,
                        -1e-30,
                        1e30,
                        -1e30,
                        f32::MAX,
                        f32::MIN,
                        f32::NAN,
                        f32::INFINITY,
                    ] {
                        for v in [0.99999994, u] {
                            let alpha = scene.alpha(&t, Vec2::new(u, v));
                            assert!(
                                (0.0..=1.0).contains(&alpha),
                                "{wrap:?} {linear} {u} {v}: {alpha}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn colour_is_decoded_from_srgb_and_data_is_not() {
        let (scene, t) = (scene(), texture(Wrap::Clamp, false));
        let uv = Vec2::new(0.9, 0.0);
        let exact = ((188.0f64 / 255.0 + 0.055) / 1.055).powf(2.4) as f32;
        assert_eq!(scene.color(&t, uv), Vec3::splat(exact));
        assert_eq!(scene.linear_texel(&t, uv), Vec3::splat(188.0 / 255.0));
    }
}
