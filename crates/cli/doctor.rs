//! `ambake doctor`: what was really loaded, and what it can do.

use crate::args::Doctor as Args;
use crate::host;
use crate::outcome::{Outcome, say};
use serde_json::{Value, json};

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let embree = embree();
    let usable = embree["usable"] != json!(false);
    let report = json!({
        "schema_version": 1,
        "ambake": { "version": host::VERSION, "target_features": host::TARGET_FEATURES },
        "threads": std::thread::available_parallelism().map_or(1, |n| n.get()),
        "backends": { "embree": embree, "obvhs": { "usable": true, "layouts": ["cwbvh", "bvh2"] } },
        "default_backend": if report_has_embree(&embree) { "embree" } else { "obvhs" },
    });
    if args.json {
        say(&format!("{}\n", serde_json::to_string_pretty(&report)?))?;
    } else {
        say(&describe(&report))?;
    }
    Ok(if usable {
        Outcome::Done
    } else {
        Outcome::Unusable
    })
}

fn report_has_embree(embree: &Value) -> bool {
    embree["usable"] == json!(true)
}

/// What the Embree library says of itself; `usable` is null where none was built in.
fn embree() -> Value {
    let Some(headers) = embree::header_version() else {
        return json!({
            "usable": null,
            "reason": "not built in: AMBAKE_NO_EMBREE left it out, as in the archive of a release, or the build found \
                       no libembree-dev and libclang-dev; build again with both, or bake with obvhs",
        });
    };
    match embree::Device::new(&embree::DeviceConfig::default()) {
        Err(error) => {
            json!({ "usable": false, "headers": headers.to_string(), "reason": error.to_string() })
        }
        Ok(device) => {
            let info = device.info();
            json!({
                "usable": true,
                "library": info.library.to_string(),
                "headers": info.headers.to_string(),
                "isa": info.isa.name(),
                "tasking": info.tasking.to_string(),
                "native_packets": { "4": info.native_packet_4, "8": info.native_packet_8, "16": info.native_packet_16 },
                "filter_functions": info.filter_functions,
                "ray_masks": info.ray_mask,
                "backface_culling": info.backface_culling,
            })
        }
    }
}

fn describe(report: &Value) -> String {
    let mut text = String::new();
    text += &format!("ambake {} ({} threads)\n", host::VERSION, report["threads"]);
    text += &format!("default backend: {}\n", plain(&report["default_backend"]));
    let embree = &report["backends"]["embree"];
    match embree["usable"].as_bool() {
        Some(true) => text += "embree: usable\n",
        Some(false) => text += "embree: UNUSABLE\n",
        None => text += "embree: absent\n",
    }
    for (key, value) in embree
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(key, _)| *key != "usable")
    {
        text += &format!("  {key}: {}\n", plain(value));
    }
    text + "obvhs: usable\n  layouts: cwbvh, bvh2\n"
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(string) => string.clone(),
        Value::Object(map) => map
            .iter()
            .map(|(k, v)| format!("{k} {}", plain(v)))
            .collect::<Vec<_>>()
            .join(", "),
        Value::Bool(true) => "yes".into(),
        Value::Bool(false) => "no".into(),
        other => other.to_string(),
    }
}
