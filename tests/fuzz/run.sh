#!/bin/sh
# Fuzzes the harnesses one after the other, for FUZZ_SECONDS (60) or FUZZ_RUNS each, from their seeds and what earlier runs found, and
# prints a table. FUZZ_HARNESSES: some of them; FUZZ_TIMEOUT: more than the ten seconds that an input may take, on a busy machine. A
# finding is a file in CRASHES/HARNESS, and exit code 1. docs/limits.md says the rest.
#   run.sh BUILD CORPORA CRASHES
set -u
build=$1
corpora=$2
crashes=$3
here=$(dirname "$0")
seeds=$corpora/seeds
names=$("$build/taut_fuzz_replay" --seeds "$seeds") || exit 1
status=0
printf '%-12s %12s %8s %8s %8s\n' harness executions edges features findings
for name in ${FUZZ_HARNESSES:-$names}; do
    mkdir -p "$corpora/$name" "$crashes/$name"
    case $name in
    mdd) words=pc2 ;;
    restore | saved) words=film ;;
    png | environment) words=image ;;
    scene | writers) words=toml ;;
    *) words=$name ;;
    esac
    dictionary=$here/dictionaries/$words.dict
    limit=${FUZZ_RUNS:+-runs=$FUZZ_RUNS}
    log=$corpora/$name.log
    # An allocation beyond the limit that docs/limits.md names is a finding, and so is an input that takes ten seconds.
    TAUT_FUZZ_HARNESS=$name ASAN_OPTIONS=quarantine_size_mb=32 "$build/taut_fuzz" ${limit:--max_total_time=${FUZZ_SECONDS:-60}} \
        -timeout="${FUZZ_TIMEOUT:-10}" -report_slow_units="${FUZZ_TIMEOUT:-10}" -malloc_limit_mb=1000 -rss_limit_mb=1500 -max_len=8192 \
        -print_final_stats=1 -artifact_prefix="$crashes/$name/" \
        $([ -f "$dictionary" ] && echo "-dict=$dictionary") "$corpora/$name" "$seeds/$name" $([ -d "$here/regressions/$name" ] && echo "$here/regressions/$name") >"$log" 2>&1 ||
        status=1
    runs=$(sed -n 's/^stat::number_of_executed_units: //p' "$log")
    last=$(grep ' cov: ' "$log" | tail -1)
    edges=$(echo "$last" | sed -n 's/.* cov: \([0-9]*\).*/\1/p')
    features=$(echo "$last" | sed -n 's/.* ft: \([0-9]*\).*/\1/p')
    printf '%-12s %12s %8s %8s %8s\n' "$name" "${runs:-0}" "${edges:-0}" "${features:-0}" "$(ls "$crashes/$name" | wc -l)"
done
exit $status
