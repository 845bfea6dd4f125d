#!/bin/sh
# Compares the hashes that the C interface and the command line give: compare_hash.sh C_TESTS BRITTLE MESH...
set -eu
c_tests=$1 brittle=$2
shift 2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
for mesh in "$@"; do
    if [ ! -e "$mesh" ]; then
        echo "skipped: $mesh is missing (package glmark2-data)"
        continue
    fi
    ours=$("$c_tests" --hash "$mesh" | sed -n 's/^hash //p')
    theirs=$("$brittle" fracture "$mesh" -n 100 --seed 1 -o "$folder/pieces.ply" | sed -n 's/^ *hash *//p')
    echo "$mesh: $ours by the C interface, $theirs by the command line"
    [ -n "$ours" ] && [ "$ours" = "$theirs" ]
done
