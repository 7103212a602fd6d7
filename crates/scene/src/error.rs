//! What can stop a load. Every message is one line: the file (or for a scene built in memory the mesh), the place in
//! it, what is wrong and what to do.

use std::path::PathBuf;

/// Why a scene cannot be loaded or built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refuses to read a file.
    #[error("cannot read {}: {cause}; check its name and permissions", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        cause: std::io::Error,
    },
    /// A directory, a device or a pipe stands where a file is expected.
    #[error("{} is not a regular file; give the path of an .obj, .gltf or .glb file", path.display())]
    NotAFile {
        /// The path as given.
        path: PathBuf,
    },
    /// A scene names a file outside of its folder.
    #[error(
        "{}: it names {}, which lies outside of the scene's folder; copy it there, or pass --allow-outside if you \
         trust the scene",
        path.display(), named.display()
    )]
    Outside {
        /// The scene file.
        path: PathBuf,
        /// The file that it names.
        named: PathBuf,
    },
    /// The file holds no byte.
    #[error("{} is empty; export the scene again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is no scene file that can be read, by its content or by its ending.
    #[error("{} is {what}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// What it is, and what to do.
        what: &'static str,
    },
    /// This build has no reader of such files.
    #[error("{}: this program was built without a reader of such files; \
        build it with the feature `obj` or `gltf` of ambake", path.display())]
    NotBuilt {
        /// The file.
        path: PathBuf,
    },
    /// The file contradicts its format or itself.
    #[error("{}: {place}: {problem}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line, mesh and primitive, accessor, or other place in the file.
        place: String,
        /// What is wrong there, and what to do.
        problem: String,
    },
    /// What a program handed to [`Scene::from_meshes`](crate::Scene::from_meshes) contradicts itself.
    #[error("{place}: {problem}")]
    Authored {
        /// Mesh or material, by number and name.
        place: String,
        /// What is wrong there, and what to do.
        problem: String,
    },
    /// A glTF file requires an extension that is not implemented.
    #[error("{}: the required extension {extension} is not supported; export the file without it", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
        /// Name of the extension.
        extension: String,
    },
    /// Nothing is left to bake.
    #[error(
        "{} has no triangle with an area in its scene; check that meshes were exported, stand in the default \
            scene and are not hidden{hint}", path.display()
    )]
    NoTriangles {
        /// The file.
        path: PathBuf,
        /// What was noticed on the way, each after a semicolon, or nothing.
        hint: String,
    },
}
