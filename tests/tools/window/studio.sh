# Helpers of the studio's tests, in addition to drive.sh: a window of 960 x 600 with both columns, so that panels are at
# known places; recipes saved by Ctrl+S; pictures of panels; names of files in a dialog.
. "$(dirname "$0")/drive.sh"

# start OPTION...
start() {
    launch "$@" --size "${size:-960x600}" --ui-scale "${scale:-1}" --classify cpu --validation --save-recipe "$work/recipe.json"
    opened
    settled 4
}
quit() {
    xdotool key --window "$window" Escape
    ends 30 0
}

# recipe EXPRESSION MESSAGE: saves the recipe and checks a Python expression over it (jq may be missing)
recipe() {
    rm -f "$work/recipe.json"
    key ctrl+s
    wait_for 20 "saved recipe" test -s "$work/recipe.json"
    python3 -c "
import json, sys
r = json.load(open('$work/recipe.json'))
p = r['pattern']
sites = p.get('sites', [])
sys.exit(0 if ($1) else 1)" || { cat "$work/recipe.json" >&2; fail "$2"; }
    cp "$work/recipe.json" "$work/last.json"
}

# differing A B: prints the number of pixels that differ
differing() { compare -metric AE -fuzz 3% "$1" "$2" null: 2>&1 | grep -oE '^[0-9]+'; }

# golden NAME GEOMETRY: compares a part of the window with its golden, up to half a per cent of its pixels. The part must
# not contain the statistics, which change from run to run. BRITTLE_UPDATE_GOLDENS=1 writes the golden instead.
golden() {
    local picture=$work/$1.png pixels size deadline=$((SECONDS + 10))
    move 480 560 # away from tooltips
    settled 10   # highlights under the mouse fade
    while :; do
        timeout 20 import -window "$window" -crop "$2" +repage "$picture"
        if [ -n "${BRITTLE_UPDATE_GOLDENS:-}" ]; then
            mkdir -p "$goldens"
            cp "$picture" "$goldens/$1.png"
            echo "$test_name: wrote $goldens/$1.png; look at it"
            return
        fi
        pixels=$(differing "$picture" "$goldens/$1.png")
        size=$(identify -format '%[fx:w*h]' "$picture")
        [ -n "$pixels" ] && [ $((pixels * 200)) -le "$size" ] && return
        [ $SECONDS -lt $deadline ] || break # workers may still be busy
        settled
        sleep 0.2
    done
    mkdir -p "$failures"
    cp "$picture" "$failures/studio_$1.actual.png"
    fail "$1 differs from its golden in ${pixels:-all} of $size pixels: $failures/studio_$1.actual.png"
}

# enter TEXT: replaces the text of the field with the keyboard focus
enter() {
    xdotool key --window "$window" ctrl+a
    settled
    xdotool type --window "$window" --delay 20 "$1"
    settled
}
# Dear ImGui misses a key that is pressed and released within a frame.
held_return() { xdotool keydown Return; settled; xdotool keyup Return; settled; }
name_file() { # FILE in the work folder, typed into the dialog
    settled
    enter "$1"
    key Return
}

# Y coordinates of the buttons of the export dialog.
export_as() { # BUTTON FILE
    local -A height=([pieces]=217 [log]=347 [pictures]=402)
    rm -f "$work/$2"
    key ctrl+e
    click 480 "${height[$1]}"
    name_file "$2"
}
export_log() { # FILE
    export_as log "$1"
    wait_for 20 "replay log" test -s "$work/$1"
}
# log_steps FILE: prints the number of steps in a replay log
log_steps() { python3 -c "import json,sys; print(max(json.loads(l).get('step', 0) for l in open(sys.argv[1])))" "$work/$1"; }
