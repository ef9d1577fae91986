#!/usr/bin/env bash
# timed_command.sh COMMAND...: runs a compiler or linker, and appends its processor time [s], user and system, and what
# it made to $OMNIFLIGHT_TIMES/PACKAGE. The launcher of build_time.sh; packages are built in folders of their name.
TIMEFORMAT='%U %S'
made="" before=""
for word in "$@"; do
  if [ "$before" = "-o" ]; then made="$word"; fi
  before="$word"
done
status=0
exec 3>&1 4>&2
spent="$({ time "$@" 1>&3 2>&4; } 2>&1)" || status=$?
# what CMake tries while it configures has folders of its own, and counts as its time
if [ -n "${OMNIFLIGHT_TIMES:-}" ] && [[ "$PWD" != *CMakeFiles* ]]; then
  printf '%s %s\n' "$spent" "$made" >>"$OMNIFLIGHT_TIMES/$(basename "$PWD")"
fi
exit "$status"
