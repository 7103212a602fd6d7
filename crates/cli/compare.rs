//! `ambake compare` (being written).

/// Runs the verb.
pub fn run(_: &crate::args::Compare) -> anyhow::Result<crate::Outcome> {
    anyhow::bail!("not there yet")
}
