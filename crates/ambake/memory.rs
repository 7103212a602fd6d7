//! How much memory a bake will take, and how much there is.

use crate::error::Error;
use crate::options::Options;
use ::bake::{Denoise, Seams};
use layers::Layer;
use std::fs;
use std::path::{Path, PathBuf};

/// Bytes of finished tiles that wait for the disk at most.
pub(crate) const WAITING: u64 = 128 << 20;
/// Bytes a page texel of pictures, masks and compressed lines while a page is finished and written.
const WRITING: u64 = 12;
/// Bytes a page texel that the denoiser takes beside the planes.
const DENOISING: u64 = 68;
/// The same of Intel's, which was measured to take 0.6 GB at 1024².
const OIDN: u64 = 600;
/// Bytes a triangle of the ray library's trees, over all meshes.
const TREE: u64 = 200;
/// The memory of a page in work, by its planes.
pub(crate) struct Memory {
    working: Vec<Layer>,
    asked: Vec<Layer>,
    denoise: Denoise,
    seams: bool,
}

impl Memory {
    /// `working` are the layers that tiles are baked into.
    pub fn of(options: &Options, working: Vec<Layer>) -> Self {
        Self {
            working,
            asked: options.layers.clone(),
            denoise: options.denoises(),
            seams: options.seams != Seams::Off,
        }
    }

    /// Channels of the layers that are written.
    pub fn channels(&self) -> u64 {
        channels(&self.asked)
    }

    /// Bytes of a page of so many texels, of which charts touch `covered`, at its peak.
    pub fn page(&self, texels: u64, covered: u64) -> u64 {
        let composed = self.asked.iter().copied();
        let composed: Vec<Layer> = composed.filter(|l| !self.working.contains(l)).collect();
        let working = channels(&self.working);
        let planes = 4 * (working + channels(&composed));
        let seams = if self.seams { 8 } else { 0 };
        let steps = match self.denoise {
            Denoise::Regression => DENOISING,
            Denoise::Oidn => OIDN,
            Denoise::Off => WRITING.max(seams),
        };
        let waiting = WAITING.min(covered * 4 * (working + 1));
        texels * (planes + steps) + waiting
    }
}

fn channels(layers: &[Layer]) -> u64 {
    let count = |layer: &Layer| layer.channels().len() as u64;
    layers.iter().map(count).sum()
}

/// How much memory a bake may take.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Limit {
    /// Bytes that were given.
    pub given: Option<u64>,
    /// Where none were given, what the system has.
    pub system: bool,
    /// No page is held: a shard.
    pub without_pages: bool,
}

/// Refuses a bake that would not fit into memory, before its layout is made.
///
/// # Errors
/// [`Error::Memory`] names the page size that fits.
pub(crate) fn check(
    options: &Options,
    working: Vec<Layer>,
    triangles: u64,
    limit: Limit,
) -> Result<(), Error> {
    let system = || limit.system.then(available).flatten();
    let Some(most) = limit.given.or_else(system) else {
        return Ok(());
    };
    let memory = Memory::of(options, working);
    let base = resident().unwrap_or(0) + triangles * TREE;
    let need = |size: u32| {
        let texels = match limit.without_pages {
            true => return base + WAITING,
            false => u64::from(size).pow(2),
        };
        base + memory.page(texels, texels / 2)
    };
    if need(options.size) <= most {
        return Ok(());
    }
    // Whole powers of two halve so that mips still fit.
    let mut fits = options.size / 2;
    while fits > 0 && need(fits) > most {
        fits = if limit.without_pages { 0 } else { fits / 2 };
    }
    Err(Error::Memory {
        need: need(options.size),
        limit: most,
        given: limit.given.is_some(),
        size: Some(fits).filter(|&size| size > 0),
    })
}

/// Memory of this process that is resident now, in bytes, where the system tells.
pub(crate) fn resident() -> Option<u64> {
    kib(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Bytes that this process may have in all: what it has and what is free, within the limits of its control groups.
pub(crate) fn available() -> Option<u64> {
    let own = resident()?;
    let free = kib(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    Some(group_limit(own).map_or(own + free, |limit| limit.min(own + free)))
}

/// The bytes in a line `NAME 123 kB`.
fn kib(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.split_whitespace().next()?.parse().ok()?;
    number.checked_mul(1024)
}

/// Bytes that the control groups of this process leave it, of which it has `own`; `None` without a limit.
fn group_limit(own: u64) -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().filter_map(|line| {
        let mut parts = line.splitn(3, ':');
        let (_, kind, path) = (parts.next()?, parts.next()?, parts.next()?);
        let (root, limit, usage) = match kind {
            "" => ("/sys/fs/cgroup", "memory.max", "memory.current"),
            kind if kind.split(',').any(|kind| kind == "memory") => (
                "/sys/fs/cgroup/memory",
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
            ),
            _ => return None,
        };
        let path = path.trim_start_matches('/');
        // In a container the path counts from the host's root, and the own group is what is mounted.
        let mut folder: PathBuf = Path::new(root).join(path);
        let mut least: Option<u64> = None;
        loop {
            let read = |name: &str| -> Option<u64> {
                let text = fs::read_to_string(folder.join(name)).ok()?;
                text.trim().parse().ok()
            };
            if let (Some(limit), Some(usage)) = (read(limit), read(usage)) {
                let others = usage.saturating_sub(own);
                let left = limit.saturating_sub(others);
                least = Some(least.map_or(left, |least| least.min(left)));
            }
            if folder == Path::new(root) || !folder.pop() {
                break;
            }
        }
        least
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_system_is_read_and_nothing_else() {
        let text = "MemTotal:  10 kB\nMemAvailable:    3 kB\nVmRSS: x kB\n";
        assert_eq!(kib(text, "MemAvailable:"), Some(3072));
        assert_eq!(kib(text, "VmRSS:"), None);
        assert_eq!(kib(text, "VmHWM:"), None);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_a_size_that_does() {
        let mut options = Options {
            size: 8192,
            ..Options::default()
        };
        let given = |bytes: u64| Limit {
            given: Some(bytes),
            ..Limit::default()
        };
        let layers = || vec![Layer::Coverage, Layer::Diffuse, Layer::StdErrDiffuse];
        assert!(check(&options, layers(), 100, given(1 << 40)).is_ok());
        let error = check(&options, layers(), 100, given(1 << 30)).unwrap_err();
        let Error::Memory {
            need,
            size: Some(size),
            ..
        } = error
        else {
            panic!("{error}");
        };
        assert!(need > 1 << 30 && size < 8192, "{need} {size}");
        options.size = size;
        assert!(check(&options, layers(), 100, given(1 << 30)).is_ok());
        let none = check(&options, layers(), 100, given(1 << 20)).unwrap_err();
        assert!(none.to_string().contains("--max-memory"), "{none}");
    }
}
