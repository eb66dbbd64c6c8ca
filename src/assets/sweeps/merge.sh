#!/bin/sh
# Merges the shards of a sweep; messages go to logs/$1 where that is given. What is merged stands in the files beside:
# merge.arguments and shards.list, an argument a line.
cd -- "$(dirname -- "$0")" || exit 2
[ -n "$1" ] && exec >>"logs/$1" 2>&1
# Lines become arguments as they are: no patterns, no other separators.
set -f
IFS='
'
# shellcheck disable=SC2046
set -- $(cat merge.arguments shards.list)
"$@"
code=$?
# 4: some rows are not done, which is a result.
[ "$code" -eq 4 ] && exit 0
exit "$code"
