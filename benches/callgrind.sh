#!/usr/bin/env bash
# Counts the instructions that one sample costs in a lane's core, and in VQF as the peer, and fails
# if a sample costs 3 % more than the record in benches/budget.toml.
#
#   benches/callgrind.sh             compare with the record
#   benches/callgrind.sh --record    write what was counted as the new record
#
# Two runs make the same samples; one takes N of them, the other 2N. Their difference over N is the
# cost of a sample: start-up, and the making of the samples, cancel. The first N hold rest and
# alignment, so what is counted is an aligned filter.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly n=8000
readonly tolerance_percent=3
readonly budget=benches/budget.toml
readonly lane_steps="${CARGO_TARGET_DIR:-target}/release/lane-steps"

case "${1:-}" in
"" | --record) readonly asked="${1:-}" ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
if ! command -v valgrind >/dev/null; then
    echo "skipped: valgrind is not installed (apt-get install valgrind)"
    exit 0
fi
cargo build --release --quiet --locked -p lodestone-benches --bin lane-steps

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

# recorded MOTION: the record.
recorded() {
    local value
    value=$(sed -n "s/^$1 = \([0-9]*\).*/\1/p" "$budget")
    [ -n "$value" ] || {
        echo "$budget: no record of $1" >&2
        return 1
    }
    echo "$value"
}

failed=0
printf '%-10s %18s %8s %8s %18s %7s\n' motion 'lane, a sample' record change 'VQF, a sample' ratio
for motion in walk standing; do
    lane=$(per_sample lane "$motion")
    vqf=$(per_sample vqf "$motion")
    record=$(recorded "$motion")
    printf '%-10s %18d %8d %8s %18d %7s\n' "$motion" "$lane" "$record" \
        "$(awk "BEGIN { printf \"%+.1f %%\", 100 * ($lane / $record - 1) }")" "$vqf" \
        "$(awk "BEGIN { printf \"%.2f\", $lane / $vqf }")"
    if [ "$asked" = --record ]; then
        sed -i "s/^$motion = [0-9]*/$motion = $lane/" "$budget"
    elif ((lane * 100 > record * (100 + tolerance_percent))); then
        echo "$motion: a sample costs over $tolerance_percent % more than recorded: find out why, or" \
            "record it with a reason (benches/callgrind.sh --record)" >&2
        failed=1
    elif ((lane * 100 < record * (100 - tolerance_percent))); then
        echo "$motion: a sample has become over $tolerance_percent % cheaper: record it, so that it" \
            "stays so (benches/callgrind.sh --record)"
    fi
done
exit $failed
