//! The help of verbs with many flags: under headings, and a short one with those that are needed most.

use clap::Command;

/// The help of verbs that share their flags.
struct Help {
    verbs: &'static [&'static str],
    /// Headings with their flags, by long name, in the order of the help.
    headings: &'static [(&'static str, &'static [&'static str])],
    /// What `-h` leaves to `--help`.
    long: &'static [&'static str],
}

const BAKE: Help = Help {
    verbs: &["bake", "plan", "watch", "layout", "bench"],
    headings: &[
        (
            "Input",
            &[
                "include",
                "exclude",
                "no-cast",
                "allow-outside",
                "normal-maps",
                "albedo",
                "specular",
                "exponent",
            ],
        ),
        (
            "Texels",
            &[
                "size",
                "density",
                "density-of",
                "seen-from",
                "pages",
                "one-page-per-mesh",
                "uv",
                "gutter",
                "mips",
                "align",
                "footprint",
                "buried",
                "buried-of",
                "under",
                "seams",
            ],
        ),
        (
            "Light",
            &[
                "sky",
                "bounces",
                "lights",
                "sun",
                "point",
                "sphere",
                "rect",
                "max-distance",
                "model",
                "view",
                "shading",
                "ambient-coefficient",
            ],
        ),
        (
            "Rays",
            &[
                "rays",
                "target-error",
                "target-relative",
                "max-rays",
                "denoise",
                "pattern",
                "seed",
                "plan-off",
            ],
        ),
        ("Files", &["output", "for", "layers", "only", "report"]),
        ("Runs", &["fresh", "resume", "shard", "update", "verify"]),
        (
            "Machine",
            &[
                "backend",
                "threads",
                "max-memory",
                "quiet",
                "json",
                "verbose",
            ],
        ),
    ],
    long: &[
        "buried-of",
        "under",
        "allow-outside",
        "albedo",
        "specular",
        "exponent",
        "density-of",
        "seen-from",
        "one-page-per-mesh",
        "gutter",
        "mips",
        "align",
        "footprint",
        "buried",
        "seams",
        "lights",
        "point",
        "sphere",
        "rect",
        "view",
        "shading",
        "ambient-coefficient",
        "target-relative",
        "max-rays",
        "pattern",
        "seed",
        "plan-off",
        "only",
        "fresh",
        "resume",
        "shard",
        "verify",
        "backend",
        "max-memory",
        "json",
        "verbose",
        "no-cast",
        "normal-maps",
        "max-distance",
        "model",
    ],
};

const PROBES: Help = Help {
    verbs: &["probes"],
    headings: &[
        (
            "Places",
            &[
                "spacing",
                "grid",
                "at",
                "within",
                "refine",
                "reflections",
                "reflection-size",
            ],
        ),
        (
            "Light",
            &[
                "bake",
                "sky",
                "bounces",
                "lights",
                "sun",
                "point",
                "sphere",
                "rect",
                "max-distance",
            ],
        ),
        (
            "Rays",
            &["rays", "target-error", "max-rays", "seed", "tried"],
        ),
        (
            "Files",
            &["output", "for", "order", "window", "parts", "allow-outside"],
        ),
        ("Runs", &["fresh", "resume", "shard"]),
        (
            "Machine",
            &["backend", "threads", "quiet", "json", "verbose"],
        ),
    ],
    long: &[
        "reflection-size",
        "lights",
        "point",
        "sphere",
        "rect",
        "max-distance",
        "max-rays",
        "seed",
        "tried",
        "order",
        "parts",
        "allow-outside",
        "fresh",
        "resume",
        "shard",
        "backend",
        "json",
        "verbose",
    ],
};

const RENDER: Help = Help {
    verbs: &["render"],
    headings: &[
        (
            "Camera",
            &["eye", "look", "up", "fov-deg", "size", "samples"],
        ),
        (
            "Light",
            &[
                "bake",
                "sky",
                "background",
                "sun",
                "point",
                "sphere",
                "rect",
                "max-distance",
                "rays",
            ],
        ),
        (
            "Surfaces",
            &[
                "model",
                "albedo",
                "specular",
                "exponent",
                "normal-maps",
                "shader",
                "shader-of",
                "ior",
                "translucency",
            ],
        ),
        (
            "Tables",
            &[
                "maps",
                "exponents",
                "incidences",
                "environment",
                "lookup",
                "diffuse-weight",
                "specular-weight",
                "normals",
                "encode",
                "relight",
            ],
        ),
        (
            "Balls",
            &["probe-ball", "probes", "mirror-ball", "reflection", "room"],
        ),
        (
            "Files",
            &[
                "output",
                "exposure",
                "response",
                "alpha",
                "backdrop",
                "figure",
                "frames",
                "turn-deg",
                "path",
                "allow-outside",
            ],
        ),
        (
            "Machine",
            &["backend", "threads", "seed", "quiet", "json", "verbose"],
        ),
    ],
    long: &[
        "up",
        "background",
        "point",
        "sphere",
        "rect",
        "max-distance",
        "albedo",
        "specular",
        "exponent",
        "shader-of",
        "ior",
        "translucency",
        "exponents",
        "incidences",
        "lookup",
        "diffuse-weight",
        "specular-weight",
        "normals",
        "encode",
        "relight",
        "probes",
        "reflection",
        "room",
        "response",
        "alpha",
        "backdrop",
        "frames",
        "turn-deg",
        "path",
        "allow-outside",
        "backend",
        "seed",
        "json",
        "verbose",
    ],
};

/// The command with its flags under headings. Those of a verb that stand under none come first.
pub fn arranged(mut command: Command) -> Command {
    for help in [BAKE, PROBES, RENDER] {
        for verb in help.verbs {
            command = command.mut_subcommand(verb, |command| help.arrange(command));
        }
    }
    command
}

impl Help {
    fn arrange(&self, command: Command) -> Command {
        command.mut_args(|arg| {
            let Some(name) = arg.get_long().map(str::to_owned) else {
                return arg;
            };
            let mut headings = self.headings.iter().enumerate();
            let found = headings.find_map(|(place, (heading, flags))| {
                let within = flags.iter().position(|flag| *flag == name)?;
                Some((*heading, 100 * (place + 1) + within))
            });
            let Some((heading, order)) = found else {
                return arg;
            };
            arg.help_heading(heading)
                .display_order(order)
                .hide_short_help(self.long.contains(&&*name))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Args;

    #[test]
    fn every_flag_has_a_heading_and_every_name_is_a_flag() {
        let grammar = Args::grammar();
        for help in [BAKE, PROBES, RENDER] {
            let command = grammar.find_subcommand(help.verbs[0]).expect("the verb");
            let known: Vec<&str> = command
                .get_arguments()
                .filter_map(|arg| arg.get_long())
                .collect();
            let under: Vec<&str> = help
                .headings
                .iter()
                .flat_map(|(_, flags)| *flags)
                .copied()
                .collect();
            for name in &known {
                let hidden = ["after", "help", "version"].contains(name);
                assert!(
                    hidden || under.contains(name),
                    "--{name} stands under no heading"
                );
            }
            for name in under.iter().chain(help.long) {
                assert!(
                    known.contains(name),
                    "{} has no flag --{name}",
                    help.verbs[0]
                );
            }
            let short = command
                .get_arguments()
                .filter(|arg| !arg.is_hide_short_help_set());
            assert!(short.count() <= 27, "-h is for what is needed most");
        }
    }
}
