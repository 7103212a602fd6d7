//! Material libraries: the parameters of the Phong model as OBJ files give them.
//!
//! Read: `Ka`, `Kd`, `Ks`, `Ns`, `Ke`, `d`, `Tr`, `map_Kd`, `map_d`; missing ones are white, black, 0, black and
//! opaque. A black `Kd` beside `map_Kd` is white, for else the picture would not show. Where Kd + Ks is above 1 in a
//! channel, both are scaled down, for no surface reflects more than it receives. `Ka` serves the traditional term
//! alone, where it is asked for. `norm`, else `map_Bump` or `bump`, is the normal map. What no face uses is not read,
//! nor are its pictures. A statement that names no file, such as `map_Kd .`, is none. `map_Ks` is noted and left out.
//! `illum` is not used either: which model is shown is chosen by layer.

use super::options::Options;
use super::{name, number, text_of};
use crate::image::{Content, Failure, TOO_LARGE, content, decode};
use crate::input::{Input, short};
use crate::material::{MAX_EXPONENT, conserving};
use crate::source::{NORMALS_STAND, beside, without_mark};
use crate::validate::{Parts, clamped};
use crate::{
    Alpha, Error, Image, Material, MaterialModel, NormalMap, Packed, PackedImage, TextureRef,
    WarningKind, Wrap,
};
use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What a texture is used for; the same file as colour and as alpha gives two images.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Role {
    Color,
    Alpha,
}

/// The images that were read, by number.
#[derive(Default)]
struct Known {
    /// `None` for a file that gives none.
    by_file: HashMap<(PathBuf, Role), Option<u32>>,
    /// Another file may hold the same.
    by_content: HashMap<(Content, Role), u32>,
}

/// Reads the materials `used` from the libraries into `parts`, in their order; the first definition of a name counts.
pub(super) fn load(
    input: &mut Input,
    names: &[String],
    used: &HashSet<&str>,
    parts: &mut Parts,
) -> Result<HashMap<String, u32>, Error> {
    let mut known = HashMap::new();
    let mut images = Known::default();
    let mut seen = Vec::new();
    let main = input.path.clone();
    let mut paths = Vec::new();
    for name in names {
        paths.extend(libraries(input, &main, name));
    }
    for path in paths {
        if seen.contains(&path) {
            continue;
        }
        seen.push(path.clone());
        if !path.is_file() {
            let message = "the material library is absent; materials from it are not known";
            input.warn(
                WarningKind::MissingMaterialLibraries,
                path.display().to_string(),
                1,
                message,
            );
            continue;
        }
        let bytes = match input.read(&path, 0) {
            Err(error @ Error::UnknownFormat { .. }) => {
                let place = path.display().to_string();
                let message = format!("{error}; materials from it are not known");
                input.warn(WarningKind::MissingMaterialLibraries, place, 1, message);
                continue;
            }
            bytes => bytes?,
        };
        for mut raw in parsed(input, &path, &bytes) {
            if known.contains_key(&raw.name) || !used.contains(raw.name.as_str()) {
                continue;
            }
            raw.drop_nameless_maps(input, &path);
            let material = material(input, &path, &raw, parts, &mut images)?;
            known.insert(raw.name, parts.materials.len() as u32);
            parts.materials.push(material);
        }
    }
    Ok(known)
}

/// The files of a `mtllib` line: one name with spaces, or several names.
fn libraries(input: &mut Input, main: &Path, line: &str) -> Vec<PathBuf> {
    let names = line.split_whitespace();
    if names.clone().count() < 2 || beside(main, line).is_file() {
        return vec![input.located(main, line)];
    }
    names.map(|name| input.located(main, name)).collect()
}

/// What a library says of a material. The last statement of a kind counts.
#[derive(Default)]
struct Statements {
    name: String,
    ka: Option<[f32; 3]>,
    kd: Option<[f32; 3]>,
    ks: Option<[f32; 3]>,
    ke: Option<[f32; 3]>,
    ns: Option<f32>,
    d: Option<f32>,
    tr: Option<f32>,
    map_kd: Option<String>,
    map_ks: Option<String>,
    map_d: Option<String>,
    bump: Option<String>,
    norm: Option<String>,
}

impl Statements {
    /// Takes away statements of pictures that name none, as programs write them of a picture without a file.
    fn drop_nameless_maps(&mut self, input: &mut Input, library: &Path) {
        let maps = [
            &mut self.map_kd,
            &mut self.map_ks,
            &mut self.map_d,
            &mut self.bump,
            &mut self.norm,
        ];
        let nameless = maps
            .into_iter()
            .filter_map(|map| map.take_if(|map| !names_a_file(library, Options::of(map).file)))
            .count();
        input.warn(
            WarningKind::UnreadTextures,
            format!("material `{}`", self.name),
            nameless as u64,
            "a picture's statement names no file, and is left out",
        );
    }
}

/// False for an empty name, and for that of a folder.
fn names_a_file(library: &Path, name: &str) -> bool {
    let name = name.replace('\\', "/");
    !name.ends_with('/')
        && Path::new(&name).file_name().is_some()
        && !beside(library, &name).is_dir()
}

/// As [`number`], rounded to 32 bits.
fn single(word: &str) -> Option<f32> {
    number(word).map(|number| number as f32)
}

/// The materials of a library. Lines without the number or the name that they need, or before the first material, are
/// counted.
fn parsed(input: &mut Input, path: &Path, bytes: &[u8]) -> Vec<Statements> {
    let mut materials: Vec<Statements> = Vec::new();
    let mut ignored = 0;
    // Files that were put together may hold a mark in the middle.
    let lines = bytes.split(|byte| b"\n\r".contains(byte)).map(without_mark);
    for line in lines.map(text_of) {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
        let rest = rest.trim_ascii();
        let numbers: Vec<f32> = rest.split_whitespace().map_while(single).collect();
        let color = match *numbers {
            [r, g, b, ..] => Some([r, g, b]),
            [grey] => Some([grey; 3]),
            _ => None,
        };
        let value = numbers.first().copied();
        let words = (!rest.is_empty()).then(|| rest.to_owned());
        let keyword = keyword.to_ascii_lowercase();
        if keyword == "newmtl" && words.is_some() {
            materials.push(Statements {
                name: name(rest.as_bytes()),
                ..Statements::default()
            });
            continue;
        }
        let mut none = Statements::default();
        let material = materials.last_mut().unwrap_or(&mut none);
        let is_set = match keyword.as_str() {
            "ka" => set(&mut material.ka, color),
            "kd" => set(&mut material.kd, color),
            "ks" => set(&mut material.ks, color),
            "ke" => set(&mut material.ke, color),
            "ns" => set(&mut material.ns, value),
            "d" => {
                let halo = rest.strip_prefix("-halo");
                set(
                    &mut material.d,
                    halo.map_or(value, |rest| single(rest.trim())),
                )
            }
            "tr" => set(&mut material.tr, value),
            "map_kd" => set(&mut material.map_kd, words),
            "map_ks" => set(&mut material.map_ks, words),
            "map_d" => set(&mut material.map_d, words),
            "map_bump" | "bump" => set(&mut material.bump, words),
            "norm" => set(&mut material.norm, words),
            "newmtl" => false,
            _ => true,
        };
        ignored += u64::from(!is_set);
    }
    input.warn(
        WarningKind::IgnoredMtlLines,
        path.display().to_string(),
        ignored,
        "lines without the number or name they need",
    );
    materials
}

/// Sets what a line says; false where it says nothing.
fn set<T>(slot: &mut Option<T>, value: Option<T>) -> bool {
    let said = value.is_some();
    *slot = value.or(slot.take());
    said
}

fn material(
    input: &mut Input,
    library: &Path,
    raw: &Statements,
    parts: &mut Parts,
    images: &mut Known,
) -> Result<Material, Error> {
    let place = format!("material `{}`", raw.name);
    let color = |c: Option<[f32; 3]>, or: f32, changed: &mut u64| match c {
        Some(c) => Vec3::from_array(c.map(|v| clamped(v, 0.0, 1.0, or, changed))),
        None => Vec3::splat(or),
    };
    let [mut changed, mut ambient_changed] = [0; 2];
    let ambient = raw.ka.map(|ka| color(Some(ka), 0.0, &mut ambient_changed));
    let mut albedo = color(raw.kd, 1.0, &mut changed);
    let specular = color(raw.ks, 0.0, &mut changed);
    let exponent = clamped(
        raw.ns.unwrap_or(0.0),
        0.0,
        MAX_EXPONENT as f32,
        0.0,
        &mut changed,
    ) as f64;
    let emission = raw.ke.map_or(Vec3::ZERO, |radiance| {
        Vec3::from_array(radiance.map(|v| clamped(v, 0.0, f32::MAX, 0.0, &mut changed)))
    });
    let opacity = clamped(
        raw.d.or(raw.tr.map(|t| 1.0 - t)).unwrap_or(1.0),
        0.0,
        1.0,
        1.0,
        &mut changed,
    );
    input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        changed,
        "factors out of range are clamped",
    );
    input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        ambient_changed,
        "Ka out of 0 to 1 is clamped; only --ambient-coefficient file takes Ka",
    );
    // Exporters write black or white where nobody chose anything.
    let is_chosen = |ka: &Vec3| ![Vec3::ZERO, Vec3::ONE, albedo].contains(ka);
    input.warn(
        WarningKind::AmbientCoefficients,
        place.as_str(),
        ambient.iter().filter(|ka| is_chosen(ka)).count() as u64,
        "Ka differs from Kd, by which `traditional` reflects; --ambient-coefficient file takes Ka",
    );
    let is_black = albedo == Vec3::ZERO;
    if is_black && raw.map_kd.is_some() {
        albedo = Vec3::ONE;
    }
    input.warn(
        WarningKind::BlackDiffuse,
        place.as_str(),
        is_black as u64,
        match &raw.map_kd {
            Some(_) => {
                "Kd is black beside a picture, as some programs write it: the picture stands alone"
            }
            None => {
                "Kd is black, and so is `lambert`; give it another colour if it is no black surface"
            }
        },
    );
    let [albedo, specular] = conserving(input, &place, [albedo, specular]);
    let normal_maps = raw.bump.is_some() as u64 + raw.norm.is_some() as u64;
    input.warn(
        WarningKind::IgnoredNormalMaps,
        place.as_str(),
        normal_maps,
        "bump and normal maps are left out, the mesh's normals stand alone; --normal-maps takes one in",
    );
    let specular_map = raw.map_ks.is_some() as u64;
    input.warn(
        WarningKind::UnreadTextures,
        place.as_str(),
        specular_map,
        "map_Ks is not read; Ks stands alone",
    );

    let mut map = |name: &Option<String>, role| match name {
        Some(name) => texture(input, library, &place, name, role, parts, images),
        None => Ok(None),
    };
    let albedo_map = map(&raw.map_kd, Role::Color)?;
    let alpha_map = map(&raw.map_d, Role::Alpha)?;
    let alpha = match (opacity < 1.0, alpha_map) {
        (true, map) => Alpha::Blend {
            factor: opacity,
            map,
        },
        (false, Some(map)) => Alpha::Mask {
            cutoff: 0.5,
            factor: 1.0,
            map: Some(map),
        },
        (false, None) => Alpha::Opaque,
    };
    let normal_map = normal_map(input, library, raw, parts)?;
    let surface = MaterialModel::Phong {
        albedo,
        albedo_map,
        specular,
        exponent,
    };
    Ok(Material {
        surface,
        ambient,
        emission,
        alpha,
        normal_map,
        ..Material::untinted(&raw.name)
    })
}

/// The normal map of `norm`, else of `map_Bump` or `bump`; `None`, with a warning, where its file is absent.
fn normal_map(
    input: &mut Input,
    library: &Path,
    raw: &Statements,
    parts: &mut Parts,
) -> Result<Option<NormalMap>, Error> {
    let norm = raw.norm.as_ref();
    let Some(statement) = norm.or(raw.bump.as_ref()) else {
        return Ok(None);
    };
    let options = Options::of(statement);
    let path = input.located(library, options.file);
    let name = path.display().to_string();
    let known = parts
        .packed_images
        .iter()
        .position(|image| image.file == path);
    let image = match known {
        Some(known) => known,
        None => {
            let Some(bytes) = input.read_picture(&path, NORMALS_STAND)? else {
                return Ok(None);
            };
            parts.packed_images.push(PackedImage {
                name,
                content: Packed::File(bytes),
                file: path,
            });
            parts.packed_images.len() - 1
        }
    };
    Ok(Some(NormalMap {
        scale: options.bump,
        heights: norm.is_none(),
        texture: texture_ref(image as u32, &options),
    }))
}

/// The use of an image that a statement's options ask for.
fn texture_ref(image: u32, options: &Options) -> TextureRef {
    let ([su, sv], [ou, ov]) = (options.scale, options.offset);
    let wrap = if options.clamp {
        Wrap::Clamp
    } else {
        Wrap::Repeat
    };
    TextureRef {
        image,
        uv_set: 0,
        wrap: [wrap; 2],
        linear: true,
        // OBJ scales and shifts with v upward: 1 - ((1 - v) sv + ov).
        transform: [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]],
    }
}

/// A texture statement: options, then a file name.
fn texture(
    input: &mut Input,
    library: &Path,
    place: &str,
    statement: &str,
    role: Role,
    parts: &mut Parts,
    images: &mut Known,
) -> Result<Option<TextureRef>, Error> {
    let options = Options::of(statement);
    let path = input.located(library, options.file);
    let image = match images.by_file.get(&(path.clone(), role)) {
        Some(&known) => known,
        None => {
            let number = image(input, place, &path, role, parts, &mut images.by_content)?;
            *images.by_file.entry((path, role)).or_insert(number)
        }
    };
    Ok(image.map(|image| texture_ref(image, &options)))
}

/// The number of the image in a file; `None`, with a warning, where the file gives none.
fn image(
    input: &mut Input,
    place: &str,
    path: &Path,
    role: Role,
    parts: &mut Parts,
    known: &mut HashMap<(Content, Role), u32>,
) -> Result<Option<u32>, Error> {
    let name = path.display().to_string();
    let instead = "the factor stands alone";
    let Some(bytes) = input.read_picture(path, instead)? else {
        return Ok(None);
    };
    let key = (content(&bytes, &name), role);
    if let Some(&number) = known.get(&key) {
        return Ok(Some(number));
    }
    let invalid = |problem| Error::Invalid {
        path: path.into(),
        place: place.into(),
        problem,
    };
    input.bounds.pictures.take(&bytes, &name).map_err(invalid)?;
    match decode(&bytes, &name) {
        Ok(mut decoded) => {
            if role == Role::Alpha && !decoded.has_alpha {
                decoded.pixels.iter_mut().for_each(|p| p[3] = p[0]);
            }
            let number = parts.images.len() as u32;
            parts.images.push(Image {
                name,
                width: decoded.width,
                height: decoded.height,
                pixels: decoded.pixels,
            });
            known.insert(key, number);
            Ok(Some(number))
        }
        Err(Failure::Unsupported(format)) => {
            let message =
                format!("texture {name} is {format}, which is not read; convert it to PNG");
            input.warn(WarningKind::UnreadTextures, place, 1, message);
            Ok(None)
        }
        Err(Failure::Broken(problem)) => {
            input.warn_of_picture(format!("texture `{name}`"), &short(&problem), instead);
            Ok(None)
        }
        Err(Failure::TooLarge) => Err(invalid(TOO_LARGE.into())),
    }
}
