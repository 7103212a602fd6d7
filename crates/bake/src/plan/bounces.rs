//! Whether light bounces in a bake, and why.

use super::{Decision, OpenTriangles, decision};
use crate::choice::Choice;
use crate::options::{Bounces, Options};
use glam::Vec3;
use scene::{Material, MaterialModel, Scene};

/// From this albedo on, light goes on for dozens of gathers; hardly any surface is so bright.
const BRIGHT: f32 = 0.95;

/// The decision about [`Choice::Bounces`].
pub(super) fn decide(scene: &Scene, options: &Options, open: &OpenTriangles) -> Decision {
    let left_out = |reason: &str| decision(Choice::Bounces, false, reason);
    let gathers = match options.bounces {
        Bounces::Off => {
            return left_out(
                "not asked for: surfaces send no light on; `--bounces auto` lets them",
            );
        }
        Bounces::Most(1) => "one gather".to_owned(),
        Bounces::Most(most) => format!("{most} gathers"),
        Bounces::Auto => "gathers until what is missing no longer counts".to_owned(),
    };
    if !options.shows_light() {
        return left_out("no asked layer shows light");
    }
    let alone = open.total > 0 && open.open == open.total;
    if alone && options.allows(Choice::Bounces) {
        return left_out("nothing stands above any triangle: no surface sees another");
    }
    let used = |index: usize| {
        let mut meshes = scene
            .instances
            .iter()
            .map(|i| scene.meshes[i.mesh as usize].material);
        meshes.any(|material| material as usize == index)
    };
    let materials = scene.materials.iter().enumerate();
    let used: Vec<&Material> = materials
        .filter(|(index, _)| used(*index))
        .map(|(_, material)| material)
        .collect();
    let albedo = |material: &&Material| match options.overrides.albedo {
        Some(albedo) => Vec3::from(albedo),
        None => most_albedo(&material.surface),
    };
    let sends = used
        .iter()
        .filter(|m| albedo(m).max_element() > 0.0)
        .count();
    let shine = used.iter().filter(|m| m.emission != Vec3::ZERO).count();
    if sends + shine == 0 && options.allows(Choice::Bounces) {
        return left_out("no material has an albedo or shines: no surface sends light on");
    }
    let brightest = used
        .iter()
        .map(|m| albedo(m).max_element())
        .fold(0.0, f32::max);
    let bright = if brightest >= BRIGHT {
        format!("; an albedo of {brightest:.2} keeps light for long, `--albedo` sets a lower one")
    } else {
        String::new()
    };
    let all = used.len();
    let reason = format!(
        "{gathers} of what surfaces send on: {sends} of {all} materials reflect diffusely, {shine} shine{bright}"
    );
    decision(Choice::Bounces, true, reason)
}

/// The albedo of a surface where its maps are white.
fn most_albedo(surface: &MaterialModel) -> Vec3 {
    match surface {
        MaterialModel::Phong { albedo, .. } => *albedo,
        MaterialModel::MetallicRoughness {
            base,
            metallic,
            roughness,
            metallic_roughness_map,
            dielectric,
            ..
        } => {
            // A map can take metallic down to 0.
            let metallic = match metallic_roughness_map {
                Some(_) => 0.0,
                None => *metallic,
            };
            scene::phong_from_metallic_roughness(*base, metallic, *roughness, *dielectric).0
        }
        MaterialModel::SpecularGlossiness {
            diffuse,
            specular,
            specular_glossiness_map,
            ..
        } => {
            // A map can take the coat down to 0.
            let specular = match specular_glossiness_map {
                Some(_) => Vec3::ZERO,
                None => *specular,
            };
            scene::phong_from_specular_glossiness(*diffuse, specular, 1.0).0
        }
    }
}
