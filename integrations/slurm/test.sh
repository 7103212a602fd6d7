#!/bin/bash
# Runs submit.sh on a cluster of one node that this script starts from Debian's packages (slurmctld, slurmd, slurm-client) and stops
# again. One task is cancelled, so there must be no merge, and one is killed in the middle and requeued. Submitted again, the result
# must be the bytes of a plain bake.
#
#     integrations/slurm/test.sh [SCENE [flags of `ambake bake`]]
#
# AMBAKE is the program, else target/debug/ambake. WAIT is how many seconds each submission may take (100). Needs root, as slurmd does,
# and touches no configuration of the system.
# With AMBAKE_TEST_STRICT=1 what is skipped has failed.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
AMBAKE=$(realpath "${AMBAKE:-$root/target/debug/ambake}")
export AMBAKE

skip() {
    echo "skip: $*"
    [ "${AMBAKE_TEST_STRICT:-}" != 1 ] || exit 1
    exit 0
}
for program in slurmctld slurmd sbatch scontrol squeue srun; do
    command -v "$program" >/dev/null || skip "$program is absent: apt-get install slurmctld slurmd slurm-client"
done
[ "$(id -u)" = 0 ] || skip "slurmd needs root"
[ -x "$AMBAKE" ] || skip "$AMBAKE is absent: cargo build --locked"

work=$(mktemp -d)
daemons=()
finish() {
    for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
    wait 2>/dev/null || true
    rm -rf "$work"
}
trap finish EXIT

if [ $# -gt 0 ]; then
    scene=$(realpath "$1")
    shift
else
    scene=$root/scenes/courtyard.obj
    set -- --size 256 --rays 256
fi

mkdir "$work/state" "$work/spool"
cpus=$(nproc)
memory=$(awk '/^MemTotal/ { print int($2 / 1024) }' /proc/meminfo)
cat >"$work/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
ReturnToService=2
MinJobAge=600
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld -D >"$work/ctld.out" 2>&1 &
daemons+=($!)
slurmd -D >"$work/slurmd.out" 2>&1 &
daemons+=($!)
up() { sinfo -h -o %T 2>/dev/null | grep -qE "idle|mixed"; }
for _ in $(seq 60); do
    up && break
    sleep 0.5
done
up || { tail -n 5 "$work"/*.out "$work"/*.log; skip "slurmd does not start here"; }

"$AMBAKE" bake "$scene" -o "$work/whole" --quiet "$@"

# A folder with a space, and what Slurm would replace in the name of a log.
parts="$work/the parts %j"
submit() {
    jobs=$(PARTS=4 "$here/submit.sh" "$scene" -o "$parts" "$@")
    echo "submitted: $jobs"
    array=${jobs% *}
    merge=${jobs#* }
}
# Waits until both jobs have ended, and kills task $1 while it runs, as by a lost node: it goes back into the queue.
killed=no
ended() {
    for _ in $(seq $((2 * ${WAIT:-100}))); do
        if [ "$killed" = no ] && squeue -h -t R -o %i | grep -q "^${array}_$1$"; then
            sleep "${KILL_AFTER:-1}"
            scontrol requeue "${array}_$1" && killed=yes
        fi
        [ -n "$(squeue -h -t PD,R,CG,CF -j "$array,$merge" 2>/dev/null)" ] || break
        # A requeued task waits two minutes by default.
        scontrol update "JobId=${array}_$1" StartTime=now 2>/dev/null || true
        sleep 0.5
    done
    state=$(scontrol show job "$merge" | grep -o "JobState=[A-Z]*")
}
failed() {
    echo "$*"
    tail -n 20 "$parts"/.slurm*
    exit 1
}

# Without task 4 there is no merge, and nothing of a result.
submit "$@"
scancel "${array}_4"
ended 2
restarts=$(scontrol show job "${array}_2" | grep -o "Restarts=[0-9]*" || true)
echo "merge: $state, task 2: $restarts, killed: $killed"
[ "$state" = JobState=CANCELLED ] || failed "the merge ran without part 4"
[ ! -e "$parts/bake.json" ] || failed "there is a result without part 4"

# Submitted again, what is done stays.
submit "$@"
ended 2
echo "merge: $state"
[ "$state" = JobState=COMPLETED ] || failed "no merge"

rm -f "$parts"/.slurm*.log "$parts"/layout.json "$parts"/*.layout "$parts"/*.layout.png
different=$(diff -rq -x bake.json "$work/whole" "$parts" || true)
[ -z "$different" ] || { echo "$different"; exit 1; }
echo "ok: the bytes of a plain bake ($(find "$parts" -type f | wc -l) files)"
