//! Reads what a bake can do without: where it is there and cannot be meant, it is as if it were not, and told of.

use super::accessor::index;
use crate::WarningKind;
use crate::input::{Input, short};
use serde_json::Value;

/// Stands for an object that is not there.
static NONE: Value = Value::Null;

/// Reads the properties of one element.
pub(super) struct Reader<'a> {
    pub input: &'a mut Input,
    /// What messages call the element.
    pub place: &'a str,
}

impl Reader<'_> {
    /// What `read` makes of the value under a key; `None` where there is none.
    pub fn read<'j, T>(
        &mut self,
        json: &'j Value,
        key: &str,
        read: impl FnOnce(&'j Value) -> Option<T>,
    ) -> Option<T> {
        let value = json.get(key).filter(|value| !value.is_null())?;
        let found = read(value);
        if found.is_none() {
            let value = short(&value.to_string());
            self.broken(
                format!("`{key}` is {value}, which cannot be meant"),
                "it counts as absent",
            );
        }
        found
    }

    /// Tells what is wrong and what is done without it.
    pub fn broken(&mut self, problem: String, instead: &str) {
        let message = format!("{problem}; {instead}");
        self.input
            .warn(WarningKind::BrokenParts, self.place, 1, message);
    }

    /// An object; one that has nothing where there is none.
    pub fn object<'j>(&mut self, json: &'j Value, key: &str) -> &'j Value {
        let found = self.read(json, key, |value| value.is_object().then_some(value));
        found.unwrap_or(&NONE)
    }

    pub fn text<'j>(&mut self, json: &'j Value, key: &str) -> Option<&'j str> {
        self.read(json, key, Value::as_str)
    }

    pub fn is_set(&mut self, json: &Value, key: &str) -> bool {
        self.read(json, key, Value::as_bool) == Some(true)
    }

    /// A size, offset or index.
    pub fn index(&mut self, json: &Value, key: &str) -> Option<usize> {
        self.read(json, key, index)
    }

    pub fn number(&mut self, json: &Value, key: &str, or: f32) -> f32 {
        self.read(json, key, float).unwrap_or(or)
    }

    pub fn numbers<const N: usize>(&mut self, json: &Value, key: &str, or: [f32; N]) -> [f32; N] {
        let read = |value: &Value| {
            let numbers: Option<Vec<f32>> = value.as_array()?.iter().map(float).collect();
            numbers?.try_into().ok()
        };
        self.read(json, key, read).unwrap_or(or)
    }
}

fn float(value: &Value) -> Option<f32> {
    Some(value.as_f64()? as f32)
}
