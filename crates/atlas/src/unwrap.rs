//! Charts made and packed by `uvunwrap`, which nothing outside this file names. See vendor-notes/uvunwrap.md.

use crate::audit::audit;
use crate::measure::{AS_IT_STANDS, density, mesh_area, world_area};
use crate::uv::twice_area;
use crate::{Atlas, Audit, Error, MeshLayout, Options, Placement, UvSource};
use glam::{Vec2, Vec3};
use scene::Scene;
use uvunwrap::{Density, MeshInput, OutputMesh, Packing};

/// Up to this many charts are packed by shape: denser, and time grows with the square.
const SHAPED: u32 = 2000;
/// Edge of a speck: two units in the last place of a coordinate in 0.5..1.
const SPECK: f32 = 1.0 / (1 << 23) as f32;
/// Instances of one mesh differ at most so much in their texels: smaller ones are laid out larger than asked, for all
/// share one layout, whose gutter is wide enough for the smallest and this much wider in the largest.
const SPREAD: f32 = 16.0;
/// Charts of curved surfaces stay below this many triangles on average: flattening takes more than linear time.
const SOLVABLE: f64 = 200_000.0;
/// The largest page edge that a bake offers.
const LARGEST: u32 = 16384;

/// Unwraps every mesh that is placed and packs all objects together.
///
/// A mesh placed once is unwrapped in its world shape, so its texels are square there, and its charts go wherever
/// there is room. A mesh placed several times is unwrapped once in its own shape; each object gets a rectangle, scaled
/// by the square root of its mean area scale.
pub(crate) fn unwrap(
    scene: &Scene,
    options: &Options,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Atlas, Error> {
    let mut sources = sources(scene)?;
    let size = options.page_size;
    let max_chart_area = largest_chart(&sources);
    let generate = |sources: &[Source], size: u32, packing: Packing| {
        let inputs: Vec<MeshInput> = sources.iter().map(Source::input).collect();
        let density = match options.density {
            None => Density::Auto { page_size: size },
            Some(density) => Density::Fixed {
                texels_per_unit: density as f32,
                page_size: Some(size),
            },
        };
        let settings = uvunwrap::Options {
            density,
            padding: options.gutter,
            packing,
            max_chart_area,
            ..uvunwrap::Options::default()
        };
        uvunwrap::generate_with_progress(&inputs, &settings, |_| !cancel())
            .map_err(|error| explain(error, size))
    };
    // Without a density everything has to go on one page.
    let holds = |made: &Result<uvunwrap::Atlas, Error>| match made {
        Ok(made) => options.density.is_some() || made.page_count <= 1,
        Err(Error::ChartTooLarge { .. }) => options.density.is_some(),
        Err(_) => true,
    };
    let mut made = Err(Error::PageSize(size));
    let mut edge = size.max(2 * options.gutter + 1);
    while edge <= LARGEST {
        made = generate(&sources, edge, Packing::Fast);
        if holds(&made) {
            break;
        }
        edge = (edge + 1).next_power_of_two();
    }
    let mut made = match made {
        Ok(made) if edge == size => made,
        Ok(_) | Err(Error::ChartTooLarge { .. }) if options.density.is_none() => {
            let charts = made.map_or(0, |made| made.chart_count);
            let fits = (edge <= LARGEST).then_some(edge);
            return Err(Error::PageFull { charts, size, fits });
        }
        Ok(_) => {
            let (width, height) = (edge, edge);
            return Err(Error::ChartTooLarge {
                width,
                height,
                size,
            });
        }
        Err(error) => return Err(error),
    };
    if made.chart_count <= SHAPED {
        // The charts are made; only the packing is done again.
        for (source, out) in sources.iter_mut().zip(&made.meshes) {
            source.take(out, [made.width, made.height]);
        }
        made = generate(&sources, size, Packing::Shape)?;
    }
    // A page that was cropped to the rows in use is square again.
    let crop = Vec2::new(1.0, made.height as f32 / size as f32);
    let mut atlas = Atlas {
        page_size: size,
        page_count: made.page_count.max(1),
        meshes: vec![MeshLayout::default(); scene.meshes.len()],
        placements: vec![AS_IT_STANDS; scene.instances.len()],
        source: UvSource::Unwrapped,
        audit: Audit::default(),
        density: 0.0,
        chart_count: made.chart_count,
        notes: Vec::new(),
    };
    let mut specks = 0;
    for (source, out) in sources.iter().zip(made.meshes) {
        for (&instance, rect) in source.instances.iter().zip(&out.instances) {
            let (low, high) = (Vec2::from(rect.min) * crop, Vec2::from(rect.max) * crop);
            atlas.placements[instance] = Placement {
                page: rect.page,
                scale: (high - low).to_array(),
                offset: low.to_array(),
            };
        }
        let crop = if out.instances.is_empty() {
            crop
        } else {
            Vec2::ONE
        };
        let mut layout = own_layout(source, out, crop)?;
        specks += add_specks(&mut layout) * source.instances.len() as u64;
        atlas.meshes[source.mesh] = layout;
    }
    if cancel() {
        return Err(Error::Cancelled);
    }
    let findings = audit(scene, &atlas);
    if let Some(mesh) = findings.mesh().filter(|_| !findings.clean()) {
        return Err(Error::Audit {
            mesh: scene.meshes[mesh as usize].name.clone(),
            overlaps: findings.audit.overlaps,
            missing: findings.audit.missing,
            outside: findings.audit.outside,
        });
    }
    atlas.audit = Audit {
        specks,
        ..findings.audit
    };
    atlas.density = density(scene, &atlas.meshes, &atlas.placements, size);
    Ok(atlas)
}

/// The area of [`SOLVABLE`] triangles of mean size; 0, which is no limit, where all sources have fewer.
fn largest_chart(sources: &[Source]) -> f32 {
    let triangles: usize = sources.iter().map(|s| s.indices.len() / 3).sum();
    if triangles as f64 <= SOLVABLE {
        return 0.0;
    }
    let area: f64 = sources.iter().map(Source::area).sum();
    ((area * SOLVABLE / triangles as f64) as f32).min(f32::MAX)
}

/// A mesh as the unwrapper sees it.
struct Source {
    mesh: usize,
    instances: Vec<usize>,
    /// The mesh's vertex behind each vertex.
    vertices: Vec<u32>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// Charts that are made already, in texels; empty before.
    uvs: Vec<[f32; 2]>,
    /// Empty for a mesh placed once: its positions are in world units.
    scales: Vec<f32>,
}

impl Source {
    fn input(&self) -> MeshInput<'_> {
        MeshInput {
            instance_scales: &self.scales,
            existing_uvs: (!self.uvs.is_empty()).then_some(&self.uvs),
            ..MeshInput::new(&self.positions, &self.indices)
        }
    }

    /// Surface area of the positions.
    fn area(&self) -> f64 {
        let corner = |v: u32| Vec3::from(self.positions[v as usize]).as_dvec3();
        let area = |t: &[u32]| {
            let [a, b, c] = [corner(t[0]), corner(t[1]), corner(t[2])];
            0.5 * (b - a).cross(c - a).length()
        };
        self.indices.chunks_exact(3).map(area).sum()
    }

    /// Takes over the charts of a first packing, made on a page of so many texels.
    fn take(&mut self, out: &OutputMesh, page: [u32; 2]) {
        let page = Vec2::new(page[0] as f32, page[1] as f32);
        // Charts in a rectangle of their own are shaped as in any of its instances.
        let texels = out.instances.first().map_or(page, |rect| {
            (Vec2::from(rect.max) - Vec2::from(rect.min)) * page
        });
        self.vertices = out
            .vertices
            .iter()
            .map(|v| self.vertices[v.xref as usize])
            .collect();
        self.positions = out
            .vertices
            .iter()
            .map(|v| self.positions[v.xref as usize])
            .collect();
        self.indices.clone_from(&out.indices);
        self.uvs = out
            .vertices
            .iter()
            .map(|v| (Vec2::from(v.uv) * texels).to_array())
            .collect();
    }
}

/// Every mesh with triangles that is placed, in the order of meshes.
fn sources(scene: &Scene) -> Result<Vec<Source>, Error> {
    let mut instances = vec![Vec::new(); scene.meshes.len()];
    for (i, instance) in scene.instances.iter().enumerate() {
        instances[instance.mesh as usize].push(i);
    }
    let mut sources = Vec::new();
    for (mesh, instances) in instances.into_iter().enumerate() {
        let data = &scene.meshes[mesh];
        if instances.is_empty() || data.triangles.is_empty() {
            continue;
        }
        let extent = |i: usize| Error::Extent(scene.instances[i].name.clone());
        let (mut shape, mut scales) = (glam::DMat3::IDENTITY, Vec::new());
        if let [only] = instances[..] {
            shape = scene.instances[only].transform.matrix3;
        } else {
            let own = mesh_area(scene, mesh);
            for &i in &instances {
                let scale = (world_area(scene, i) / own).sqrt() as f32;
                if !(scale.is_finite() && scale > 0.0) {
                    return Err(extent(i));
                }
                scales.push(scale);
            }
            // The gutter of the smallest instance grows with the instance.
            let largest = scales.iter().copied().fold(0.0, f32::max);
            for scale in &mut scales {
                *scale = scale.max(largest / SPREAD);
            }
        }
        let positions: Vec<[f32; 3]> = data
            .positions
            .iter()
            .map(|p| (shape * p.as_dvec3()).as_vec3().to_array())
            .collect();
        if positions.iter().flatten().any(|x| !x.is_finite()) {
            return Err(extent(instances[0]));
        }
        sources.push(Source {
            mesh,
            instances,
            vertices: (0..data.positions.len() as u32).collect(),
            positions,
            uvs: Vec::new(),
            indices: data.triangles.iter().flatten().copied().collect(),
            scales,
        });
    }
    Ok(sources)
}

/// The layout of one mesh. Vertices without a chart go to the page's first corner, which the gutter keeps free.
fn own_layout(source: &Source, out: OutputMesh, crop: Vec2) -> Result<MeshLayout, Error> {
    let (given, made) = (source.indices.len(), out.indices.len());
    assert_eq!(made, given, "indices of mesh {}", source.mesh);
    let behind = |xref: u32| source.vertices[xref as usize];
    let page = |t: &[u32]| out.vertices[t[0] as usize].page.unwrap_or(0);
    let pages: Vec<u32> = out.indices.chunks_exact(3).map(page).collect();
    let triangle_pages = if pages.iter().all(|&p| p == 0) {
        Vec::new()
    } else {
        let narrow = |&p: &u32| u16::try_from(p).map_err(|_| Error::TooManyTexels(1 << 30));
        pages.iter().map(narrow).collect::<Result<_, _>>()?
    };
    Ok(MeshLayout {
        source_vertices: out.vertices.iter().map(|v| behind(v.xref)).collect(),
        uvs: out
            .vertices
            .iter()
            .map(|v| Vec2::from(v.uv) * crop)
            .collect(),
        triangles: out
            .indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
        triangle_pages,
    })
}

/// Gives every triangle without area a speck at its first corner, with vertices of its own, and counts them.
///
/// These are triangles that the unwrapper found too thin (under a millionth of the mesh's diagonal) and collapsed onto
/// a neighbour's corner, and those that rounding to 32 bits flattened. A speck is smaller than what 32-bit coordinates
/// can tell apart on a page, so it takes nothing from its neighbour.
fn add_specks(layout: &mut MeshLayout) -> u64 {
    let mut specks = 0;
    for t in 0..layout.triangles.len() {
        let corners = layout.triangles[t];
        let uvs = corners.map(|v| layout.uvs[v as usize]);
        if twice_area(uvs.map(Vec2::as_dvec2)) != 0.0 {
            continue;
        }
        specks += 1;
        // Toward the middle of the square, so that the speck stays inside.
        let inward = |x: f32| if x < 0.5 { SPECK } else { -SPECK };
        let at = uvs[0];
        let (u, v) = (Vec2::new(inward(at.x), 0.0), Vec2::new(0.0, inward(at.y)));
        let (first, second) = if u.x * v.y > 0.0 { (u, v) } else { (v, u) };
        let next = layout.uvs.len() as u32;
        layout.uvs.extend([at, at + first, at + second]);
        let sources = corners.map(|c| layout.source_vertices[c as usize]);
        layout.source_vertices.extend(sources);
        layout.triangles[t] = [next, next + 1, next + 2];
    }
    specks
}

/// The unwrapper's errors in our words.
fn explain(error: uvunwrap::Error, size: u32) -> Error {
    match error {
        uvunwrap::Error::Cancelled => Error::Cancelled,
        uvunwrap::Error::AtlasTooLarge { texels } => Error::TooManyTexels(texels),
        uvunwrap::Error::ChartTooLarge { width, height, .. } => Error::ChartTooLarge {
            width,
            height,
            size,
        },
        other => Error::Unwrap(other.to_string()),
    }
}
