//! How much memory a bake will take, and how much there is.

use crate::error::{Error, LimitedBy};
use ::bake::{Denoise, Effort, Plan, Seams, bytes_of_surveys, sampled};
use layers::Layer;
use std::fs;
use std::path::{Path, PathBuf};

/// Bytes of finished tiles that wait for the disk at most.
pub(crate) const WAITING: u64 = 128 << 20;
/// Bytes a page texel of pictures, masks and compressed lines while a page is composed and written.
const WRITING: u64 = 12;
/// Bytes a texel of charts that the denoiser takes beside the planes: the charts themselves and what becomes of a term,
/// by channels.
const DENOISING: u64 = 20;
const DENOISED: u64 = 4;
/// Bytes a page texel of what it knows of the shape of bent charts.
const SHAPE: u64 = 8;
/// Bytes a texel of charts while it finds which texels are of one surface, and their heights.
const GROUPING: u64 = 17;
/// The same of the texels that are fitted at a time: charts, or parts of larger ones, which have so many texels at most
/// and some rows about them, one for each thread.
const FITTING: u64 = 110;
const FITTED: u64 = 1 << 21;
const FITTED_ROWS: u64 = 96;
/// Bytes a point of a seam, and those of every four channels that are solved there together.
const SEAM: u64 = 450;
const SOLVING: u64 = 470;
/// Bytes a page texel of Intel's, which was measured to take 0.6 GB at 1024².
const OIDN: u64 = 600;
/// Bytes a page texel of the light that a gather is sent, and of that which it brings.
const SENT: u64 = 13;
/// Bytes a page texel of what is known of the surfaces that send light on.
const PATCH: u64 = 36;
/// Bytes a triangle of the ray library's trees and of what plan and layout keep, over all meshes; and while these are
/// made.
const TREE: u64 = 120;
const MAKING: u64 = 200;
/// Bytes an instance of what plan and layout keep of it: its part, its surfaces where they are placed, its body.
/// Measured with 8,000 boxes.
const PLACED: u64 = 2800;
/// Bytes of stack of a thread, and of addresses that the system's allocator reserves for it.
const STACK: u64 = 8 << 20;
const RESERVED: u64 = (64 << 20) + STACK;

/// The memory of the pages of a bake, by their planes.
pub(crate) struct Memory {
    /// Channels of a page that tiles are baked into.
    pub working: u64,
    /// The same after its last steps.
    kept: u64,
    /// Of the working ones, those that go once the denoiser has found surfaces, and all that go before the last step.
    places: u64,
    dropped: u64,
    /// Those that the last step adds.
    composed: u64,
    /// Channels of terms.
    pub denoised: u64,
    /// Channels of the broadest of them.
    broadest: u64,
    /// Channels of the page of light beside it; 0 where no light bounces.
    pub light: u64,
    denoise: Denoise,
    seams: bool,
    /// A page of a few rays stands beside each while its target is sought.
    seeks: bool,
}

impl Memory {
    pub fn of(options: &::bake::Options, plan: &Plan) -> Self {
        let working = ::bake::layers_in_work(options, plan);
        let [kept, light] = ::bake::layers_of_light(options, plan);
        let count = |layers: &[Layer], wanted: &dyn Fn(&Layer) -> bool| {
            let wanted = layers.iter().filter(|layer| wanted(layer));
            wanted.map(|layer| layer.channels().len() as u64).sum()
        };
        let [denoised, broadest] = ::bake::channels_of_terms(options, plan);
        let is_place = |layer: &Layer| {
            let place = [Layer::Position, Layer::Normal, Layer::Object];
            place.contains(layer) && !kept.contains(layer)
        };
        let goes = |layer: &Layer| {
            let done = matches!(layer, Layer::Validity | Layer::Sealed) || layer.is_of_halves();
            is_place(layer) || (done && !kept.contains(layer))
        };
        Self {
            working: count(&working, &|_| true),
            kept: count(&kept, &|_| true),
            places: count(&working, &is_place),
            dropped: count(&working, &goes),
            composed: count(&kept, &|l| !working.contains(l)),
            denoised,
            broadest: match working.contains(&Layer::Sh) {
                true => 3,
                false => broadest,
            },
            light: count(&light, &|_| true),
            denoise: options.denoise,
            seams: options.seams != Seams::Off,
            seeks: matches!(options.effort, Effort::Target { .. }),
        }
    }

    /// Bytes at the peak, of so many pages of so many texels, of which charts touch `covered` on each. `known` has the
    /// texels of the largest charts, one for each thread, and the most points of seams on a page; without it charts may
    /// be as large as can be.
    pub fn pages(
        &self,
        pages: u64,
        texels: u64,
        covered: u64,
        known: Option<(&[u64], u64)>,
    ) -> u64 {
        let threads = rayon::current_num_threads() as u64;
        let waiting = covered * 4 * (self.working + 1);
        let places = match self.denoise {
            Denoise::Regression => self.places,
            _ => 0,
        };
        let denoise = match self.denoise {
            Denoise::Regression => {
                let most = threads * (FITTED + FITTED_ROWS * texels.isqrt());
                let fitted = match known {
                    Some((charts, _)) if charts.iter().all(|&texels| texels <= FITTED) => {
                        charts.iter().sum()
                    }
                    _ => covered.min(most),
                };
                let planes = DENOISING + DENOISED * self.broadest;
                texels * SHAPE + covered * planes + fitted * FITTING
            }
            Denoise::Oidn => texels * OIDN,
            Denoise::Off => texels * if self.seams { 8 } else { 0 },
        };
        let bakes = texels * 4 * self.working + waiting.min(WAITING);
        let groups = texels * (4 * self.working + SHAPE) + covered * GROUPING;
        let solving = threads.min(self.denoised.div_ceil(4));
        let seams = known.map_or(0, |(_, points)| points * (SEAM + solving * SOLVING));
        let finishes = texels * 4 * (self.working - places) + denoise + seams;
        let finishes = groups.max(finishes) + waiting.min(WAITING);
        let planes = 4 * (self.working - self.dropped + self.composed);
        let composes = texels * (planes + WRITING) + waiting.min(WAITING);
        let one = bakes.max(finishes).max(composes);
        if self.light == 0 {
            let surveys = if self.seeks { sampled(covered) } else { 0 };
            return one + bytes_of_surveys(surveys);
        }
        // Light goes from page to page, so all of them wait for it.
        let kept = texels * 4 * self.kept;
        let waiting = covered * 4 * (self.light + 1);
        let bounces =
            pages * (kept + texels * (4 * self.light + 2 * SENT + PATCH)) + waiting.min(WAITING);
        let last = denoise.max(pages * texels * SENT);
        (one + (pages - 1) * kept).max(bounces + last) + bytes_of_surveys(pages * covered)
    }
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
///
/// * `content`: triangles of all meshes, and instances.
pub(crate) fn check(
    size: u32,
    memory: &Memory,
    content: [u64; 2],
    limit: Limit,
) -> Result<(), Error> {
    let [triangles, instances] = content;
    let system = || limit.system.then(available).flatten();
    let given = limit.given.map(|bytes| (bytes, LimitedBy::Given));
    let Some((most, limited_by)) = given.or_else(system) else {
        return Ok(());
    };
    let base = resident().unwrap_or(0);
    let need = |size: u32| {
        let texels = u64::from(size).pow(2);
        let pages = match limit.without_pages {
            true => WAITING,
            false => memory.pages(1, texels, texels * 3 / 4, None),
        };
        base + instances * PLACED + (triangles * MAKING).max(triangles * TREE + pages)
    };
    if need(size) <= most {
        return Ok(());
    }
    // Whole powers of two halve so that mips still fit.
    let mut fits = size / 2;
    while fits > 0 && need(fits) > most {
        fits = if limit.without_pages { 0 } else { fits / 2 };
    }
    Err(Error::Memory {
        need: need(size),
        limit: most,
        limited_by,
        size: Some(fits).filter(|&size| size > 0),
    })
}

/// Memory of this process that is resident now, in bytes, where the system tells.
pub(crate) fn resident() -> Option<u64> {
    kib(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Bytes that this process may have in all, what it has and what is free, and what allows no more.
fn available() -> Option<(u64, LimitedBy)> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let own = kib(&status, "VmRSS:")?;
    let free = kib(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let threads = rayon::current_num_threads() as u64;
    let limits = fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let all = [
        (Some(own + free), LimitedBy::Machine),
        (group_limit(own), LimitedBy::Group),
        (process_limit(&limits, &status, threads), LimitedBy::Process),
    ];
    let all = all.into_iter().filter_map(|(most, by)| Some((most?, by)));
    all.min_by_key(|&(most, _)| most)
}

/// Resident bytes that the limits on this process's addresses and data leave it, by the system's texts on both.
fn process_limit(limits: &str, status: &str, threads: u64) -> Option<u64> {
    let own = kib(status, "VmRSS:")?;
    let rows = [
        ("Max address space", "VmSize:", RESERVED),
        ("Max data size", "VmData:", STACK),
    ];
    let left = rows.iter().filter_map(|&(limit, used, reserved)| {
        let row = limits.lines().find_map(|row| row.strip_prefix(limit))?;
        // Where there is none it says `unlimited`.
        let most: u64 = row.split_whitespace().next()?.parse().ok()?;
        // One more for the main thread and one for the backend's.
        let used = kib(status, used)? + (threads + 2) * reserved;
        Some(own + most.saturating_sub(used))
    });
    left.min()
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
    fn limits_of_the_process_count_what_is_reserved() {
        let status = "VmSize:  300 kB\nVmRSS: 100 kB\nVmData: 200 kB\n";
        let row = |name: &str, most: &str| format!("{name}  {most}  unlimited  bytes\n");
        let addresses = row("Max address space", &(3 * RESERVED + (1 << 20)).to_string());
        let data = row("Max data size", &(3 * STACK + (1 << 20)).to_string());
        assert_eq!(
            process_limit(&addresses, status, 1),
            Some((1024 - 200) << 10)
        );
        assert_eq!(process_limit(&data, status, 1), Some((1024 - 100) << 10));
        let both = format!("{data}{addresses}");
        assert_eq!(process_limit(&both, status, 1), Some((1024 - 200) << 10));
        // What is used up already leaves what the process has.
        assert_eq!(process_limit(&both, status, 2), Some(100 << 10));
        let none = row("Max address space", "unlimited");
        assert_eq!(process_limit(&none, status, 1), None);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_a_size_that_does() {
        let memory = Memory {
            working: 25,
            kept: 15,
            places: 7,
            dropped: 11,
            composed: 9,
            denoised: 3,
            broadest: 1,
            light: 0,
            seeks: false,
            denoise: Denoise::Regression,
            seams: true,
        };
        let given = |bytes: u64| Limit {
            given: Some(bytes),
            ..Limit::default()
        };
        assert!(check(8192, &memory, [100, 1], given(1 << 40)).is_ok());
        let error = check(8192, &memory, [100, 1], given(1 << 30)).unwrap_err();
        let Error::Memory {
            need,
            size: Some(size),
            ..
        } = error
        else {
            panic!("{error}");
        };
        assert!(need > 1 << 30 && size < 8192, "{need} {size}");
        assert!(check(size, &memory, [100, 1], given(1 << 30)).is_ok());
        let none = check(size, &memory, [100, 1], given(1 << 20)).unwrap_err();
        assert!(none.to_string().contains("`max_memory`"), "{none}");
        // Copies of a mesh of a few triangles: a page of their own size matters little beside them.
        let copies = |count| {
            check(
                16,
                &memory,
                [12, count],
                given(resident().unwrap_or(0) + (300 << 20)),
            )
        };
        assert!(copies(1000).is_ok() && copies(1_000_000).is_err());
    }
}
