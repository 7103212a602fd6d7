//! `ambake layout`: the atlas alone.

use super::args::LayoutArgs as Args;
use crate::args::{Verb, words};
use crate::outcome::{Outcome, say, say_json};
use crate::progress::{count, square};
use crate::{host, project};
use report::Output;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let _folder = Output::create(&args.output)?.folder();
    let completed = project::completed(&args.scene, &words())?;
    let args = match &completed {
        Some(Verb::Layout(layout)) => layout,
        _ => args,
    };
    host::set_threads(args.common.threads)?;
    let scene = ambake::load_with(&args.scene, args.common.files())?;
    let layout = args.job.bake(&scene, &args.common)?.lay_out()?;
    let files = layout.write(&args.output)?;
    if args.common.json {
        say_json(&layout.describe())?;
    } else if !args.common.quiet {
        let atlas = layout.atlas();
        say(&format!(
            "{} of {}, {} texels, layout {}\n{}{} files in {}\n",
            count(atlas.page_count, "page"),
            square(atlas.page_size),
            atlas.audit.texels,
            layout.hash(),
            layout.report().text(),
            files.len(),
            args.output.display(),
        ))?;
    }
    Ok(Outcome::Done)
}
