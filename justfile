# Everyday commands. `just` lists them; each line below also works when typed by hand.

# lists the commands
default:
    @just --list

# the program, optimised, in target/release/ambake
build:
    cargo build --release --locked

# every test
test:
    cargo test --workspace --locked

# the tests of one package whose names contain NAME: `just one ambake-rays tree`
one package name="":
    cargo test --locked -p {{ package }} {{ name }}

# formatting, lints of every target, licences and sources of dependencies
lint:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --locked -- -D warnings
    cargo deny --locked check licenses bans sources

# the documentation of every crate, in target/doc
docs:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked

# speed against error of a scene, in DIR
bench scene="scenes/courtyard.obj" dir="out/bench":
    cargo run --release --locked --features bench -- bench {{ scene }} -o {{ dir }}

# the authored scenes, written anew; git shows what changed
scenes:
    python3 scenes/generate.py
    git status --short scenes

# the tables of flags in docs/flags.md and in the stubs of Python, written anew; git shows what changed
tables:
    AMBAKE_WRITE_TABLES=1 cargo test --locked --bin ambake tables
    git status --short docs integrations

# the files of a release, in target/dist
release:
    .ci/release

# all that a change must pass; installs what it needs
ci:
    .ci/run
