//! Reads the lines of an OBJ file.

use super::corners::NONE;
use super::{File, name, number, polygon, text_of};
use crate::input::{Input, short};
use crate::lookup::linear;
use crate::source::{open, without_mark};
use crate::{Error, WarningKind};
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::io::{BufRead, BufReader};

/// A line beyond this is no OBJ: it would be a polygon of some million corners.
const LONGEST_LINE: usize = 64 << 20;

/// Where the reader stands: names in force, the part they select, and counts of what was ignored.
struct State {
    file: File,
    object: String,
    group: String,
    material: u32,
    /// The part of (object, group, material), looked up at the first face after one of them changed.
    part: Option<u32>,
    part_numbers: HashMap<(String, u32), u32>,
    material_numbers: HashMap<String, u32>,
    ignored_elements: u64,
    ignored_uvs: u64,
    ignored_normals: u64,
    // Kept between faces, so that a face costs no allocation.
    face: Vec<[u32; 3]>,
    outline: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

/// Reads the main file of `input` from its first to its last line.
pub(super) fn read(input: &mut Input) -> Result<File, Error> {
    let path = input.path.clone();
    let mut reader = BufReader::with_capacity(1 << 20, open(&path)?);
    input.files.push(path);
    let mut state = State::new();
    let mut line = Vec::new();
    let mut number = 0u64;
    while next_line(input, &mut reader, &mut line, &mut number)? {
        // Files that were put together may hold a mark in the middle.
        state
            .line(without_mark(&line))
            .map_err(|problem| input.invalid(format!("line {number}"), problem))?;
    }
    let name = "the file";
    input.warn(
        WarningKind::IgnoredLinesAndPoints,
        name,
        state.ignored_elements,
        "elements without an area are left out",
    );
    input.warn(
        WarningKind::IgnoredUvReferences,
        name,
        state.ignored_uvs,
        "corners name vt 0, or a vt where none stands before them",
    );
    input.warn(
        WarningKind::IgnoredNormalReferences,
        name,
        state.ignored_normals,
        "corners name vn 0, or a vn where none stands before them",
    );
    Ok(state.file)
}

/// The next line with its continuations, without its end; false at the end of the file.
fn next_line(
    input: &mut Input,
    reader: &mut BufReader<std::fs::File>,
    line: &mut Vec<u8>,
    number: &mut u64,
) -> Result<bool, Error> {
    line.clear();
    loop {
        let start = line.len();
        let read = add_line(reader, &mut input.hasher, line).map_err(|cause| Error::Read {
            path: input.path.clone(),
            cause,
        })?;
        if !read {
            return Ok(start > 0);
        }
        *number += 1;
        if line.len() >= LONGEST_LINE {
            let problem =
                format!("more than {LONGEST_LINE} bytes in one line; this is not an OBJ file");
            return Err(input.invalid(format!("line {number}"), problem));
        }
        let text = line.trim_ascii_end().len();
        if text == 0 || line[text - 1] != b'\\' {
            return Ok(true);
        }
        line.truncate(text - 1);
        line.push(b' ');
    }
}

/// Adds what stands before the next end of a line (LF, CR or both), or [`LONGEST_LINE`] bytes of it; false at the end
/// of the file.
fn add_line(
    reader: &mut impl BufRead,
    hasher: &mut blake3::Hasher,
    line: &mut Vec<u8>,
) -> std::io::Result<bool> {
    let mut any = false;
    while line.len() < LONGEST_LINE {
        let bytes = reader.fill_buf()?;
        if bytes.is_empty() {
            return Ok(any);
        }
        any = true;
        let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let content = end.unwrap_or(bytes.len());
        let returned = bytes.get(content) == Some(&b'\r');
        line.extend_from_slice(&bytes[..content]);
        let taken = content + usize::from(end.is_some());
        hasher.update(&bytes[..taken]);
        reader.consume(taken);
        if returned && reader.fill_buf()?.first() == Some(&b'\n') {
            hasher.update(b"\n");
            reader.consume(1);
        }
        if end.is_some() {
            break;
        }
    }
    Ok(true)
}

impl State {
    fn new() -> State {
        State {
            file: File {
                materials: vec![String::new()],
                ..File::default()
            },
            object: String::new(),
            group: String::new(),
            material: 0,
            part: None,
            part_numbers: HashMap::new(),
            material_numbers: HashMap::from([(String::new(), 0)]),
            ignored_elements: 0,
            ignored_uvs: 0,
            ignored_normals: 0,
            face: Vec::new(),
            outline: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Takes one line in. An error is a sentence about it.
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let line = line.trim_ascii();
        let end = line
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(line.len());
        let (keyword, rest) = line.split_at(end);
        match keyword {
            b"v" => self.vertex(rest)?,
            b"vt" => {
                let uv: [f64; 2] = numbers(rest, 1)?;
                self.file.uvs.push(Vec2::from_array(uv.map(|x| x as f32)));
            }
            b"vn" => (self.file.normals).push(DVec3::from_array(numbers(rest, 3)?).as_vec3()),
            b"f" | b"fo" => self.face(rest)?,
            b"l" | b"p" => self.ignored_elements += 1,
            b"o" => {
                self.object = name(rest);
                self.group.clear();
                self.part = None;
            }
            b"g" => {
                self.group = name(rest);
                self.part = None;
            }
            b"usemtl" => {
                let next = self.file.materials.len() as u32;
                let name = name(rest);
                self.material = *self.material_numbers.entry(name.clone()).or_insert(next);
                if self.material == next {
                    self.file.materials.push(name);
                }
                self.part = None;
            }
            b"mtllib" => {
                self.file.libraries.push(text_of(rest));
            }
            _ if line.contains(&0) => {
                return Err("binary data; this is not an OBJ file in UTF-8 or ASCII, save or export it as one".into());
            }
            _ => {}
        }
        Ok(())
    }

    /// A position, and where six numbers stand a colour in sRGB, as programs that write them have it.
    fn vertex(&mut self, rest: &[u8]) -> Result<(), String> {
        let [x, y, z, r, g, b] = numbers_or(rest, 3, f64::INFINITY)?;
        if b != f64::INFINITY {
            self.file
                .colors
                .resize(self.file.positions.len(), Vec3::ONE);
            self.file
                .colors
                .push(DVec3::new(r, g, b).as_vec3().map(linear));
        }
        self.file.positions.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let counts = [
            self.file.positions.len(),
            self.file.uvs.len(),
            self.file.normals.len(),
        ];
        if counts.iter().any(|&n| n >= NONE as usize) {
            return Err("more than 4294967294 vertices; split the scene".into());
        }
        self.face.clear();
        for word in rest
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
        {
            if word[0] == b'#' {
                break;
            }
            let mut corner = [NONE; 3];
            for (i, field) in word.split(|&b| b == b'/').enumerate() {
                match (i, field.is_empty()) {
                    (3.., _) => {
                        return Err(format!(
                            "corner `{}` has more than three indices",
                            text(word)
                        ));
                    }
                    (0, true) => return Err(format!("corner `{}` names no vertex", text(word))),
                    (_, true) => {}
                    (1, _) if counts[1] == 0 || is_zero(field) => self.ignored_uvs += 1,
                    (2, _) if counts[2] == 0 || is_zero(field) => self.ignored_normals += 1,
                    _ => corner[i] = index(field, counts[i], ["v", "vt", "vn"][i])?,
                }
            }
            self.face.push(corner);
        }
        if self.face.len() < 3 {
            self.ignored_elements += 1;
            return Ok(());
        }
        self.triangles.clear();
        if self.face.len() == 3 {
            self.triangles.push([0, 1, 2]);
        } else {
            self.outline.clear();
            self.outline
                .extend(self.face.iter().map(|c| self.file.positions[c[0] as usize]));
            polygon::triangulate(&self.outline, &mut self.triangles);
        }
        let part = self.part();
        let full = || "more than 4294967294 corners; split the scene".to_string();
        for corner in &mut self.face {
            // The corner's number takes the place of its position.
            corner[0] = self.file.corners.insert(part, *corner).ok_or_else(full)?;
        }
        let triangles = self.triangles.iter();
        let numbered = triangles.map(|triangle| triangle.map(|i| self.face[i][0]));
        self.file.corners.add(part, numbered);
        Ok(())
    }

    /// Number of the part that faces go to now.
    fn part(&mut self) -> u32 {
        if let Some(part) = self.part {
            return part;
        }
        let name = match (self.object.as_str(), self.group.as_str()) {
            ("", "") => "default".to_string(),
            (object, "") => object.to_string(),
            ("", group) => group.to_string(),
            (object, group) => format!("{object}/{group}"),
        };
        let next = self.file.parts.len() as u32;
        let part = *self
            .part_numbers
            .entry((name.clone(), self.material))
            .or_insert(next);
        if part == next {
            self.file.parts.push((name, self.material));
        }
        self.part = Some(part);
        part
    }
}

/// Numbers of a line, at least `needed` of the `N`; the others are 0, further ones are left.
fn numbers<const N: usize>(rest: &[u8], needed: usize) -> Result<[f64; N], String> {
    numbers_or(rest, needed, 0.0)
}

/// As [`numbers`], where the others are `absent`.
fn numbers_or<const N: usize>(rest: &[u8], needed: usize, absent: f64) -> Result<[f64; N], String> {
    let mut out = [absent; N];
    let mut words = rest
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    for (i, slot) in out.iter_mut().enumerate() {
        match words.next() {
            Some(word) => match std::str::from_utf8(word).ok().and_then(number) {
                Some(number) => *slot = number,
                None if i >= needed => break,
                None => return Err(format!("`{}` is not a number", text(word))),
            },
            None if i >= needed => break,
            None => return Err(format!("{needed} numbers are needed, {i} are there")),
        }
    }
    Ok(out)
}

/// Whether a field is the index 0, by which some writers say that there is none.
fn is_zero(field: &[u8]) -> bool {
    field.iter().all(|&digit| digit == b'0')
}

/// An OBJ index, from 1 or backward from -1, as an index from 0.
fn index(field: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let number: Option<i64> = std::str::from_utf8(field)
        .ok()
        .and_then(|field| field.parse().ok());
    let number = number.ok_or_else(|| format!("`{}` is not an index", text(field)))?;
    let index = if number < 0 {
        count as i64 + number
    } else {
        number - 1
    };
    if number == 0 || index < 0 || index >= count as i64 {
        return Err(format!(
            "the face uses {what} {number}, but {count} stand before it; the file is corrupt"
        ));
    }
    Ok(index as u32)
}

/// Words of a line as text, for messages.
fn text(bytes: &[u8]) -> String {
    short(&text_of(bytes))
}
