//! The functions of the library, found when the program runs.

use crate::{Error, FOLDER};
use libloading::Library;
use std::ffi::{CStr, OsString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;
use std::sync::OnceLock;

/// Names of the library, the newest version first.
const NAMES: [&str; 6] = [
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so.1",
    "libOpenImageDenoise.so.0",
    "libOpenImageDenoise.so",
    "libOpenImageDenoise.dylib",
    "OpenImageDenoise.dll",
];

/// `OIDN_DEVICE_TYPE_CPU`.
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

type Handle = *mut c_void;

/// The functions that are called, by their C types.
struct Api {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    commit_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_image: unsafe extern "C" fn(
        Handle,
        *const c_char,
        *mut c_void,
        c_int,
        usize,
        usize,
        usize,
        usize,
        usize,
    ),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// The loaded library, which stays until the program ends.
pub struct Oidn(Api);

/// The library: of the folder that [`FOLDER`] names where it is set, else of the system. It is looked for once.
///
/// # Errors
/// [`Error::Absent`], [`Error::Foreign`] or [`Error::Version`].
pub fn load() -> Result<&'static Oidn, Error> {
    static LOADED: OnceLock<Result<Oidn, Error>> = OnceLock::new();
    let loaded = LOADED.get_or_init(|| {
        let places: Vec<OsString> = match std::env::var_os(FOLDER) {
            Some(folder) => ["lib", ""]
                .iter()
                .flat_map(|inner| NAMES.map(|name| Path::new(&folder).join(inner).join(name)))
                .map(OsString::from)
                .collect(),
            None => NAMES.map(OsString::from).to_vec(),
        };
        for place in places {
            // SAFETY: this runs the initialisers of a library that the user installed under this name; nothing of ours
            // depends on what they do, and nobody unloads it.
            if let Ok(library) = unsafe { Library::new(&place) } {
                let library: &'static Library = Box::leak(Box::new(library));
                let file = place.to_string_lossy().into_owned();
                return Oidn::of(library, file);
            }
        }
        Err(Error::Absent)
    });
    loaded.as_ref().map_err(Clone::clone)
}

impl Api {
    /// The functions of a library, or the name of the first that it lacks.
    fn of(library: &'static Library) -> Result<Self, &'static str> {
        /// The function of the first name that the library has.
        ///
        /// # Safety
        /// `T` is the C type of the functions of these names.
        unsafe fn function<T: Copy>(
            library: &'static Library,
            names: &[&'static str],
        ) -> Result<T, &'static str> {
            for name in names {
                // SAFETY: the caller answers for `T`; the library is never unloaded, so the pointer stays good.
                if let Ok(found) = unsafe { library.get::<T>(name.as_bytes()) } {
                    return Ok(*found);
                }
            }
            Err(names[0])
        }
        // SAFETY: the fields have the types that the header declares for these names in versions 1 and 2. `Oidn::of`
        // hands out no other version, and to learn it calls three functions that have been the same since version 0.
        unsafe {
            Ok(Self {
                new_device: function(library, &["oidnNewDevice"])?,
                get_device_int: function(library, &["oidnGetDeviceInt", "oidnGetDevice1i"])?,
                set_device_int: function(library, &["oidnSetDeviceInt", "oidnSetDevice1i"])?,
                commit_device: function(library, &["oidnCommitDevice"])?,
                device_error: function(library, &["oidnGetDeviceError"])?,
                release_device: function(library, &["oidnReleaseDevice"])?,
                new_filter: function(library, &["oidnNewFilter"])?,
                set_image: function(library, &["oidnSetSharedFilterImage"])?,
                commit_filter: function(library, &["oidnCommitFilter"])?,
                execute_filter: function(library, &["oidnExecuteFilter"])?,
                release_filter: function(library, &["oidnReleaseFilter"])?,
            })
        }
    }
}

impl Oidn {
    /// The functions of a library at `file`, if it is of a version that has them as they are called.
    fn of(library: &'static Library, file: String) -> Result<Self, Error> {
        let api = match Api::of(library) {
            Ok(api) => api,
            Err(function) => return Err(Error::Foreign { file, function }),
        };
        // SAFETY: these three functions have had these types in all versions; the device is not null where it is
        // asked and released, once.
        let version = unsafe {
            let device = (api.new_device)(CPU);
            if device.is_null() {
                return Err(no_device());
            }
            let version = (api.get_device_int)(device, c"version".as_ptr());
            (api.release_device)(device);
            version
        };
        match version {
            10_000..30_000 => Ok(Self(api)),
            _ => Err(Error::Version { file, version }),
        }
    }

    /// The picture through the filter for lightmaps, row by row, linear, 0 and above; with at most so many threads.
    ///
    /// # Errors
    /// [`Error::Refused`] with what the library says.
    ///
    /// # Panics
    /// If `picture` is not `width * height` long.
    pub fn denoise(
        &self,
        picture: &[[f32; 3]],
        [width, height]: [usize; 2],
        threads: usize,
    ) -> Result<Vec<[f32; 3]>, Error> {
        assert_eq!(picture.len(), width * height, "texels of the picture");
        let api = &self.0;
        let mut denoised = picture.to_vec();
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the functions have the types of their header. Device and filter are made here, used by this thread
        // alone, never null where they are used, and released below, the filter first. The pictures hold width x height
        // x 3 floats without gaps, which is what strides of 0 mean, and outlive the filter; `color` is only read.
        unsafe {
            let device = (api.new_device)(CPU);
            if device.is_null() {
                return Err(no_device());
            }
            (api.set_device_int)(device, c"numThreads".as_ptr(), threads);
            (api.commit_device)(device);
            let filter = (api.new_filter)(device, c"RTLightmap".as_ptr());
            if !filter.is_null() {
                for (name, pointer) in [
                    (c"color", picture.as_ptr().cast_mut().cast()),
                    (c"output", denoised.as_mut_ptr().cast()),
                ] {
                    (api.set_image)(
                        filter,
                        name.as_ptr(),
                        pointer,
                        FLOAT3,
                        width,
                        height,
                        0,
                        0,
                        0,
                    );
                }
                (api.commit_filter)(filter);
                (api.execute_filter)(filter);
                (api.release_filter)(filter);
            }
            let mut message = ptr::null();
            let code = (api.device_error)(device, &raw mut message);
            let said = match message.is_null() {
                true => format!("error {code}"),
                false => CStr::from_ptr(message).to_string_lossy().replace('\n', " "),
            };
            (api.release_device)(device);
            match code {
                0 => Ok(denoised),
                _ => Err(Error::Refused(said)),
            }
        }
    }
}

fn no_device() -> Error {
    Error::Refused("no device for this processor".to_owned())
}

#[cfg(test)]
#[path = "../../../tests/skip.rs"]
mod skip;

#[cfg(test)]
mod tests {
    use super::*;

    /// A library that states its version and ends the program where any other function is called.
    const STATES: &str = "
        #include <stdlib.h>
        static int device;
        void *oidnNewDevice(int type) { return &device; }
        int oidnGetDeviceInt(void *of, const char *name) { return VERSION; }
        void oidnReleaseDevice(void *of) { }
        #define ENDS(name) void name(void) { abort(); }
        ENDS(oidnSetDeviceInt) ENDS(oidnCommitDevice) ENDS(oidnGetDeviceError) ENDS(oidnNewFilter)
        ENDS(oidnSetSharedFilterImage) ENDS(oidnCommitFilter) ENDS(oidnExecuteFilter) ENDS(oidnReleaseFilter)
    ";

    #[cfg(target_os = "linux")]
    #[test]
    fn a_library_of_another_version_is_asked_for_it_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("ambake-oidn-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let source = folder.join("states.c");
        std::fs::write(&source, STATES).expect("a file");
        for (version, taken) in [
            (9_900, false),
            (10_000, true),
            (29_999, true),
            (30_001, false),
        ] {
            let file = folder.join(format!("{version}.so"));
            let built = std::process::Command::new("cc")
                .arg(format!("-DVERSION={version}"))
                .args(["-shared", "-fPIC", "-o"])
                .args([&file, &source])
                .status();
            if built.is_err() {
                return skip::skip("there is no C compiler");
            }
            // SAFETY: it was just built, and has no initialisers.
            let library = unsafe { Library::new(&file) }.expect("a library");
            let found = Oidn::of(Box::leak(Box::new(library)), "it".into()).err();
            let refused = (!taken).then_some(Error::Version {
                file: "it".into(),
                version,
            });
            assert_eq!(found, refused);
        }
        let version = Error::Version {
            file: "it".into(),
            version: 30_102,
        };
        assert!(
            version.to_string().starts_with("it is version 3.1 of"),
            "{version}"
        );
        std::fs::remove_dir_all(folder).expect("it is there");
    }

    #[test]
    fn noise_goes_and_a_step_stays_with_any_number_of_threads() {
        let Ok(oidn) = load() else {
            return skip::skip(&Error::Absent.to_string());
        };
        let mut state = 1u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0 - 0.5
        };
        let truth = |i: usize| if i % 64 < 32 { 0.2f32 } else { 0.7 };
        let picture: Vec<_> = (0..64 * 64)
            .map(|i| [truth(i) + 0.2 * noise(); 3])
            .collect();
        let error = |picture: &[[f32; 3]]| {
            let squares = picture
                .iter()
                .enumerate()
                .map(|(i, v)| (v[0] - truth(i)).powi(2));
            (squares.sum::<f32>() / 4096.0).sqrt()
        };
        let one = oidn.denoise(&picture, [64, 64], 1).expect("it denoises");
        let two = oidn.denoise(&picture, [64, 64], 2).expect("it denoises");
        assert!(
            error(&one) < 0.4 * error(&picture),
            "{} of {}",
            error(&one),
            error(&picture)
        );
        assert_eq!(one, two);
    }
}
