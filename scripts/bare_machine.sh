#!/usr/bin/env bash
# A bare Debian 12 with nothing but git: clones this checkout's HEAD there, runs both commands of the README, and the slow tests.
# Packages that a developer's machine happens to have hide what scripts/dependencies.sh forgets; they are absent there.
#
# Usage, as root, with the package debootstrap: scripts/bare_machine.sh [--prepare] [--release DIR] [--copy FILE]... [FOLDER]
#   FOLDER       where the root is made, new or empty; kept. Without it: a temporary folder, removed if all passed.
#   --prepare    stop after debootstrap, the clone and scripts/dependencies.sh (minutes)
#   --release DIR  try a release that scripts/release.sh made there instead: install its packages, run them, then
#                build its archive and run the first example
#   --copy FILE  copy a file of this machine to the same path there, before anything is installed: npm's settings, for
#                example. A certificate under /usr/local/share/ca-certificates is trusted there.
#
# apt uses the mirrors, keys and Acquire settings (proxies) of this machine's apt. The last line that is printed is a row
# (date, commit, cores, times of ./run.sh, ./test.sh and the slow tests, tests passed). Exit code 1 if a command failed.
set -euo pipefail
cd "$(dirname "$0")/.."
suite=bookworm
prepare='' release='' copies=() root=''
usage() { sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2; }
while [ $# -gt 0 ]; do
  case "$1" in
    --prepare) prepare=yes ;;
    --release) [ -d "${2:-}" ] || { echo "bare_machine.sh: --release ${2:-}: no such folder" >&2; exit 2; }
               release=$(realpath "$2"); shift ;;
    --copy) [ -f "${2:-}" ] || { echo "bare_machine.sh: --copy ${2:-}: no such file" >&2; exit 2; }
            copies+=("$(realpath -s "$2")"); shift ;;
    -*) usage ;;
    *) [ -z "$root" ] || usage; root=$1 ;;
  esac
  shift
done
[ "$(id -u)" -eq 0 ] || { echo "bare_machine.sh: a root of its own needs root's rights (sudo $0)" >&2; exit 2; }
for program in debootstrap git unshare chroot; do
  command -v "$program" >/dev/null || { echo "bare_machine.sh: $program is missing: apt-get install debootstrap git" >&2; exit 2; }
done
temporary=''
if [ -z "$root" ]; then
  temporary=yes root=$(mktemp -d "${TMPDIR:-/tmp}/bare_machine.XXXXXX")
else
  mkdir -p "$root"
  [ -z "$(ls -A "$root")" ] || { echo "bare_machine.sh: $root is not empty; name a new folder" >&2; exit 2; }
fi
root=$(realpath "$root")
chmod 755 "$root"  # apt downloads as a user of its own.
[ -z "$(git status --porcelain --untracked-files=no)" ] || echo "bare_machine.sh: changes that are not committed are left out" >&2

# Debian's own mirror serves machines that are no Debian 12.
mirror=$(apt-get indextargets --format '$(CODENAME) $(COMPONENT) $(SITE)' 'Created-By: Packages' 2>/dev/null |
         awk -v suite="$suite" '$1 == suite && $2 == "main" && !found { print $3; found = 1 }')
proxies=()
for scheme in http https; do
  proxy=''
  eval "$(apt-config shell proxy "Acquire::$scheme::Proxy")"
  case "$proxy" in ''|DIRECT) ;; *) proxies+=("${scheme}_proxy=$proxy") ;; esac
done
wanted=git
[[ $mirror != https:* ]] || wanted=git,ca-certificates  # Else apt cannot read that mirror.
echo "== debootstrap into $root"
env "${proxies[@]}" debootstrap --variant=minbase --include="$wanted" "$suite" "$root" ${mirror:+"$mirror"} >"$root.debootstrap.log" 2>&1 ||
  { tail -n 20 "$root.debootstrap.log" >&2; exit 1; }
mv "$root.debootstrap.log" "$root/debootstrap.log"

# Settings of this machine's apt: where packages come from, whose keys, which proxies. Nothing else of it: hooks name
# programs that a bare machine has not.
if [ -n "$mirror" ]; then
  rm -f "$root/etc/apt/sources.list"
  copy_if_there() { for path in "$@"; do [ ! -e "$path" ] || cp -a --parents "$path" "$root"; done; }
  copy_if_there /etc/apt/sources.list /etc/apt/sources.list.d /etc/apt/preferences.d /etc/apt/keyrings /etc/apt/trusted.gpg.d \
    /etc/apt/auth.conf.d
  mapfile -t keys < <(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
                      sed -nE 's/^Signed-By: *(\/.*)/\1/p; s/.*signed-by=([^] ]*).*/\1/p' | sort -u)
  copy_if_there "${keys[@]}"
fi
apt-config dump | grep -E '^Acquire::' >"$root/etc/apt/apt.conf.d/90settings-of-the-host" || true
echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/throw-away"  # Nobody needs these packages after a power cut.
for file in /etc/resolv.conf /etc/hosts "${copies[@]}"; do
  [ ! -e "$file" ] || { mkdir -p "$root$(dirname "$file")"; cp -L "$file" "$root$file"; }
done
git bundle create --quiet "$root/root/seam.bundle" HEAD

# Mounts and processes are of namespaces of their own, and end with them.
inside() {  # inside COMMAND: by bash, in /root.
  unshare --mount --pid --ipc --uts --fork --kill-child bash -euc '
    root=$1
    mount --make-rprivate /
    mount --bind "$root" "$root"
    mount -t proc proc "$root/proc"
    mount -t sysfs sysfs "$root/sys"
    mount --rbind /dev "$root/dev"
    mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
    mount -t tmpfs -o mode=755 tmpfs "$root/run"
    exec chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 TERM=dumb PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      bash -euo pipefail -c "cd; $2"' bare_machine "$root" "$1" </dev/null
}
step() {  # step NAME COMMAND: its output in a file, its time in minutes in the variable minutes.
  local began=$SECONDS failed=0
  echo "== $1 (output: $root/root/$1.log)"
  inside "$2" >"$root/root/$1.log" 2>&1 || failed=1
  minutes=$(((SECONDS - began + 30) / 60))
  [ "$failed" = 0 ] || { tail -n 30 "$root/root/$1.log"; echo "== $1 FAILED after $minutes min"; }
  return "$failed"
}
end() {  # end CODE: what was made goes if it was temporary and all went well.
  if [ -n "$temporary" ] && [ "$1" = 0 ]; then rm -rf --one-file-system "$root"; else echo "kept: $root"; fi
  exit "$1"
}
if [ -n "$release" ]; then
  mkdir -p "$root/root/release"
  cp "$release"/*.deb "$release"/*.tar.gz "$release/SHA256SUMS" "$root/root/release"
  step packages 'cd release && sha256sum --check SHA256SUMS && apt-get update -q &&
    DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends ./*.deb &&
    seam --version && seam run /usr/share/seam/scenarios/head_swing.yaml --set duration_s=0.2 --log try.mcap && seam replay verify try.mcap' || end 1
  step archive 'tar -xzf release/seam-*.tar.gz && cd seam-* && ./run.sh' || end 1
  echo "== release: packages installed and run, archive built and run ($minutes min)"
  end 0
fi
step clone 'git clone --quiet seam.bundle seam && git -C seam log -1 --format=%h' || end 1
if [ -n "$prepare" ]; then
  step dependencies 'cd seam && scripts/dependencies.sh' || end 1
  echo "== packages installed after $minutes min"
  end 0
fi
failed=0
step run 'cd seam && ./run.sh' || failed=1
times=("$minutes min")
# The program's build alone serves a behaviour in Python, which decides as the one in C++ does.
step python 'cd seam
  for behaviour in head_swing head_swing.py; do
    build/seam run scenarios/head_swing.yaml --set robots[0].behaviour.command[0]=$behaviour --set duration_s=0.2 --json $behaviour.json
  done
  cmp <(grep "^  .fingerprint" head_swing.json) <(grep "^  .fingerprint" head_swing.py.json)' || failed=1
step test 'cd seam && ./test.sh' || failed=1
times+=("$minutes min")
step slow 'cd seam && ctest --test-dir build -L slow --output-on-failure -j "$(nproc)"' || failed=1
times+=("$minutes min")
lost=0 all=0
for log in "$root"/root/test.log "$root"/root/slow.log; do
  counted=$(sed -nE 's/.* ([0-9]+) tests failed out of ([0-9]+).*/\1 \2/p' "$log" | tail -n 1)
  read -r lost_here all_here <<<"${counted:-0 0}"
  lost=$((lost + lost_here)) all=$((all + all_here))
done
# ctest counts what was skipped as passed.
skipped=$(sed -nE 's/^[[:space:]]*[0-9]+ - (.*) \((Skipped|Not Run)\)$/\1/p' "$root"/root/{test,slow}.log | paste -sd, | sed 's/,/, /g')
printf '| %s | %s | %s |' "$(date -u +%F)" "$(tail -n 1 "$root/root/clone.log")" "$(nproc)"
printf ' %s |' "${times[@]}"
echo " $((all - lost)) of $all${skipped:+; skipped: $skipped} |"
end "$failed"
