//! Help about layers, from the one table of them.

use ambake::Layer;

/// What `--layers` and `--only` take, for help.
pub fn layer_help(start: &str) -> String {
    let standard = |layer: &Layer| Layer::STANDARD.contains(layer);
    let further = Layer::all().filter(|layer| !standard(layer));
    let rows = further.map(|layer| format!("{} ({})", layer.name(), layer.help()));
    let names: Vec<_> = Layer::STANDARD.iter().map(|layer| layer.name()).collect();
    format!(
        "{start}: {}. Written by default: {}",
        rows.collect::<Vec<_>>().join(", "),
        names.join(", ")
    )
}
