# The JavaScript that pages load, for scripts/setup: npm packages in the versions and with the hashes of
# scripts/web/package-lock.json. What pages need of them goes beside these pages, in folders that git ignores, with the
# licences and that file. Sourced, never run.
# shellcheck shell=bash

web=$sextant_root/scripts/web
page_vendor=$sextant_root/scripts/sextant_py/dashboard/page/vendor
site_vendor=$sextant_root/scripts/sextant_py/site/vendor

web_is_fetched() {
  cmp -s "$web/package-lock.json" "$page_vendor/package-lock.json" &&
    cmp -s "$web/package-lock.json" "$site_vendor/package-lock.json"
}

# bring_npm FOLDER: an npm on the PATH: that of the machine, else one in FOLDER.
bring_npm() {
  ! command -v npm >/dev/null || return 0
  say "setup: fetching npm (65 MB), which this machine lacks, for the time of this set-up"
  { "$python" -m venv "$1" && "$1/bin/python" -m pip install --quiet --disable-pip-version-check --no-input \
    -r "$web/requirements.txt"; } >>"$log" 2>&1 || die "pip could not install npm ($log has pip's words)."
  PATH=$1/bin:$PATH
}

# fetch_web: the packages, by the machine's own configuration of npm; a package whose hash differs is refused by npm.
fetch_web() {
  ! web_is_fetched || return 0
  local part=$sextant_root/.cache/web.part words
  rm -rf "$part"
  mkdir -p "$part"
  cp "$web/package.json" "$web/package-lock.json" "$part/"
  bring_npm "$part/npm"
  say "setup: fetching $(grep -c '"integrity"' "$web/package-lock.json") npm packages that pages load"
  if ! words=$(cd "$part" && npm ci --ignore-scripts --no-audit --no-fund --no-update-notifier 2>&1); then
    printf '%s\n' "$words" >>"$log"
    ! grep -q EINTEGRITY <<<"$words" ||
      die "npm found a package whose hash is not that of scripts/web/package-lock.json ($log has npm's words)."
    die "npm could not fetch the packages of scripts/web; check the network or npm's configuration ($log has its words)."
  fi
  install_web "$part/node_modules" || die "an npm package of scripts/web lacks a file that pages load."
  rm -rf "$part"
}

# install_web NODE_MODULES: what pages need; package-lock.json last, which says that all of it is there.
install_web() {
  rm -rf "$page_vendor" "$site_vendor" &&
    install -D -m 644 -t "$page_vendor/uplot" "$1"/uplot/{LICENSE,dist/uPlot.esm.js,dist/uPlot.min.css} &&
    install -D -m 644 "$1/iframe-worker/shim/index.js" "$site_vendor/iframe-worker.js" &&
    install -D -m 644 "$1/iframe-worker/LICENSE" "$site_vendor/iframe-worker.LICENSE" &&
    install -m 644 "$web/package-lock.json" "$page_vendor/" && install -m 644 "$web/package-lock.json" "$site_vendor/"
}
