use super::*;
use crate::map;

fn job(file: &str, typed: &str) -> anyhow::Result<ambake::flags::bake::Job> {
    let table: Table = file.parse().expect("TOML");
    let typed = format!("ambake bake folder/hall.glb -o out {typed}");
    let typed: Vec<OsString> = typed.split_whitespace().map(OsString::from).collect();
    let path = Path::new("folder/ambake.toml");
    let args = with_flags(&typed, |typed| {
        flags(path, &table, Path::new("folder/hall.glb"), ("bake", typed))
    })?;
    match args.verb {
        Verb::Bake(bake) => Ok(bake.job),
        _ => unreachable!("bake was typed"),
    }
}

#[test]
fn typed_flags_win_over_the_scene_and_the_scene_over_the_folder() {
    let file = "[bake]\nsize = 64\nrays = 8\nlayers = ['bent', 'normal']\nnormal-maps = true\nsky = [1, 0.5, 0.25]\n\
        [scene.'hall.glb']\nsize = 128\n[scene.'other.glb']\nsize = 256\n[object.'wall*']\ndensity = 20\n\
        exclude = false\ncast = false\nburied = 'keep'";
    let plain = job(file, "").unwrap();
    assert_eq!((plain.size, plain.rays, plain.layers.len()), (128, 8, 2));
    assert!(plain.normal_maps);
    assert_eq!(plain.density_of, [("wall*".to_owned(), 20.0)]);
    assert_eq!(plain.no_cast, ["wall*"]);
    assert_eq!(plain.buried_of.len(), 1);
    assert!(plain.buried_of[0].0 == "wall*" && plain.buried_of[0].1 == ambake::Buried::Keep);
    let typed = job(file, "--size 32 --target-error 0.1 --density-of door=4").unwrap();
    assert_eq!((typed.size, typed.target_error), (32, Some(0.1)));
    assert_eq!(typed.density_of.len(), 2, "later ones win, so both stand");
    assert_eq!(typed.density_of[1].0, "door");
}

#[test]
fn verbs_with_a_table_of_their_own_take_theirs_alone_and_it_may_hold_what_is_required() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = "[bake]\nsize = 64\n[probes]\nspacing = 2\nrays = 128\noutput = 'x'\n[scene.'hall.glb'.probes]\n\
        rays = 256\nbake = 'baked'\n\
        [render]\nsize = '32x16'";
    let write =
        |text: &str| std::fs::write(folder.path().join(PROJECT_FILE), text).expect("written");
    std::fs::create_dir(folder.path().join("baked")).expect("a folder");
    let words = |verb: &str, more: &str| -> Vec<OsString> {
        let scene = folder.path().join("hall.glb");
        let words = ["ambake".into(), verb.into(), scene.into_os_string()].into_iter();
        words
            .chain(more.split_whitespace().map(OsString::from))
            .collect()
    };
    write(file);
    let error = with_own_table(words("probes", "-o out")).expect_err("the scene is absent");
    assert!(format!("{error:#}").contains("[scene.\"hall.glb\"] names no file"));
    std::fs::write(folder.path().join("hall.glb"), "").expect("written");
    write(file);
    let error = with_own_table(words("probes", "-o out")).expect_err("output is typed");
    assert!(format!("{error:#}").contains("`output` in [probes] belongs to one run"));
    write(&file.replace("output = 'x'", ""));
    let probes = |more: &str| match Args::of(with_own_table(words("probes", more))?)?.verb {
        Verb::Probes(probes) => anyhow::Ok(probes.job),
        _ => unreachable!("probes was typed"),
    };
    let plain = probes("-o out").expect("all that is required");
    assert_eq!((plain.spacing, plain.rays), (Some(2.0), 256));
    assert_eq!(plain.bake, Some(folder.path().join("baked")));
    // Places and numbers of rays are of one kind or another.
    let typed = probes("-o out --at 0,1,0 --target-error 0.1").expect("all that is required");
    assert_eq!((typed.spacing, typed.at.len(), typed.rays), (None, 1, 1024));
    assert!(
        with_own_table(words("render", ""))
            .expect("words")
            .contains(&"--size=32x16".into())
    );
    let untouched = words("view", "");
    assert_eq!(with_own_table(untouched.clone()).expect("words"), untouched);
}

#[test]
fn verbs_that_read_a_folder_or_a_picture_take_the_table_of_the_file_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = "[export]\nfor = ['three', 'godot']\ncompress = true\n[view]\nno-open = true\n\
        [map.specular]\nexponent = [4, 16]\n[map.capture]\nface = 32\n";
    let write = |text: &str| {
        std::fs::write(folder.path().join(PROJECT_FILE), text).expect("written");
    };
    write(file);
    let of = |typed: &str| {
        let place = |word: &str| match word.strip_prefix('@') {
            Some(name) => folder.path().join(name).into_os_string(),
            None => word.into(),
        };
        let words = typed.split_whitespace().map(place).collect();
        anyhow::Ok(Args::of(with_own_table(words)?)?.verb)
    };
    match of("ambake export @out/").expect("what is required stands in the file") {
        Verb::Export(export) => {
            assert_eq!(
                export.engines,
                [ambake::Engine::Three, ambake::Engine::Godot]
            );
            assert!(export.compress);
        }
        _ => unreachable!("export was typed"),
    }
    match of("ambake export @out --for bevy").expect("words") {
        Verb::Export(export) => {
            let third = export.engines.get(2);
            assert_eq!(third, Some(&ambake::Engine::Bevy), "lists add up");
        }
        _ => unreachable!("export was typed"),
    }
    assert!(matches!(of("ambake view @out"), Ok(Verb::View(view)) if view.no_open));
    let specular = "ambake map specular @sky.hdr -o map.exr";
    match of(specular).expect("words") {
        Verb::Map(map) => match *map {
            map::args::Args::Specular(own) => assert_eq!(own.exponent, [4.0, 16.0]),
            _ => unreachable!("map specular was typed"),
        },
        _ => unreachable!("map was typed"),
    }
    for (text, word) in [
        ("[export]\nfro = 3", "`fro` in [export]"),
        ("[map]\nsize = 3", "`size` stands in [map]"),
        ("[map.blur]\nsize = 3", "[map.blur]: there is no such verb"),
        ("[map.stats]\nexponent = 3", "ambake map stats --help"),
    ] {
        write(text);
        let error = of(specular).err().expect(text);
        assert!(format!("{error:#}").contains(word), "{text}: {error:#}");
    }
}

#[test]
fn objects_of_one_scene_are_named_below_it() {
    let file = "[object.wall]\ndensity = 20\n[scene.'hall.glb'.object.altar]\ndensity = 80\n\
        [scene.'other.glb'.object.door]\ndensity = 4";
    let found = job(file, "").unwrap().density_of;
    assert_eq!(
        found,
        [("wall".to_owned(), 20.0), ("altar".to_owned(), 80.0)]
    );
}

#[test]
fn what_is_wrong_is_one_line_that_names_the_place() {
    for (file, word) in [
        ("size = 64", "outside of a table"),
        ("[bake]\nsise = 64", "unknown option `sise` in [bake]"),
        ("[bake]\nsize = 0", "--size"),
        ("[bake]\nsize = 'big'", "--size"),
        ("[bake]\nsize = {}", "`size` in [bake]"),
        (
            "[bake]\noutput = 'x'",
            "`output` in [bake] belongs to one run",
        ),
        ("[scenes]\n", "unknown table [scenes]"),
        ("[scene]\nrays = 3", "`rays` stands in [scene]"),
        ("[object]\ndensity = 3", "`density` stands in [object]"),
        ("[bake]\nsun = [[1, 2, 3, 4]]", "a list of lists"),
        ("[scene.'other.glb']\nsise = 3", "in [scene.\"other.glb\"]"),
        ("[scene.'other.glb'.object.x]\ndensty = 3", "`densty = 3`"),
        ("[probes]\nsize = 4", "unknown option `size` in [probes]"),
        (
            "[scene.'hall.glb'.render]\nrais = 4",
            "in [scene.\"hall.glb\".render]",
        ),
        ("[object.wall]\nrays = 4", "[object.\"wall\"]"),
        (
            "[scene.'hall.glb'.object.wall]\nrays = 4",
            "[object.\"wall\"]",
        ),
        ("[scene.'hall.glb']\nobject = 3", "unknown option `object`"),
        ("[bake]\nlayers = []", "`layers` in [bake]"),
    ] {
        let Err(error) = job(file, "") else {
            panic!("{file} was taken");
        };
        let text = format!("{error:#}");
        assert!(
            text.contains(word) && !text.contains('\n'),
            "{file}: {text}"
        );
    }
}
