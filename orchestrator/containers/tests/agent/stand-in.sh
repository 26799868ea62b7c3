#!/bin/sh
# Stands in for webloop as an agent starts it: `stand-in serve ROLE --settings - --out FOLDER`.
# The role is a plant, controller or link in name only; how it behaves is said by the setting h.
role=$2
out=$6
shift 2
settings=$(cat)
how=ready
case $settings in
    *'"h":"'*) how=${settings#*'"h":"'} how=${how%%'"'*} ;;
esac
idle() { while :; do sleep 0.05; done; }
trap 'exit 0' TERM

case $how in
    ready)
        echo "hello"
        echo "ready $$ as $role"
        printf '%s\n' "$@" "$settings" > "$out/arguments.txt"
        idle ;;
    slow)
        sleep 1.5
        echo "ready at last"
        idle ;;
    mute)
        idle ;;
    stubborn)
        trap '' TERM
        echo "ready $$"
        idle ;;
    ends-*)
        echo "first line" >&2
        echo "what it lacks is a quiet machine" >&2
        exit "${how#ends-}" ;;
    breaks)
        echo "ready"
        sleep 0.2
        echo "it broke" >&2
        exit 1 ;;
    grows)
        # Rows in two halves, a file beyond what one answer carries, and a report at the end.
        trap 'echo last >> "$out/ticks.csv"; echo "{}" > "$out/plant.partial"
              mv "$out/plant.partial" "$out/plant.json"; exit 0' TERM
        echo "ready"
        head -c 3000000 /dev/urandom > "$out/arrivals.csv"
        n=0
        while :; do
            n=$((n + 1))
            printf 'row %s, first half' $n >> "$out/ticks.csv"
            sleep 0.03
            printf ', second half\n' >> "$out/ticks.csv"
        done ;;
esac
