//! What stands elsewhere of the flags: the tables of docs/flags.md, the types of Python's stubs, the panel of Blender.
//! `just tables` writes the first two.

use crate::args::Args;
use ambake::flags::keywords::{Keyword, Kind, keywords};
use ambake::flags::{Bake, Probes};
use clap::Arg;
use std::collections::BTreeSet;
use std::path::PathBuf;

const FLAGS: &str = "docs/flags.md";
const STUBS: &str = "integrations/python/python/ambake/__init__.pyi";

fn read(file: &str) -> (PathBuf, String) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = std::fs::read_to_string(&path).expect(file);
    (path, text)
}

/// Compares what stands in a file between two texts with what should, or writes it.
fn expect(file: &str, from: &str, to: &str, wanted: &str) {
    let (path, text) = read(file);
    let (before, rest) = text.split_once(from).expect(from);
    let (found, after) = rest.split_once(to).expect(to);
    if std::env::var_os("AMBAKE_WRITE_TABLES").is_some() {
        let text = [before, from, wanted, to, after].concat();
        std::fs::write(path, text).expect(file);
    } else {
        assert_eq!(found, wanted, "in {file}; `just tables` writes it anew");
    }
}

/// A row of docs/flags.md.
fn row(arg: &Arg) -> String {
    let words = arg.get_possible_values();
    let names: Vec<_> = words.iter().map(|word| word.get_name()).collect();
    let form = match arg.get_value_names() {
        _ if !arg.get_action().takes_values() => String::new(),
        _ if !names.is_empty() => names.join("|"),
        form => form.unwrap_or_default().concat(),
    };
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let (help, told) = help.split_once(" [default: ").unwrap_or((&help, ""));
    let given: Vec<_> = arg
        .get_default_values()
        .iter()
        .map(|value| value.display().to_string())
        .collect();
    let default = match form.is_empty() || given.is_empty() {
        true => told.trim_end_matches(']').to_owned(),
        false => given.concat(),
    };
    let meanings = words
        .iter()
        .filter_map(|word| Some((word.get_name(), word.get_help()?.to_string())));
    let meanings = meanings.map(|(word, of)| format!(". `{word}`: {of}"));
    let help = help.replace('*', "\\*") + &meanings.collect::<String>();
    let short = arg
        .get_short()
        .map_or(String::new(), |short| format!("`-{short}`, "));
    let flag = format!("--{} {form}", arg.get_long().unwrap_or_default());
    let cells = [
        format!("{short}`{}`", flag.trim()),
        code(&help),
        code(&default),
    ];
    format!(
        "| {} |\n",
        cells.map(|cell| cell.replace('|', "\\|")).join(" | ")
    )
}

/// A sentence in which flags are code.
fn code(text: &str) -> String {
    let word = |word: &str| match word.trim_end_matches([',', '.', ':']) {
        flag if flag.starts_with("--") && !flag.contains('`') => {
            word.replace(flag, &format!("`{flag}`"))
        }
        _ => word.to_owned(),
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

#[test]
fn the_document_of_flags_has_those_of_the_program() {
    let mut grammar = Args::grammar();
    grammar.build();
    let bake = grammar.find_subcommand("bake").expect("the verb");
    let shown = || bake.get_arguments().filter(|arg| !arg.is_hide_set());
    for heading in shown()
        .filter_map(Arg::get_help_heading)
        .collect::<BTreeSet<_>>()
    {
        let rows = shown()
            .filter(|arg| arg.get_help_heading() == Some(heading))
            .map(row);
        let table = format!(
            "\n| flag | what it does | default |\n|---|---|---|\n{}\n",
            rows.collect::<String>()
        );
        expect(
            FLAGS,
            &format!("<!-- flags: {heading} -->\n"),
            "<!-- end -->",
            &table,
        );
    }
}

/// What a keyword takes, as Python's types say it.
fn python_type(keyword: &Keyword) -> String {
    let form = match &keyword.kind {
        Kind::Switch => "bool",
        Kind::Whole => "int",
        Kind::Number => "float",
        Kind::Path => "_Path",
        Kind::Word(words) => return format!("Literal{words:?}"),
        Kind::Text(form) => form,
    };
    match form {
        "D|even" => r#"Union[float, Literal["even"]]"#,
        "auto|N" | "N|auto" => r#"Union[int, Literal["auto"]]"#,
        "SIZE" => "Union[int, str]",
        "NAME=D" => "Mapping[str, float]",
        "NAME=drop|keep" => r#"Mapping[str, Literal["drop", "keep"]]"#,
        "R,G,B" => "_Rgb",
        "R,G,B|albedo|file" => r#"Union[_Rgb, Literal["albedo", "file"]]"#,
        "R,G,B|FILE" => "Union[_Rgb, _Path, npt.NDArray[Any]]",
        "normal|X,Y,Z" => r#"Union[Literal["normal"], Sequence[float]]"#,
        "auto|X,Y,Z[:X,Y,Z][;..]" => r#"Union[Sequence[_Rgb], Literal["auto"]]"#,
        "X,Y,Z;.." => "Union[Sequence[_Rgb], npt.NDArray[np.float64]]",
        "X,Y,Z:X,Y,Z" => "Sequence[_Rgb]",
        "NXxNYxNZ" => "Sequence[int]",
        "NAME" | "A,B,C" | "NAME,.." | "ENGINE,.." => "Union[str, Sequence[str]]",
        light if light.starts_with("X,Y,Z,") => "Sequence[Sequence[float]]",
        plain => plain,
    }
    .to_owned()
}

#[test]
fn the_stubs_of_python_have_every_keyword() {
    for (class, keywords) in [
        ("Options", keywords::<Bake>()),
        ("ProbeOptions", keywords::<Probes>()),
    ] {
        let line = |keyword: &Keyword| format!("\n    {}: {}", keyword.name, python_type(keyword));
        let lines: String = keywords.iter().map(line).collect();
        expect(
            STUBS,
            &format!("class {class}(TypedDict, total=False):"),
            "\n\n",
            &lines,
        );
    }
}

#[test]
fn the_panel_of_blender_has_flags_and_words_of_the_program() {
    let keywords = [keywords::<Bake>(), keywords::<Probes>()].concat();
    for file in ["command.py", "scene_light.py", "lamps.py"] {
        let (_, text) = read(&format!("integrations/blender/ambake/{file}"));
        for rest in text.split("\"--").skip(1) {
            let name = rest
                .split(['"', '='])
                .next()
                .unwrap_or_default()
                .replace('-', "_");
            let is_known =
                ["json", "for"].contains(&&*name) || keywords.iter().any(|of| of.name == name);
            assert!(is_known, "{file}: there is no flag {name}");
        }
    }
    let (_, settings) = read("integrations/blender/ambake/settings.py");
    for keyword in keywords {
        let property = settings.split_once(&format!("    {}: EnumProperty", keyword.name));
        let words = property.and_then(|(_, of)| of.split("Property").next()?.split_once("_plain("));
        if let (Some((_, plain)), Kind::Word(words)) = (words, keyword.kind) {
            let plain = plain.split(')').next().unwrap_or_default();
            let plain: BTreeSet<_> = plain
                .split(", ")
                .map(|word| word.trim_matches('"'))
                .collect();
            let words = words.iter().map(String::as_str).collect();
            assert_eq!(plain, words, "settings.py: {}", keyword.name);
        }
    }
}
