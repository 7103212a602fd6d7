//! `ambake completions` and `ambake man`: made from the same table of arguments as the help.

use crate::args::{Args, Completions, Man};
use crate::outcome::{Outcome, say};
use report::Output;

/// Prints the completions of a shell.
pub fn completions(args: &Completions) -> anyhow::Result<Outcome> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Args::grammar(), "ambake", &mut text);
    say(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Done)
}

/// Prints the manual page, or writes that of every verb into a directory.
pub fn pages(args: &Man) -> anyhow::Result<Outcome> {
    let mut command = Args::grammar();
    command.build();
    let Some(dir) = &args.output else {
        say(&String::from_utf8_lossy(&page(&command)?))?;
        return Ok(Outcome::Done);
    };
    let mut output = Output::create(dir)?;
    let mut waiting = vec![("ambake".to_owned(), command)];
    while let Some((name, command)) = waiting.pop() {
        let verbs = command
            .get_subcommands()
            .filter(|verb| verb.get_name() != "help");
        waiting.extend(verbs.map(|verb| (format!("{name}-{}", verb.get_name()), verb.clone())));
        output.stage_bytes(&format!("{name}.1"), &page(&command)?)?;
    }
    output.publish()?;
    Ok(Outcome::Done)
}

/// One page in troff.
fn page(command: &clap::Command) -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut text)?;
    Ok(text)
}
