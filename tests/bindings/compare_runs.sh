#!/bin/sh
# Runs and replays of the C interface and of the command line repeat each other: compare_runs.sh TEST_RUNS BRITTLE
set -eu
test_runs=$1 brittle=$2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cat >"$folder/one.json" <<EOF
{"brittle": 1, "mesh": "shape:torus", "pattern": {"count": 15, "seed": 4}, "world": {"bonded": true}}
EOF
cat >"$folder/scene.json" <<EOF
{"brittle": 2, "objects": [
 {"name": "plinth", "mesh": "shape:cube", "fixed": true, "scale": [0.5, 0.5, 0.5], "translation": [0, 0.25, 0]},
 {"name": "ball", "mesh": "shape:icosphere:2", "material": "stone", "scale": [0.4, 0.4, 0.4], "translation": [0, 1, 0]}],
 "world": {"shots": [{"time": 0.1, "from": [0, 1, -3], "velocity": [0, 0, 20], "radius": 0.1}]}}
EOF
ours=$("$test_runs" --hash "$folder/one.json" | sed -n 's/^hash //p')
theirs=$("$brittle" fracture "$folder/one.json" -o "$folder/pieces.ply" | sed -n 's/^ *hash *//p')
echo "hash: $ours by the C interface, $theirs by the command line"
[ -n "$ours" ] && [ "$ours" = "$theirs" ]
for name in one scene; do
    "$test_runs" --record "$folder/$name.json" "$folder/$name.log"
    "$brittle" replay "$folder/$name.log"
    "$brittle" render "$folder/$name.json" -o "$folder/$name.png" --frames 20 --size 64x48 --record "$folder/drawn_$name.log"
    "$test_runs" --replay "$folder/drawn_$name.log"
done
