//! The shell commands of a Markdown page.
//!
//! Every line of a block fenced as `sh`, `bash` or `shell` is a command; in an indented block, or one fenced without a
//! label, only a line that begins with `ambake `. `<!-- not run: REASON -->` directly above a block leaves it out.

/// A command of a page, and what becomes of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// The line of the page on which it starts, from 1.
    pub line: usize,
    /// As the page gives it; continued lines are joined.
    pub text: String,
    /// Why it is not run, where the page or a rule says so.
    pub skipped: Option<String>,
}

/// The commands of `page` in order.
///
/// # Errors
///
/// A line and what is wrong there: a block that is never closed, or a comment `not run` without a reason or a block.
pub fn commands(page: &str) -> Result<Vec<Command>, String> {
    let lines: Vec<&str> = page.lines().collect();
    let (mut found, mut at) = (Vec::new(), 0);
    // The comment that still waits for its block: its line and its reason.
    let mut waiting: Option<(usize, String)> = None;
    // An indented line below a line of text belongs to its paragraph.
    let mut below_text = false;
    while at < lines.len() {
        let start = at;
        let in_paragraph = std::mem::take(&mut below_text);
        let trimmed = lines[at].trim_start();
        if trimmed.is_empty() {
            at += 1;
        } else if trimmed.starts_with("<!--") {
            at = end(&lines, start, |line| line.contains("-->"), "comment")? + 1;
            if let Some(reason) = reason(&lines[start..at].join(" ")) {
                if reason.is_empty() {
                    let form = "<!-- not run: REASON -->";
                    return Err(format!("line {}: write {form}", start + 1));
                }
                waiting = Some((start, reason));
            }
        } else if let Some((fence, label)) = fence(trimmed) {
            let closes = |line: &str| {
                let line = line.trim();
                line.len() >= fence.len() && line.chars().all(|c| fence.starts_with(c))
            };
            let close = end(&lines, start + 1, closes, "fenced block")?;
            let all = ["sh", "bash", "shell"].contains(&label);
            if all || label.is_empty() {
                let body = (start + 1..close).map(|k| (k + 1, lines[k].trim()));
                let why = waiting.as_ref().map(|(_, reason)| reason.as_str());
                found.extend(of_block(body, all, why));
            }
            (waiting, at) = (None, close + 1);
        } else if indented(lines[at]) && !in_paragraph {
            let inside = |line: &&&str| line.trim().is_empty() || indented(line);
            at += lines[start..].iter().take_while(inside).count();
            let body = (start..at).map(|k| (k + 1, lines[k].trim()));
            let why = waiting.as_ref().map(|(_, reason)| reason.as_str());
            found.extend(of_block(body, false, why));
            waiting = None;
        } else if let Some((line, _)) = waiting {
            return Err(format!(
                "line {}: this comment stands above no block",
                line + 1
            ));
        } else {
            (at, below_text) = (at + 1, true);
        }
    }
    match waiting {
        Some((line, _)) => Err(format!(
            "line {}: this comment stands above no block",
            line + 1
        )),
        None => Ok(found),
    }
}

/// The first line from `start` on that ends what began before it.
fn end(
    lines: &[&str],
    start: usize,
    ends: impl Fn(&str) -> bool,
    what: &str,
) -> Result<usize, String> {
    let found = lines[start..].iter().position(|line| ends(line));
    found
        .map(|k| start + k)
        .ok_or(format!("line {}: the {what} is never closed", start.max(1)))
}

/// What a comment `<!-- not run: REASON -->` says; empty where it says nothing.
fn reason(comment: &str) -> Option<String> {
    let text = comment.trim_start().strip_prefix("<!--")?;
    let text = text.split("-->").next()?.trim();
    let rest = text.strip_prefix("not run")?;
    Some(rest.trim_start_matches(':').trim().to_owned())
}

/// The fence and the label of a line that opens a fenced block.
fn fence(line: &str) -> Option<(&str, &str)> {
    let mark = ["`", "~"].into_iter().find(|mark| line.starts_with(mark))?;
    let length = line.len() - line.trim_start_matches(mark).len();
    let label = line[length..].split_whitespace().next().unwrap_or("");
    (length >= 3).then_some((&line[..length], label))
}

fn indented(line: &str) -> bool {
    line.starts_with("    ") || line.starts_with('\t')
}

/// The commands of one block, given as numbered lines: all of them, or those of ambake alone.
fn of_block<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    all: bool,
    why: Option<&str>,
) -> Vec<Command> {
    let mut found: Vec<Command> = Vec::new();
    let mut goes_on = false;
    for (line, text) in lines {
        if goes_on && let Some(last) = found.last_mut() {
            last.text = format!("{} {text}", last.text.trim_end_matches('\\').trim_end());
        } else if text.is_empty() || text.starts_with('#') || !(all || text.starts_with("ambake "))
        {
            continue;
        } else {
            found.push(Command {
                line,
                text: text.to_owned(),
                skipped: None,
            });
        }
        goes_on = ["\\", "|", "&&"].iter().any(|mark| text.ends_with(mark));
    }
    for command in &mut found {
        command.skipped = why.map(str::to_owned).or_else(|| rule(&command.text));
    }
    found
}

/// Why a command is never run by a test: it installs packages or builds.
fn rule(text: &str) -> Option<String> {
    let simple = text.split(['&', '|', ';']);
    let program = |command: &str| {
        let mut words = command.split_whitespace();
        words
            .find(|word| *word != "sudo" && !word.contains('='))
            .map(str::to_owned)
    };
    simple
        .filter_map(program)
        .find(|program| ["apt-get", "apt", "cargo"].contains(&program.as_str()))
        .map(|program| format!("by rule, {program} is not run"))
}

#[cfg(test)]
mod tests {
    use super::{Command, commands};

    const SAMPLE: &str = r#"# A page

Inline `ambake doctor` is no command, and an indented line
    ambake goes on with the paragraph, so it is none either.

<!-- first-command -->
```sh
sudo apt-get update && sudo apt-get install -y g++
AMBAKE_NO_EMBREE=1 cargo build --release
# A comment, then a command on two lines.
ambake bake scenes/a.obj -o out \
    --size 64

ambake map stats a.hdr |
  head -1
```

    ambake plan a.obj
    what it prints is no command

    ambake compare out

1. A list:

   ~~~bash
   ls "out"
   ~~~

<!-- not run: it needs
a camera -->

```shell
map-a-photo
ambake map ball photo.jpg -o a.exr
```

```
ambake doctor
Embree 4.3.3
```

```toml
ambake = "0.1"
```

<!-- not run: no such file -->
<!-- another comment -->
    ambake bake b.obj -o out
"#;

    #[test]
    fn every_command_is_found_once_where_it_stands() {
        let rule = |program: &str| Some(format!("by rule, {program} is not run"));
        let camera = || Some("it needs a camera".to_owned());
        let expected = [
            (
                8,
                "sudo apt-get update && sudo apt-get install -y g++",
                rule("apt-get"),
            ),
            (9, "AMBAKE_NO_EMBREE=1 cargo build --release", rule("cargo")),
            (11, "ambake bake scenes/a.obj -o out --size 64", None),
            (14, "ambake map stats a.hdr | head -1", None),
            (18, "ambake plan a.obj", None),
            (21, "ambake compare out", None),
            (26, "ls \"out\"", None),
            (33, "map-a-photo", camera()),
            (34, "ambake map ball photo.jpg -o a.exr", camera()),
            (38, "ambake doctor", None),
            (
                48,
                "ambake bake b.obj -o out",
                Some("no such file".to_owned()),
            ),
        ];
        let expected = expected.map(|(line, text, skipped)| Command {
            line,
            text: text.to_owned(),
            skipped,
        });
        let found = commands(SAMPLE).expect("a sound page");
        assert_eq!(found, expected, "{found:#?}");
    }

    #[test]
    fn a_page_that_hides_its_commands_is_refused() {
        for (page, words) in [
            ("text\n```sh\nambake doctor\n", "line 2: the fenced block"),
            ("<!-- not run: why\n", "line 1: the comment"),
            ("\n<!-- not run -->\n```sh\nls\n```\n", "line 2: write"),
            (
                "<!-- not run: why -->\nText.\n```sh\nls\n```\n",
                "line 1: this",
            ),
            ("<!-- not run: why -->\n", "line 1: this comment"),
        ] {
            let error = commands(page).expect_err("it is refused");
            assert!(error.starts_with(words), "{page:?}: {error}");
        }
    }
}
