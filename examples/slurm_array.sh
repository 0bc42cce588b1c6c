#!/usr/bin/env bash
# A batch on a cluster: a Slurm array of shards, each a bare `slew`, and `slew merge` at the end.
#
#   sbatch --array=1-40 examples/slurm_array.sh maneuver.toml results 40
#   slew merge results/shard-*.jsonl -o all.jsonl
#
# A shard that was killed, or ran into its time limit, goes on where it was left when it is
# submitted again, alone as well (`--array=3 … 40`: the number of shards stays); what is finished
# costs nothing. The merged file is, byte for byte, that of one long run. Works the same without
# Slurm:
#
#   for i in 1 2 3; do SLURM_ARRAY_TASK_ID=$i examples/slurm_array.sh maneuver.toml results 3 & done
#
#SBATCH --cpus-per-task=4
#SBATCH --time=04:00:00
#SBATCH --signal=B:TERM@60
set -euo pipefail

spec=$1
results=$2
shards=$3
shard=${SLURM_ARRAY_TASK_ID:?"run as an array: sbatch --array=1-40 $0 SPEC RESULTS 40"}
mkdir -p "$results"

"${SLEW:-slew}" monte-carlo "$spec" --shard "$shard/$shards" --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --progress -o "$results/shard-$shard.jsonl" &
# The signal before the time limit reaches this shell alone: it is passed on, and what is done is
# kept.
trap 'kill -TERM $! 2>/dev/null' TERM
code=0
wait $! || code=$?
# A wait that the signal has ended waits once more, for the program.
if [ "$code" -gt 128 ]; then
    code=0
    wait $! || code=$?
fi
# 9 says that some cases failed: they are counted and recorded, and the array has done its work.
[ "$code" -eq 9 ] || exit "$code"
