//! Whether lights join in a bake, and why.

use super::{Decision, decision};
use crate::choice::Choice;
use crate::options::Options;
use rays::Light;

/// The decision about [`Choice::Lights`].
pub(super) fn decide(options: &Options) -> Decision {
    let left_out = |reason: &str| decision(Choice::Lights, false, reason);
    if options.lights.is_empty() {
        return left_out(
            "there are none: `--sun`, `--point`, `--sphere`, `--rect` and `--lights file` name some",
        );
    }
    if !options.shows_light() {
        return left_out("no asked layer shows light");
    }
    let count = |what: &str, is_one: fn(&Light) -> bool| {
        let count = options.lights.iter().filter(|light| is_one(light)).count();
        let plural = if count == 1 { "" } else { "s" };
        (count > 0).then(|| format!("{count} {what}{plural}"))
    };
    let kinds = [
        count("sun", |light| matches!(light, Light::Distant { .. })),
        count("point light", |light| {
            matches!(light, Light::Point { cone: None, .. })
        }),
        count("spot", |light| {
            matches!(light, Light::Point { cone: Some(_), .. })
        }),
        count("ball", |light| matches!(light, Light::Sphere { .. })),
        count("panel", |light| matches!(light, Light::Rect { .. })),
    ];
    let kinds: Vec<String> = kinds.into_iter().flatten().collect();
    decision(
        Choice::Lights,
        true,
        format!(
            "{}: shadow rays to each from all over a texel",
            kinds.join(", ")
        ),
    )
}
