//! `ambake bench --stated`: stated errors beside true ones.

use super::args::Args;
use crate::host;
use crate::outcome::{Outcome, note, say, say_json};
use ambake::{Bake, Baked, Bounces, Denoise, Layer, Scene, Seams};
use bench::stated::{Judged, Row, markdown, scenes};
use report::Output;
use serde_json::json;

/// Rays of the truth for each ray of a judged bake, and the fewest.
const MORE: u32 = 16;
const LEAST: u32 = 4096;

/// What is judged, and the layer that states its error.
const TERMS: [(Layer, Layer); 4] = [
    (Layer::Diffuse, Layer::StdErrDiffuse),
    (Layer::Visibility, Layer::StdErrVisibility),
    (Layer::Irradiance, Layer::StdErrIrradiance),
    (Layer::Reflection, Layer::StdErrReflection),
];

/// Runs the mode, on one scene or on those of the seed.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let threads = host::set_threads(args.common.threads)?;
    let mut output = args.output.as_deref().map(Output::create).transpose()?;
    let made = match args.scene.as_deref() {
        Some(path) => {
            let scene = ambake::load_with(path, args.common.files())?;
            vec![(scene.stem(), scene)]
        }
        None => {
            let made = scenes(args.common.seed).into_iter();
            let made = made.map(|(name, meshes, materials)| {
                Ok((name.to_owned(), Scene::from_meshes(meshes, materials)?))
            });
            made.collect::<Result<_, ambake::Error>>()?
        }
    };
    let mut rows = Vec::new();
    for (name, scene) in &made {
        rows.extend(judged(args, name, scene)?);
        if !args.common.quiet {
            note(&format!("{name} is judged"));
        }
    }
    let mut table = markdown(&rows);
    table += &format!(
        "\nambake {}, seed {}, pages of {}, {threads} threads\n",
        host::VERSION,
        args.common.seed,
        args.job.size
    );
    if let Some(mut output) = output.take() {
        output.stage_bytes("stated.md", table.as_bytes())?;
        output.publish()?;
    }
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "seed": args.common.seed, "rows": rows }))?;
    } else {
        say(&table)?;
    }
    Ok(Outcome::Done)
}

/// A scene's rows: a quarter of the rays and all of them, against a plain bake of many rays with another seed and
/// without seams.
fn judged(args: &Args, name: &str, scene: &Scene) -> anyhow::Result<Vec<Row>> {
    let layers = TERMS.iter().flat_map(|&(term, error)| [term, error]);
    let baked = |rays: u32, change: fn(Bake, u64) -> Bake| -> anyhow::Result<Baked> {
        let mut job = args.job.clone();
        job.rays = rays;
        let bake = job.bake(scene, &args.common)?;
        let asked = layers.clone().chain([Layer::Validity, Layer::Coverage]);
        Ok(change(bake, args.common.seed).layers(asked).run(&())?)
    };
    let rays = args.job.rays;
    let truth = baked((rays * MORE).max(LEAST), |bake, seed| {
        let plain = bake.denoise(Denoise::Off).seams(Seams::Off);
        plain.seed(seed ^ 1 << 40)
    })?;
    // Under a uniform sky irradiance is the diffuse term.
    let is_even = args.job.sky.file().is_none() && args.job.bounces == Bounces::Off;
    let mut rows = Vec::new();
    for rays in [(rays / 4).max(1), rays] {
        let bake = baked(rays, |bake, _| bake)?;
        for (term, error) in TERMS {
            if is_even && term == Layer::Irradiance {
                continue;
            }
            let texels = texels(&bake, &truth, term, error);
            rows.push(Row::of(name, rays, term.name(), &texels));
        }
    }
    Ok(rows)
}

/// The texels that can be seen, by the mean over their channels.
fn texels(bake: &Baked, truth: &Baked, term: Layer, error: Layer) -> Vec<Judged> {
    let mut found = Vec::new();
    for (page, exact) in bake.pages().zip(truth.pages()) {
        let count = (page.size() as usize).pow(2);
        let mean = |values: &[f32], texel: usize| {
            let planes = values.chunks_exact(count);
            let many = planes.len().max(1) as f64;
            planes.map(|plane| f64::from(plane[texel])).sum::<f64>() / many
        };
        let [seen, covered] = [Layer::Validity, Layer::Coverage].map(|layer| exact.layer(layer));
        let texels = (0..count).filter(|&texel| seen[texel] > 0.0 && covered[texel] > 0.0);
        found.extend(texels.map(|texel| {
            let of = |page: &ambake::Page, layer| mean(page.layer(layer), texel);
            Judged {
                value: of(page, term),
                std_err: of(page, error),
                truth: of(exact, term),
                truth_err: of(exact, error),
            }
        }));
    }
    found
}
