# Where clang-format and clang-tidy are; sourced after lib.sh, never run.
# shellcheck shell=bash

# find_clang_tool VARIABLE NAME: the path of the tool: what the environment variable names, else .venv's,
# else Debian's.
find_clang_tool() {
  local candidate
  for candidate in "${!1:-}" "$sextant_root/.venv/bin/$2" "/usr/bin/$2"; do
    if [ -n "$candidate" ] && [ -x "$candidate" ]; then
      printf '%s\n' "$candidate"
      return
    fi
  done
  die "there is no $2 in .venv or /usr/bin; run scripts/setup, or name one in $1."
}

# clang_tidy: the path of a clang-tidy that knows function effects.
clang_tidy() {
  local tool version
  tool=$(find_clang_tool CLANG_TIDY clang-tidy)
  version=$("$tool" --version | sed -n 's/.*version \([0-9]*\).*/\1/p' | head -1)
  [ "${version:-0}" -ge 20 ] || die "$tool is version ${version:-unknown}; 20 or newer is needed: run scripts/setup."
  printf '%s\n' "$tool"
}

# prepare_standalone: brings the lists of faults and of telemetry up to date and sets standalone_flags: how to compile,
# from the top of the tree, a header or a source that needs nothing else that is generated.
prepare_standalone() {
  cmake -DDBC="$sextant_root/configs/interfaces/sextant.dbc" -DOUTPUT="$sextant_root/build/standalone" \
    -P "$sextant_root/cmake/SextantFaults.cmake" || die "the list of faults cannot be made from configs/interfaces/sextant.dbc."
  cmake -DIDL="$sextant_root/configs/interfaces/telemetry.idl" -DOUTPUT="$sextant_root/build/standalone" \
    -P "$sextant_root/cmake/SextantTelemetry.cmake" || die "the telemetry cannot be made from configs/interfaces/telemetry.idl."
  standalone_flags=(-std=c++20 -Iinclude -Ibuild/standalone/include -Iapps -Itests -isystem /usr/include/eigen3)
}

# own_sources PATTERN...: tracked and new files of the project that match, none of them ignored.
own_sources() {
  git -C "$sextant_root" ls-files --cached --others --exclude-standard -- "$@" | sort -u |
    while read -r file; do [ ! -f "$sextant_root/$file" ] || printf '%s\n' "$file"; done
}
