//! What headers, `bake.json` and saved states say of the options.

use super::{Effort, Options, Pages};
use crate::words::Words;
use ::bake::{AmbientCoefficient, Bounces, View};
use rays::Light;
use serde_json::{Value, json};

impl Options {
    /// Every option under the name of its flag, as headers and `bake.json` carry it and as an interrupted bake compares
    /// it. The pattern names every field, so that a new option cannot be forgotten here.
    pub fn describe(&self) -> Value {
        let Self {
            size,
            density,
            even_density,
            density_of,
            include,
            exclude,
            no_cast,
            buried_of,
            seen_from,
            seen_from_within,
            pages,
            one_page_per_mesh,
            uv,
            gutter,
            mips,
            align,
            effort,
            footprint,
            denoise: _,
            seams,
            seed,
            sky,
            up,
            view: _,
            shading,
            buried,
            under,
            max_distance,
            model,
            bounces,
            lights,
            // Where they are baked they are among the others.
            file_lights: _,
            layers,
            normal_maps,
            ambient_coefficient,
            albedo,
            specular,
            exponent,
            full_highlights: _,
            plan_off,
            engines: _,
            compress: _,
            vertices: _,
        } = self;
        let (rays, target_error, target_relative, max_rays) = match *effort {
            Effort::Rays(rays) => (Some(rays), None, None, None),
            Effort::Target {
                error,
                relative,
                max_rays,
            } => {
                let relative = (relative > 0.0).then_some(relative);
                (None, Some(error), relative, Some(max_rays))
            }
        };
        json!({
            "size": size,
            "density": match even_density {
                true => json!("even"),
                false => json!(density),
            },
            "density_of": density_of.iter().map(|(name, d)| format!("{name}={d}")).collect::<Vec<_>>(),
            "include": include,
            "exclude": exclude,
            "no_cast": no_cast,
            "buried_of": buried_of.iter().map(|(name, of)| format!("{name}={}", of.word())).collect::<Vec<_>>(),
            "seen_from": match seen_from_within {
                true => json!("auto"),
                false => json!(seen_from),
            },
            "pages": match pages {
                Pages::Auto => json!("auto"),
                Pages::Most(pages) => json!(pages),
            },
            "one_page_per_mesh": one_page_per_mesh,
            "uv": uv.word(),
            "gutter": gutter,
            "mips": mips,
            "align": align,
            "rays": rays,
            "target_error": target_error,
            "target_relative": target_relative,
            "max_rays": max_rays,
            "footprint": footprint.word(),
            "denoise": self.denoises().word(),
            "seams": seams.word(),
            "seed": seed,
            "sky": sky,
            "up": up.word(),
            "view": self.view_rule(),
            "shading": shading.word(),
            "buried": buried.word(),
            "under": under,
            "max_distance": max_distance,
            "model": model.map(Words::word),
            "bounces": match bounces {
                Bounces::Off => json!(0),
                Bounces::Most(gathers) => json!(gathers),
                Bounces::Auto => json!("auto"),
            },
            "lights": lights.iter().map(described).collect::<Vec<_>>(),
            "layers": layers,
            "normal_maps": normal_maps,
            "ambient_coefficient": match ambient_coefficient {
                AmbientCoefficient::Albedo => json!("albedo"),
                AmbientCoefficient::Rgb(rgb) => json!(rgb),
                AmbientCoefficient::Material => json!("file"),
            },
            "albedo": albedo,
            "specular": specular,
            "exponent": exponent,
            "full_highlights": self.has_full_highlights(),
            "plan_off": plan_off,
        })
    }

    /// The view rule as outputs state it: `normal`, or an eye point.
    pub fn view_rule(&self) -> String {
        match self.view {
            View::Normal => "normal".into(),
            View::Eye(eye) => format!("{},{},{}", eye.x, eye.y, eye.z),
        }
    }
}

/// A light as outputs state it.
pub(crate) fn described(light: &Light) -> Value {
    match light {
        Light::Distant { toward, irradiance } => {
            json!({ "sun": toward.to_array(), "irradiance": irradiance.to_array() })
        }
        Light::Point {
            position,
            intensity,
            cone,
            range,
        } => json!({
            "point": position.to_array(),
            "intensity": intensity.to_array(),
            "axis": cone.map(|cone| cone.axis.to_array()),
            "cosines": cone.map(|cone| cone.cosines),
            "range": range.is_finite().then_some(range),
        }),
        Light::Sphere {
            position,
            radius,
            radiance,
        } => json!({
            "sphere": position.to_array(),
            "radius": radius,
            "radiance": radiance.to_array(),
        }),
        Light::Rect {
            corner,
            sides,
            radiance,
        } => json!({
            "rect": corner.to_array(),
            "sides": sides.map(|side| side.to_array()),
            "radiance": radiance.to_array(),
        }),
    }
}
