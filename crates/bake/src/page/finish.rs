//! The last steps of a page whose tiles are all finished, in this order: mend, denoise, solve seams, dilate, compose.

use super::compose::is_light;
use super::composed::{compose_asked, drop_unasked, is_place};
use super::directional;
use super::joined::{Gutters, Joined, keep_sides, solve_seams};
use super::planes::BakedPage;
use super::stats::ErrorSums;
use super::tangent;
use super::terms::{TermLayers, lights, terms};
use crate::denoise::{Denoiser, Field, Term, oidn};
use crate::mend::{MendedPlanes, Mends};
use crate::options::{Denoise, Options};
use crate::plan::Plan;
use crate::seams::{Across, Seams};
use ambient::Estimate;
use atlas::{Atlas, Dilation, Rasters};
use glam::{DVec3, Vec3};
use layers::Layer;
use rayon::prelude::*;
use rays::World;

/// What the last steps of a page need to know of its bake.
pub(crate) struct Site<'a> {
    pub world: &'a World,
    pub plan: &'a Plan,
    pub atlas: &'a Atlas,
    pub options: &'a Options,
    /// Solids may bury texels.
    pub mends: bool,
    /// Seams between pages.
    pub across: &'a Across,
    pub rasters: &'a Rasters,
}

/// Finishes a page that has all its tiles.
pub(super) fn finish(page: &mut BakedPage, site: &Site<'_>) {
    let Site {
        world,
        plan,
        atlas,
        options,
        rasters,
        ..
    } = *site;
    last_steps(page, site, &terms(options, plan), false);
    directional::unpack(page);
    if options.layers.contains(&Layer::BentTangent) {
        let raster = &rasters.page(world.scene(), atlas, page.page);
        tangent::make(page, world, atlas, raster, options.rings);
    }
    compose_asked(page, options);
    page.finished = true;
}

/// Finishes a page of light alone, but for the layers that would follow from it.
pub(crate) fn finish_light(page: &mut BakedPage, site: &Site<'_>) {
    last_steps(page, site, &lights(site.plan), true);
    page.finished = true;
}

/// Brings these terms of texels that can be seen, on a page that has all its tiles, to about what they are after
/// denoising, without more.
pub(super) fn settle(page: &mut BakedPage, site: &Site<'_>, values: &[Layer]) {
    let Site { plan, options, .. } = *site;
    if options.denoise == Denoise::Regression {
        let mut terms = terms(options, plan);
        terms.retain(|term| values.contains(&term.value));
        terms.iter_mut().for_each(|term| term.rider = None);
        let denoisers = [Denoiser::new(&field(page), &[])];
        denoise_by(page, &terms, options, (&denoisers, None));
    }
}

/// Mends, denoises, solves seams and fills gutters.
fn last_steps(page: &mut BakedPage, site: &Site<'_>, terms: &[TermLayers], of_light: bool) {
    let Site {
        world,
        atlas,
        options,
        mends,
        across,
        rasters,
        ..
    } = *site;
    let seams = &Seams::find(world, atlas, page.page, options.seams, across);
    if mends {
        mend_terms(page, terms);
    }
    if options.denoise != Denoise::Off {
        denoise_terms(page, terms, options, mends, seams);
        if !of_light {
            count_errors(page, options);
        }
    }
    let light = match of_light {
        true => mean_irradiance(page),
        false => options.sky.brightness(),
    };
    let raster = &rasters.page(world.scene(), atlas, page.page);
    let validity = page.layer(Layer::Validity);
    let is_dark = of_light && light == 0.0;
    let system =
        (!seams.is_empty() && !is_dark).then(|| seams.system(world, raster, page.size, validity));
    let joined = system.as_ref().map(|system| Joined {
        system,
        across,
        light: of_light,
    });
    let gutters = solve_seams(page, light, terms, joined);
    if joined.is_some()
        && !of_light
        && let Some((errors, light)) = errors_of(page, options)
    {
        (page.stats.shown, page.stats.irradiance_squares) = (Some(errors), light);
    }
    place(page, world.origin());
    fill_gutters(page, options.rings, &gutters);
    keep_sides(page, terms, joined);
}

/// The mean irradiance of the texels of a page, of the mean of the channels.
fn mean_irradiance(page: &BakedPage) -> f64 {
    let covered = fact(page, Layer::Coverage, 0);
    let lit = |channel| {
        let plane = fact(page, Layer::Irradiance, channel).iter().zip(covered);
        let lit = plane.filter(|(_, covered)| **covered > 0.0);
        lit.map(|(light, _)| f64::from(*light)).sum::<f64>()
    };
    let texels = covered.iter().filter(|covered| **covered > 0.0).count();
    (0..3).map(lit).sum::<f64>() / (3 * texels.max(1)) as f64
}

/// What of a page decides how it is mended.
fn surface(page: &BakedPage) -> MendedPlanes<'_> {
    let three = |layer| [0, 1, 2].map(|channel| fact(page, layer, channel));
    MendedPlanes {
        size: page.size as usize,
        coverage: fact(page, Layer::Coverage, 0),
        validity: fact(page, Layer::Validity, 0),
        position: three(Layer::Position),
        normal: three(Layer::Normal),
        object: fact(page, Layer::Object, 0),
        moved: false,
    }
}

/// Mends the terms of texels that are buried, wholly or in part.
fn mend_terms(page: &mut BakedPage, terms: &[TermLayers]) {
    let mends = Mends::of(&surface(page));
    let texels = page.texels();
    for term in terms {
        let most = if is_light(term.value) { f64::MAX } else { 1.0 };
        // The span of a term of several channels is the largest of theirs.
        let mut spans: Vec<f64> = Vec::new();
        for plane in page.planes_of(term.value).chunks_mut(texels) {
            let own = mends.apply(plane, 0.0, most);
            spans.resize(own.len(), 0.0);
            spans
                .iter_mut()
                .zip(own)
                .for_each(|(span, own)| *span = span.max(own));
        }
        if page.layer(term.std_err).is_some() {
            mends.apply_to_errors(page.planes_of(term.std_err), &spans);
        }
        if let Some(rider) = term.rider {
            page.mend(rider, &mends, [0.0, most]);
        }
        page.mend(term.half, &mends, [f64::MIN, f64::MAX]);
    }
    for layer in [Layer::AnyView, Layer::AnyView4, Layer::AnyView8] {
        page.mend(layer, &mends, [f64::MIN, f64::MAX]);
    }
    directional::mend(page, &mends);
}

/// Gives positions in the coordinates of the file, whatever world coordinates count from.
fn place(page: &mut BakedPage, origin: DVec3) {
    if origin == DVec3::ZERO || page.layer(Layer::Position).is_none() {
        return;
    }
    let texels = page.texels();
    let covered: Vec<bool> = fact(page, Layer::Coverage, 0)
        .iter()
        .map(|&c| c > 0.0)
        .collect();
    let planes = page.planes_of(Layer::Position).chunks_mut(texels);
    for (plane, origin) in planes.zip(origin.to_array()) {
        for (value, _) in plane
            .iter_mut()
            .zip(&covered)
            .filter(|(_, covered)| **covered)
        {
            *value = (f64::from(*value) + origin) as f32;
        }
    }
}

/// Denoises the terms that tiles integrated, over the surfaces of the page. Texels of which nothing can be seen have no
/// part in that: they were carried on from noisy neighbours, and are carried on again, lest a rim of grain stays along
/// every contact. Those too far from what is seen keep their own values and are denoised apart: a picture may show them
/// from where nobody is thought to stand.
fn denoise_terms(
    page: &mut BakedPage,
    terms: &[TermLayers],
    options: &Options,
    mends: bool,
    seams: &Seams,
) {
    let unseen = mends.then(|| Mends::of_unseen(&surface(page)));
    let hidden = hidden(page);
    let denoisers: Vec<Denoiser<'_>> = match options.denoise {
        Denoise::Regression => {
            let field = field(page);
            let hidden = hidden.as_deref().map(|hidden| Field {
                validity: Some(hidden),
                ..field
            });
            let apart = hidden.map(|hidden| Denoiser::new(&hidden, &[]));
            let seen = Denoiser::new(&field, seams.points());
            std::iter::once(seen).chain(apart).collect()
        }
        _ => Vec::new(),
    };
    denoise_by(page, terms, options, (&denoisers, unseen.as_ref()));
}

/// Denoises the terms by these, the first of which is for what can be seen, or by Open Image Denoise where there is
/// none. Those of which nothing can be seen are carried on from the others then.
fn denoise_by(
    page: &mut BakedPage,
    terms: &[TermLayers],
    options: &Options,
    (denoisers, unseen): (&[Denoiser<'_>], Option<&Mends>),
) {
    let texels = page.texels();
    if !denoisers.is_empty() {
        drop_unasked(page, options, is_place);
    }
    for term in terms {
        let &TermLayers {
            value,
            std_err,
            half,
            rider,
            ..
        } = term;
        let all = |layer: Layer| {
            let channels = 0..layer.channels().len();
            channels.map(|channel| fact(page, layer, channel)).collect()
        };
        let mut planes = Term {
            values: all(value),
            riders: rider.map_or(Vec::new(), all),
            halves: match denoisers.is_empty() {
                true => Vec::new(),
                false => all(half),
            },
            std_err: fact(page, std_err, 0),
            sealed: page.layer(Layer::Sealed),
            largest: if is_light(value) { f32::INFINITY } else { 1.0 },
            is_smooth: matches!(value, Layer::Diffuse | Layer::Visibility),
            crosses: !matches!(value, Layer::Specular | Layer::Reflection),
        };
        let found = match denoisers {
            [] => oidn::denoise(&field(page), &planes),
            [seen, apart @ ..] => {
                let mut found = seen.denoise(&planes);
                planes.sealed = None;
                found.extend(apart.iter().flat_map(|apart| apart.denoise(&planes)));
                found
            }
        };
        let mut first = 0;
        for value in term.values() {
            let values = page.planes_of(value);
            for (channel, plane) in values.chunks_mut(texels).enumerate() {
                found
                    .iter()
                    .for_each(|part| part.set_values(first + channel, plane));
            }
            first += value.channels().len();
            if let Some(unseen) = unseen {
                let most = if is_light(value) { f64::MAX } else { 1.0 };
                page.mend(value, unseen, [0.0, most]);
            }
        }
        let errors = page.planes_of(std_err);
        found.iter().for_each(|part| part.set_errors(errors));
    }
    directional::denoise(page, denoisers.first(), unseen, field);
    drop_unasked(page, options, |layer| {
        layer.is_of_halves() || layer == Layer::Sealed
    });
}

/// 1 at the covered texels of which nothing can be seen, 0 elsewhere; `None` where all can.
fn hidden(page: &BakedPage) -> Option<Vec<f32>> {
    let texels = fact(page, Layer::Coverage, 0)
        .iter()
        .zip(page.layer(Layer::Validity)?);
    let hidden = texels.map(|(coverage, validity)| f32::from(*coverage > 0.0 && *validity == 0.0));
    let hidden: Vec<f32> = hidden.collect();
    hidden.contains(&1.0).then_some(hidden)
}

/// The texels of the page as the denoiser sees them.
fn field(page: &BakedPage) -> Field<'_> {
    let plane = |layer, channel| fact(page, layer, channel);
    let three = |layer| [0, 1, 2].map(|channel| plane(layer, channel));
    Field {
        size: page.size as usize,
        coverage: plane(Layer::Coverage, 0),
        validity: page.layer(Layer::Validity),
        position: three(Layer::Position),
        normal: three(Layer::Normal),
        object: plane(Layer::Object, 0),
    }
}

/// One channel of a fact that the page must have.
fn fact(page: &BakedPage, layer: Layer, channel: usize) -> &[f32] {
    let missing = || panic!("the last steps need the layer {}", layer.name());
    page.channel(layer, channel).unwrap_or_else(missing)
}

/// Counts the errors of the page as they stand after denoising.
fn count_errors(page: &mut BakedPage, options: &Options) {
    let Some((mut errors, light)) = errors_of(page, options) else {
        return;
    };
    errors.share(page.stats.errors.squares);
    page.stats.errors = errors;
    page.stats.irradiance_squares = light;
}

/// The errors of diffuse of a page as they stand, and the sum of the squares of those of irradiance.
fn errors_of(page: &BakedPage, options: &Options) -> Option<(ErrorSums, f64)> {
    let std_errs = page.layer(Layer::StdErrDiffuse)?;
    let values = fact(page, Layer::Diffuse, 0);
    let mut errors = ErrorSums::default();
    let mut lights = 0.0;
    let light = page.layer(Layer::StdErrIrradiance);
    let validity = page.layer(Layer::Validity);
    for (texel, coverage) in fact(page, Layer::Coverage, 0).iter().enumerate() {
        if *coverage > 0.0 && validity.is_none_or(|validity| validity[texel] > 0.0) {
            let place = [texel as u32 % page.size, texel as u32 / page.size];
            let [value, std_err] = [values[texel], std_errs[texel]].map(f64::from);
            errors.add(Estimate { value, std_err }, place);
            lights += light.map_or(0.0, |light| f64::from(light[texel]).powi(2));
        }
    }
    if options.sky.map().is_none() {
        lights = (options.sky.brightness()).powi(2) * errors.squares;
    }
    Some((errors, lights))
}

/// Fills so many rings of gutter texels of every layer that dilates, and renews the length of directions there. Values
/// that seams give stand.
fn fill_gutters(page: &mut BakedPage, rings: u32, of_seams: &Gutters) {
    let texels = page.texels();
    let dilation = Dilation::new(&page.planes[0].values, page.size, rings);
    page.planes
        .par_iter_mut()
        .filter(|planes| planes.layer.dilates())
        .flat_map(|planes| planes.values.par_chunks_mut(texels))
        .for_each(|plane| {
            dilation.apply(plane);
        });
    for (layer, channel, gutter) in of_seams {
        let plane = &mut page.planes_of(*layer)[channel * texels..][..texels];
        for &(texel, value) in gutter {
            plane[texel as usize] = value;
        }
    }
    for layer in [Layer::Normal, Layer::Geometric] {
        let Some(planes) = page.planes.iter_mut().find(|p| p.layer == layer) else {
            continue;
        };
        for &target in dilation.targets() {
            let at = |c: usize| c * texels + target as usize;
            let v = &mut planes.values;
            let unit = Vec3::new(v[at(0)], v[at(1)], v[at(2)]).normalize_or_zero();
            for c in 0..3 {
                v[at(c)] = unit[c];
            }
        }
    }
}

#[cfg(test)]
mod tests;
