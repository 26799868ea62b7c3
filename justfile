# What a developer runs. `just` lists it; CONTRIBUTING.md has the times. Each recipe is a line that one can also type.

# Format, counts and lints: no comma is told late
lint:
    cargo fmt --all --check
    .ci/count --check
    .ci/lint
    cargo clippy --workspace --all-targets -- -D warnings
    cargo real-clippy -- -D warnings

# All tests of the pure crates
quick:
    cargo fmt --all --check
    cargo test -p webloop-control -p webloop-endpoint -p webloop-link -p webloop-text -p webloop-plan -p webloop-judge -p webloop-record -p webloop-sim -p webloop-chart

# New cases of all property tests: as many of each as asked
laws cases="10000":
    PROPTEST_CASES={{cases}} cargo test --workspace --release --lib --test all --no-fail-fast

# Real runs in network namespaces
net:
    cargo test -p webloop-shaper --test namespaces
    cargo test -p webloop --test runs --test sabotage
    cargo test -p webloop-bench --test runs

# The page in both browsers, and Python's own tests
browsers:
    cargo test -p webloop-browser --test browser
    cargo test -p webloop-python --test loopback --test package

# Containers, with images of this tree
containers:
    for client in native python chromium firefox; do CLIENT=$client docker compose build || exit; done
    cargo test -p webloop --test containers

# The book: its links, commands, tables and reference
book:
    cargo test -p webloop --test command book

# What the house is made of, held against .ci/count.csv: `just count --write` keeps what fell, and what has a new reason
count *words="--check":
    .ci/count {{words}}

# Instructions of what a message passes through, held against those kept: `just instructions --write` keeps these
instructions *words:
    .ci/instructions {{words}}

# Webloop beside its limits and its peers, in about nine minutes: `just bench step tick --times 9` is two tables
bench *words:
    cargo build --release
    cargo run --release -p webloop-bench -- {{words}}

# Measures what docs/reliability.md says, row by row: all in some hours, or `just faults 5 17`
faults *rows:
    cargo test --release -p webloop --test reliability -- --measure {{rows}}

# All of it, as CI has it
all: lint
    cargo test --workspace
    cargo real

# What is made from types and help texts: schemas and the book's reference
write:
    WEBLOOP_TEST_WRITE=1 cargo test -p webloop-plant -p webloop-record -p webloop-backend -p webloop-plan -p webloop --lib --test kept --test settings --test all --test command
