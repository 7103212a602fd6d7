//! Finds Embree, generates the bindings and compiles the shim; where something is missing, says so and builds nothing.
//! With the feature `required` that is an error, unless `AMBAKE_NO_EMBREE` asks for it.

use std::env;
use std::fs;
use std::panic;
use std::path::{Path, PathBuf};

/// An installed Embree: headers and library of one major.
struct Embree {
    major: u32,
    include_dir: PathBuf,
    lib_dir: PathBuf,
    header_version: String,
}

fn main() {
    println!("cargo::rustc-check-cfg=cfg(embree)");
    for file in ["build.rs", "shim/shim.h", "shim/shim.c"] {
        println!("cargo::rerun-if-changed={file}");
    }
    for variable in [
        "AMBAKE_NO_EMBREE",
        "EMBREE_INCLUDE_DIR",
        "EMBREE_LIB_DIR",
        "LIBCLANG_PATH",
    ] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    match find().and_then(build) {
        Ok(embree) => {
            println!("cargo::rustc-cfg=embree");
            println!("cargo::metadata=available=1");
            println!("cargo::metadata=header_version={}", embree.header_version);
            println!("cargo::metadata=lib_dir={}", embree.lib_dir.display());
        }
        Err(reason) if env::var_os("CARGO_FEATURE_REQUIRED").is_some() && !is_left_out() => {
            println!(
                "cargo::error={reason}. The feature `embree` asks for it; AMBAKE_NO_EMBREE=1 builds without"
            );
        }
        Err(reason) => {
            // An installation that comes later is seen through dpkg's own list; elsewhere through the variables.
            let dpkg = Path::new("/var/lib/dpkg/status");
            if dpkg.exists() {
                println!("cargo::rerun-if-changed={}", dpkg.display());
            }
            println!("cargo::metadata=available=0");
            println!("cargo::metadata=absent_because={reason}");
            println!("cargo::warning={reason}; building with the obvhs backend alone");
        }
    }
}

/// True where `AMBAKE_NO_EMBREE` asks for a build without it.
fn is_left_out() -> bool {
    env::var_os("AMBAKE_NO_EMBREE").is_some_and(|v| !v.is_empty() && v != "0")
}

/// The Embree to use: the variables' folders first, then the system's; 4 before 3.
fn find() -> Result<Embree, String> {
    if is_left_out() {
        return Err("AMBAKE_NO_EMBREE is set".into());
    }
    let include_dirs = folders(
        "EMBREE_INCLUDE_DIR",
        &["/usr/local/include".into(), "/usr/include".into()],
    );
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let lib_dirs = folders(
        "EMBREE_LIB_DIR",
        &[
            "/usr/local/lib".into(),
            format!("/usr/lib/{arch}-linux-gnu"),
            "/usr/lib64".into(),
            "/usr/lib".into(),
        ],
    );
    for major in [4, 3] {
        let header = format!("embree{major}/rtcore_config.h");
        let library = format!("libembree{major}.so");
        let include_dir = include_dirs.iter().find(|d| d.join(&header).is_file());
        let lib_dir = lib_dirs.iter().find(|d| d.join(&library).exists());
        if let (Some(include_dir), Some(lib_dir)) = (include_dir, lib_dir) {
            let header = include_dir.join(&header);
            println!("cargo::rerun-if-changed={}", header.display());
            println!(
                "cargo::rerun-if-changed={}",
                lib_dir.join(&library).display()
            );
            return Ok(Embree {
                major,
                include_dir: include_dir.clone(),
                lib_dir: lib_dir.clone(),
                header_version: header_version(&header)?,
            });
        }
    }
    Err(format!(
        "Embree is not installed (no embree4 or embree3 headers in {} with their library in {}): apt install \
         libembree-dev",
        list(&include_dirs),
        list(&lib_dirs),
    ))
}

/// The folder a variable names, alone, or else the system's.
fn folders(variable: &str, system: &[String]) -> Vec<PathBuf> {
    match env::var_os(variable).filter(|v| !v.is_empty()) {
        Some(folder) => vec![folder.into()],
        None => system.iter().map(PathBuf::from).collect(),
    }
}

fn list(folders: &[PathBuf]) -> String {
    let names: Vec<_> = folders.iter().map(|f| f.display().to_string()).collect();
    names.join(" or ")
}

/// `RTC_VERSION_STRING` of a `rtcore_config.h`.
fn header_version(header: &Path) -> Result<String, String> {
    let text =
        fs::read_to_string(header).map_err(|e| format!("cannot read {}: {e}", header.display()))?;
    text.lines()
        .find_map(|line| line.trim().strip_prefix("#define RTC_VERSION_STRING"))
        .map(|rest| rest.trim().trim_matches('"').to_owned())
        .ok_or_else(|| format!("{} does not define RTC_VERSION_STRING", header.display()))
}

/// Bindings and shim. The link directives come last, so that a failure leaves none behind.
fn build(embree: Embree) -> Result<Embree, String> {
    let define = format!("-DAMBAKE_EMBREE_MAJOR={}", embree.major);
    let include = format!("-I{}", embree.include_dir.display());
    write_bindings(&define, &include)?;
    cc::Build::new()
        .file("shim/shim.c")
        .include("shim")
        .flag(&define)
        .flag(&include)
        .std("c11")
        .opt_level(3)
        .warnings(true)
        .extra_warnings(true)
        .cargo_warnings(false)
        .try_compile("ambake_embree_shim")
        .map_err(|e| {
            format!(
                "the C shim over Embree does not compile ({}): apt install gcc libc6-dev",
                one_line(&e)
            )
        })?;
    println!(
        "cargo::rustc-link-search=native={}",
        embree.lib_dir.display()
    );
    println!("cargo::rustc-link-lib=dylib=embree{}", embree.major);
    Ok(embree)
}

/// Writes `bindings.rs`. bindgen panics where libclang cannot be loaded; that is an answer here, not a failure.
fn write_bindings(define: &str, include: &str) -> Result<(), String> {
    let out =
        PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("bindings.rs");
    let builder = bindgen::Builder::default()
        .header("shim/shim.h")
        .clang_args([define, include])
        .allowlist_function("ambake_.*")
        .allowlist_function("rtc(Release|Commit)(Device|Geometry|Scene)")
        .allowlist_function(
            "rtc(NewGeometry|SetNewGeometryBuffer|SetGeometryInstancedScene|SetGeometryTransform)",
        )
        .allowlist_function(
            "rtc(NewScene|SetSceneFlags|AttachGeometryByID|SetDeviceMemoryMonitorFunction)",
        )
        .allowlist_type("RTC(Error|DeviceProperty|SceneFlags|GeometryType|BufferType|Format)")
        .allowlist_type("ambake_.*")
        .allowlist_var("RTC_VERSION|AMBAKE_NO_INSTANCE")
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .use_core()
        .formatter(bindgen::Formatter::None);
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let generated = panic::catch_unwind(panic::AssertUnwindSafe(|| builder.generate()));
    panic::set_hook(hook);
    let bindings = match generated {
        Ok(Ok(bindings)) => bindings,
        Ok(Err(e)) => {
            return Err(format!(
                "bindgen cannot read Embree's headers ({}): apt install libclang-dev",
                one_line(&e)
            ));
        }
        Err(_) => return Err("libclang is not installed: apt install libclang-dev".into()),
    };
    bindings
        .write_to_file(&out)
        .map_err(|e| format!("cannot write {}: {e}", out.display()))
}

/// The first line of a message: a build warning has one line.
fn one_line(e: &dyn std::fmt::Display) -> String {
    e.to_string().lines().next().unwrap_or_default().to_owned()
}
