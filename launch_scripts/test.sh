#!/usr/bin/env bash
# Builds with tests and runs all of them. Closes with "N passed, N failed, N skipped"; exit code 0 when none failed.
# Options: --sanitize address,undefined | thread   build and test with these sanitizers (separate build folder)
#          --label LABEL                           only tests with this label (for instance long)
# Example: ./launch_scripts/test.sh
source "$(dirname "$0")/common.sh"
sanitize="" label=""
while [ $# -gt 0 ]; do
  case "$1" in
    --sanitize) sanitize="${2:?--sanitize needs a list}"; shift 2 ;;
    --label) label="${2:?--label needs a name}"; shift 2 ;;
    *) sed -n '2,6p' "$0"; exit 4 ;;
  esac
done
./launch_scripts/install_dependencies.sh
base="$OMNIFLIGHT_ROOT/build/testing${sanitize:+-${sanitize//,/-}}"
say "building with tests"
omniflight_build "$base" -DBUILD_TESTING=ON "-DOMNIFLIGHT_SANITIZE=$sanitize"

say "testing"
if [ -z "${OMNIFLIGHT_REAL_DATA:-}" ] && [ -d "$OMNIFLIGHT_ROOT/../shared/data" ]; then
  OMNIFLIGHT_REAL_DATA="$(cd "$OMNIFLIGHT_ROOT/../shared/data" && pwd)"
  export OMNIFLIGHT_REAL_DATA
fi
ctest_args=(--output-on-failure)
if [ -n "$label" ]; then ctest_args+=(-L "$label"); else ctest_args+=(-LE long); fi
status=0
say "layout of the packages"
python3 tests/test_architecture.py | tail -n 1 || status=1
if [[ "$sanitize" == *thread* ]]; then
  export TSAN_OPTIONS="suppressions='$OMNIFLIGHT_ROOT/tests/thread_sanitizer.supp' ${TSAN_OPTIONS:-}"
fi
# without it UBSan prints what it finds and the test passes
export UBSAN_OPTIONS="halt_on_error=1 print_stacktrace=1 ${UBSAN_OPTIONS:-}"
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs"
export OMNIFLIGHT_BIN="$base/install"
run_tests() {  # how many tests at once, then which packages, in colcon's options
  colcon --log-base "$base/log" test --metas "$OMNIFLIGHT_ROOT/colcon.meta" \
    --event-handlers console_direct- console_stderr- status- summary- \
    --base-paths src --build-base "$base/build" --install-base "$base/install" --executor sequential \
    "${@:2}" --return-code-on-test-failure --ctest-args -j"$1" "${ctest_args[@]}" || status=1
}
# tests of the diagnosis only compute; others fly, keep times or measure them, and have the processors alone
run_tests "$JOBS" --packages-select omniflight_diagnosis
run_tests 1 --packages-skip omniflight_diagnosis
colcon test-result --test-result-base "$base/build" --all --verbose || status=1

python3 - "$base/build" <<'PY' || status=1
# the plain closing line, from CTest's own result files
import glob, sys, xml.etree.ElementTree as ET
passed = failed = skipped = 0
for tag in glob.glob(sys.argv[1] + "/*/Testing/TAG"):
    stamp = open(tag).readline().strip()
    for test in ET.parse(tag.replace("TAG", stamp + "/Test.xml")).getroot().iter("Test"):
        status = test.get("Status")
        if status is None:
            continue
        output = "".join(v.text or "" for v in test.iter("Value"))
        if status == "notrun" or "[  SKIPPED ]" in output or "Skipped" in "".join(m.findtext("Value") or "" for m in test.iter("NamedMeasurement")):
            skipped += 1
        elif status == "passed":
            passed += 1
        else:
            failed += 1
            print("failed:", test.findtext("FullName"))
print(f"{passed} passed, {failed} failed, {skipped} skipped")
sys.exit(0 if passed > 0 and failed == 0 else 1)
PY
exit "$status"
