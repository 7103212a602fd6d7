//! What the parts of a file are called.

use serde_json::Value;

/// The name of a node, a mesh or a material; `None` without one that anybody could read and type.
pub(super) fn own_name(json: &Value) -> Option<&str> {
    let name = json.get("name").and_then(Value::as_str);
    name.filter(|name| !name.trim().is_empty())
}
