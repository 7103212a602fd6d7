//! Corners of OBJ faces, made unique: OBJ numbers positions, UVs and normals apart, a [`crate::Mesh`] together.

/// Stands for an absent UV or normal.
pub(super) const NONE: u32 = u32::MAX;

/// How far the chain of one position is searched. Beyond it a vertex is stored twice, which costs memory only where a
/// position carries more than this many different UVs or normals, and keeps the search linear in the file.
const LONGEST_SEARCH: usize = 64;

/// A vertex of a part: what its position, UV and normal are numbered in the file.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub part: u32,
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
    /// While reading: the next corner with the same position, or [`NONE`]. Afterwards: the vertex number in its part.
    link: u32,
}

/// All corners so far, chained by position, and the triangles of each part between them.
#[derive(Default)]
pub(super) struct Corners {
    newest: Vec<u32>,
    all: Vec<Corner>,
    triangles: Vec<Vec<[u32; 3]>>,
    faces: Vec<Faces>,
}

/// Which triangles of a part are of the face that the one before them is of: a bit each.
#[derive(Default)]
pub(super) struct Faces(Vec<u64>);

impl Faces {
    /// True for a triangle, by its number, that goes on with the face of the one before.
    pub fn goes_on(&self, triangle: usize) -> bool {
        let word = self.0.get(triangle / 64);
        word.is_some_and(|word| word >> (triangle % 64) & 1 == 1)
    }

    fn go_on(&mut self, triangle: usize) {
        let word = triangle / 64;
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= 1 << (triangle % 64);
    }
}

impl Corners {
    /// Number of the corner, an earlier one if it was met before; `None` when the numbers are used up.
    pub fn insert(&mut self, part: u32, [position, uv, normal]: [u32; 3]) -> Option<u32> {
        let slot = position as usize;
        if slot >= self.newest.len() {
            self.newest.resize(slot + 1, NONE);
        }
        let mut at = self.newest[slot];
        for _ in 0..LONGEST_SEARCH {
            let Some(corner) = self.all.get(at as usize) else {
                break;
            };
            if (corner.part, corner.uv, corner.normal) == (part, uv, normal) {
                return Some(at);
            }
            at = corner.link;
        }
        let number = u32::try_from(self.all.len()).ok().filter(|&n| n != NONE)?;
        self.all.push(Corner {
            part,
            position,
            uv,
            normal,
            link: self.newest[slot],
        });
        self.newest[slot] = number;
        Some(number)
    }

    /// Adds the triangles of a face to a part; its corners were inserted for the same part.
    pub fn add(&mut self, part: u32, face: impl Iterator<Item = [u32; 3]>) {
        let part = part as usize;
        if part >= self.triangles.len() {
            self.triangles.resize_with(part + 1, Vec::new);
            self.faces.resize_with(part + 1, Faces::default);
        }
        let triangles = &mut self.triangles[part];
        let first = triangles.len();
        triangles.extend(face);
        for further in first + 1..triangles.len() {
            self.faces[part].go_on(further);
        }
    }

    /// The corners in the order of their vertices within each of `parts` parts, each part's triangles, and which of
    /// them are of one face.
    pub fn into_vertices(mut self, parts: usize) -> (Vec<Corner>, Vec<Vec<[u32; 3]>>, Vec<Faces>) {
        self.newest = Vec::new();
        let mut counts = vec![0; parts];
        for corner in &mut self.all {
            corner.link = counts[corner.part as usize];
            counts[corner.part as usize] += 1;
        }
        self.triangles.resize_with(parts, Vec::new);
        for index in self.triangles.iter_mut().flatten().flatten() {
            *index = self.all[*index as usize].link;
        }
        self.faces.resize_with(parts, Faces::default);
        (self.all, self.triangles, self.faces)
    }
}
