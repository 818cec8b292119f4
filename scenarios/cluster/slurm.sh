#!/bin/bash
# A campaign in 16 shards on a Slurm cluster, all writing to one folder that every node sees:
#
#     job=$(sbatch --parsable --array=0-15 slurm.sh 16 OUT FILE.scn …)
#     sbatch --dependency=afterany:$job --wrap "falsify merge --shards 16 --out OUT FILE.scn …"
#
# The merge writes the report, or names the shards that are missing; submit those again: sbatch --array=2,7-9 slurm.sh 16 OUT FILE.scn …
#SBATCH --job-name=falsify
#SBATCH --cpus-per-task=4
#SBATCH --mem=2G
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --signal=B:USR1@60
#SBATCH --open-mode=append
#SBATCH --output=falsify-%A_%a.log
set -u
shards=$1 out=$2
shift 2

"${FALSIFY:-falsify}" run --shard "auto/$shards" --threads "${SLURM_CPUS_PER_TASK:-1}" --out "$out" "$@" &
falsify=$!

# A minute before the time is up, what is under way is kept, and the task goes back into the queue. A node that is needed
# otherwise says so by TERM; Slurm requeues then by itself.
again=no
trap 'again=yes; heard=yes; kill -TERM $falsify 2>/dev/null' USR1
trap 'heard=yes; kill -TERM $falsify 2>/dev/null' TERM
heard=yes
while [ "$heard" = yes ]; do
    heard=no
    wait $falsify
    code=$?
done
if [ "$again" = yes ] && [ "$code" = 130 ]; then
    exec scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
