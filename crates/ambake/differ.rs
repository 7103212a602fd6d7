//! What two bakes differ by: parts that are to be merged, or a bake and the one it is updated from.

use serde_json::Value;

/// What two bakes differ by, in words.
pub(crate) fn difference(a: &Value, b: &Value) -> Option<String> {
    let words = [
        ("version", "ambake's version"),
        ("revision", "ambake's revision"),
        ("scene", "the scene"),
        ("options", "options"),
        ("layout", "the layout"),
        ("pages", "the bake of --bake"),
        ("backend", "the ray library or the processor it runs on"),
    ];
    let (key, word) = words.into_iter().find(|(key, _)| a[key] != b[key])?;
    if key != "options" {
        return Some(word.into());
    }
    let (a, b) = (a[key].as_object()?, b[key].as_object()?);
    // What no flag says by itself follows from one that is named.
    let names = a
        .keys()
        .filter(|name| *name != "full_highlights" && a.get(*name) != b.get(*name));
    let names: Vec<String> = names
        .map(|name| format!("--{}", name.replace('_', "-")))
        .collect();
    Some(names.join(", "))
}
