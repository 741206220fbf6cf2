# QEMU as the guest of scripts/with_vcan: Debian's own kernel on an emulated machine, or on the processor itself where
# KVM can be had. Sourced after guest.sh, never run.
#
# The guest's root is the host's "/" by 9p, cached: what the guest writes reaches the host within a second or two, at the
# latest with the guest's end; what the host writes meanwhile the guest may not see. Output and status go by files in
# $work, which are not cached.
# shellcheck shell=bash

guest_kernel=$sextant_root/.cache/guest-kernel # vmlinux, modules/ and version, which scripts/setup fetches

# In the order of their loading.
qemu_modules=(
  drivers/virtio/virtio_ring drivers/virtio/virtio drivers/virtio/virtio_pci_legacy_dev
  drivers/virtio/virtio_pci_modern_dev drivers/virtio/virtio_pci
  net/9p/9pnet net/9p/9pnet_virtio fs/netfs/netfs fs/fscache/fscache fs/9p/9p
  drivers/net/can/dev/can-dev net/can/can net/can/can-raw net/can/can-bcm net/can/can-gw net/can/can-isotp
  drivers/net/can/vcan drivers/net/can/vxcan net/sched/sch_tbf
)

qemu_missing() {
  missing_programs qemu-system-x86_64 busybox ip
  [ -s "$guest_kernel/version" ] || printf '%s ' "a kernel for the guest"
}

# kvm_may_work: a /dev/kvm alone is no proof. Without these processor flags it needs a kernel made for it.
kvm_may_work() {
  [ -r /dev/kvm ] && [ -w /dev/kvm ] && grep -q -E '^flags.* (vmx|svm)( |$)' /proc/cpuinfo &&
    [ -z "$(finding kvm_fails)" ]
}

qemu_prepare() { write_initramfs; }

# write_initramfs: $work/initramfs, which loads the modules and goes over to the host's file system and $work/init.
write_initramfs() {
  local tree=$work/tree module index=100
  mkdir -p "$tree"/{bin,dev,proc,root,modules}
  cp "$(command -v busybox)" "$tree/bin/busybox"
  for module in "${qemu_modules[@]##*/}"; do
    cp "$guest_kernel/modules/$module.ko" "$tree/modules/$((index++))-$module.ko"
  done
  cat >"$tree/init" <<GUEST
#!/bin/busybox sh
for module in /modules/*; do /bin/busybox insmod \$module; done
/bin/busybox mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose root /root
/bin/busybox mount -t 9p -o trans=virtio,version=9p2000.L,msize=65536,cache=none work /root$work
exec /bin/busybox switch_root /root $work/init
GUEST
  chmod 755 "$tree/init"
  (cd "$tree" && find . | busybox cpio -o -H newc 2>/dev/null) >"$work/initramfs"
  rm -rf "$tree"
}

qemu_init() {
  cat <<'GUEST'
echo 100 >/proc/sys/vm/dirty_expire_centisecs
echo 100 >/proc/sys/vm/dirty_writeback_centisecs
exec 3>>$work/out 4>>$work/err
GUEST
}

qemu_finish() { echo 'timeout 20 sync'; }

# boot_with ACCELERATOR: the guest's output arrives in files, from which it goes on at once. A file keeps every byte
# whatever becomes of the guest, which a virtual console does not.
boot_with() {
  local processors=1 model=host clock='' owner=none alive out err status
  [ "$(id -u)" != 0 ] || owner=passthrough
  # Two emulated processors without real-time scheduling wait for each other, three times longer on a busy host.
  if [ "$(nproc)" -ge 2 ] && { [ "$1" = kvm ] || chrt -p $$ 2>/dev/null | grep -q -E 'SCHED_(RR|FIFO)'; }; then
    processors=2
  fi
  # The emulated counter follows the host's clock; the kernel would distrust it and read a slow one, and not go on where a
  # busy host delays its first ticks.
  [ "$1" = kvm ] || { model=max,la57=off clock='clocksource=tsc tsc=reliable no_timer_check'; }
  : >"$work/out"
  : >"$work/err"
  sleep infinity &
  alive=$!
  tail -f -s 0.05 -c +1 --pid=$alive "$work/out" 2>/dev/null &
  out=$!
  tail -f -s 0.05 -c +1 --pid=$alive "$work/err" 1>&2 2>/dev/null &
  err=$!
  run_and_wait timeout -k 5 "$limit" \
    qemu-system-x86_64 -accel "$1" -cpu "$model" -smp $processors -m "${memory:-1G}" -M pc -nodefaults -no-user-config \
    -display none -serial stdio -no-reboot -pidfile "$work/qemu.pid" \
    -fsdev local,id=root,path=/,security_model=$owner,multidevs=remap -device virtio-9p-pci,fsdev=root,mount_tag=root \
    -fsdev local,id=work,path="$work",security_model=$owner -device virtio-9p-pci,fsdev=work,mount_tag=work \
    -kernel "$guest_kernel/vmlinux" -initrd "$work/initramfs" \
    -append "console=ttyS0 quiet loglevel=1 panic=-1 mitigations=off preempt=full nowatchdog $clock" \
    >"$work/kernel.log" 2>&1
  status=$?
  { kill $alive && wait $alive "$out" "$err"; } 2>/dev/null
  return $status
}

# end_unless_started SECONDS: ends a guest that has not reached the command by then.
end_unless_started() {
  local i
  for ((i = 0; i < $1 * 10; i++)); do
    [ ! -e "$work/started" ] || return 0
    sleep 0.1
  done
  kill "$(cat "$work/qemu.pid")" 2>/dev/null
}

qemu_boot() {
  local status watch
  if kvm_may_work; then
    rm -f "$work/qemu.pid"
    end_unless_started 30 &
    watch=$!
    boot_with kvm
    status=$?
    { kill $watch; wait $watch; } 2>/dev/null
    if [ -e "$work/started" ] || [ $status = 124 ] || [ $status = 137 ] || [ $status = 143 ]; then return $status; fi
    finding kvm_fails yes
    echo "with_vcan: no guest comes up by KVM on this machine; its processor is emulated" >&2
  fi
  boot_with tcg
}

qemu_never_works() { :; }
