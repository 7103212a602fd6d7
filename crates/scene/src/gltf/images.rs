//! The images that glTF materials read: found, decoded, each once.

use super::accessor::index;
use super::document::uri_of;
use crate::image::{Failure, Pixels, TOO_LARGE, content, decode};
use crate::input::{Input, short};
use crate::source::{NORMALS_STAND, Uri};
use crate::validate::{Parts, slots};
use crate::{Error, GltfDocument, Image, Packed, PackedImage, TextureRef, WarningKind};
use rayon::prelude::*;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Reads the images of normal maps, undecoded and the same one once, and leads the maps to them.
pub(super) fn packed_images(
    input: &mut Input,
    document: &GltfDocument,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<(), Error> {
    let mut numbers = HashMap::new();
    let mut known = HashMap::new();
    for material in &mut parts.materials {
        let Some(map) = &mut material.normal_map else {
            continue;
        };
        let source = map.texture.image as usize;
        let number = match numbers.entry(source) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(slot) => {
                let image = encoded(input, document, source, NORMALS_STAND)?;
                *slot.insert(image.map(|(name, bytes)| {
                    let number = *known.entry(content(&bytes, &name)).or_insert_with(|| {
                        parts.packed_images.push(PackedImage {
                            name,
                            content: Packed::File(bytes.to_vec()),
                            file: input.path.clone(),
                        });
                        parts.packed_images.len() as u32 - 1
                    });
                    if let Cow::Owned(bytes) = bytes {
                        files.insert(source, bytes);
                    }
                    number
                }))
            }
        };
        let Some(number) = number else {
            material.normal_map = None;
            continue;
        };
        map.texture.image = number;
        input.warn(
            WarningKind::IgnoredNormalMaps,
            format!("material `{}`", material.name),
            1,
            "normalTexture is left out, the mesh's normals stand alone; --normal-maps takes it in",
        );
    }
    Ok(())
}

/// Decodes the images that surfaces, emission and transmission read, and leads the textures to them.
pub(super) fn images(
    input: &mut Input,
    document: &GltfDocument,
    parts: &mut Parts,
    files: &mut BTreeMap<usize, Vec<u8>>,
) -> Result<(), Error> {
    let mut wanted: Vec<(usize, Encoded)> = Vec::new();
    let mut seen = BTreeSet::new();
    for texture in parts.materials.iter_mut().flat_map(slots).flatten() {
        let source = texture.image as usize;
        if seen.insert(source)
            && let Some(image) = encoded(input, document, source, "the factor stands alone")?
        {
            wanted.push((source, image));
        }
    }
    let (mut pictures, which) = decoded(input, &wanted)?;
    let mut known = vec![None; pictures.len()];
    let mut numbers = HashMap::new();
    for ((source, (name, bytes)), which) in wanted.into_iter().zip(which) {
        if let Cow::Owned(bytes) = bytes {
            files.insert(source, bytes);
        }
        let place = image_place(source, &name);
        match &mut pictures[which] {
            Ok(picture) => {
                let number = *known[which].get_or_insert_with(|| {
                    parts.images.push(Image {
                        name,
                        width: picture.width,
                        height: picture.height,
                        pixels: std::mem::take(&mut picture.pixels),
                    });
                    parts.images.len() as u32 - 1
                });
                numbers.insert(source as u32, number);
            }
            Err(Failure::Unsupported(format)) => {
                input.warn(
                    WarningKind::UnreadTextures,
                    place,
                    1,
                    format!("{format} is not read; convert the image to PNG"),
                );
            }
            Err(Failure::Broken(problem)) => {
                input.warn_of_picture(place, &short(problem), "the factor stands alone");
            }
            Err(Failure::TooLarge) => return Err(input.invalid(place, TOO_LARGE)),
        }
    }
    for slot in parts.materials.iter_mut().flat_map(slots) {
        *slot = slot.take().and_then(|texture| {
            let image = *numbers.get(&texture.image)?;
            Some(TextureRef { image, ..texture })
        });
    }
    Ok(())
}

/// Decodes images, the same one once; returns the pictures, and which of them each image is.
///
/// # Errors
/// Together they would take too much memory.
fn decoded(
    input: &mut Input,
    wanted: &[(usize, Encoded)],
) -> Result<(Vec<Decoded>, Vec<usize>), Error> {
    let mut known = HashMap::new();
    let (mut distinct, mut which) = (Vec::new(), Vec::with_capacity(wanted.len()));
    for (source, (name, bytes)) in wanted {
        let next = distinct.len();
        let picture = *known.entry(content(bytes, name)).or_insert(next);
        if picture == next {
            let taken = input.bounds.pictures.take(bytes, name);
            taken.map_err(|problem| input.invalid(image_place(*source, name), problem))?;
            distinct.push((bytes, name));
        }
        which.push(picture);
    }
    let pictures = distinct.par_iter();
    let pictures = pictures.map(|(bytes, name)| decode(bytes, name)).collect();
    Ok((pictures, which))
}

/// A picture, or why there is none.
type Decoded = Result<Pixels, Failure>;

/// What messages call an image.
fn image_place(number: usize, name: &str) -> String {
    format!("image {number} `{}`", short(name))
}

/// Name and file bytes of an image.
type Encoded<'a> = (String, Cow<'a, [u8]>);

/// The file of an image; `None`, with a warning that says what is done `instead`, where it cannot be had.
///
/// # Errors
/// It lies where the scene may not have files read.
fn encoded<'a>(
    input: &mut Input,
    document: &'a GltfDocument,
    number: usize,
    instead: &str,
) -> Result<Option<Encoded<'a>>, Error> {
    let json = &document.list("images")[number];
    let own = json.get("name").and_then(Value::as_str).map(str::to_owned);
    let name = own.clone().unwrap_or_else(|| format!("image {number}"));
    let found = match (json.get("bufferView"), json.get("uri")) {
        (Some(view), _) => {
            let view = index(view).ok_or_else(|| "its bufferView is no number".to_owned());
            let bytes = view.and_then(|view| document.view(view));
            bytes.map(|(bytes, _)| (name, Cow::Borrowed(bytes)))
        }
        (None, None) => Err("it has neither a uri nor a bufferView".to_owned()),
        (None, Some(uri)) => match uri_of(uri) {
            Ok(Uri::Data(bytes)) => Ok((name, Cow::Owned(bytes))),
            Ok(Uri::File(file)) => {
                let path = input.located(&input.path.clone(), &file);
                let bytes = input.read_picture(&path, instead)?;
                return Ok(bytes.map(|bytes| (own.unwrap_or(file), Cow::Owned(bytes))));
            }
            Err(problem) => Err(problem),
        },
    };
    if let Err(problem) = &found {
        input.warn_of_picture(format!("image {number}"), problem, instead);
    }
    Ok(found.ok())
}
