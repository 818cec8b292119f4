#!/bin/sh
# Three rounds of attack and repair of a learnt driver: scenarios/learnt/harden.sh SEED FOLDER DEMONSTRATIONS
#
# The first driver is trained as train.scn does, with this number of demonstrations. A round attacks the last driver, and trains one anew, as long, among people who
# cross as recorded ones do and among all attackers up to then. `control` is trained as the first driver, with another seed. The last attack is on the
# driver of round 3. reports/learning.md has the results.
set -e
seed=$1 out=$2 demonstrations=$3
here=$(realpath "$(dirname "$0")")
mkdir -p "$out"

run() {
  file=$1 folder=$out/$2
  shift 2
  falsify run "$file" --seed "$seed" --threads 1 --formats csv --out "$folder" "$@"
}
network() {
  realpath "$out/$1"/*/"$2"/*.onnx
}
attack() {
  run "$here/harden.scn" "$1" --only attack --set "attacked.model=\"$driver\""
}
# Trains a driver among seldom_heedful and the attackers in $attackers.
train() {
  {
    echo "edition 1"
    for file in ../lib/drivers.scn ../lib/towns.scn ../lib/carla_towns.scn harden.scn train.scn; do
      echo "import \"$here/$file\""
    done
    names=seldom_heedful
    for attacker in $attackers; do
      name=attacker$(echo "$names" | wc -w)
      echo "pedestrian $name = onnx(model: \"$attacker\")"
      names="$names, $name"
    done
    echo "campaign school {"
    echo "  vehicle: model3  body: person  spawn: ahead_of_a_moving_car  episode: until_passed  training: driving"
    echo "  drive { towns: [harbour, village, town01_outline]  imitates: idm  pedestrians: [$names]  demonstrations: $demonstrations }"
    echo "}"
  } > "$out/$1.scn"
  run "$out/$1.scn" "$1"
}

attackers=
train before
before=$(network before drivers)
driver=$before
for round in 1 2 3; do
  attack "attack$round"
  attackers="$attackers $(network "attack$round" pedestrians)"
  train "after$round"
  driver=$(network "after$round" drivers)
done
attack attack4
attackers=
seed=$((seed + 100))
train control
seed=$1
run "$here/harden.scn" test --only test --set "before.model=\"$before\"" --set "after.model=\"$driver\"" \
  --set "control.model=\"$(network control drivers)\""
