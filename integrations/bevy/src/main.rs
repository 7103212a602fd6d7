//! Shows a bake in Bevy without a window, writes what a camera sees, and holds it against a picture of `ambake render`.
//!
//! Usage: `ambake-bevy DIR STEM EYE LOOK FOV PICTURE.exr [OUT.exr]`, with EYE and LOOK as X,Y,Z and FOV vertical in
//! degrees. DIR is a bake with `--for bevy`. PICTURE.exr, which says the size, is `ambake render` of the same view from
//! the same bake. The mean and the largest difference away from edges are printed, in 1/255; a mean above 2 ends with
//! status 1.

use anyhow::{Context as _, Result, anyhow, bail};
use bevy::{
    app::ScheduleRunnerPlugin,
    asset::RenderAssetUsages,
    camera::{
        Hdr, RenderTarget,
        primitives::Aabb,
        visibility::{InheritedVisibility, ViewVisibility, VisibilityClass},
    },
    core_pipeline::tonemapping::Tonemapping,
    gltf::{
        GltfExtras, GltfMaterialExtras, GltfMaterialName, GltfMeshExtras, GltfMeshName,
        GltfSceneExtras, GltfSceneName,
    },
    pbr::Lightmap,
    prelude::*,
    render::{
        RenderPlugin,
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
    },
    transform::components::TransformTreeChanged,
    window::ExitCondition,
};
use exr::prelude::{f16, read_first_rgba_layer_from_file, write_rgb_file};
use serde_json::Value;
use std::{path::Path, process::ExitCode, sync::Mutex, time::Duration};

/// What the camera saw, row by row from the top: red, green, blue and alpha.
static SEEN: Mutex<Option<Vec<[f32; 4]>>> = Mutex::new(None);

/// What stands behind the scene in OUT.exr.
const BEHIND: [f32; 3] = [0.55, 0.7, 0.95];

/// Frames after everything is loaded, so that all of it is on the graphics card.
const SETTLE: u32 = 20;

/// What the command line and `bake.json` say.
#[derive(Resource, Clone)]
struct Shown {
    stem: String,
    eye: Vec3,
    look: Vec3,
    fov: f32,
    size: [u32; 2],
    /// What `bake.json` says that Bevy multiplies by.
    scale: f32,
    /// The page that each texture of the GLB belongs to.
    pages: Vec<Option<u32>>,
}

#[derive(Resource)]
struct Scene {
    gltf: Handle<bevy::gltf::Gltf>,
    target: Handle<Image>,
    lightmaps: Vec<Handle<Image>>,
    frames: u32,
}

fn main() -> ExitCode {
    match run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<ExitCode> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [dir, stem, eye, look, fov, picture, rest @ ..] = words.as_slice() else {
        bail!("usage: ambake-bevy DIR STEM EYE LOOK FOV PICTURE.exr [OUT.exr]");
    };
    let dir = std::fs::canonicalize(dir).with_context(|| dir.clone())?;
    let ([width, height], wanted) = read(Path::new(picture))?;
    let glb = std::fs::read(dir.join(format!("{stem}.glb")))?;
    let shown = Shown {
        stem: stem.clone(),
        eye: point(eye)?,
        look: point(look)?,
        fov: fov.parse()?,
        size: [width as u32, height as u32],
        scale: scale(&dir.join("bake.json"))?,
        pages: pages(&glb)?,
    };
    App::new()
        .insert_resource(shown)
        // The light is baked: Bevy's own ambient light must not come on top.
        .insert_resource(GlobalAmbientLight {
            affects_lightmapped_meshes: false,
            ..default()
        })
        .insert_resource(ClearColor(Color::NONE))
        .add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .set(AssetPlugin {
                    file_path: dir.to_string_lossy().into_owned(),
                    ..default()
                }),
        )
        .register_type::<Transform>()
        .register_type::<GlobalTransform>()
        .register_type::<TransformTreeChanged>()
        .register_type::<Name>()
        .register_type::<ChildOf>()
        .register_type::<Children>()
        .register_type::<Visibility>()
        .register_type::<InheritedVisibility>()
        .register_type::<ViewVisibility>()
        .register_type::<VisibilityClass>()
        .register_type::<Aabb>()
        .register_type::<Mesh3d>()
        .register_type::<MeshMaterial3d<StandardMaterial>>()
        .register_type::<GltfMeshName>()
        .register_type::<GltfMaterialName>()
        .register_type::<GltfSceneName>()
        .register_type::<GltfExtras>()
        .register_type::<GltfMaterialExtras>()
        .register_type::<GltfMeshExtras>()
        .register_type::<GltfSceneExtras>()
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::from_millis(5)))
        .add_systems(Startup, load)
        .add_systems(Update, (light, take).chain())
        .run();
    let seen = SEEN
        .lock()
        .map_err(|_| anyhow!("a system panicked"))?
        .take();
    let seen = seen.context("nothing was drawn")?;
    if let [out] = rest {
        let at = |x: usize, y: usize| {
            let [r, g, b, alpha] = seen[y * width + x];
            let over = |seen: f32, behind: f32| seen + (1.0 - alpha) * behind;
            (over(r, BEHIND[0]), over(g, BEHIND[1]), over(b, BEHIND[2]))
        };
        write_rgb_file(out, width, height, at)?;
    }
    let (mean, most, pixels) = difference([width, height], &seen, &wanted);
    println!("mean {mean:.3}, largest {most:.1} of 255 over {pixels} pixels");
    Ok(match mean <= 2.0 && pixels > 0 {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn load(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut images: ResMut<Assets<Image>>,
    shown: Res<Shown>,
) {
    let [width, height] = shown.size;
    let size = Extent3d {
        width,
        height,
        ..default()
    };
    let format = TextureFormat::Rgba16Float;
    let mut target = Image::new_fill(
        size,
        TextureDimension::D2,
        &[0; 8],
        format,
        RenderAssetUsages::default(),
    );
    target.texture_descriptor.usage |=
        TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING;
    let target = images.add(target);
    let glb = format!("{}.glb", shown.stem);
    commands.spawn(WorldAssetRoot(
        assets.load(GltfAssetLabel::Scene(0).from_asset(glb.clone())),
    ));
    commands.spawn((
        Camera3d::default(),
        Hdr,
        // So that what the camera sees are the numbers of the light.
        Tonemapping::None,
        Projection::Perspective(PerspectiveProjection {
            fov: shown.fov.to_radians(),
            near: 0.01,
            ..default()
        }),
        RenderTarget::Image(target.clone().into()),
        Transform::from_translation(shown.eye).looking_at(shown.look, Vec3::Y),
    ));
    let count = shown
        .pages
        .iter()
        .flatten()
        .max()
        .map_or(0, |last| last + 1);
    let lightmap = |page| assets.load(format!("{}.{page}.lightmap.ktx2", shown.stem));
    let lightmaps = (0..count).map(lightmap).collect();
    commands.insert_resource(Scene {
        gltf: assets.load(glb),
        target,
        lightmaps,
        frames: 0,
    });
}

/// Gives every mesh that has occlusion the lightmap of its page.
fn light(
    mut commands: Commands,
    shown: Res<Shown>,
    scene: Res<Scene>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    assets: Res<AssetServer>,
    meshes: Query<(Entity, &MeshMaterial3d<StandardMaterial>), Without<Lightmap>>,
) {
    for (entity, material) in &meshes {
        let Some(own) = materials.get(material) else {
            continue;
        };
        let Some(occlusion) = &own.occlusion_texture else {
            continue;
        };
        // `courtyard.glb#Texture3` is the texture 3 of the file.
        let path = assets.get_path(occlusion);
        let number = path
            .as_ref()
            .and_then(|path| path.label()?.strip_prefix("Texture")?.parse::<usize>().ok());
        let page = number.and_then(|number| *shown.pages.get(number)?);
        let Some(page) = page else { continue };
        if let Some(mut own) = materials.get_mut(material) {
            // The coat takes what it reflects from the light below; Bevy does not.
            let coat = 0.16 * own.reflectance * own.reflectance;
            own.lightmap_exposure = shown.scale * (1.0 - coat);
        }
        commands.entity(entity).insert(Lightmap {
            image: scene.lightmaps[page as usize].clone(),
            ..default()
        });
    }
}

/// Reads the picture back once everything is there.
fn take(
    mut commands: Commands,
    mut scene: ResMut<Scene>,
    assets: Res<AssetServer>,
    lit: Query<&Lightmap>,
) {
    let loaded = assets.is_loaded_with_dependencies(&scene.gltf)
        && scene
            .lightmaps
            .iter()
            .all(|map| assets.is_loaded_with_dependencies(map))
        && !lit.is_empty();
    if !loaded || scene.frames > SETTLE {
        return;
    }
    scene.frames += 1;
    if scene.frames == SETTLE {
        scene.frames += 1;
        commands
            .spawn(Readback::texture(scene.target.clone()))
            .observe(
                |event: On<ReadbackComplete>,
                 shown: Res<Shown>,
                 mut exit: MessageWriter<AppExit>| {
                    let half = |at: &[u8]| f16::from_le_bytes([at[0], at[1]]).to_f32();
                    let pixel =
                        |at: &[u8]| [half(at), half(&at[2..]), half(&at[4..]), half(&at[6..])];
                    // Rows are as long as the card copies them, 256 bytes or a multiple.
                    let [width, height] = shown.size.map(|n| n as usize);
                    let rows = event.data.chunks_exact(event.data.len() / height);
                    let row = |row: &[u8]| {
                        row.chunks_exact(8)
                            .take(width)
                            .map(pixel)
                            .collect::<Vec<_>>()
                    };
                    let pixels: Vec<[f32; 4]> = rows.flat_map(row).collect();
                    assert_eq!(pixels.len(), width * height);
                    if let Ok(mut seen) = SEEN.lock() {
                        *seen = Some(pixels);
                    }
                    exit.write(AppExit::Success);
                },
            );
    }
}

fn point(text: &str) -> Result<Vec3> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(str::parse).collect();
    match numbers?.as_slice() {
        [x, y, z] => Ok(Vec3::new(*x, *y, *z)),
        _ => bail!("{text}: expected X,Y,Z"),
    }
}

/// What Bevy multiplies the lightmaps by.
fn scale(path: &Path) -> Result<f32> {
    let bake: Value = serde_json::from_slice(&std::fs::read(path)?)?;
    let maps = bake["lightmaps"]
        .as_array()
        .context("bake.json has no lightmaps")?;
    let own = maps.iter().find(|map| map["engine"] == "bevy");
    let scale = own.and_then(|map| map["scale"].as_f64());
    Ok(scale.context("bake.json has nothing for bevy; run ambake export DIR --for bevy")? as f32)
}

/// The page of each texture of a GLB that is a page's occlusion, `STEM.P.occlusion`.
fn pages(glb: &[u8]) -> Result<Vec<Option<u32>>> {
    let length = glb.get(12..16).context("no GLB")?;
    let length = u32::from_le_bytes(length.try_into()?) as usize;
    let json: Value = serde_json::from_slice(glb.get(20..20 + length).context("no GLB")?)?;
    let page = |texture: &Value| {
        let image = &json["images"][texture["source"].as_u64()? as usize];
        let name = image["name"].as_str()?.strip_suffix(".occlusion")?;
        name.rsplit('.').next()?.parse().ok()
    };
    let textures = json["textures"]
        .as_array()
        .context("the GLB has no textures")?;
    Ok(textures.iter().map(page).collect())
}

/// Size and pixels of an EXR file.
fn read(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let new = |size: exr::math::Vec2<usize>, _: &_| (size.0, vec![[0.0; 3]; size.area()]);
    let set = |(width, pixels): &mut (usize, Vec<[f32; 3]>),
               at: exr::math::Vec2<usize>,
               (r, g, b, _): (f32, f32, f32, f32)| {
        pixels[at.1 * *width + at.0] = [r, g, b];
    };
    let image = read_first_rgba_layer_from_file(path, new, set)
        .with_context(|| path.display().to_string())?;
    let (width, pixels) = image.layer_data.channel_data.pixels;
    let height = image.layer_data.size.1;
    Ok(([width, height], pixels))
}

/// Mean and largest difference in 1/255, and of how many pixels: edges are drawn with other sampling, and left out.
fn difference(
    [width, height]: [usize; 2],
    seen: &[[f32; 4]],
    wanted: &[[f32; 3]],
) -> (f32, f32, usize) {
    let (mut sum, mut most, mut pixels) = (0.0, 0.0f32, 0);
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let i = y * width + x;
            let edge = [i, i - 1, i + 1, i - width, i + width].iter().any(|&j| {
                seen[j][3] < 1.0 || (0..3).any(|c| (wanted[i][c] - wanted[j][c]).abs() > 0.1)
            });
            if edge {
                continue;
            }
            pixels += 1;
            for c in 0..3 {
                let own = 255.0 * (seen[i][c] - wanted[i][c]).abs();
                sum += own / 3.0;
                most = most.max(own);
            }
        }
    }
    (sum / pixels.max(1) as f32, most, pixels)
}
