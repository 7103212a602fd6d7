#!/bin/bash
# Bakes a scene in PARTS parts on a Slurm cluster and merges them:
#
#     PARTS=8 integrations/slurm/submit.sh SCENE -o DIR [any flag of `ambake bake`]
#
# DIR and the scene lie on a file system that all nodes share. SBATCH_FLAGS (words) goes to both jobs, for a partition or an account;
# CPUS and MEMORY are those of one part. AMBAKE is the program, if it is not on the path. LAYOUT=0 leaves out the layout, which is made
# on this machine. Prints the numbers of the two jobs.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
parts=${PARTS:-}
[[ $parts =~ ^[1-9][0-9]*$ ]] || {
    echo "submit.sh: PARTS=N is missing, the number of parts" >&2
    exit 2
}

folder=
previous=
for word in "$@"; do
    case $previous in -o | --output) folder=$word ;; esac
    case $word in
        --output=*) folder=${word#--output=} ;;
        -o?*) folder=${word#-o} folder=${folder#=} ;;
    esac
    previous=$word
done
[ -n "$folder" ] || {
    echo "submit.sh: -o DIR is missing" >&2
    exit 2
}
mkdir -p "$folder"

# The layout is made once, here, and every part takes it from DIR. Without it each part makes the same one again.
if [ "${LAYOUT:-1}" = 1 ]; then
    "${AMBAKE:-ambake}" layout "$@" --quiet >&2
fi

# What the jobs print, above all why one failed. Slurm replaces what follows a percent sign.
logs=${folder//%/%%}/.slurm
flags=(--cpus-per-task="${CPUS:-1}" ${SBATCH_FLAGS:-})
[ -z "${MEMORY:-}" ] || flags+=(--mem="$MEMORY")
array=$(sbatch --parsable --output="$logs-%A-%a.log" "${flags[@]}" --array="1-$parts" "$here/bake.sbatch" "$folder" "$@")
array=${array%%;*}
merge=$(sbatch --parsable --output="$logs-%j.log" "${flags[@]}" --dependency="afterok:$array" --kill-on-invalid-dep=yes \
    "$here/merge.sbatch" "$folder") || {
    scancel "$array"
    exit 1
}
merge=${merge%%;*}
echo "$array $merge"
