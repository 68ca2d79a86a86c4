#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# A Slurm cluster in one computer, with a configuration, a key and ports of its own: two nodes of four declared processors each, whatever the
# computer has. Sourced: . tests/cluster/private_slurm.sh <folder> starts munged, slurmctld and slurmd, which end with the shell.
# Needs munge, slurmctld, slurmd and slurm-client (scripts/setup.sh --all), and root.
slurm_folder=$(realpath -m "$1")
rm -rf "$slurm_folder"
mkdir -p "$slurm_folder/state"
slurm_daemons=() slurm_munged=
slurm_sockets=$(mktemp -d /tmp/munge.XXXXXX)  # paths of sockets have at most 107 characters
chmod 711 "$slurm_sockets"
end_slurm() {
  if ((${#slurm_daemons[@]})); then
    scancel --user="$(id -un)" --signal=KILL --full 2> /dev/null
    scancel --user="$(id -un)" 2> /dev/null
    for _ in $(seq 100); do [[ -z $(squeue --noheader 2> /dev/null) ]] && break; sleep 0.1; done
    kill "${slurm_daemons[@]}" 2> /dev/null
    wait "${slurm_daemons[@]}" 2> /dev/null
  fi
  [[ -n $slurm_munged ]] && kill "$slurm_munged" 2> /dev/null && wait "$slurm_munged" 2> /dev/null
  rm -rf "$slurm_sockets"
}
trap end_slurm EXIT

head -c 128 /dev/urandom > "$slurm_folder/munge.key"
chmod 400 "$slurm_folder/munge.key"
munged --foreground --force --num-threads=10 --socket="$slurm_sockets/socket" --key-file="$slurm_folder/munge.key" \
  --pid-file="$slurm_folder/munged.pid" --log-file="$slurm_folder/munged.log" --seed-file="$slurm_folder/munge.seed" \
  > "$slurm_folder/munged.out" 2>&1 &
slurm_munged=$!
for _ in $(seq 100); do [[ -S $slurm_sockets/socket ]] && break; sleep 0.1; done

slurm_host=$(hostname -s) slurm_port=$((20000 + $$ % 10000 * 3))
{
  cat << CONFIGURATION
ClusterName=private
SlurmctldHost=$slurm_host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
SlurmctldPort=$slurm_port
AuthType=auth/munge
AuthInfo=socket=$slurm_sockets/socket
CredType=cred/munge
StateSaveLocation=$slurm_folder/state
SlurmctldPidFile=$slurm_folder/slurmctld.pid
SlurmctldLogFile=$slurm_folder/slurmctld.log
SlurmdSpoolDir=$slurm_folder/%n
TmpFS=$slurm_folder/%n  # PMIx: two nodes must not share it
SlurmdPidFile=$slurm_folder/%n.pid
SlurmdLogFile=$slurm_folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
KillWait=30
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONFIGURATION
  for node in 1 2; do
    echo "NodeName=node$node NodeHostname=$slurm_host NodeAddr=127.0.0.1 Port=$((slurm_port + node)) CPUs=4 State=UNKNOWN"
    mkdir -p "$slurm_folder/node$node"
  done
} > "$slurm_folder/slurm.conf"
echo "CgroupPlugin=cgroup/v1" > "$slurm_folder/cgroup.conf"  # not used, but one must be there
export SLURM_CONF=$slurm_folder/slurm.conf
slurmctld -D > "$slurm_folder/slurmctld.out" 2>&1 &
slurm_daemons+=($!)
for node in node1 node2; do
  slurmd -D -N "$node" > "$slurm_folder/$node.out" 2>&1 &
  slurm_daemons+=($!)
done
slurm_is_up() { [[ $(sinfo --noheader --format=%T%D 2> /dev/null) == idle2 ]]; }
for _ in $(seq 300); do slurm_is_up && break; sleep 0.1; done
if ! slurm_is_up; then
  echo "Slurm does not start:"
  tail -n 5 "$slurm_folder"/*.out
  exit 1
fi
