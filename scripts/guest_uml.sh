# User Mode Linux as the guest of scripts/with_vcan: a kernel that is a program. Sourced after guest.sh, never run.
# It is the machine's own, or where scripts/setup has fetched another one, that one.
# shellcheck shell=bash

guest_uml=$sextant_root/.cache/guest-uml # linux.uml, lib/, modules/ and version, which scripts/setup fetches

# In the order of their loading.
uml_modules=(
  drivers/net/can/dev/can-dev net/can/can net/can/can-raw net/can/can-bcm net/can/can-gw
  drivers/net/can/vcan drivers/net/can/vxcan net/sched/sch_tbf
)

# uml_is_fetched: linux.uml names its libraries by full path, so that one of a tree that was moved is none.
uml_is_fetched() { [ "$(sed -n 2p "$guest_uml/version" 2>/dev/null)" = "$(realpath -m "$guest_uml")" ]; }

# choose_uml: sets linux_uml to the program, uml_name to what messages call it, and uml_kernel to the directory of its
# modules, as the guest's shell writes it.
choose_uml() {
  linux_uml=linux.uml
  uml_name="User Mode Linux"
  # shellcheck disable=SC2016
  uml_kernel='/usr/lib/uml/modules/$(uname -r)/kernel'
  if uml_is_fetched; then
    linux_uml=$guest_uml/linux.uml
    uml_name="User Mode Linux ($(sed -n 1p "$guest_uml/version") of Debian unstable)"
    uml_kernel=$(printf '%q' "$guest_uml/modules")
  fi
}

uml_missing() { missing_programs "$linux_uml" taskset busybox ip flock; }

# directory_for_memory: the guest's memory is a file that is mapped executable.
directory_for_memory() {
  local need=$((${uml_memory%[MG]} * 1024)) parent available
  [[ $uml_memory == *G ]] && need=$((need * 1024))
  for parent in /dev/shm /tmp /var/tmp; do
    [ -w "$parent" ] || continue
    [[ ,$(findmnt -no OPTIONS -T "$parent" 2>/dev/null), == *,noexec,* ]] && continue
    available=$(df -kP "$parent" 2>/dev/null | awk 'NR == 2 {print $4}')
    [ "${available:-0}" -gt "$need" ] && echo "$parent" && return 0
  done
  echo /tmp
}

# take_cpu: sets cpu to one that no other guest has, as long as there is one. A guest on one CPU makes system calls four times
# faster than one that wanders. The lock lives as long as descriptor 9.
take_cpu() {
  local ranges range
  cpus=()
  IFS=, read -ra ranges <<<"$(sed -n 's/^Cpus_allowed_list:[[:space:]]*//p' /proc/self/status)"
  for range in "${ranges[@]}"; do
    mapfile -t -O ${#cpus[@]} cpus < <(seq "${range%-*}" "${range#*-}")
  done
  for cpu in "${cpus[@]}"; do
    { exec 9>"/tmp/.with_vcan.$(id -u).cpu$cpu"; } 2>/dev/null && flock -n 9 && return 0
  done
  cpu=${cpus[$(($$ % ${#cpus[@]}))]}
}

uml_prepare() {
  uml_memory=${memory:-512M}
  take_cpu
}

uml_init() {
  cat <<GUEST
modules=$uml_kernel
for module in ${uml_modules[*]}; do
  busybox insmod "\$modules/\$module.ko"
done
GUEST
  cat <<'GUEST'
# The consoles carry the command's output as bytes.
stty -F /dev/tty1 raw -echo
stty -F /dev/tty2 raw -echo
exec 3>/dev/tty1 4>/dev/tty2
GUEST
}

uml_finish() {
  cat <<'GUEST'
# Leaving raw mode waits until the consoles have sent everything.
stty -F /dev/tty1 cooked
stty -F /dev/tty2 cooked
GUEST
}

uml_boot() {
  : >"$work/kernel.log"
  # The guest's output goes through cat: linux.uml makes its descriptors non-blocking, and the caller's are not ours to change.
  exec 7> >(exec cat >&1)
  local out=$!
  exec 8> >(exec cat >&2)
  local err=$!
  # shellcheck disable=SC2094
  TMPDIR=$(directory_for_memory) run_and_wait timeout -k 5 "$limit" taskset -c "$cpu" \
    "$linux_uml" mem="$uml_memory" umid=guest uml_dir="$work/" root=/dev/root rootfstype=hostfs rootflags=/ rw \
    init="$work/init" quiet loglevel=1 con=null con0=null,fd:1 con1=null,fd:7 con2=null,fd:8 ssl=null \
    >"$work/kernel.log" 2>&1 7>&7 8>&8
  local status=$?
  exec 7>&- 8>&-
  wait "$out" "$err" 2>/dev/null
  return $status
}

# Linux 6.1 keeps too little room for the registers of a processor with AMX.
uml_never_works() {
  ! grep -q put_fp_registers "$work/kernel.log" ||
    echo "$uml_name does not run on this processor (put_fp_registers failed: more registers than it has room for)"
}
