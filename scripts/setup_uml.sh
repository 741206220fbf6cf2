# The User Mode Linux of Debian unstable for scripts/setup: where the installed one does not run. Sourced, never run. It is
# unpacked in .cache/guest-uml, with its C library, and not installed; apt's own configuration, lists and cache stay as they
# are. Which version it is, the archive decides: only a guest that came up with vcan shows that one runs here.
# shellcheck shell=bash

# debian_mirror: the address of the Debian archive that this machine is configured with.
debian_mirror() {
  # shellcheck disable=SC2016
  apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Label: Debian' 'Component: main' 2>/dev/null |
    sed -n 1p
}

# apt_unstable PROGRAM ARGUMENTS...: apt-get or apt-cache with Debian unstable as its one source and with state in $part.
apt_unstable() {
  "$1" -q -o Dir::Etc::sourcelist="$part/unstable.list" -o Dir::Etc::sourceparts=- \
    -o Dir::Etc::preferences=- -o Dir::Etc::preferencesparts=- -o APT::Default-Release= \
    -o Dir::State="$part/state" -o Dir::State::status="$part/status" -o Dir::Cache="$part/cache" \
    -o Acquire::Languages=none -o APT::Update::Error-Mode=any "${@:2}"
}

# uml_version: of the package that apt_unstable offers; nothing where it offers none.
uml_version() { apt_unstable apt-cache show --no-all-versions user-mode-linux 2>/dev/null | sed -n 's/^Version: //p'; }

# download_uml: user-mode-linux and the packages it depends on, unpacked in $part/tree; otherwise says why not, in reason.
download_uml() {
  local keyring=/usr/share/keyrings/debian-archive-keyring.gpg mirror options packages package
  mirror=$(debian_mirror)
  if [ -z "$mirror" ] && can_be_root && apt update; then mirror=$(debian_mirror); fi
  reason="no package source of this system is a Debian archive, which has a User Mode Linux that runs here"
  [ -n "$mirror" ] || return 1
  options="target=Packages arch=$(dpkg --print-architecture)"
  [ ! -e $keyring ] || options+=" signed-by=$keyring"
  echo "deb [$options] $mirror unstable main" >"$part/unstable.list"
  : >"$part/status"
  reason="apt-get could not read the suite unstable of $mirror ($log has apt's words)"
  apt_unstable apt-get update >>"$log" 2>&1 || return 1
  reason="the suite unstable of $mirror has no package user-mode-linux"
  [ -n "$(uml_version)" ] || return 1
  mapfile -t packages < <(apt_unstable apt-cache depends user-mode-linux 2>>"$log" | sed -n 's/^ *Depends: \([^<]*\)$/\1/p')
  reason="apt-get could not download user-mode-linux of $mirror, suite unstable ($log has apt's words)"
  (cd "$part" && apt_unstable apt-get download user-mode-linux "${packages[@]}") >>"$log" 2>&1 || return 1
  reason="dpkg-deb could not unpack user-mode-linux of $mirror, suite unstable ($log has its words)"
  for package in "$part"/*.deb; do
    dpkg-deb -x "$package" "$part/tree" >>"$log" 2>&1 || return 1
  done
}

# assemble_uml: $part/new from $part/tree, made for the place $guest_uml; otherwise says why not, in reason.
assemble_uml() {
  local new=$part/new version=$1 kernel module place
  place=$(realpath -m "$guest_uml")
  reason="user-mode-linux $version of Debian unstable lacks a file that guests need ($log names it)"
  mkdir -p "$new/modules"
  kernel=$(echo "$part"/tree/usr/lib/uml/modules/*/kernel)
  {
    for module in "${uml_modules[@]}"; do
      install -D -m 644 "$kernel/$module.ko" "$new/modules/$module.ko" || return 1
    done
    rm -rf "$part"/tree/usr/lib/*-linux-gnu/gconv
    mv "$part"/tree/usr/lib/*-linux-gnu "$new/lib" && mv "$part/tree/usr/bin/linux.uml" "$new/" || return 1
    reason="patchelf could not prepare user-mode-linux $version of Debian unstable ($log has its words)"
    # shellcheck disable=SC2016
    patchelf --set-interpreter "$place/lib/ld-linux-x86-64.so.2" --force-rpath --set-rpath '$ORIGIN/lib' \
      "$new/linux.uml" || return 1
  } >>"$log" 2>&1
  printf '%s\n' "$version" "$place" >"$new/version"
}

# fetch_uml: whether .cache/guest-uml holds the newest User Mode Linux and it offers vcan; otherwise says why not, in reason,
# and keeps nothing.
fetch_uml() {
  local part=$guest_uml.part version status=0
  say "setup: fetching user-mode-linux of Debian unstable (50 MB) into .cache/guest-uml: neither this kernel nor the" \
    "installed User Mode Linux offers vcan here"
  rm -rf "$guest_uml" "$part"
  mkdir -p "$part"/{state/lists/partial,cache/archives/partial,tree}
  if download_uml; then
    version=$(uml_version)
    if assemble_uml "$version"; then
      mv "$part/new" "$guest_uml"
      try_uml || status=$?
      reason="user-mode-linux $version of Debian unstable does not offer vcan here: $(tail -n 1 "$log")"
      [ $status != 124 ] || reason="a guest of user-mode-linux $version of Debian unstable did not end within $uml_limit s"
      [ $status = 0 ] || rm -rf "$guest_uml"
    fi
  fi
  rm -rf "$part"
  uml_is_fetched
}
