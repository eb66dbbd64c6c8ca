#!/bin/sh
# Run shard $1 of a sweep for a cluster's scheduler. If $2 is given, messages go to logs/$2. The files run.arguments and
# shards.list in this folder contain the command and the shards, one argument per line.
# A shard continues where it stopped, so you can start this script again at any time.
cd -- "$(dirname -- "$0")" || exit 2
index=$1
[ -n "$2" ] && exec >>"logs/$2" 2>&1
shard=$(sed -n "${index}p" shards.list)
count=$(grep -c '' shards.list)
# Each line is one argument: no patterns, no other separators.
set -f
IFS='
'
# shellcheck disable=SC2046
set -- $(cat run.arguments)
child=
stopped=
stop() {
    stopped=yes
    [ -n "$child" ] && kill -TERM "$child"
}
trap stop TERM INT
attempt=1
while :; do
    "$@" --shard "$index/$count" --output "$shard" &
    child=$!
    wait "$child"
    code=$?
    if [ -n "$stopped" ]; then
        # The signal ended the first wait; running rows still finish.
        wait "$child"
        again=$?
        [ "$again" -ne 127 ] && code=$again
    fi
    case $code in
    0 | 4) exit 0 ;; # 4: some rows are not done, which is a result.
    5)
        # Time is up: back into the queue, where it is one.
        if [ -n "$SLURM_ARRAY_JOB_ID" ]; then
            scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
            exit 0
        fi
        exit 5
        ;;
    esac
    # Killed: what it had done is kept, so it goes on; five times, in case the rows themselves are the reason.
    if [ "$code" -le 128 ] || [ -n "$stopped" ] || [ "$attempt" -ge 5 ]; then
        exit "$code"
    fi
    attempt=$((attempt + 1))
    echo "shard $index was killed (exit code $code); attempt $attempt" >&2
done
