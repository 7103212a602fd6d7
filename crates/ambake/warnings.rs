//! What a bake warns of before a ray is cast.

use crate::facing::{dark_sides, faces_away};
use crate::hidden::hidden_faces;
use crate::job::Job;
use crate::outline::outlines;
use crate::shell::{Shell, looks};
use ::bake::{AmbientCoefficient, Bounces, Model};
use atlas::Pages;
use layers::Layer;
use report::WarningReport;

/// Share of the texels from which outsides are told of.
const LEAST_OUTSIDE: f64 = 0.1;

/// Share of an object's surface from which it is told that normals were turned round: the smooth normals of a coarse
/// mesh lean behind some slivers of it.
const LEAST_AVERSE: f64 = 0.01;

/// What names of bodies for collisions have in them: of Unity and Decentraland, of engines' own meshes, and of Godot's
/// importer, where `-col` alone is a visible mesh.
const COLLISIONS: [&str; 3] = ["collider", "collision", "colonly"];
/// How Unreal's importer wants them to begin.
const UNREAL: [&str; 4] = ["ucx_", "ubx_", "usp_", "ucp_"];
/// Navigation meshes, on which engines find ways: as a word of a name, or as two. `NavMeshAgent` is another thing.
const NAVIGATION: [&str; 2] = ["navmesh", "navigationmesh"];

/// True for names of bodies that engines never draw: those for collisions, and navigation meshes.
fn is_named_as_undrawn(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let mut parts = name.split(['/', ' ']);
    let words = name.split(|at: char| !at.is_alphanumeric());
    let words = words.map(|word| word.trim_end_matches(|at: char| at.is_ascii_digit()));
    let pairs = words.clone().zip(words.clone().skip(1));
    COLLISIONS.iter().any(|word| name.contains(word))
        || parts.any(|part| UNREAL.iter().any(|start| part.starts_with(start)))
        || words.clone().any(|word| NAVIGATION.contains(&word))
        || pairs
            .map(|(a, b)| [a, b].concat())
            .any(|two| NAVIGATION.contains(&two.as_str()))
}

impl Job {
    /// Everything that was repaired, ignored or is doubtful before a ray was cast, and matters to this bake.
    pub fn warnings(&self) -> Vec<WarningReport> {
        let ignored = |warning: &&::scene::Warning| {
            let tinted = [Layer::Lambert, Layer::Traditional];
            match warning.kind {
                ::scene::WarningKind::IgnoredNormalMaps => self.options().normal_maps,
                ::scene::WarningKind::MissingNormalMaps | ::scene::WarningKind::BadTangents => {
                    !self.options().normal_maps
                }
                ::scene::WarningKind::AmbientCoefficients => {
                    let options = self.options();
                    let shown = options.layers.contains(&Layer::Traditional);
                    !shown || options.ambient_coefficient != AmbientCoefficient::Albedo
                }
                // Light without a tint is not black on them.
                ::scene::WarningKind::BlackMetals | ::scene::WarningKind::BlackDiffuse => !tinted
                    .iter()
                    .any(|layer| self.options().layers.contains(layer)),
                _ => false,
            }
        };
        let layout = self.options().layout();
        let alone = layout.pages == Pages::Auto && !layout.one_page_per_mesh;
        let is_shared = layout.is_shared() && self.atlas().source.is_packed();
        let small_page = is_shared.then(|| {
            self.layout_report()
                .small_page(self.scene(), self.atlas(), alone)
        });
        // Whoever asks for densities in the file knows that they differ.
        let asks = self.scene().instances.iter().any(|of| of.density.is_some());
        let uneven = (is_shared && !asks).then(|| self.layout_report().uneven_density());
        let looks = self.within(|| looks(self.world(), self.backend(), self.atlas()));
        let of_scene = self
            .scene()
            .warnings
            .iter()
            .filter(|warning| !ignored(warning));
        of_scene
            .map(Into::into)
            .chain(self.broken_normal_maps())
            .chain(self.layout_report().warnings())
            .chain(small_page.flatten())
            .chain(uneven.flatten())
            .chain(self.touching())
            .chain(self.outsides())
            .chain(self.within(|| hidden_faces(self, &looks)))
            .chain(self.within(|| outlines(self, &looks)))
            .chain(self.inside_out())
            .chain(self.collision_bodies())
            .chain(self.turned_over())
            .chain(self.averse_normals())
            .chain(self.within(|| faces_away(self, &looks)))
            .chain(self.within(|| dark_sides(self, &looks)))
            .chain(self.too_bright())
            .chain(self.lights_left_out())
            .chain(self.lamps_left_out())
            .collect()
    }

    /// Pictures of normal maps that are there and cannot be read.
    fn broken_normal_maps(&self) -> impl Iterator<Item = WarningReport> {
        let broken = self.world().broken_normal_maps().iter();
        broken.map(|(name, problem)| WarningReport {
            kind: ::scene::WarningKind::MissingNormalMaps.name().into(),
            place: format!("texture `{name}`"),
            count: 1,
            message: format!("{problem}; the mesh's normals stand alone"),
        })
    }

    /// Coefficients given for all surfaces by which the sum of diffuse and highlight is more than arrives.
    fn too_bright(&self) -> Option<WarningReport> {
        let (albedo, specular) = (self.options().albedo?, self.options().specular?);
        let sums = [0, 1, 2].map(|channel| albedo[channel] + specular[channel]);
        let most = sums.into_iter().fold(0.0, f32::max);
        let adds = self.options().model != Some(Model::Ggx);
        (adds && most > 1.0 + 1e-6).then(|| WarningReport {
            kind: "too-bright".into(),
            place: "scene".into(),
            count: 1,
            message: format!(
                "`--albedo` and `--specular` together reflect {} times the light that arrives, and no surface \
                 reflects more than all of it; lower one of them, or take `--model ggx`, which gives the highlight's \
                 share to it alone",
                (100.0 * most).round() / 100.0
            ),
        })
    }

    /// Coordinates of the file of which look-ups mix surfaces.
    fn touching(&self) -> Option<WarningReport> {
        let is_kept = !self.atlas().source.is_packed();
        let found = is_kept.then(|| self.within(|| atlas::touching(self.scene(), self.atlas())));
        let (texels, instance) = found.flatten()?;
        let share = texels as f64 / self.atlas().audit.texels.max(1) as f64;
        (share >= atlas::LEAST_TOUCHING).then(|| WarningReport {
            kind: "touching-charts".into(),
            place: format!("object `{}`", self.scene().instances[instance as usize].name),
            count: texels,
            message: "texels of the file's coordinates stand beside those of other surfaces without a gutter, so that \
                      look-ups mix both; give the charts two empty texels between them, \
                      or let `--uv unwrap` make others"
                .into(),
        })
    }

    /// Outsides of rooms that take texels though nobody within sees them.
    fn outsides(&self) -> Option<WarningReport> {
        let options = self.options();
        let is_asked = options.seen_from_within || !options.seen_from.is_empty();
        if is_asked || !self.atlas().source.is_packed() {
            return None;
        }
        let share =
            self.within(|| Some(Shell::of(self.world(), self.backend())?.share(self.atlas())))?;
        (share >= LEAST_OUTSIDE).then(|| WarningReport {
            kind: "outsides".into(),
            place: "scene".into(),
            count: (share * self.atlas().audit.texels as f64) as u64,
            message: format!(
                "{:.0} % of the texels lie on outsides of rooms, which nobody within sees; `--seen-from auto` gives \
                 each of their charts one texel, and theirs to what is seen",
                100.0 * share
            ),
        })
    }

    /// Surfaces with texels whose backs are lit.
    fn turned_over(&self) -> Option<WarningReport> {
        let message = "faces that are drawn from both sides look inward where nothing is, or at what is close before \
                       all of them: the side that one sees is baked, and turning them over in the scene ends this line";
        self.of_objects("turned-over", message, |instance| {
            self.world().has_turned_over(instance)
        })
    }

    /// Surfaces with texels of which some normals were turned round.
    fn averse_normals(&self) -> Option<WarningReport> {
        let message = "vertex normals point into their body, or away from where the rest of their surface looks: the \
                       side of the winding is baked, and recalculating the normals ends this line";
        self.of_objects("averse-normals", message, |instance| {
            self.world().averse_share(instance) >= LEAST_AVERSE
        })
    }

    /// Objects with texels that are named as bodies for collisions or as navigation meshes, which nobody sees.
    fn collision_bodies(&self) -> Option<WarningReport> {
        let message = "bodies for collisions and navigation meshes, by their names, take texels and block light; where \
                       nobody is to see them, `--no-cast NAME --exclude NAME` leaves them out";
        let instances = &self.scene().instances;
        self.of_objects("collision-bodies", message, |instance| {
            is_named_as_undrawn(&instances[instance as usize].name)
        })
    }

    /// A warning about the objects with texels of which something holds.
    fn of_objects(
        &self,
        kind: &str,
        message: &str,
        holds: impl Fn(u32) -> bool,
    ) -> Option<WarningReport> {
        let (instances, placements) = (&self.scene().instances, &self.atlas().placements);
        let found = (0..).zip(instances.iter().zip(placements));
        let found = found.filter(|(number, of)| of.1.is_somewhere() && holds(*number));
        let names: Vec<&str> = found.map(|(_, of)| of.0.name.as_str()).collect();
        Some(WarningReport {
            kind: kind.into(),
            place: format!("object `{}`", names.first()?),
            count: names.len() as u64,
            message: message.into(),
        })
    }

    /// Closed surfaces with texels that are lit from within.
    fn inside_out(&self) -> Option<WarningReport> {
        let mut found = self.world().solids().inside_out();
        found.retain(|&(instance, triangle)| {
            self.atlas().placements[instance as usize].is_somewhere()
                && !self.world().is_turned_over(instance, triangle)
        });
        let first = &self.scene().instances[found.first()?.0 as usize];
        Some(WarningReport {
            kind: "inside-out".into(),
            place: format!("object `{}`", first.name),
            count: found.len() as u64,
            message: "faces of a closed surface look inward, so it is lit from within and dark: turn them over, unless \
                      it is an empty room"
                .into(),
        })
    }

    /// Lights of the file that nobody said anything about.
    fn lights_left_out(&self) -> Option<WarningReport> {
        let lights = &self.scene().lights;
        let first = lights
            .first()
            .filter(|_| self.options().file_lights.is_none())?;
        Some(WarningReport {
            kind: "file-lights".into(),
            place: named("light", &first.name, lights.len()),
            count: lights.len() as u64,
            message: "lights of the file are not baked; `--lights file` bakes them, \
                `--lights none` leaves them out"
                .into(),
        })
    }

    /// True where light comes from elsewhere than the sky.
    pub(crate) fn has_lamps(&self) -> bool {
        let options = self.options();
        let shine = options.bounces != Bounces::Off && options.file_lights != Some(false);
        !options.lights.is_empty() || (shine && !self.shining_materials().is_empty())
    }

    /// The materials that shine on something which casts.
    fn shining_materials(&self) -> Vec<u32> {
        let casting = self.scene().instances.iter().filter(|of| of.casts);
        let shines = |&material: &u32| {
            let emission = self.scene().materials[material as usize].emission;
            emission != glam::Vec3::ZERO
        };
        let mut lit: Vec<u32> = casting
            .map(|of| self.scene().meshes[of.mesh as usize].material)
            .filter(shines)
            .collect();
        lit.sort_unstable();
        lit.dedup();
        lit
    }

    /// Surfaces of the file that shine, in a bake in which no light bounces and nobody said that they should not.
    fn lamps_left_out(&self) -> Option<WarningReport> {
        let is_dark =
            self.options().bounces == Bounces::Off && self.baker_options().asks_for_light();
        if !is_dark || self.options().file_lights == Some(false) {
            return None;
        }
        let lit = self.shining_materials();
        let first = &self.scene().materials[*lit.first()? as usize];
        Some(WarningReport {
            kind: "dark-lamps".into(),
            place: named("material", &first.name, lit.len()),
            count: lit.len() as u64,
            message: "surfaces that shine (`Ke`, emissiveFactor) send out no light where none bounces; `--bounces 1` \
                      bakes what they send, `--bounces auto` also what others send on, and `--lights none` says that \
                      they should stay dark"
                .into(),
        })
    }
}

/// The first of so many things, for a message.
fn named(what: &str, first: &str, count: usize) -> String {
    match count {
        1 => format!("{what} `{first}`"),
        _ => format!("{what} `{first}` and {} more", count - 1),
    }
}
