#!/bin/bash
# Bakes a scene in PARTS parts on a Slurm cluster and merges them:
#
#     PARTS=8 integrations/slurm/submit.sh SCENE -o DIR [any flag of `ambake bake`]
#
# DIR and the scene lie on a file system that all nodes share. SBATCH_FLAGS (words) goes to both jobs, for a partition or an account;
# CPUS and MEMORY are those of one part. AMBAKE is the program, if it is not on the path. Prints the numbers of the two jobs.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
parts=${PARTS:?PARTS is the number of parts}

folder=
previous=
for word in "$@"; do
    case $previous in -o | --output) folder=$word ;; esac
    case $word in --output=*) folder=${word#--output=} ;; esac
    previous=$word
done
[ -n "$folder" ] || {
    echo "submit.sh: -o DIR is missing" >&2
    exit 2
}
mkdir -p "$folder"

# The layout is made once, here, and every part takes it from DIR. Without it each part makes the same one again.
if [ "${LAYOUT:-1}" = 1 ]; then
    "${AMBAKE:-ambake}" layout "$@" --quiet
fi

flags=(--cpus-per-task="${CPUS:-1}" --output="$folder/.slurm-%A-%a.log" ${SBATCH_FLAGS:-})
[ -z "${MEMORY:-}" ] || flags+=(--mem="$MEMORY")
array=$(sbatch --parsable "${flags[@]}" --array="1-$parts" "$here/bake.sbatch" "$@")
merge=$(sbatch --parsable "${flags[@]}" --dependency="afterok:$array" --kill-on-invalid-dep=yes "$here/merge.sbatch" "$folder")
echo "$array $merge"
