# A command inside a guest kernel that has vcan, for scripts/with_vcan; sourced after lib.sh, never run.
# What the guests share is here; guest_uml.sh and guest_qemu.sh know how one kind K is had and booted:
#   K_missing       prints what of it this machine lacks, nothing when all is there
#   K_prepare       once, before the first boot
#   K_init          prints the part of the guest's init that is its own: modules, and descriptors 3 and 4, on which the
#                   guest's stdout and stderr leave it
#   K_finish        prints what its init does when the command has ended
#   K_boot          boots the guest with $work/init and returns when it is gone; its kernel speaks in $work/kernel.log
#   K_never_works   prints why the log says that this machine will never run it, nothing when it does not say so
# shellcheck shell=bash

# A boot's findings about this machine; what the machine can do may change with the next boot.
findings=$sextant_root/.cache/with_vcan

# finding NAME [TEXT]: prints what was found since this machine was started; or keeps TEXT, where it may be written.
finding() {
  local boot file
  boot=$(cat /proc/sys/kernel/random/boot_id)
  file=$findings/$boot/$1
  if [ $# = 1 ]; then
    cat "$file" 2>/dev/null
  elif mkdir -p "$findings/$boot" 2>/dev/null; then
    find "$findings" -mindepth 1 -maxdepth 1 ! -name "$boot" -exec rm -rf {} + 2>/dev/null
    { echo "$2" >"$file"; } 2>/dev/null
  fi
}

# forget NAME: the finding is none any more.
forget() { rm -f "$findings/$(cat /proc/sys/kernel/random/boot_id)/$1"; }

# directory_for_guest: on the host's file system (the guest has its own /dev, /run), of a path short enough for the
# guest's control socket and without characters that a kernel command line would split.
directory_for_guest() {
  local parent
  for parent in "${TMPDIR:-/tmp}" /tmp /var/tmp; do
    [[ $parent =~ ^/[A-Za-z0-9_./-]{1,40}$ && ! $parent =~ ^/(dev|run|proc|sys)(/|$) ]] || continue
    mktemp -d "$parent/with_vcan.XXXXXX" 2>/dev/null && return 0
  done
  return 1
}

# write_guest_files KIND COMMAND...: environment, command and init of the guest, in $work.
write_guest_files() {
  local kind=$1
  shift
  {
    export -p | grep -v -E '^declare -[a-z]*r[a-z]* ' | grep -v -E '^declare -x (OLDPWD|SHLVL|WITH_VCAN)(=|$)'
    printf 'export WITH_VCAN=%q\ncd %q\numask %s\n' "$kind" "$PWD" "$(umask)"
  } >"$work/environment"
  {
    printf 'exec'
    printf ' %q' "$@"
    echo
  } >"$work/command"
  cat >"$work/init" <<GUEST
#!/bin/bash
work=$work
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
mountpoint -q /proc || mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t tmpfs -o mode=755 tmp /run
mountpoint -q /dev || mount -t devtmpfs dev /dev
mkdir -p /dev/shm /dev/pts
mount -t tmpfs -o mode=1777 shm /dev/shm
mount -t devpts -o ptmxmode=666 devpts /dev/pts
ln -sfn /proc/self/fd /dev/fd
ln -sf /proc/self/fd/0 /dev/stdin
ln -sf /proc/self/fd/1 /dev/stdout
ln -sf /proc/self/fd/2 /dev/stderr
$("${kind}_init")
ip link set lo up
for ((i = 0; i < $interfaces; i++)); do
  ip link add dev vcan\$i type vcan && ip link set vcan\$i mtu 72 && ip link set vcan\$i up || busybox poweroff -f
done
echo -1 >/proc/sys/kernel/sched_rt_runtime_us
mkfifo /run/out /run/err
cat </run/out >&3 & out=\$!
cat </run/err >&4 & err=\$!
touch \$work/started
(exec 3>&- 4>&-; . \$work/environment; . \$work/command) </dev/null >/run/out 2>/run/err &
wait \$!
status=\$?
# What the command left running may hold its output open; that ends here.
for ((i = 0; i < 20; i++)); do
  kill -0 \$out 2>/dev/null || kill -0 \$err 2>/dev/null || break
  sleep 0.05
done
kill \$out \$err 2>/dev/null
$("${kind}_finish")
echo \$status >\$work/status
busybox poweroff -f
GUEST
  chmod 755 "$work/init"
}

# run_guest KIND COMMAND...: exits as COMMAND does; returns, with the reason in why, when the guest did not come up. Where
# it never will, that is a finding named KIND_fails.
run_guest() {
  local kind=$1 status attempt
  shift
  [ -z "$work" ] || rm -rf "$work"
  work=$(directory_for_guest) || refuse "neither ${TMPDIR:-/tmp} nor /var/tmp can be written."
  trap 'rm -rf "$work"' EXIT
  "${kind}_prepare"
  for attempt in 1 2 3; do
    write_guest_files "$kind" "$@"
    "${kind}_boot"
    status=$?
    [ $verbose = no ] || sed 's/^/[guest] /' "$work/kernel.log" >&2
    [ ! -s "$work/status" ] || exit "$(cat "$work/status")"
    if [ $status = 124 ] || [ $status = 137 ]; then
      echo "with_vcan: time limit ($limit s)" >&2
      exit 124
    fi
    [ $status != 143 ] || exit 143
    # Booting again is safe as long as the command has not begun.
    [ ! -e "$work/started" ] || refuse "the guest died (status $status): $(tail -n 20 "$work/kernel.log")"
    why=$("${kind}_never_works")
    if [ -n "$why" ]; then
      finding "${kind}_fails" "$why"
      return
    fi
    echo "with_vcan: the guest did not come up (attempt $attempt, status $status)" >&2
  done
  tail -n 20 "$work/kernel.log" >&2
  why="the guest did not come up (status $status)"
}
