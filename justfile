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

# Licences, bans and sources of all dependencies (needs cargo-deny).
deny:
    cargo deny check licenses bans sources
