# Helpers of the bash scripts; sourced, never run.
# shellcheck shell=bash

sextant_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
sextant_python=$sextant_root/.venv/bin/python
multicast_group=239.74.163.2 # of CAN frames that travel by UDP
multicast_route_made=no

# The gates that have a --self-test, each with what it is made of beside scripts/check_<gate>.
# shellcheck disable=SC2034
declare -A self_tests=(
  [format]=.clang-format
  [tidy]='.clang-tidy scripts/clang_tools.sh tests/tidy'
  [function_effects]='scripts/clang_tools.sh tests/nonblocking'
  [control_thread_audit]=tests/audit
  [paper]='scripts/command scripts/studies/paper/check_paper.py'
  [sanitizers]=tests/sanitizers
  [rtsan]='scripts/clang_tools.sh tests/audit'
  [instructions]='scripts/studies/bench/instructions.py tests/bench/instruction_probe.cpp'
  [coverage]=''
  [cortex_m]='scripts/studies/microcontroller/cortex_m.py scripts/studies/microcontroller/golden.py tests/cortex_m'
)

say() { printf '%s\n' "$*"; }

# die MESSAGE...: one sentence on stderr, exit status 1.
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# refuse_argument WORD: ends the script, as one that cannot run.
refuse_argument() {
  printf '%s: unknown argument "%s"; see %s --help.\n' "$(basename "$0")" "$1" "$(basename "$0")" >&2
  exit 2
}

# print_help: the block of comments at the top of the running script, without the marks.
print_help() { sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0"; }

# accept ARGUMENT [KNOWN...]: prints the help and ends, or refuses an argument that is neither empty nor known.
accept() {
  case $1 in -h | --help) print_help && exit 0 ;; esac
  local known
  for known in '' "${@:2}"; do [ "$1" != "$known" ] || return 0; done
  refuse_argument "$1"
}

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

ip() { PATH=$PATH:/usr/sbin:/sbin command ip "$@"; }

# multicast_route: whether UDP multicast can be sent here; where there is no route, 239.0.0.0/8 goes over the loopback
# until drop_multicast_route.
multicast_route() {
  ! ip route get "$multicast_group" >/dev/null 2>&1 || return 0
  if ! can_be_root || ! as_root ip route add 239.0.0.0/8 dev lo; then return 1; fi
  multicast_route_made=yes
  say "$(basename "$0"): no multicast route here; 239.0.0.0/8 goes over the loopback until the end"
}

drop_multicast_route() {
  [ $multicast_route_made = no ] || as_root ip route delete 239.0.0.0/8 dev lo 2>/dev/null || true
}

# build_preset PRESET [TARGET...]: configures and builds build/PRESET, all targets unless some are named.
build_preset() {
  local preset=$1
  shift
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  (cd "$sextant_root" && cmake --preset "$preset" && cmake --build --preset "$preset" "${targets[@]}" -j "$(nproc)")
}

# test_jobs: how many tests at once. Many wait for processes and clocks, and leave a processor idle.
test_jobs() { printf '%s\n' $(($(nproc) + 1)); }

need_python() {
  [ -x "$sextant_python" ] || die "the Python packages are not installed yet; scripts/setup does it."
}

# module_of NAME: the module of a program, of scripts/sextant_py or a study; fails where none is called so.
module_of() {
  local file
  for file in "$sextant_root"/scripts/{sextant_py,studies/*}/"$1"{.py,/__main__.py}; do
    grep -qs '__name__ == "__main__"' "$file" || continue
    file=${file#"$sextant_root/scripts/"} file=${file%.py} file=${file%/__main__}
    printf '%s\n' "${file//\//.}" && return
  done
  return 1
}

# run_module NAME [ARGUMENTS...]: becomes the program.
run_module() {
  need_python
  local module
  module=$(module_of "$1") || die "no program is called \"$1\"."
  shift
  PYTHONPATH=$sextant_root/scripts${PYTHONPATH:+:$PYTHONPATH} exec "$sextant_python" -m "$module" "$@"
}

# mil_module MODULE [ARGUMENTS...]: as run_module; the program builds what it needs of the release, once it has read its
# arguments.
mil_module() { SEXTANT_BUILD=release run_module "$@"; }
