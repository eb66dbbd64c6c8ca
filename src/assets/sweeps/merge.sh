#!/bin/sh
# Merge the shards of a sweep. If $1 is given, messages go to logs/$1. The files merge.arguments and shards.list in this
# folder contain the command and the shards, one argument per line.
cd -- "$(dirname -- "$0")" || exit 2
[ -n "$1" ] && exec >>"logs/$1" 2>&1
# Each line is one argument: no patterns, no other separators.
set -f
IFS='
'
# shellcheck disable=SC2046
set -- $(cat merge.arguments shards.list)
"$@"
code=$?
# 4: finished, but some rows are not done.
[ "$code" -eq 4 ] && exit 0
exit "$code"
