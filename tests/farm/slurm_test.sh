#!/bin/bash
# An animation, and one frame in shards, by a Slurm of two nodes on this machine, of which one is taken down in the middle: every frame
# is there, and each is the file that one process renders. TAUT SCRATCH. Exit code 77: skipped, since there is no Slurm or no right.
# TAUT_PATIENCE=10 is for programs that sanitizers make slow: a tenth of the samples, and ten times as long for all that is waited for.
set -u
taut=$1
scratch=$2
patience=${TAUT_PATIENCE:-1}
project=$(cd "$(dirname "$0")/../.." && pwd)
for program in slurmctld slurmd munged sbatch scontrol squeue; do
    if ! PATH="$PATH:/usr/sbin" command -v $program > /dev/null; then
        echo "skipped: there is no $program (apt-get install slurm-wlm munge)"
        exit 77
    fi
done
if [ "$(id -u)" != 0 ]; then
    echo "skipped: slurmd wants to be root"
    exit 77
fi
export PATH="$PATH:/usr/sbin"
rm -rf "$scratch"
mkdir -p "$scratch/state" "$scratch/log" "$scratch/munge"
cd "$scratch" || exit 1

fail() {
    echo "FAILED: $*"
    tail -n 30 log/*.log "$scratch"/job/log/* 2> /dev/null
    exit 1
}
finish() {
    kill $(cat state/*.pid 2> /dev/null) $(jobs -p) 2> /dev/null
    sleep 0.5
    kill -9 $(cat state/*.pid 2> /dev/null) $(jobs -p) 2> /dev/null
    return 0
}
trap finish EXIT

# --- a cluster of its own -----------------------------------------------------------------------------------------------
chmod 711 . munge
dd if=/dev/urandom of=munge/key bs=1 count=1024 2> /dev/null
chmod 600 munge/key
munged --force --foreground --socket="$scratch/munge/socket" --key-file="$scratch/munge/key" --pid-file="$scratch/munge/pid" \
    --log-file="$scratch/log/munged.log" --seed-file="$scratch/munge/seed" 2> log/munged.err &
host=$(hostname -s)
port=$((20000 + RANDOM % 12000)) # below those that the system gives to clients
cat > slurm.conf << END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
AuthType=auth/munge
AuthInfo=socket=$scratch/munge/socket,cred_expire=5
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$scratch/state
SlurmdSpoolDir=$scratch/state/%n
SlurmctldPidFile=$scratch/state/slurmctld.pid
SlurmdPidFile=$scratch/state/slurmd.%n.pid
SlurmctldLogFile=$scratch/log/slurmctld.log
SlurmdLogFile=$scratch/log/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=sched_interval=2,bf_interval=2
SlurmdTimeout=10
KillWait=5
ReturnToService=2
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 RealMemory=1000 State=UNKNOWN
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF="$scratch/slurm.conf"
sleep 1
slurmctld -D -c > log/slurmctld.err 2>&1 &
for node in n1 n2; do
    mkdir -p state/$node
    slurmd -D -c -N $node > log/slurmd.$node.err 2>&1 &
    eval "$node=$!"
done
# Waits up to $1 seconds (times the patience) for a condition.
await() {
    local end=$((SECONDS + patience * $1))
    shift
    until eval "$*"; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.3
    done
}
await 120 '[ "$(sinfo -h -N -t idle 2> /dev/null | wc -l)" = 2 ]' || fail "no two idle nodes"

# --- the jobs -----------------------------------------------------------------------------------------------------------
mkdir -p job
cd job || exit 1
cat > scene.toml << END
[render]
width = 160
height = 120
spp = $((900 / patience))
frames = "1-24"
shutter = 0.5
[camera]
position = [0.1, -1.6, 1.8]
look_at = [0, 0, 0]
fov_deg = 45
[environment]
radiance = [0.5, 0.6, 0.7]
[material.brushed]
type = "conductor"
metal = "Al"
alpha = [0.1, 0.4]
[[mesh]]
file = "plate.obj"
material = "brushed"
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0.0], [24, 1.2]]
END
cp "$project/meshes/plate.obj" . || exit 1
one="--frames 12 --spp $((3000 / patience)) --aov m,depth"
"$taut" render scene.toml -o whole/f##.exr -q || fail "the local render"
"$taut" render scene.toml -o whole/one.exr $one -q || fail "the local render of one frame"
"$taut" farm scene.toml --slurm -o farm --image out/f##.exr || fail "taut farm"
"$taut" farm scene.toml --slurm -o farm_one --image out/one.exr --shards 8 --checkpoint 1s $one || fail "taut farm --shards"
for folder in farm farm_one; do ./$folder/submit.sh || fail "submit.sh"; done

# When something is done and the second node is in the middle of a task, which is held there, it is gone, and what ran on it.
# Of this cluster: another test of the kind may go on beside it.
is_of_n2() { [ "$(tr '\0' '\n' < /proc/"$1"/environ | grep -cxF -e SLURMD_NODENAME=n2 -e "SLURM_CONF=$SLURM_CONF")" = 2 ]; } 2> /dev/null
holds_a_task_of_n2() {
    local task
    for task in $(pgrep -x taut); do
        if is_of_n2 "$task"; then kill -STOP "$task" && held="$held $task"; fi
    done
    [ -n "$held" ]
}
parent_of() { ps -o ppid= -p "$1" | tr -d ' '; }
held=
await 300 '[ "$(ls out 2> /dev/null | grep -c "exr$")" -ge 3 ] && holds_a_task_of_n2' || fail "nothing is done"
squeue -h -t running -w n2
kill -9 $n2
for task in $held; do
    # From the top: the step would tell how its script ended, and a script how its task did.
    script=$(parent_of "$task")
    step=$(parent_of "$script")
    [ "$(ps -o comm= -p "$step")" = slurmstepd ] || fail "process $step above a task is no slurmstepd"
    kill -9 "$step" "$script" "$task"
done
for task in $(pgrep -x taut) $(pgrep -f slurm_script); do
    if is_of_n2 "$task"; then kill -9 "$task"; fi
done
scontrol update nodename=n2 state=down reason=gone
await 400 '[ -z "$(squeue -h)" ]' || { squeue; scontrol show jobs; fail "jobs that do not end"; }

for frame in $(seq -w 1 24); do cmp whole/f$frame.exr out/f$frame.exr || fail "frame $frame"; done
cmp whole/one.exr out/one.exr || fail "the merged frame"
again=$(grep -oE '(Started|Allocate) JobId=[0-9_]+' ../log/slurmctld.log | sed 's/.* //' | sort | uniq -d | wc -l)
[ "$again" -gt 0 ] || fail "nothing was started again"
echo "24 frames and one frame of eight shards are the same files as the local ones; $again tasks were started again"
