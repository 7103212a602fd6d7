//! The objects of a layout: what shares one density, how large it is, and what was asked for it by name.

use crate::glob::fits;
use crate::measure::world_area;
use crate::{Error, Options};
use scene::{Format, Scene, around};
use std::collections::HashMap;

/// What a user takes for one thing: a node of a glTF file (each copy of an instanced one), an object of an OBJ file
/// with all its materials, a mesh of a built scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjectName {
    /// The file's name for it; `#2`, `#3` and so on at the end of names that repeat.
    pub name: String,
    /// Indices into `Scene::instances`.
    pub instances: Vec<u32>,
}

/// The objects of a scene in the order of their first instances.
pub fn object_names(scene: &Scene) -> Vec<ObjectName> {
    let mut objects: Vec<ObjectName> = Vec::new();
    let mut known = HashMap::new();
    let mut repeats: HashMap<String, usize> = HashMap::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let plain = plain_name(scene, i);
        let key = match scene.format {
            Format::Gltf | Format::Glb => (instance.node, instance.copy, ""),
            Format::Obj => (0, None, plain),
            Format::Memory => (i as u32, None, ""),
        };
        let object = *known.entry(key).or_insert_with(|| {
            let count = repeats.entry(plain.into()).or_default();
            *count += 1;
            objects.push(ObjectName {
                name: match *count {
                    1 => plain.into(),
                    k => format!("{plain}#{k}"),
                },
                instances: Vec::new(),
            });
            objects.len() - 1
        });
        objects[object].instances.push(i as u32);
    }
    objects
}

/// The name of an instance's object without the number of its repeat.
fn plain_name(scene: &Scene, instance: usize) -> &str {
    let instance = &scene.instances[instance];
    let mesh = &scene.meshes[instance.mesh as usize].name;
    // Readers of glTF name instances `node / mesh`.
    let node = instance.name.strip_suffix(mesh.as_str());
    node.and_then(|n| n.strip_suffix(" / "))
        .unwrap_or(&instance.name)
}

/// What the layout knows of an object. All its parts share one density.
#[derive(Debug, Clone)]
pub(crate) struct Object {
    /// Indices into `Scene::instances`.
    pub instances: Vec<u32>,
    /// Surface in the world, in square scene units.
    pub area: f64,
    /// Texels of its charts that nobody sees, whose surface the area is without.
    pub hidden: f64,
    /// Longest edge of the box around it in the world, in scene units.
    pub extent: f64,
    /// Texels per scene unit that were asked for this object.
    pub asked: Option<f64>,
    /// It takes texels; an object without only occludes.
    pub included: bool,
}

/// The objects of a scene in the order of their first instances, with what the options say of them by name.
///
/// # Errors
///
/// A pattern that fits no name, an object too large to measure, or a scene of which nothing is left to lay out.
pub(crate) fn objects(scene: &Scene, options: &Options) -> Result<Vec<Object>, Error> {
    let names = object_names(scene);
    let chosen = |patterns: &[String], flag| -> Result<Vec<bool>, Error> {
        let mut chosen = vec![false; names.len()];
        for pattern in patterns {
            mark(&names, pattern, flag, |i| chosen[i] = true)?;
        }
        Ok(chosen)
    };
    let included = chosen(&options.include, "--include")?;
    let excluded = chosen(&options.exclude, "--exclude")?;
    // All parts of an object are of one node.
    let first = |object: &ObjectName| &scene.instances[object.instances[0] as usize];
    let asked = names
        .iter()
        .map(|object| first(object).density.or(options.density));
    let mut asked: Vec<Option<f64>> = asked.collect();
    let bakes: Vec<bool> = names.iter().map(|object| first(object).bakes).collect();
    // Later patterns win, and all of them over what the file says.
    for (pattern, density) in &options.density_of {
        if !(density.is_finite() && *density > 0.0) {
            return Err(Error::Density(*density));
        }
        mark(&names, pattern, "--density-of", |i| {
            asked[i] = Some(*density)
        })?;
    }
    let mut objects = Vec::with_capacity(names.len());
    for (i, ObjectName { name, instances }) in names.into_iter().enumerate() {
        let area = instances
            .iter()
            .map(|&i| world_area(scene, i as usize))
            .sum();
        let extent = extent(scene, &instances);
        if !(f64::is_finite(area) && extent.is_finite()) {
            return Err(Error::Extent(name));
        }
        objects.push(Object {
            instances,
            area,
            hidden: 0.0,
            extent,
            asked: asked[i],
            included: !excluded[i]
                && if options.include.is_empty() {
                    bakes[i]
                } else {
                    included[i]
                },
        });
    }
    match objects.iter().any(|o| o.included && o.area > 0.0) {
        true => Ok(objects),
        false => Err(Error::Empty),
    }
}

/// The instances of the objects that `pattern` names, with or without the number of a repeat; where none has that very
/// name, of those that it fits, `*` for any characters and `?` for one.
///
/// # Errors
///
/// [`Error::NoSuchObject`], which names `flag`.
pub fn instances_named(
    scene: &Scene,
    pattern: &str,
    flag: &'static str,
) -> Result<Vec<u32>, Error> {
    let names = object_names(scene);
    let mut found = Vec::new();
    mark(&names, pattern, flag, |i| found.extend(&names[i].instances))?;
    Ok(found)
}

/// Calls `chosen` with each object that `pattern` names, with or without the number of its repeat; where none has that
/// very name, with each that it fits. So a name with a star in it is that of one object, and a long name may be given
/// whole.
fn mark(
    names: &[ObjectName],
    pattern: &str,
    flag: &'static str,
    mut chosen: impl FnMut(usize),
) -> Result<(), Error> {
    fn unnumbered(name: &str) -> Option<(&str, &str)> {
        let parts = name.rsplit_once('#');
        parts.filter(|(_, k)| k.parse::<u32>().is_ok())
    }
    let kept = match unnumbered(pattern) {
        Some((plain, k)) => format!("{}#{k}", scene::kept_name(plain)),
        None => scene::kept_name(pattern).into_owned(),
    };
    let any = |is: &dyn Fn(&str) -> bool| -> Vec<usize> {
        let plain = |name: &str| unnumbered(name).is_some_and(|(plain, _)| is(plain));
        let all = names.iter().enumerate();
        let found = all.filter(|(_, object)| is(&object.name) || plain(&object.name));
        found.map(|(i, _)| i).collect()
    };
    let mut found = any(&|name| name == pattern || name == kept);
    if found.is_empty() {
        found = any(&|name| fits(pattern, name));
    }
    match found.is_empty() {
        false => {
            found.into_iter().for_each(&mut chosen);
            Ok(())
        }
        true => Err(Error::NoSuchObject {
            flag,
            pattern: pattern.into(),
            names: names.iter().take(4).map(|o| o.name.clone()).collect(),
            count: names.len(),
        }),
    }
}

/// Longest edge of the box around some instances in the world.
pub(crate) fn extent(scene: &Scene, instances: &[u32]) -> f64 {
    let corners = |&instance: &u32| {
        let instance = &scene.instances[instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let vertices = mesh.triangles.iter().flatten();
        let place = |&v: &u32| mesh.positions[v as usize].as_dvec3();
        vertices.map(move |v| instance.transform.transform_point3(place(v)))
    };
    let (low, high) = around(instances.iter().flat_map(corners));
    (high - low).max_element().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of the objects that a pattern names.
    fn named(names: &[&str], pattern: &str) -> Vec<usize> {
        let object = |name: &&str| ObjectName {
            name: (*name).into(),
            instances: vec![0],
        };
        let names: Vec<ObjectName> = names.iter().map(object).collect();
        let mut found = Vec::new();
        let _ = mark(&names, pattern, "--no-cast", |i| found.push(i));
        found
    }

    #[test]
    fn a_name_with_a_star_names_itself_before_it_stands_for_others() {
        let names = ["a*b", "axb", "a*b#2", "c"];
        assert_eq!(named(&names, "a*b"), [0, 2]);
        assert_eq!(named(&names, "a*b#2"), [2]);
        assert_eq!(named(&names, "a?b"), [0, 1, 2]);
        assert_eq!(named(&["axb", "c"], "a*b"), [0]);
        assert!(named(&names, "d*").is_empty());
    }

    #[test]
    fn a_long_name_is_found_as_the_file_has_it_and_as_it_is_told() {
        let [one, other] = ["1", "2"].map(|end| "wall".repeat(60) + end);
        let kept = [&one, &other].map(|name| scene::kept_name(name).into_owned());
        assert!(kept.iter().all(|name| name.len() <= 200), "{kept:?}");
        let second = format!("{}#2", kept[1]);
        let names = [&*kept[0], &*kept[1], &*second];
        assert_eq!(named(&names, &one), [0]);
        assert_eq!(named(&names, &other), [1, 2]);
        assert_eq!(named(&names, &(other + "#2")), [2]);
        assert_eq!(named(&names, &kept[0]), [0]);
    }
}
