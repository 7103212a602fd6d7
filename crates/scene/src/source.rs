//! Reads the bytes of a scene: the main file and the files it names, all of them hashed in the order they are read.

use crate::foreign;
use crate::input::{Files, Input, short};
use crate::{Error, Format, WarningKind};
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The most bytes that a file named by a scene may hold beyond what the scene says of it: 1 GiB.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// What is done without the picture of a normal map.
pub(crate) const NORMALS_STAND: &str = "the mesh's normals stand alone";

impl Input {
    /// All bytes of the main file, hashed.
    pub fn read_main(&mut self) -> Result<Vec<u8>, Error> {
        let path = self.path.clone();
        let bytes = bytes_of(open(&path)?, &path)?;
        self.hasher.update(&bytes);
        self.files.push(path);
        Ok(bytes)
    }

    /// All bytes of a file that the scene names, hashed.
    ///
    /// * `announced`: how many bytes the scene says that it has; 0 where it says nothing.
    pub fn read(&mut self, path: &Path, announced: u64) -> Result<Vec<u8>, Error> {
        let bytes = self.read_unhashed(path, announced)?;
        if foreign::is_pointer(&bytes) {
            return Err(Error::UnknownFormat {
                path: path.into(),
                what: foreign::POINTER,
            });
        }
        self.hasher.update(&bytes);
        self.files.push(path.to_owned());
        Ok(bytes)
    }

    /// The bytes of a picture; `None`, with a warning that says what is done `instead`, where they cannot be had.
    ///
    /// # Errors
    /// It lies where the scene may not have files read.
    pub fn read_picture(&mut self, path: &Path, instead: &str) -> Result<Option<Vec<u8>>, Error> {
        let problem = match path.is_file().then(|| self.read(path, 0)) {
            Some(Ok(bytes)) => return Ok(Some(bytes)),
            Some(Err(error @ Error::Outside { .. })) => return Err(error),
            Some(Err(error)) => error.to_string(),
            None => "the picture is absent".into(),
        };
        self.warn_of_picture(format!("texture `{}`", path.display()), &problem, instead);
        Ok(None)
    }

    /// Notes that a picture cannot be had, and what is done `instead`.
    pub fn warn_of_picture(&mut self, place: String, problem: &str, instead: &str) {
        let message = format!("{problem}; {instead}");
        let kind = match instead {
            NORMALS_STAND => WarningKind::MissingNormalMaps,
            _ => WarningKind::MissingTextures,
        };
        self.warn(kind, place, 1, message);
    }

    /// As [`Input::read`], for a file without influence on a bake.
    pub fn read_unhashed(&self, path: &Path, announced: u64) -> Result<Vec<u8>, Error> {
        self.check_place(path)?;
        let file = open(path)?;
        let length = file.metadata().map_or(0, |about| about.len());
        let most = announced.saturating_add(MOST_BYTES);
        let long = |place: String| Error::Invalid {
            path: path.into(),
            place,
            problem: "no file that a scene names may be so long; check what it is".into(),
        };
        if length > most {
            return Err(long(format!("{length} bytes")));
        }
        // It may grow while it is read, or say nothing of its length.
        let bytes = bytes_of(file.take(most.saturating_add(1)), path)?;
        match bytes.len() as u64 > most {
            true => Err(long(format!("more than {most} bytes"))),
            false => Ok(bytes),
        }
    }

    /// The file that a name inside another file stands for. One that is not there is looked for with letters in the
    /// other case, and from each of its folders on as if that lay beside the file: names are written on other systems
    /// and machines. Finding it so is noted.
    pub fn located(&mut self, file: &Path, name: &str) -> PathBuf {
        let plain = beside(file, name);
        if plain.exists() {
            return plain;
        }
        let name = name.replace('\\', "/");
        let slashed = beside(file, &name);
        if slashed.exists() {
            return slashed;
        }
        let parts: Vec<&str> = name.split('/').collect();
        let folder = file.parent().unwrap_or(Path::new(""));
        let found = (0..parts.len()).find_map(|from| in_any_case(folder, &parts[from..]));
        let Some(found) = found else {
            return slashed;
        };
        let place = format!("`{}`, found as {}", short(&name), found.display());
        let message = "a file is not where its name says; one of the same name, but for its folders or the case of \
            letters, is read";
        self.warn(WarningKind::FilesFoundElsewhere, place, 1, message);
        found
    }

    /// Refuses a file outside of the folders of the main file: the one it was named in and the one it really lies in.
    fn check_place(&self, path: &Path) -> Result<(), Error> {
        // What is absent is somebody else's complaint.
        let (Files::Inside, Ok(real)) = (self.bounds.allowed, path.canonicalize()) else {
            return Ok(());
        };
        let named = match self.path.parent() {
            Some(folder) if folder != Path::new("") => folder.canonicalize().ok(),
            _ => Path::new(".").canonicalize().ok(),
        };
        let own = self.path.canonicalize().ok();
        let own = own.and_then(|file| file.parent().map(Path::to_owned));
        match [named, own]
            .into_iter()
            .flatten()
            .any(|folder| real.starts_with(folder))
        {
            true => Ok(()),
            false => Err(Error::Outside {
                path: self.path.clone(),
                named: path.into(),
            }),
        }
    }
}

fn bytes_of(mut file: impl Read, path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let read = file.read_to_end(&mut bytes);
    read.map_err(|cause| Error::Read {
        path: path.into(),
        cause,
    })?;
    Ok(bytes)
}

/// The file that a relative name inside another file stands for.
pub(crate) fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}

/// The file at a path below a folder, whatever the case of letters; the first by name where several fit.
fn in_any_case(folder: &Path, parts: &[&str]) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for part in parts.iter().filter(|part| !matches!(**part, "" | ".")) {
        let lower = part.to_lowercase();
        let listed = if path == Path::new("") {
            Path::new(".")
        } else {
            &path
        };
        let names = std::fs::read_dir(listed)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()));
        let fits = names.filter(|name| {
            name.to_str()
                .is_some_and(|name| name.to_lowercase() == lower)
        });
        path = path.join(fits.min()?);
    }
    path.is_file().then_some(path)
}

/// An open regular file. A directory opens too on some systems and a pipe blocks for ever, so both are refused first.
pub(crate) fn open(path: &Path) -> Result<File, Error> {
    let read = |cause| Error::Read {
        path: path.into(),
        cause,
    };
    if !std::fs::metadata(path).map_err(read)?.is_file() {
        return Err(Error::NotAFile { path: path.into() });
    }
    File::open(path).map_err(read)
}

/// What a file is: GLB by its first bytes, which also tell what is none of ours, the rest by the ending.
pub(crate) fn format_of(path: &Path) -> Result<Format, Error> {
    let mut start = Vec::new();
    let read = open(path)?
        .take(foreign::LOOKED_AT as u64)
        .read_to_end(&mut start);
    read.map_err(|cause| Error::Read {
        path: path.into(),
        cause,
    })?;
    if start.is_empty() {
        return Err(Error::Empty { path: path.into() });
    }
    if start.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    let ending = path
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or("")
        .to_ascii_lowercase();
    let unknown = |what| {
        Err(Error::UnknownFormat {
            path: path.into(),
            what,
        })
    };
    if let Some(what) = foreign::by_content(&start, &ending) {
        return unknown(what);
    }
    match ending.as_str() {
        "obj" | "glb" if foreign::is_gltf(&start) => unknown(foreign::by_ending("", &start)),
        "obj" => Ok(Format::Obj),
        "gltf" => Ok(Format::Gltf),
        "glb" => Err(Error::Invalid {
            path: path.into(),
            place: "byte 0".into(),
            problem: "a GLB file starts with `glTF`, this one does not; check what wrote it".into(),
        }),
        ending => unknown(foreign::by_ending(ending, &start)),
    }
}

/// What a glTF URI points at.
pub(crate) enum Uri {
    /// The bytes of a `data:` URI.
    Data(Vec<u8>),
    /// A path relative to the file, percent-decoded.
    File(String),
}

/// Decodes a URI. A `%` without two hex digits stands for itself.
///
/// # Errors
/// A sentence, for a scheme other than `data` and `file` and for base64 that is none.
pub(crate) fn uri(text: &str) -> Result<Uri, String> {
    if let Some(rest) = text.strip_prefix("data:") {
        let (head, body) = rest
            .split_once(',')
            .ok_or("data URI without a comma; it must be `data:TYPE;base64,CONTENT`")?;
        if !head.ends_with(";base64") {
            return Ok(Uri::Data(percent_decode_str(body).collect()));
        }
        // Writers disagree about the padding, so none, some and full are read.
        let config =
            GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
        let bytes = engine.decode(body).map_err(|e| {
            format!("data URI is not base64 ({e}); the file is damaged, copy or export it again")
        })?;
        return Ok(Uri::Data(bytes));
    }
    let local = text
        .strip_prefix("file://")
        .or_else(|| text.strip_prefix("file:"))
        .unwrap_or(text);
    if local.len() == text.len() && text.contains("://") {
        return Err(format!(
            "`{}` is not a local file and is not fetched; download it and name it relative to the scene",
            short(text)
        ));
    }
    let name = percent_decode_str(local)
        .decode_utf8()
        .map_err(|_| "file name is not UTF-8; rename the file")?;
    if name.is_empty() || name.contains('\0') {
        return Err("its uri is empty or holds a zero byte, and must be the name of a file".into());
    }
    Ok(Uri::File(name.into_owned()))
}

/// A text after its byte order mark, where it has one.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(text: &str) -> Vec<u8> {
        match uri(text) {
            Ok(Uri::Data(bytes)) => bytes,
            Ok(Uri::File(name)) => panic!("{text} is the file {name}"),
            Err(problem) => panic!("{text}: {problem}"),
        }
    }

    #[test]
    fn data_uris_are_decoded_with_any_padding_and_any_escape() {
        assert_eq!(data("data:image/png;base64,AAEC"), [0, 1, 2]);
        assert_eq!(data("data:;base64,AAE"), [0, 1]);
        assert_eq!(data("data:;base64,AAE="), [0, 1]);
        assert_eq!(data("data:,a%20b%2Fc%zz%"), b"a b/c%zz%");
        assert!(uri("data:;base64").is_err(), "no comma");
    }

    #[test]
    fn file_names_are_percent_decoded() {
        for (text, expected) in [
            ("a%20b.bin", "a b.bin"),
            ("100%.bin", "100%.bin"),
            ("file:///x/y%2Bz", "/x/y+z"),
        ] {
            match uri(text) {
                Ok(Uri::File(name)) => assert_eq!(name, expected),
                Ok(Uri::Data(_)) => panic!("{text} is no data URI"),
                Err(problem) => panic!("{text}: {problem}"),
            }
        }
        for refused in ["%ff", "", "a%00b", "https://a.example/b.bin"] {
            assert!(uri(refused).is_err(), "{refused}");
        }
    }
}
