//! The help of the verbs that bake: flags under headings, and a short one with those that most bakes need.

use clap::Command;

/// Headings with their flags, by long name, in the order of the help.
const HEADINGS: [(&str, &[&str]); 7] = [
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
];

/// What `-h` leaves to `--help`.
const LONG: [&str; 40] = [
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
];

/// The verbs that take the options of a bake.
const VERBS: [&str; 5] = ["bake", "plan", "watch", "layout", "bench"];

/// The command with its flags under headings. Those of a verb that stand under none come first.
pub fn arranged(command: Command) -> Command {
    VERBS.iter().fold(command, |command, verb| {
        command.mut_subcommand(verb, |command| {
            command.mut_args(|arg| {
                let Some(name) = arg.get_long().map(str::to_owned) else {
                    return arg;
                };
                let place = HEADINGS
                    .iter()
                    .position(|(_, flags)| flags.contains(&&*name));
                let Some(place) = place else { return arg };
                let (heading, flags) = HEADINGS[place];
                let within = flags.iter().position(|flag| *flag == name).unwrap_or(0);
                arg.help_heading(heading)
                    .display_order(100 * (place + 1) + within)
                    .hide_short_help(LONG.contains(&&*name))
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Args;

    #[test]
    fn every_flag_of_a_bake_has_a_heading_and_every_name_is_a_flag() {
        let command = Args::grammar();
        let bake = command.find_subcommand("bake").expect("the verb");
        let known: Vec<&str> = bake
            .get_arguments()
            .filter_map(|arg| arg.get_long())
            .collect();
        let under: Vec<&str> = HEADINGS
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
        for name in under.iter().chain(&LONG) {
            assert!(known.contains(name), "there is no flag --{name}");
        }
        let short = bake
            .get_arguments()
            .filter(|arg| !arg.is_hide_short_help_set());
        assert!(short.count() <= 27, "-h is for what most bakes need");
    }
}
