//! The layout of a scene: which coordinates are kept, which are made.

use crate::arrange::unwrap;
use crate::keep::{keep, note};
use crate::objects::objects;
use crate::touching::is_touching;
use crate::{Atlas, Error, Options, Pages, SurfacePoint, UvMode, UvSource, Why};
use layers::Progress;
use scene::Scene;

/// Tells whether any of some points of one triangle in one place can be seen. It is asked from any thread.
pub type Seen<'a> = dyn Fn(&[SurfacePoint]) -> bool + Sync + 'a;

/// A place on a page for every triangle of every object, audited: nothing overlaps, nothing is missing or outside.
///
/// Under [`UvMode::Auto`] TEXCOORD_1 is kept where it is a usable lightmap set on all meshes, else TEXCOORD_0, else
/// everything is unwrapped; [`Atlas::notes`] says why. A set whose objects are fine by themselves but share the square
/// is kept with a rectangle for each object. `cancel` is asked now and then, from any thread.
///
/// # Errors
///
/// Options out of range, an unusable set under [`UvMode::Keep`], charts that do not fit, a cancelled job.
pub fn layout(
    scene: &Scene,
    options: &Options,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Atlas, Error> {
    layout_seen(scene, options, None, &Until(cancel))
}

/// A listener that only says when to stop.
struct Until<'a>(&'a (dyn Fn() -> bool + Sync));

impl Progress for Until<'_> {
    fn advance(&self, _done: u64, _total: u64) {}

    fn cancelled(&self) -> bool {
        (self.0)()
    }
}

/// As [`layout`], with the smallest place for charts of which `seen` holds for no sample point: they take a texel.
///
/// `progress` hears of two phases where charts are made. In `making charts` it is told how many triangles of distinct
/// meshes lie in charts, in `packing charts` nothing more.
///
/// # Errors
///
/// As [`layout`].
pub fn layout_seen(
    scene: &Scene,
    options: &Options,
    seen: Option<&Seen<'_>>,
    progress: &dyn Progress,
) -> Result<Atlas, Error> {
    if !(1..=16384).contains(&options.page_size) {
        return Err(Error::PageSize(options.page_size));
    }
    if let Some(density) = options.density
        && !(density.is_finite() && density > 0.0)
    {
        return Err(Error::Density(density));
    }
    if options.pages == Pages::Most(0) {
        return Err(Error::Pages);
    }
    let objects = objects(scene, options)?;
    let mut notes = Vec::new();
    if options.uv != UvMode::Unwrap {
        let mut refusal = None;
        for set in [1, 0] {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            match keep(scene, &objects, options, set, progress) {
                Ok(mut atlas) => {
                    if options.uv == UvMode::Auto && is_touching(scene, &atlas) {
                        let meshes = Some(&atlas.meshes[..]);
                        match unwrap(scene, &objects, options, meshes, seen, progress) {
                            Ok(mut apart) => {
                                notes.push(format!(
                                    "charts of TEXCOORD_{set} stand side by side without a gutter: they are packed \
                                     apart, each in its own shape"
                                ));
                                apart.source = UvSource::Apart { set };
                                apart.notes = notes;
                                return Ok(apart);
                            }
                            Err(Error::Cancelled) => return Err(Error::Cancelled),
                            // By less than a texel, but they have no shape that could be packed.
                            Err(Error::Audit { mesh, .. }) => {
                                notes.push(format!(
                                    "charts of TEXCOORD_{set} stand side by side without a gutter, and cannot \
                                        be packed apart, for triangles of `{mesh}` overlap"
                                ));
                                continue;
                            }
                            Err(why) => notes.push(note(&why)),
                        }
                    }
                    if seen.is_some() {
                        let note = "the file's coordinates are kept, so charts that nobody sees keep their size";
                        notes.push(note.into());
                    }
                    notes.append(&mut atlas.notes);
                    atlas.notes = notes;
                    return Ok(atlas);
                }
                // That the file has no second set is no news when the first is at fault.
                Err(Error::Unusable {
                    why: Why::Absent, ..
                }) if set == 1 => {}
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(why) => {
                    notes.push(note(&why));
                    refusal.get_or_insert(why);
                }
            }
        }
        if let (UvMode::Keep, Some(why)) = (options.uv, refusal) {
            return Err(why);
        }
    }
    if progress.cancelled() {
        return Err(Error::Cancelled);
    }
    let mut atlas = unwrap(scene, &objects, options, None, seen, progress)?;
    atlas.notes = notes;
    Ok(atlas)
}
