//! The planner: decides what this scene needs, and says why. Printed by `ambake plan`, stored in `bake.json`.

mod open;

pub use open::OpenTriangles;

use crate::options::{Options, Sky, View};
use ambient::sampling::Mixture;
use layers::Layer;
use rays::{Error, PlaneErrors, World, WorldOptions};
use scene::{Alpha, Scene, Surface};
use serde::Serialize;
use std::sync::Arc;

/// Something the planner may leave out. Each can be switched off by name; then it is modelled whatever the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Choice {
    /// Closed forms and no rays on triangles that nothing stands above.
    Open,
    /// No lobe rays where nothing reflects specularly or no asked layer shows it.
    Specular,
    /// No hemisphere rays where only the specular term is asked for.
    Diffuse,
    /// No share of uniform directions where no asked layer needs the visibility.
    Visibility,
    /// No instance level in the ray scene where nothing is instanced.
    Instances,
    /// No filter callback where no material is alpha-masked.
    Filter,
    /// No map look-up where the sky is uniform.
    Sky,
}

impl Choice {
    /// Every choice, in the order in which the planner reports them.
    pub const ALL: [Self; 7] = [
        Self::Sky,
        Self::Diffuse,
        Self::Visibility,
        Self::Specular,
        Self::Open,
        Self::Instances,
        Self::Filter,
    ];

    /// The name on the command line and in `bake.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Specular => "specular",
            Self::Diffuse => "diffuse",
            Self::Visibility => "visibility",
            Self::Instances => "instances",
            Self::Filter => "filter",
            Self::Sky => "sky",
        }
    }

    /// The choice of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|choice| choice.name() == name)
    }
}

/// One decision with its reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// What was decided about.
    pub choice: Choice,
    /// True where it is modelled, false where it is left out.
    pub modelled: bool,
    /// Why, in one sentence.
    pub reason: String,
}

/// What a bake models.
#[derive(Debug, Clone)]
pub struct Plan {
    /// All decisions, one for each of [`Choice::ALL`].
    pub decisions: Vec<Decision>,
    /// Triangles that need no rays.
    pub open: OpenTriangles,
    /// How hemisphere directions are drawn: cosine-weighted alone where no visibility is needed.
    pub mixture: Mixture,
}

impl Plan {
    /// Decides, and builds the world that the rays of this plan see.
    ///
    /// # Errors
    /// See [`World::new`].
    pub fn of(scene: &Arc<Scene>, options: &Options) -> Result<(Self, World), Error> {
        let instances = instances(scene, options);
        let filter = filter(scene, options);
        let world = World::new(
            Arc::clone(scene),
            WorldOptions {
                instancing: instances.modelled,
                filter_all: !options.allows(Choice::Filter),
            },
        )?;
        let visibility = visibility(options);
        let diffuse = diffuse(options, visibility.modelled);
        let specular = specular(scene, options);
        let open_triangles = if options.allows(Choice::Open) {
            OpenTriangles::of(&world, &PlaneErrors::of(&world))
        } else {
            OpenTriangles::default()
        };
        let open = open(&open_triangles, options);
        let plan = Self {
            open: open_triangles,
            mixture: if visibility.modelled {
                Mixture::BALANCED
            } else {
                Mixture::COSINE
            },
            decisions: vec![
                sky(options),
                diffuse,
                visibility,
                specular,
                open,
                instances,
                filter,
            ],
        };
        Ok((plan, world))
    }

    /// True where `choice` is modelled.
    pub fn models(&self, choice: Choice) -> bool {
        self.decisions
            .iter()
            .any(|decision| decision.choice == choice && decision.modelled)
    }
}

fn decision(choice: Choice, modelled: bool, reason: impl Into<String>) -> Decision {
    Decision {
        choice,
        modelled,
        reason: reason.into(),
    }
}

fn off(choice: Choice) -> Decision {
    decision(choice, true, "the planner's choice was switched off")
}

fn sky(options: &Options) -> Decision {
    match (&options.sky, options.sky.map()) {
        (_, Some(map)) => {
            let (width, height) = map.size();
            let reason = format!(
                "an illumination map of {width} x {height}: rays are drawn from its light too, and no term has a closed form"
            );
            decision(Choice::Sky, true, reason)
        }
        (Sky::Map(_), None) => decision(
            Choice::Sky,
            false,
            "the illumination map is constant: its radiance is a factor, no map is looked up",
        ),
        (Sky::Uniform(_), None) => decision(
            Choice::Sky,
            false,
            "the sky is uniform: its radiance is a factor, no map is looked up",
        ),
    }
}

fn diffuse(options: &Options, visibility: bool) -> Decision {
    let users = [
        Layer::Diffuse,
        Layer::Lambert,
        Layer::Phong,
        Layer::Error,
        Layer::Irradiance,
        Layer::ErrorIrradiance,
        Layer::Bent,
        Layer::DifferenceLambert,
        Layer::DifferencePhong,
    ];
    if !options.allows(Choice::Diffuse) {
        off(Choice::Diffuse)
    } else if visibility || options.wants_any(&users) {
        let reason =
            "an asked layer needs the hemisphere: rays over it, weighted for every term at once";
        decision(Choice::Diffuse, true, reason)
    } else {
        let reason = "no asked layer needs the hemisphere: no rays over it";
        decision(Choice::Diffuse, false, reason)
    }
}

fn visibility(options: &Options) -> Decision {
    let users = [
        Layer::Visibility,
        Layer::Traditional,
        Layer::DifferenceLambert,
        Layer::DifferencePhong,
        Layer::ErrorVisibility,
    ];
    if !options.allows(Choice::Visibility) {
        off(Choice::Visibility)
    } else if options.wants_any(&users) {
        decision(
            Choice::Visibility,
            true,
            "an asked layer needs the open solid angle: half of the hemisphere directions are drawn uniformly",
        )
    } else {
        decision(
            Choice::Visibility,
            false,
            "no asked layer needs the open solid angle: all directions are cosine-weighted",
        )
    }
}

fn specular(scene: &Scene, options: &Options) -> Decision {
    let users = [
        Layer::Specular,
        Layer::Phong,
        Layer::DifferencePhong,
        Layer::ErrorSpecular,
        Layer::Reflection,
        Layer::ErrorReflection,
    ];
    let choice = Choice::Specular;
    if !options.allows(choice) {
        return off(choice);
    }
    if !options.wants_any(&users) {
        return decision(choice, false, "no asked layer shows the specular term");
    }
    if options.overrides.exponent.is_some() {
        return decision(choice, true, "an exponent was given on the command line");
    }
    if let Some(specular) = options.overrides.specular {
        let any = specular.iter().any(|&s| s > 0.0);
        let word = if any { "not zero" } else { "zero" };
        return decision(
            choice,
            any,
            format!("the specular reflectance given on the command line is {word}"),
        );
    }
    let used: Vec<_> = scene
        .materials
        .iter()
        .enumerate()
        .filter(|(index, _)| {
            scene
                .meshes
                .iter()
                .any(|mesh| mesh.material as usize == *index)
        })
        .collect();
    let shiny = used
        .iter()
        .filter(|(_, material)| reflects(&material.surface))
        .count();
    if shiny > 0 {
        decision(
            choice,
            true,
            format!(
                "{shiny} of {} materials have a specular reflectance",
                used.len()
            ),
        )
    } else {
        decision(choice, false, "no material has a specular reflectance")
    }
}

fn reflects(surface: &Surface) -> bool {
    match surface {
        Surface::Phong { specular, .. } => specular.max_element() > 0.0,
        Surface::MetallicRoughness {
            dielectric,
            metallic,
            ..
        } => dielectric.max_element() > 0.0 || *metallic > 0.0,
    }
}

fn open(triangles: &OpenTriangles, options: &Options) -> Decision {
    if !options.allows(Choice::Open) {
        return decision(
            Choice::Open,
            true,
            "the planner's choice was switched off: every texel is sampled by rays",
        );
    }
    let OpenTriangles { open, total, .. } = *triangles;
    let form = match (options.sky.map(), options.view) {
        (Some(_), _) => "no rays",
        (None, View::Normal) => "closed form, no rays",
        (None, View::Eye(_)) => "closed form, the specular lobe by its lune, no rays",
    };
    if open == total {
        let reason = format!("nothing stands above any triangle (a convex body alone): {form}");
        decision(Choice::Open, false, reason)
    } else if open > 0 {
        let reason = format!("{open} of {total} triangles have nothing above them: {form} there");
        decision(Choice::Open, true, reason)
    } else {
        decision(
            Choice::Open,
            true,
            "something stands above every triangle: rays everywhere",
        )
    }
}

fn instances(scene: &Scene, options: &Options) -> Decision {
    let mut uses = vec![0u32; scene.meshes.len()];
    for instance in &scene.instances {
        uses[instance.mesh as usize] += 1;
    }
    let shared = uses.iter().filter(|&&n| n > 1).count();
    if !options.allows(Choice::Instances) {
        let reason = "the planner's choice was switched off: every object is flattened";
        decision(Choice::Instances, false, reason)
    } else if shared > 0 {
        decision(
            Choice::Instances,
            true,
            format!("{shared} meshes stand in several places: one instance level"),
        )
    } else {
        decision(
            Choice::Instances,
            false,
            "no mesh stands in several places: one flat ray scene",
        )
    }
}

fn filter(scene: &Scene, options: &Options) -> Decision {
    let masked = scene
        .meshes
        .iter()
        .filter(|mesh| {
            matches!(
                scene.materials[mesh.material as usize].alpha,
                Alpha::Mask { .. }
            )
        })
        .count();
    if masked > 0 {
        decision(
            Choice::Filter,
            true,
            format!("{masked} meshes are alpha-masked: hits on them are filtered"),
        )
    } else if !options.allows(Choice::Filter) {
        decision(
            Choice::Filter,
            true,
            "the planner's choice was switched off: hits on every mesh are filtered",
        )
    } else {
        decision(
            Choice::Filter,
            false,
            "no material is alpha-masked: no filter callback",
        )
    }
}
