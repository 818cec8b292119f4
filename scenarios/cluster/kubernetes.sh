#!/bin/sh
# A campaign in shards on Kubernetes, and the merge, with the manifest beside this script:
#
#     kubernetes.sh IMAGE SHARDS FILE.scn [a file that it imports …]
#
# Files are named from the current folder, which is above all of them. IMAGE is one of the Dockerfile here. It waits until all shards have ended, whether they succeeded or not; the merge names those that are missing, and
# a second call makes them.
set -eu
image=$1 shards=$2 scenario=$3
shift 2
# A ConfigMap is flat: each file has a key, and the volume puts it back into its folder. Names of files with blanks have no place here.
files="" items="" count=0
for file; do
    case $file in
    /* | ../* | */../*) echo "$file is not below the current folder" >&2; exit 2 ;;
    esac
    files="$files --from-file=file$count=$file" items="$items{key: file$count, path: $file}, " count=$((count + 1))
done
# The image comes last: it may have any number in its name.
manifest=$(sed -e "s|\([^0-9]\)16\b|\1$shards|g; s|mine\.scn|$scenario|; s|{name: scenarios}|{name: scenarios, items: [${items%, }]}|" \
    -e "s|registry\.example/falsify:0\.1\.0|$image|" "$(dirname "$0")/kubernetes.yaml")

apply() {
    printf '%s\n' "$manifest" | kubectl apply -f - -l "step=$1"
}

# `kubectl wait` waits for one condition, and a job ends with one of two.
ended() {
    while kubectl get "job/$1" >/dev/null; do
        if kubectl wait --for=condition=complete --timeout=20s "job/$1" 2>/dev/null; then return 0; fi
        if kubectl wait --for=condition=failed --timeout=1s "job/$1" 2>/dev/null; then return 1; fi
    done
    return 1
}

kubectl create configmap scenarios $files --dry-run=client -o yaml | kubectl apply -f -
kubectl delete job falsify falsify-merge --ignore-not-found
apply volume
apply shards
ended falsify || echo "not all shards succeeded: kubectl logs job/falsify" >&2
apply merge
code=0
ended falsify-merge || code=1
kubectl logs job/falsify-merge
exit $code
