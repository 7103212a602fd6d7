//! The `layout` of `bake.json` and `ambake plan --json`: where the texels went, in words and numbers.

use crate::WarningReport;
use serde::{Deserialize, Serialize};

/// Where the texels of a layout went.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LayoutReport {
    /// Share of the pages' texels that a chart touches or that are its gutter, 0..=1.
    pub page_use: f64,
    /// Share of the pages' area inside charts, 0..=1.
    pub covered: f64,
    /// Texels per scene unit, over objects that somebody sees and that have 16 texels or more; over all that somebody
    /// sees where none has.
    pub texels_per_unit: Spread,
    /// Number of charts.
    pub charts: u32,
    /// Triangles with an area of less than one texel.
    pub triangles_under_one_texel: u64,
    /// Every object, in the order of the scene.
    pub objects: Vec<ObjectLayout>,
}

/// The least, the middle and the greatest of some numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The middle one.
    pub median: f64,
    /// The greatest.
    pub max: f64,
}

/// Where the texels of an object went.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectLayout {
    /// Name of its node, with `#2` and so on for repeats.
    pub name: String,
    /// Area on the pages in texels; 0 for an excluded object.
    pub texels: f64,
    /// Texels per scene unit; 0 for an excluded object and for one that nobody sees.
    pub density: f64,
    /// Its part of all objects' texels, 0..=1.
    pub share: f64,
    /// Texels across its longest extent; 0 as `density`.
    pub across: f64,
}

impl ObjectLayout {
    /// True for an object that takes texels and that somebody sees.
    fn is_seen(&self) -> bool {
        self.texels > 0.0 && self.density > 0.0
    }
}

/// Objects of fewer texels have what the least number of texels gives them, and may be finer than all others.
const LEAST: f64 = 16.0;
/// From this part of all texels an object is named in a warning, if others have fewer than [`FEW`] across.
const LARGE_SHARE: f64 = 0.5;
const FEW: f64 = 32.0;
/// Densities that are fewer times apart look alike.
const ALIKE: f64 = 1.1;
/// With fewer texels across its extent an object is named in a warning.
const COARSE: f64 = 3.5;
/// So many do.
const ENOUGH: f64 = 4.0;
/// With less of the texels in use inside charts, the page is named in a warning.
const LEAST_INSIDE: f64 = 0.25;

impl LayoutReport {
    /// The facts of a layout.
    pub fn of(scene: &scene::Scene, atlas: &atlas::Atlas) -> LayoutReport {
        let facts = atlas::facts(scene, atlas);
        let object = |o: atlas::ObjectFacts| ObjectLayout {
            name: o.name,
            texels: o.texels,
            density: o.density,
            share: o.share,
            across: o.across,
        };
        let objects: Vec<ObjectLayout> = facts.objects.into_iter().map(object).collect();
        let seen = || objects.iter().filter(|o| o.is_seen());
        let is_any = seen().any(|o| o.texels >= LEAST);
        let counted = seen().filter(|o| o.texels >= LEAST || !is_any);
        let mut densities: Vec<f64> = counted.map(|o| o.density).collect();
        densities.sort_by(f64::total_cmp);
        let at = |k: usize| densities.get(k).copied().unwrap_or(0.0);
        LayoutReport {
            page_use: facts.page_use,
            covered: facts.covered,
            texels_per_unit: Spread {
                min: at(0),
                median: at(densities.len() / 2),
                max: at(densities.len().saturating_sub(1)),
            },
            charts: atlas.chart_count,
            triangles_under_one_texel: facts.small_triangles,
            objects,
        }
    }

    /// What may be wrong with it, each with the flag that mends it.
    pub fn warnings(&self) -> Vec<WarningReport> {
        let mut warnings = Vec::new();
        let seen: Vec<_> = self.objects.iter().filter(|o| o.is_seen()).collect();
        let large = seen
            .iter()
            .find(|o| o.share > LARGE_SHARE && o.across >= FEW && !self.is_coarser(o));
        let few = seen.iter().filter(|o| o.across < FEW).count();
        if let Some(large) = large.filter(|_| few > 0) {
            let name = &large.name;
            let least = short(large.density);
            // Where most have more, the page is small; what equal densities differ by is rounding.
            let (though, cure) = match ALIKE * large.density < self.texels_per_unit.median {
                true => (
                    ", though fewer per unit than most",
                    format!(
                        "a larger `--size` gives all more; `--density-of {name}=D` below {least} leaves more for \
                         them if it may be coarser still"
                    ),
                ),
                false => (
                    "",
                    format!("`--density-of {name}=D` below {least} leaves more for them"),
                ),
            };
            warnings.push(WarningReport {
                kind: "large-share".into(),
                place: format!("object `{name}`"),
                count: 1,
                message: format!(
                    "one object has {:.0} % of the texels{though}, while {few} of {} have fewer than {FEW} across; \
                     {cure}",
                    100.0 * large.share,
                    seen.len(),
                ),
            });
        }
        let coarse: Vec<_> = seen.iter().filter(|o| o.across < COARSE).collect();
        if let Some(first) = coarse.first() {
            warnings.push(WarningReport {
                kind: "coarse-objects".into(),
                place: format!("object `{}`", first.name),
                count: coarse.len() as u64,
                message: format!(
                    "objects have fewer than {COARSE} texels across; `--density-of {}={}`, a larger `--size` or more \
                     `--pages` gives them more",
                    first.name,
                    short(first.density * ENOUGH / first.across),
                ),
            });
        }
        warnings
    }

    /// True where an object has so few texels per unit that it can spare none for others.
    fn is_coarser(&self, object: &ObjectLayout) -> bool {
        UNEVEN * object.density < self.texels_per_unit.median
    }

    /// The warning that names what stands out of a layout in which nobody asked for densities: the object whose density
    /// is farthest from the usual one, and how many are three times apart from that. Objects at the least number of
    /// texels do not count, and not those that another warning says have too few.
    pub fn uneven_density(&self) -> Option<WarningReport> {
        let usual = self.texels_per_unit.median;
        let apart = |object: &ObjectLayout| (object.density / usual).max(usual / object.density);
        let known = self.objects.iter();
        let known = known.filter(|object| object.texels > FLOOR && object.across >= COARSE);
        let uneven: Vec<&ObjectLayout> = known.filter(|object| apart(object) > UNEVEN).collect();
        let first = uneven.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let how = if first.density > usual {
            "more"
        } else {
            "fewer"
        };
        // What has most of the page can only get more from a larger one.
        let (though, cure) = match self.is_coarser(first) && first.share > LARGE_SHARE {
            true => (
                format!(", though {:.0} % of all are its", 100.0 * first.share),
                "a larger `--size` gives it more".to_owned(),
            ),
            false => {
                let own = format!("`--density-of {}=D` gives it its own", first.name);
                (String::new(), own)
            }
        };
        Some(WarningReport {
            kind: "uneven-density".into(),
            place: format!("object `{}`", first.name),
            count: uneven.len() as u64,
            message: format!(
                "{how} texels per unit than others have, {} where the median is {}{though}; {cure}, `--density even` \
                 all the same",
                short(first.density),
                short(usual),
            ),
        })
    }

    /// Where the page is too small for its charts: mostly gutters, or, where `alone` is asked for, more than one.
    /// `None` also where no page is large enough.
    pub fn small_page(
        &self,
        scene: &scene::Scene,
        atlas: &atlas::Atlas,
        alone: bool,
    ) -> Option<WarningReport> {
        let spread = alone && atlas.page_count > 1;
        let inside = self.covered / self.page_use.max(f64::MIN_POSITIVE);
        if !spread && inside >= LEAST_INSIDE {
            return None;
        }
        let size = atlas::roomy_size(scene, atlas).filter(|&size| size > atlas.page_size)?;
        let what = match spread {
            true => format!("the charts are spread over {} pages", atlas.page_count),
            false => format!(
                "gutters take {:.0} % of the texels in use",
                100.0 * (1.0 - inside).min(0.99)
            ),
        };
        Some(WarningReport {
            kind: "small-page".into(),
            place: format!("pages of {}²", atlas.page_size),
            count: 1,
            message: format!(
                "{what}: a page this small is mostly gutters; `--size {size}` gives the texels to the charts"
            ),
        })
    }

    /// What is said of objects that are finer than all that count for [`LayoutReport::texels_per_unit`].
    fn specks(&self) -> String {
        let is_finer = |o: &&ObjectLayout| o.is_seen() && o.density > self.texels_per_unit.max;
        let finer = || self.objects.iter().filter(is_finer);
        match finer().map(|o| o.density).fold(0.0, f64::max) {
            0.0 => String::new(),
            most => {
                let (count, texels) = (finer().count(), LEAST as u32);
                format!(
                    "; {count} of fewer than {texels} texels: up to {}",
                    short(most)
                )
            }
        }
    }

    /// What an artist asks first, a few lines.
    pub fn text(&self) -> String {
        let Spread { min, median, max } = &self.texels_per_unit;
        let coarse = match self.triangles_under_one_texel {
            0 => "every triangle has a texel or more".into(),
            some => {
                format!("{some} triangles under one texel: they share their light with neighbours")
            }
        };
        let mut text = format!(
            "{:.1} % of the pages in use ({:.1} % inside charts), {} chart{}; {coarse}\n\
             texels per unit: {} to {}, median {}{}{}\n",
            100.0 * self.page_use,
            100.0 * self.covered,
            self.charts,
            if self.charts == 1 { "" } else { "s" },
            short(*min),
            short(*max),
            short(*median),
            match self.uneven_density() {
                Some(_) => ", uneven",
                None => "",
            },
            self.specks(),
        );
        let mut largest: Vec<_> = self.objects.iter().collect();
        largest.sort_by(|a, b| b.share.total_cmp(&a.share));
        text += "    texels  per unit  across  object\n";
        for object in largest.into_iter().take(LISTED).filter(|o| o.share > 0.0) {
            text += &format!(
                "{:>8.1} %  {:>8}  {:>6.0}  {}\n",
                100.0 * object.share,
                match object.is_seen() {
                    true => short(object.density),
                    false => "unseen".into(),
                },
                object.across,
                object.name,
            );
        }
        let further = self.objects.iter().filter(|o| o.share > 0.0).count();
        if further > LISTED {
            text += &format!("            and {} more objects\n", further - LISTED);
        }
        text
    }
}

/// So many objects stand in the text, the largest ones.
const LISTED: usize = 5;
/// Densities that are so many times apart show.
const UNEVEN: f64 = 3.0;
/// An object of so many texels or fewer has the least that any has.
const FLOOR: f64 = 16.5;

/// Three digits.
fn short(value: f64) -> String {
    let digits = 2 - value.abs().max(1e-6).log10().floor() as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(name: &str, texels: f64, across: f64) -> ObjectLayout {
        ObjectLayout {
            name: name.into(),
            texels,
            density: 2.0,
            share: texels / 100.0,
            across,
        }
    }

    #[test]
    fn an_object_of_fewer_texels_than_any_needs_does_not_count_for_the_densities() {
        let mut layout = LayoutReport {
            texels_per_unit: Spread {
                min: 2.0,
                median: 3.0,
                max: 8.0,
            },
            objects: vec![object("floor", 900.0, 40.0)],
            ..LayoutReport::default()
        };
        let line = "texels per unit: 2.00 to 8.00, median 3.00";
        assert!(
            layout.text().contains(&format!("{line}\n")),
            "{}",
            layout.text()
        );
        let speck = |density: f64| ObjectLayout {
            density,
            ..object("screw", 15.9, 4.0)
        };
        layout.objects.extend([speck(31.0), speck(9.0), speck(7.0)]);
        let line = format!("{line}; 2 of fewer than 16 texels: up to 31.0\n");
        assert!(layout.text().contains(&line), "{}", layout.text());
    }

    #[test]
    fn a_large_share_and_coarse_objects_are_warned_of_with_a_flag() {
        let mut layout = LayoutReport {
            objects: vec![
                object("ground", 58.0, 90.0),
                object("cup", 2.0, 3.25),
                object("cup#2", 1.0, 2.5),
                object("house", 39.0, 40.0),
                object("excluded", 0.0, 0.0),
                // In something closed.
                ObjectLayout {
                    density: 0.0,
                    ..object("hinge", 0.3, 0.0)
                },
            ],
            ..LayoutReport::default()
        };
        let warnings = layout.warnings();
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert_eq!(warnings[0].place, "object `ground`");
        assert!(warnings[0].message.contains("--density-of ground=D"));
        assert_eq!(
            (warnings[1].count, warnings[1].place.as_str()),
            (2, "object `cup`")
        );
        // The only object has everything, and that is as it should be.
        layout.objects = vec![object("ground", 100.0, 90.0)];
        assert!(layout.warnings().is_empty());
    }

    #[test]
    fn an_object_is_not_asked_for_texels_of_which_it_has_fewer_than_others() {
        // A room of which the page is full, and what stands in it, as fine as the least number of texels makes it.
        let room = |density: f64| LayoutReport {
            texels_per_unit: Spread {
                min: density,
                median: 37.0,
                max: 119.0,
            },
            objects: vec![
                ObjectLayout {
                    density,
                    ..object("room", 80.0, 253.0)
                },
                ObjectLayout {
                    density: 37.0,
                    ..object("shelf", 20.0, 31.0)
                },
                ObjectLayout {
                    density: 120.0,
                    ..object("screw", 17.0, 3.0)
                },
            ],
            ..LayoutReport::default()
        };
        let kinds = |layout: &LayoutReport| {
            let warnings = layout.warnings().into_iter();
            let all = warnings.chain(layout.uneven_density());
            all.map(|warning| (warning.kind, warning.place))
                .collect::<Vec<_>>()
        };
        let of = |kind: &str, object: &str| (kind.to_owned(), format!("object `{object}`"));
        let coarse = of("coarse-objects", "screw");
        let scarce = room(9.26);
        assert_eq!(
            kinds(&scarce),
            [coarse.clone(), of("uneven-density", "room")]
        );
        let line = scarce.uneven_density().expect("a warning").message;
        assert!(
            line.contains("fewer texels per unit than others have, 9.26 where the median is 37.0"),
            "{line}"
        );
        assert!(
            line.contains("80 % of all") && line.contains("larger `--size`"),
            "{line}"
        );
        assert!(!line.contains("--density-of"), "{line}");
        assert_eq!(kinds(&room(20.0)), [of("large-share", "room"), coarse]);
        // It has fewer all the same, so that the page is to blame first.
        let line = &room(20.0).warnings()[0].message;
        assert!(
            line.contains("though fewer per unit than most")
                && line.contains("; a larger `--size` gives all more"),
            "{line}"
        );
        let line = &room(40.0).warnings()[0].message;
        assert!(
            !line.contains("--size") && line.contains("; `--density-of room=D` below 40.0"),
            "{line}"
        );
    }

    #[test]
    fn an_object_that_is_much_finer_than_the_others_is_named_unless_it_is_as_small_as_can_be() {
        let dense = |name: &str, texels: f64, density: f64| ObjectLayout {
            density,
            ..object(name, texels, 40.0)
        };
        let layout = |cup: ObjectLayout| LayoutReport {
            texels_per_unit: Spread {
                min: 2.0,
                median: 3.0,
                max: 40.0,
            },
            objects: vec![dense("floor", 900.0, 2.0), dense("wall", 300.0, 3.0), cup],
            ..LayoutReport::default()
        };
        let warned = layout(dense("cup", 40.0, 40.0))
            .uneven_density()
            .expect("a warning");
        assert_eq!(
            (warned.kind.as_str(), warned.place.as_str()),
            ("uneven-density", "object `cup`")
        );
        assert!(
            warned.message.contains("--density-of cup=D"),
            "{}",
            warned.message
        );
        assert!(layout(dense("cup", 16.0, 40.0)).uneven_density().is_none());
        assert!(layout(dense("cup", 40.0, 8.0)).uneven_density().is_none());
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0.00000000"),
            (0.01234, "0.0123"),
            (1.0, "1.00"),
            (123.4, "123"),
            (9876.5, "9876"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
