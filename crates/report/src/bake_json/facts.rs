//! What reports say of a scene, its layout and its pages, from these themselves.

use super::{AtlasReport, BuriedReport, PageReport, SceneReport, WarningReport};

impl SceneReport {
    /// The facts of a loaded scene.
    pub fn of(scene: &scene::Scene) -> SceneReport {
        let triangles = |mesh: &scene::Mesh| mesh.triangles.len() as u64;
        SceneReport {
            path: scene.path.display().to_string(),
            file: None,
            format: match scene.format {
                scene::Format::Obj => "obj",
                scene::Format::Gltf => "gltf",
                scene::Format::Glb => "glb",
                scene::Format::Memory => "memory",
            }
            .into(),
            content_hash: scene.content_hash.clone(),
            meshes: scene.meshes.len() as u64,
            instances: scene.instances.len() as u64,
            triangles: scene.meshes.iter().map(triangles).sum(),
            instanced_triangles: scene
                .instances
                .iter()
                .map(|i| triangles(&scene.meshes[i.mesh as usize]))
                .sum(),
            materials: scene.materials.len() as u64,
            images: scene.images.len() as u64,
        }
    }
}

impl AtlasReport {
    /// The facts of a layout.
    pub fn of(atlas: &atlas::Atlas) -> AtlasReport {
        let (source, kept_set) = match atlas.source {
            atlas::UvSource::Kept { set } => ("kept", Some(set)),
            atlas::UvSource::Repacked { set } | atlas::UvSource::Apart { set } => {
                ("repacked", Some(set))
            }
            atlas::UvSource::Unwrapped => ("unwrapped", None),
        };
        AtlasReport {
            source: source.into(),
            kept_set,
            page_size: atlas.page_size,
            pages: atlas.page_count,
            charts: atlas.chart_count,
            density: atlas.density,
            overlaps: atlas.audit.overlaps,
            missing: atlas.audit.missing,
            outside: atlas.audit.outside,
            texels: atlas.audit.texels,
            hash: crate::layout_hash(atlas),
        }
    }
}

impl From<&scene::Warning> for WarningReport {
    fn from(warning: &scene::Warning) -> WarningReport {
        WarningReport {
            kind: warning.kind.name().into(),
            place: warning.place.clone(),
            count: warning.count,
            message: warning.message.clone(),
        }
    }
}

impl BuriedReport {
    /// What lies inside of solids on all pages.
    pub fn of(pages: &[PageReport]) -> Self {
        let area: f64 = pages.iter().map(|page| page.coverage_used).sum();
        let buried = |page: &PageReport| page.buried.share * page.coverage_used;
        Self {
            texels: pages.iter().map(|page| page.buried.texels).sum(),
            share: match area > 0.0 {
                true => pages.iter().map(buried).sum::<f64>() / area,
                false => 0.0,
            },
        }
    }
}
