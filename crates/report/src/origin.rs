//! Whether two pages may be compared at all, by what their headers say about where they come from.

use crate::{Error, PageFile};

const SCENE: &str = "ambakeSceneHash";
const PAGE: &str = "ambakePage";

/// Nothing where the headers of two pages do not speak against a comparison. A file of another program states no scene
/// and may be compared with any page.
///
/// # Errors
/// [`Error::Unrelated`] where both state a scene and the scenes differ, or where they are different pages of one bake:
/// everything that ambake states of them is equal but the page number.
pub fn check_origin(a: &PageFile, b: &PageFile) -> Result<(), Error> {
    let unrelated = |reason: String| Err(Error::Unrelated { reason });
    let (Some(scene), Some(other)) = (stated(a, SCENE), stated(b, SCENE)) else {
        return Ok(());
    };
    if scene != other {
        let [scene, other] = [scene, other].map(short);
        return unrelated(format!(
            "they show different scenes ({SCENE} {scene} and {other}); compare pages baked from the same scene files"
        ));
    }
    if let (Some(page), Some(other)) = (stated(a, PAGE), stated(b, PAGE))
        && page != other
        && rest(a).eq(rest(b))
    {
        let [page, other] = [page, other].map(short);
        return unrelated(format!(
            "they are pages {page} and {other} of one bake and show different surfaces; compare pages of one number"
        ));
    }
    Ok(())
}

/// An attribute that says something.
fn stated<'a>(file: &'a PageFile, name: &str) -> Option<&'a str> {
    let value = file.attributes.get(name)?;
    (!value.is_empty()).then_some(value.as_str())
}

/// What ambake states of a page but its number.
fn rest(file: &PageFile) -> impl Iterator<Item = (&String, &String)> {
    let own = |(name, _): &(&String, &String)| name.starts_with("ambake") && *name != PAGE;
    file.attributes.iter().filter(own)
}

/// The beginning of a value that may be long: enough to tell two hashes apart.
fn short(value: &str) -> String {
    value.chars().take(12).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Page, PageLayer as Layer};

    fn file(attributes: &[(&str, &str)]) -> PageFile {
        let attributes = attributes.iter();
        PageFile {
            page: Page {
                size: 1,
                layers: vec![Layer::scalar("diffuse", vec![1.0])],
            },
            attributes: attributes
                .map(|(n, v)| ((*n).into(), (*v).into()))
                .collect(),
        }
    }

    #[test]
    fn pages_of_different_scenes_are_refused_and_foreign_ones_are_not() {
        let (a, b) = (file(&[(SCENE, "aa11")]), file(&[(SCENE, "bb22")]));
        let error = check_origin(&a, &b).expect_err("two scenes").to_string();
        assert!(error.contains("aa11") && error.contains("bb22"), "{error}");
        let silent = [file(&[]), file(&[(SCENE, "")])];
        for other in silent.iter().chain([&a]) {
            check_origin(&a, other).expect("nothing speaks against it");
            check_origin(other, &a).expect("nothing speaks against it");
        }
    }

    #[test]
    fn different_pages_are_refused_only_within_one_bake() {
        let page = |number, options| {
            file(&[
                (SCENE, "aa11"),
                (PAGE, number),
                ("ambakeOptions", options),
                ("owner", number),
            ])
        };
        let error = check_origin(&page("0", "{}"), &page("1", "{}"));
        let error = error.expect_err("two pages of one bake").to_string();
        assert!(error.contains("pages 0 and 1 of one bake"), "{error}");
        // An object baked alone lies on another page than in the whole.
        check_origin(&page("0", "{}"), &page("1", "{\"rays\":8}")).expect("two bakes");
        check_origin(&page("1", "{}"), &page("1", "{\"rays\":8}")).expect("one page");
    }
}
