//! What `extras.ambake` of a node or a mesh says of an object.

use serde_json::Value;

/// What is said; `None` where nothing is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Said {
    /// `cast`: it blocks light.
    pub casts: Option<bool>,
    /// `buried`: what nobody sees of it is baked like the rest.
    pub keeps_buried: Option<bool>,
    /// `density`: texels per scene unit, above 0.
    pub density: Option<f64>,
    /// `bake`: it takes texels.
    pub bakes: Option<bool>,
}

impl Said {
    /// What a node or a mesh says, and the names in it that mean nothing.
    ///
    /// # Errors
    /// A value that its name cannot have.
    pub fn of(holder: &Value) -> Result<(Self, Vec<&str>), String> {
        let (mut said, mut unknown) = (Self::default(), Vec::new());
        let own = holder.get("extras").and_then(|extras| extras.get("ambake"));
        if let Some(other) = own.filter(|own| !own.is_object()) {
            return Err(format!(
                "extras.ambake is {other}; give an object, such as {{\"bake\": false}}"
            ));
        }
        for (name, value) in own.and_then(Value::as_object).into_iter().flatten() {
            let wrong =
                |expected: &str| format!("extras.ambake.{name} is {value}; give {expected}");
            let answer = || value.as_bool().ok_or_else(|| wrong("true or false"));
            match name.as_str() {
                "cast" => said.casts = Some(answer()?),
                "bake" => said.bakes = Some(answer()?),
                "buried" => match value.as_str() {
                    Some("drop") => said.keeps_buried = Some(false),
                    Some("keep") => said.keeps_buried = Some(true),
                    _ => return Err(wrong("\"drop\" or \"keep\"")),
                },
                "density" => match value.as_f64() {
                    Some(density) if density > 0.0 => said.density = Some(density),
                    _ => return Err(wrong("texels per scene unit above 0")),
                },
                other => unknown.push(other),
            }
        }
        Ok((said, unknown))
    }

    /// What is said, and what another says where it is silent.
    pub fn or(self, other: Self) -> Self {
        Self {
            casts: self.casts.or(other.casts),
            keeps_buried: self.keeps_buried.or(other.keeps_buried),
            density: self.density.or(other.density),
            bakes: self.bakes.or(other.bakes),
        }
    }
}
