//! The light and the occlusion of one page, whether it was just baked or read back.

use crate::bake_json::BakeReport;
use crate::{Error, Page};
use std::borrow::Cow;

/// What engine files are made of: one page of a bake.
#[derive(Debug, Clone)]
pub struct PageLight<'a> {
    /// Page number from 0.
    pub page: u32,
    /// Edge in texels.
    pub size: u32,
    /// Rings of void texels that the bake filled around charts.
    pub rings: u32,
    /// Mip levels on which no look-up mixes packed charts.
    pub mips: u32,
    /// Fraction of each texel inside its charts.
    pub coverage: Cow<'a, [f32]>,
    /// The diffuse term: the occlusion.
    pub diffuse: Cow<'a, [f32]>,
    /// E / pi by channel.
    pub light: [Cow<'a, [f32]>; 3],
    /// The layer `lambert` by channel, where there is one.
    pub lit: Option<[Cow<'a, [f32]>; 3]>,
    /// The layer `sh`, plane after plane, where there is one.
    pub sh: Option<Vec<Cow<'a, [f32]>>>,
}

/// Where the light of a bake stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSource {
    /// In the layer `irradiance`.
    Irradiance,
    /// Nowhere: under a uniform sky it is this radiance times the diffuse term.
    Uniform([f32; 3]),
}

/// Where the light of a finished bake stands, by its options.
pub fn light_source(bake: &BakeReport) -> LightSource {
    let rgb = bake.options.get("sky").and_then(|sky| {
        let [r, g, b] = sky.as_array()?.as_slice() else {
            return None;
        };
        Some([r.as_f64()? as f32, g.as_f64()? as f32, b.as_f64()? as f32])
    });
    // Light that surfaces reflect is in no other layer.
    let bounces = bake.options.get("bounces");
    let once = bounces.is_none_or(|bounces| bounces.is_null() || bounces.as_u64() == Some(0));
    let lights = bake
        .options
        .get("lights")
        .and_then(|lights| lights.as_array());
    let alone = once && lights.is_none_or(Vec::is_empty);
    match rgb.filter(|_| alone) {
        Some(sky) => LightSource::Uniform(sky),
        None => LightSource::Irradiance,
    }
}

impl LightSource {
    /// The light of a page whose layer `irradiance` is `light`, where it has one, and whose diffuse term is `diffuse`.
    pub fn light<'a>(
        self,
        light: Option<[Cow<'a, [f32]>; 3]>,
        diffuse: &[f32],
    ) -> Result<[Cow<'a, [f32]>; 3], Error> {
        match (light, self) {
            (Some(light), _) => Ok(light),
            (None, LightSource::Uniform(sky)) => Ok(sky.map(|sky| {
                let light = |&v: &f32| (f64::from(sky) * f64::from(v)) as f32;
                Cow::Owned(diffuse.iter().map(light).collect())
            })),
            (None, LightSource::Irradiance) => Err(Error::MissingLayer {
                layer: "irradiance".into(),
            }),
        }
    }
}

impl<'a> PageLight<'a> {
    /// What `page` of a finished bake, read from its file, holds.
    ///
    /// # Errors
    /// [`Error::MissingLayer`] where the page lacks one that engine files are made of.
    pub fn of(bake: &BakeReport, number: u32, page: &'a Page) -> Result<Self, Error> {
        let layer = |name: &str| {
            let missing = || Error::MissingLayer { layer: name.into() };
            page.values(name).map(Cow::Borrowed).ok_or_else(missing)
        };
        let diffuse = layer("diffuse")?;
        let three = |name: &str| match page.layer(name)?.channels.as_slice() {
            [r, g, b] => Some([r, g, b].map(|c| Cow::Borrowed(c.values.as_slice()))),
            _ => None,
        };
        let option = |name: &str, default: u32| {
            let value = bake.options.get(name).and_then(|value| value.as_u64());
            value.map_or(default, |value| value.min(128) as u32)
        };
        let mips = option("mips", 0).min(6);
        let gutter = atlas::gutter::needed(option("gutter", 2), mips, option("align", 1).max(1));
        Ok(Self {
            page: number,
            size: page.size,
            rings: atlas::RINGS.max(gutter).min(250),
            mips,
            coverage: layer("coverage")?,
            light: light_source(bake).light(three("irradiance"), &diffuse)?,
            lit: three("lambert"),
            sh: ["sh.0", "sh.x", "sh.y", "sh.z"]
                .into_iter()
                .map(three)
                .collect::<Option<Vec<_>>>()
                .map(|planes| planes.into_iter().flatten().collect()),
            diffuse,
        })
    }
}
