# Helpers of the tests in this folder: drives `brittle demo` in a window of the current display with real keys and a real
# mouse. Waits for the window's progress (settle.cpp) instead of a fixed time. Sourced with the arguments of the test:
#   ../../with_display WINDOW_MANAGER TEST PROGRAM SETTLE DROP_FILE FAILURES
set -uo pipefail
test_name=$(basename "$0")
program=$1
settle=$2
drop_file=$3
failures=$4 # folder for pictures of failures
goldens=$(cd "$(dirname "$0")/../../images/studio" && pwd)
work=$(mktemp -d)
demo=   # process id
window= # X11 window id
step=   # name of the current step, for messages
export XDG_STATE_HOME=$work/state

cleanup() {
    [ -n "$demo" ] && kill "$demo" 2>/dev/null
    rm -rf "$work"
}
trap cleanup EXIT

fail() {
    echo "$test_name: ${step:+$step: }$*" >&2
    cat "$work"/*.log.txt >&2
    if [ -n "$window" ]; then
        mkdir -p "$failures"
        timeout 10 import -window "$window" "$failures/$test_name.png" && echo "the window: $failures/$test_name.png" >&2
    fi
    exit 1
}

# wait_for SECONDS WHAT COMMAND...: waits until the command succeeds
wait_for() {
    local deadline=$((SECONDS + $1)) what=$2
    shift 2
    until "$@"; do
        kill -0 "$demo" 2>/dev/null || fail "the program ended while waiting for $what"
        [ $SECONDS -lt $deadline ] || fail "no $what"
        sleep 0.1
    done
}

# The time limit ends an xdotool whose window has gone.
xdotool() { timeout 20 /usr/bin/env xdotool "$@"; }
find_window() { window=$(xdotool search --name '^Brittle: ' 2>/dev/null | sed -n 1p); [ -n "$window" ]; }
titled() { xdotool getwindowname "$window" 2>/dev/null | grep -E "$1" >/dev/null; }
alive() { kill -0 "$demo" 2>/dev/null || fail "the program ended"; }

# launch OPTION...: starts the program; `opened` waits for its window and mesh
launch() {
    window=
    (cd "$work" && exec "$program" demo "$@" --device cpu) >"$work/demo.log.txt" 2>&1 &
    demo=$!
}
opened() {
    wait_for 60 "window" find_window
    wait_for 60 "title of the whole mesh" titled 'whole$'
}

# settled [FRAMES]: waits until the window has processed all input and drawn the result
settled() {
    "$settle" "$window" "${1:-2}" && return
    alive
    fail "the window does not answer"
}
key() { alive; xdotool key --window "$window" "$@"; settled; }
move() { alive; xdotool mousemove --window "$window" "$1" "$2"; settled; }
press() { xdotool mousedown "$1"; settled; }
release() { xdotool mouseup "$1"; settled; }
click() { move "$1" "$2"; press 1; release 1; }
drag() { # BUTTON DX DY, from the current position
    press "$1"
    for _ in 1 2 3 4; do xdotool mousemove_relative -- $(($2 / 4)) $(($3 / 4)); settled; done
    release "$1"
}

# ends SECONDS CODE: waits for the program to end in time, with this exit code and without a validation message
ends() {
    for _ in $(seq $((10 * $1))); do
        kill -0 "$demo" 2>/dev/null || break
        sleep 0.1
    done
    kill -0 "$demo" 2>/dev/null && fail "it did not end within $1 s"
    wait "$demo"
    local status=$?
    demo=
    window=
    [ "$status" -eq "$2" ] || fail "exit code $status, not $2"
    grep -qi "validation" "$work/demo.log.txt" && fail "validation messages"
    return 0
}
