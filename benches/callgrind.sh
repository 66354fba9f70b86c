#!/usr/bin/env bash
# Counts the instructions that one sample costs in a lane's core, and in VQF as the peer, and fails
# above the budget of benches/budget.toml.
#
# Two runs make the same samples; one takes N of them, the other 2N. Their difference over N is the
# cost of a sample: start-up, and the making of the samples, cancel. The first N hold rest and
# alignment, so what is counted is an aligned filter.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly n=8000
readonly lane_steps="${CARGO_TARGET_DIR:-target}/release/lane-steps"

if ! command -v valgrind >/dev/null; then
    echo "skipped: valgrind is not installed (apt-get install valgrind)"
    exit 0
fi
cargo build --release --quiet -p lodestone-benches --bin lane-steps

# instructions SUBJECT MOTION TAKEN: instructions of a whole run.
instructions() {
    local said
    said=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null "$lane_steps" \
        --subject "$1" --motion "$2" --made $((2 * n)) --taken "$3" 2>&1) || {
        echo "$said" >&2
        return 1
    }
    sed -n 's/^==[0-9]*== Collected : \([0-9]*\)$/\1/p' <<<"$said"
}

# per_sample SUBJECT MOTION: instructions a sample.
per_sample() {
    local once twice
    once=$(instructions "$1" "$2" $n)
    twice=$(instructions "$1" "$2" $((2 * n)))
    echo $(((twice - once) / n))
}

budget() {
    sed -n "s/^$1 = \([0-9]*\).*/\1/p" benches/budget.toml
}

failed=0
printf '%-10s %20s %8s %18s %7s\n' motion 'lane, per sample' budget 'VQF, per sample' ratio
for motion in walk standing; do
    lane=$(per_sample lane "$motion")
    vqf=$(per_sample vqf "$motion")
    allowed=$(budget "$motion")
    ratio=$(awk "BEGIN { printf \"%.2f\", $lane / $vqf }")
    printf '%-10s %20d %8d %18d %7s\n' "$motion" "$lane" "$allowed" "$vqf" "$ratio"
    if ((lane > allowed)); then
        echo "$motion: $lane instructions per sample; benches/budget.toml allows $allowed" >&2
        failed=1
    fi
done
exit $failed
