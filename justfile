# `just` lists these; CI runs .ci/run, which is the same in one go.

# Everything CI checks.
ci:
    .ci/run

# Every test.
test:
    cargo test --workspace

# Formatting and lints.
lint:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --locked -- -D warnings

# What a sample costs in instructions, against the record.
step-cost:
    benches/callgrind.sh

# Latency beside every peer: some twelve minutes on a machine that does nothing else.
latency:
    cargo bench -p lodestone-benches --features zenoh --bench latency -- --html latency.html --json latency.json

# Licences, bans and sources of all dependencies (needs cargo-deny).
deny:
    cargo deny check licenses bans sources
