# Helpers of the bash scripts; sourced, never run.
# shellcheck shell=bash

sextant_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
sextant_python=$sextant_root/.venv/bin/python

say() { printf '%s\n' "$*"; }

# die MESSAGE...: one sentence on stderr, exit status 1.
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# print_help: the block of comments at the top of the running script, without the marks.
print_help() { sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0"; }

# can_be_root: whether as_root can work without asking anybody who is not there.
can_be_root() {
  [ "$(id -u)" = 0 ] && return 0
  command -v sudo >/dev/null || return 1
  sudo -n true 2>/dev/null || [ -t 0 ]
}

# as_root COMMAND...: runs it as root, through sudo where needed.
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# build_preset PRESET [TARGET...]: configures and builds build/PRESET, all targets unless some are named.
build_preset() {
  local preset=$1
  shift
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  (cd "$sextant_root" && cmake --preset "$preset" && cmake --build --preset "$preset" "${targets[@]}" -j "$(nproc)")
}

# run_module MODULE [ARGUMENTS...]: becomes a program of scripts/sextant_py.
run_module() {
  [ -x "$sextant_python" ] || die "the Python packages are not installed yet; scripts/setup does it."
  local module=$1
  shift
  PYTHONPATH=$sextant_root/scripts${PYTHONPATH:+:$PYTHONPATH} exec "$sextant_python" -m "sextant_py.$module" "$@"
}
