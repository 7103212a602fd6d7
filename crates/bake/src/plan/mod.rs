//! The planner: decides what this scene needs, and says why. Printed by `ambake plan`, stored in `bake.json`.

mod any_view;
mod bounces;
mod lights;
mod open;

pub use any_view::AnyViewErrors;
pub use open::OpenTriangles;

use crate::choice::Choice;
use crate::options::{Model, Options, Shading, Sky, View};
use ambient::sampling::Mixture;
use glam::DVec3;
use layers::Term;
use rays::{Error, Light, PlaneErrors, World, WorldOptions};
use scene::{MaterialModel, Scene};
use std::sync::Arc;

/// How a term comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By closed forms at points of each texel: no directions are drawn.
    ClosedForm,
    /// By directions drawn for each texel. Where nothing stands above the texel they cost no ray query.
    Rays,
    /// Not at all.
    Off,
}

impl Method {
    /// The word in `bake.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed_form",
            Self::Rays => "rays",
            Self::Off => "off",
        }
    }
}

/// One decision with its reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// What was decided about.
    pub choice: Choice,
    /// True where it is modelled, false where it is left out.
    pub modelled: bool,
    /// Why, in one sentence.
    pub reason: String,
    /// How the term comes about; `None` for what is not a term.
    pub method: Option<Method>,
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
        let mut world = World::near(
            Arc::clone(scene),
            WorldOptions {
                instancing: instances(scene, options).modelled,
                alpha_test_all: !options.allows(Choice::AlphaTest),
            },
        )?;
        if options.normal_maps {
            world.read_normal_maps()?;
        }
        world.turn_over(options.places());
        Ok((Self::over(&world, scene, options), world))
    }

    /// Decides over the world of an earlier plan of the same scene, one that [`Options::differs_in_world`] lets serve.
    pub fn over(world: &World, scene: &Scene, options: &Options) -> Self {
        let instances = instances(scene, options);
        let alpha_test = alpha_test(scene, options);
        let mut open_triangles = if options.allows(Choice::Open) {
            OpenTriangles::of(world, &PlaneErrors::of(world))
        } else {
            OpenTriangles::default()
        };
        open_triangles.tilted |= options.normal_maps;
        let visibility = visibility(scene, options);
        let mut decisions = vec![
            sky(options),
            diffuse(options, visibility.modelled),
            visibility,
            specular(scene, options),
            open(&open_triangles, options),
            instances,
            alpha_test,
            bounces::decide(scene, options, &open_triangles),
            lights::decide(options),
        ];
        for term in Term::ALL {
            let decision = &mut decisions[place(choice_of(term))];
            decision.method = Some(method(term, decision.modelled, &open_triangles, options));
        }
        Self {
            mixture: if decisions[place(Choice::Visibility)].modelled {
                Mixture::BALANCED
            } else {
                Mixture::COSINE
            },
            open: open_triangles,
            decisions,
        }
    }

    /// True where `choice` is modelled.
    pub fn models(&self, choice: Choice) -> bool {
        self.decisions[place(choice)].modelled
    }

    /// How a term comes about over the whole bake: [`Method::Rays`] where any texel needs them.
    pub fn method(&self, term: Term) -> Method {
        self.decisions[place(choice_of(term))]
            .method
            .unwrap_or(Method::Off)
    }
}

impl Options {
    /// Where lights and eyes are, in the coordinates of the file: who is within a closed surface sees it from there.
    fn places(&self) -> impl Iterator<Item = DVec3> {
        let eye = match self.view {
            View::Normal => None,
            View::Eye(eye) => Some(eye),
        };
        self.lights.iter().filter_map(Light::place).chain(eye)
    }

    /// The name of an option by which these would have another world than `world`, which was built for `before`; `None`
    /// where it serves.
    pub fn differs_in_world(&self, world: &World, before: &Self) -> Option<&'static str> {
        let shapes = |choice| self.allows(choice) == before.allows(choice);
        if ![Choice::Instances, Choice::AlphaTest]
            .into_iter()
            .all(shapes)
        {
            Some("plan_off")
        } else if self.normal_maps != before.normal_maps {
            Some("normal_maps")
        } else if !world.is_turned_by(self.places()) {
            Some("lights or view")
        } else {
            None
        }
    }
}

/// Where a choice stands among the decisions.
fn place(choice: Choice) -> usize {
    choice as usize
}

/// The choice whether a term is modelled.
fn choice_of(term: Term) -> Choice {
    match term {
        Term::Diffuse => Choice::Diffuse,
        Term::Visibility => Choice::Visibility,
        Term::Specular => Choice::Specular,
    }
}

/// How a term comes about; the integrator follows the same rules texel by texel.
fn method(term: Term, modelled: bool, triangles: &OpenTriangles, options: &Options) -> Method {
    let along_normal = options.view == View::Normal && options.model == Model::Phong;
    let lobe_is_closed =
        options.shading == Shading::Production || along_normal || !triangles.tilted;
    if !modelled {
        Method::Off
    } else if options.sky.map().is_none()
        && triangles.open == triangles.total
        && triangles.total > 0
        && (term != Term::Specular || lobe_is_closed)
    {
        Method::ClosedForm
    } else {
        Method::Rays
    }
}

fn decision(choice: Choice, modelled: bool, reason: impl Into<String>) -> Decision {
    Decision {
        choice,
        modelled,
        reason: reason.into(),
        method: None,
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
    if !options.allows(Choice::Diffuse) {
        off(Choice::Diffuse)
    } else if visibility || options.wants(Term::Diffuse) {
        let reason =
            "an asked layer needs the hemisphere: rays over it, weighted for every term at once";
        decision(Choice::Diffuse, true, reason)
    } else {
        let reason = "no asked layer needs the hemisphere: no rays over it";
        decision(Choice::Diffuse, false, reason)
    }
}

fn visibility(scene: &Scene, options: &Options) -> Decision {
    if !options.allows(Choice::Visibility) {
        off(Choice::Visibility)
    } else if options.wants(Term::Visibility) {
        decision(
            Choice::Visibility,
            true,
            "an asked layer needs the open solid angle: half of the hemisphere directions are drawn uniformly".to_owned() + &any_view::words(scene, options),
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
    let choice = Choice::Specular;
    if !options.allows(choice) {
        return off(choice);
    }
    if !options.wants(Term::Specular) {
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

fn reflects(surface: &MaterialModel) -> bool {
    match surface {
        MaterialModel::Phong { specular, .. }
        | MaterialModel::SpecularGlossiness { specular, .. } => specular.max_element() > 0.0,
        MaterialModel::MetallicRoughness {
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
    let tilted = triangles.tilted && options.shading == Shading::Exact;
    let form = match (options.sky.map(), options.view, tilted) {
        (Some(_), ..) => "directions are drawn but no ray is cast",
        (None, View::Normal, _) => "closed form, no rays",
        (None, View::Eye(_), false) => "closed form, the specular lobe by its lune, no rays",
        (None, View::Eye(_), true) => {
            "closed form for diffuse and visibility; the lobes of smooth-shaded texels are sampled against their horizons, without rays"
        }
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

fn alpha_test(scene: &Scene, options: &Options) -> Decision {
    let masked = scene
        .meshes
        .iter()
        .filter(|mesh| !scene.materials[mesh.material as usize].is_opaque())
        .count();
    if masked > 0 {
        decision(
            Choice::AlphaTest,
            true,
            format!(
                "{masked} meshes are cut out or see-through: hits on them are tested against their alpha"
            ),
        )
    } else if !options.allows(Choice::AlphaTest) {
        decision(
            Choice::AlphaTest,
            true,
            "the planner's choice was switched off: hits on every mesh are tested",
        )
    } else {
        decision(
            Choice::AlphaTest,
            false,
            "no material is cut out or see-through: no alpha test in the ray query",
        )
    }
}
