#!/bin/bash
# Runs a batch on a private Slurm cluster of three nodes on this machine, with faults, and compares
# every output with that of a run without Slurm:
#   slurm_test.sh NACRE [SCANS]   (a folder of scans, encoded with cheap options; default: made here)
# Faults: a node loses its power in the middle of a shard; another is cut off and its shard is given
# to a third while the first copy still runs; a shard is told to stop (75) and goes on; the controller
# is killed and started again. Nothing of the machine's own Slurm is read or changed. Leaves with 77,
# "skipped", where Slurm cannot be installed or run. All of it together may take NACRE_SLURM_SECONDS
# (default 220, some 80 on an idle machine of two cores): whatever is waited for, it is waited for
# until then, so that a busy machine fails nothing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
nacre=$(realpath "$1")
scans=${2:+$(realpath "$2")}

skip() {
  echo "SKIPPED: $1"
  exit 77
}
if [ -z "${NACRE_SLURM_INSIDE:-}" ]; then
  [ "$(id -u)" -eq 0 ] || skip "a private Slurm cluster needs root"
  for program in slurmctld slurmd sbatch munged; do
    command -v $program >/dev/null && continue
    timeout 120 "$here/install-packages.sh" slurm-wlm munge >/dev/null 2>&1 ||
      skip "Slurm cannot be installed here (Debian: apt-get install slurm-wlm munge)"
    break
  done
  # All goes on in a process namespace, so that nothing of it can outlive this script, and under the
  # name localhost, whatever address this machine's own name has.
  inside=(unshare --uts --pid --fork --kill-child --mount-proc)
  "${inside[@]}" unshare --pid --fork --kill-child --mount-proc hostname localhost 2>/dev/null ||
    skip "no process namespaces here (a container without the right to make them)"
  getent ahostsv4 localhost | grep -q '^127\.' || skip "localhost does not mean 127.x here"
  NACRE_SLURM_INSIDE=$SECONDS exec "${inside[@]}" "$0" "$nacre" ${scans:+"$scans"}
fi
hostname localhost
fail() {
  echo "slurm_test: FAILED: $1" >&2
  [ -z "${dir:-}" ] || {
    timeout 10 scontrol show job
    timeout 10 scontrol show node
    tail -n 40 "$dir"/log/*.log "$dir"/jobs/*.log "$dir"/jobs/*.out
  } >&2 || true
  exit 1
}

dir=$(mktemp -d /tmp/nacre-slurm-XXXXXX)
chmod 755 "$dir"
mkdir -p "$dir"/{state,log,munge,jobs}
chmod 700 "$dir/munge"
export SLURM_CONF=$dir/slurm.conf
pids=()
controller=""
cleanup() {
  scancel --user root >/dev/null 2>&1 || true
  for pid in "${pids[@]}" $controller; do kill -KILL "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$dir"
}
trap cleanup EXIT

SECONDS=$NACRE_SLURM_INSIDE # what the installation took counts as well
deadline=${NACRE_SLURM_SECONDS:-220}
say() { echo "$SECONDS s: $*"; }
until_true() { # WHAT COMMAND...
  local what=$1
  shift
  until "$@"; do
    [ "$SECONDS" -lt "$deadline" ] || fail "waited in vain for: $what"
    sleep 0.2
  done
}

# --- the cluster: everything listens on 127.0.0.1 only -------------------------------------------
# Each node claims six processors, so that the last one left can take all shards at once.
nodes=3
memory=$(awk -v n=$nodes '/MemTotal/ { print int($2 / 1024 * 0.8 / n) }' /proc/meminfo)
base=$((20000 + RANDOM % 12000)) # below the ports that connections get
(umask 077 && dd if=/dev/urandom of="$dir/munge/key" bs=128 count=1 status=none)
cat >"$SLURM_CONF" <<CONF
ClusterName=nacretest
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$base
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge/sock
CredType=cred/munge
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/state/%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/%n.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
JobCompType=jobcomp/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=8
KillWait=5
SlurmdParameters=config_overrides
CONF
for i in $(seq $nodes); do
  mkdir -p "$dir/state/n$i"
  echo "NodeName=n$i NodeHostname=localhost NodeAddr=127.0.0.1 Port=$((base + i)) CPUs=6 RealMemory=$memory"
done >>"$SLURM_CONF"
echo "PartitionName=scan Nodes=n[1-$nodes] Default=YES LLN=YES MaxTime=INFINITE State=UP" >>"$SLURM_CONF"

munged --foreground --force --socket="$dir/munge/sock" --key-file="$dir/munge/key" \
  --pid-file="$dir/munge/pid" --log-file="$dir/munge/log" --seed-file="$dir/munge/seed" \
  >/dev/null 2>&1 &
pids+=($!)
start_controller() { # slurmctld [-c]
  slurmctld -D "$@" >/dev/null 2>&1 &
  controller=$!
}
start_node() { # each in a process namespace of its own: one kill is a power cut
  unshare --pid --fork --kill-child --mount-proc slurmd -D -N "n$1" >/dev/null 2>&1 &
  node_pid[$1]=$!
  pids+=($!)
}
idle_nodes() { sinfo -h -N -t idle -o %N 2>/dev/null | wc -l; }
until_true "munge" test -S "$dir/munge/sock"
start_controller -c
declare -a node_pid
for i in $(seq $nodes); do start_node "$i"; done
all_idle() { [ "$(idle_nodes)" -eq $nodes ]; }
until_true "three idle nodes" all_idle
say "three nodes are up"

# --- the batch, without and with Slurm -------------------------------------------------------------
# Wavy tori of a few hundred triangles, two dozen; and a file that is no scan.
make_scans() {
  mkdir -p "$1/sub"
  for i in $(seq 24); do
    awk -v w="$i" 'BEGIN {
      n = 12; m = 6; pi = atan2(0, -1)
      printf "OFF\n%d %d 0\n", n * m, 2 * n * m
      for (i = 0; i < n; i++) for (k = 0; k < m; k++) {
        u = 2 * pi * i / n; v = 2 * pi * k / m
        s = 0.4 + 0.05 * sin(w * u + v); r = 1 + s * cos(v)
        printf "%g %g %g\n", r * cos(u), r * sin(u), s * sin(v)
      }
      for (i = 0; i < n; i++) for (k = 0; k < m; k++) {
        a = i * m + k; b = (i + 1) % n * m + k
        c = (i + 1) % n * m + (k + 1) % m; d = i * m + (k + 1) % m
        printf "3 %d %d %d\n3 %d %d %d\n", a, b, c, a, c, d
      }
    }' >"$1/$([ $((i % 3)) -eq 0 ] && echo sub/)torus$i.off"
  done
  echo "OFF 1" >"$1/broken.off"
}
if [ -z "$scans" ]; then
  scans=$dir/scans
  make_scans "$scans"
fi
options=(-- --quality 30 --levels 1 --effort fast --samples 1000)
"$nacre" batch plan "$scans" -o "$dir/alone.jsonl" --output-dir "$dir/alone" -q "${options[@]}"
"$nacre" batch plan "$scans" -o "$dir/manifest.jsonl" --output-dir "$dir/out" -q "${options[@]}"
shards=6 # two on each node
"$nacre" batch sbatch "$dir/manifest.jsonl" --shards $shards --max-memory 500Mi >"$dir/printed.sbatch"

# The script as printed, but with this in the place of nacre: it logs, and holds shards back so that
# faults find them at work. Shard 0 waits for its second copy; the others for the word "go".
cat >"$dir/held-nacre" <<HELD
#!/bin/bash
shard=\$SLURM_ARRAY_TASK_ID restart=\${SLURM_RESTART_COUNT:-0}
echo "start \$shard \$restart \$SLURMD_NODENAME" >>"$dir/jobs/\$shard.events"
trap 'echo "stopped \$shard \$restart" >>"$dir/jobs/\$shard.events"; exit 75' TERM
if [ "\$restart" -eq 0 ]; then
  while [ ! -e "$dir/go-\$shard" ]; do sleep 0.1; done
else
  touch "$dir/go-\$shard"
fi
trap - TERM
"$nacre" "\$@" & child=\$!
trap 'kill -TERM \$child' TERM
wait \$child; code=\$?
while kill -0 \$child 2>/dev/null; do wait \$child; code=\$?; done
echo "end \$shard \$restart \$code" >>"$dir/jobs/\$shard.events"
exit \$code
HELD
chmod +x "$dir/held-nacre"
sed "s|^nacre=.*|nacre='$dir/held-nacre'|" "$dir/printed.sbatch" >"$dir/nacre.sbatch"
cd "$dir/jobs"
run_alone() {
  "$nacre" batch run "$dir/alone.jsonl" -q || [ $? -eq 8 ] || return 1
  "$nacre" batch merge "$dir/alone.jsonl" -q || [ $? -eq 8 ]
}
run_alone >"$dir/jobs/alone.log" 2>&1 &
alone=$!
job=$(sbatch --parsable --export=ALL "$dir/nacre.sbatch")
merge=$(sbatch --parsable --dependency="afterany:$job" --mem=300M \
  --wrap "'$nacre' batch merge '$dir/manifest.jsonl'")
say "job $job: $shards shards; job $merge: the summary"

node_of() { awk '$1 == "start" { node = $4 } END { print node }' "$dir/jobs/$1.events" 2>/dev/null; }
event() { grep -q "^$1" "$dir/jobs/$2.events" 2>/dev/null; }
all_started() { for s in $(seq 0 $((shards - 1))); do event start "$s" || return 1; done; }
until_true "all shards to start" all_started

# Requeued tasks would wait two minutes.
hurry() {
  squeue -h -t PD -o '%F_%K %r' -j "$job" 2>/dev/null | while read -r task why; do
    case $why in
      BeginTime | None) scontrol update "jobid=$task" StartTime=now >/dev/null 2>&1 || true ;;
    esac
  done
}
again() { hurry; event "start $1 [1-9]" "$1"; }

# Fault 1: one node is cut off. Its slurmd is stopped, so that the controller hears nothing of it, and
# its shards live on and are given to others as well.
cut=$(node_of 0)
slurmd_of() { pgrep -P "${node_pid[${1#n}]}" -x slurmd; }
kill -STOP "$(slurmd_of "$cut")"
# Fault 2: another node loses its power, in the middle of a shard.
for s in $(seq 1 $((shards - 1))); do
  [ "$(node_of "$s")" = "$cut" ] || { dead_shard=$s; break; }
done
dead=$(node_of "${dead_shard:?all shards are on one node}")
touch "$dir/go-$dead_shard"
working() { ls "$dir"/out/.nacre/work/*/0 >/dev/null 2>&1 || event end "$dead_shard"; }
until_true "shard $dead_shard to work" working
disown "${node_pid[${dead#n}]}" # bash need not tell of its death
kill -KILL "${node_pid[${dead#n}]}"
say "node $cut cut off with shard 0, node $dead dead with shard $dead_shard"
# Fault 3: a shard on the third node is told to stop, as before the end of its time.
for s in $(seq 1 $((shards - 1))); do
  node=$(node_of "$s")
  [ "$node" = "$cut" ] || [ "$node" = "$dead" ] || { told=$s; break; }
done
scancel --batch --signal=TERM "${job}_${told:?all shards are on two nodes}"
until_true "shard $told to be stopped" event stopped "$told"
touch "$dir/go-$told"
until_true "shard $told to be started again" again "$told"
say "shard $told stopped with 75 and started again"
# Fault 4: the controller is killed. It saves the jobs' states every 5 s, and a task whose end it
# has heard of, but not saved, would count as running until its time limit (docs/batch.md).
has_left() { event "end $1" "$1" && ! squeue -h -t R,CG -j "${job}_$1" 2>/dev/null | grep -q .; }
until_true "shard $told to leave the queue" has_left "$told"
touch "$dir/left"
scontrol update "jobid=$merge" Comment=left # so that there is something to save
until_true "the controller to save that" test "$dir/state/job_state" -nt "$dir/left"
disown "$controller"
kill -KILL "$controller"
start_controller
until_true "the controller" sh -c 'scontrol ping | grep -q "is UP"'
say "controller killed and started again"
for s in $(seq 1 $((shards - 1))); do touch "$dir/go-$s"; done

until_true "shard 0 to be started a second time" again 0
say "shard 0 runs twice"
# 8: the file that is no scan may be its share.
copies_ended() { [ "$(grep -c '^end 0 [0-9]* [08]$' "$dir/jobs/0.events")" -ge 2 ]; }
until_true "both copies of shard 0" copies_ended
kill -CONT "$(slurmd_of "$cut")"
say "node $cut is back"
merged() { hurry; [ -e "$dir/out/summary.json" ] && ! squeue -h -j "$merge" 2>/dev/null | grep -q .; }
until_true "the summary" merged
say "all shards and the summary are done"

event "start $dead_shard [1-9]" "$dead_shard" || fail "the dead node's shard was not started again"

wait "$alone" || fail "the run without Slurm"
diff -r --exclude=.nacre --exclude='summary.*' "$dir/alone" "$dir/out" ||
  fail "the outputs differ from those of a run without Slurm"
number=$(find "$dir/out" -name '*.ncr' | wc -l)
[ "$number" -gt $shards ] || fail "only $number outputs"
say "PASSED: $number outputs, bit for bit those of one machine without Slurm"
