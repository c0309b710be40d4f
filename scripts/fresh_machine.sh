#!/usr/bin/env bash
# An empty Debian in a folder, and commands in it as on a machine of its own. Needs root, debootstrap and a package source.
#
#   scripts/fresh_machine.sh make FOLDER [RELEASE]
#       Makes it: Debian 12 (bookworm), or the release of that name, such as trixie. From this machine it takes the package sources
#       of Debian 12, for the other release by its name, and what reaches them: proxies, certificates, names of hosts, npm's
#       registry.
#   scripts/fresh_machine.sh run FOLDER [--bind OUTSIDE INSIDE]... [--] COMMAND...
#       Runs COMMAND there as root with an environment of its own. It sees /sys and the network of this machine. Devices, mounts
#       and processes are its own: they end with COMMAND, or with this script if it is killed.
# Exits with 3 where no such machine can be had.
set -euo pipefail
usage() { sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "$0" >&2; exit 2; }
none() { printf 'fresh_machine: %s\n' "$*" >&2; exit 3; }

# Mounts and processes that end with the command.
in_namespaces=(unshare --mount --propagation private --pid --fork --kill-child --)

# debian_sources: files of apt that name Debian 12, and no other maker's packages.
debian_sources() {
  grep -lrE '(^|[[:space:]])bookworm(-updates|-security)?([[:space:]]|$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null
}

# npm_settings: how this machine's npm reaches its registry.
npm_settings() {
  local key value
  for key in registry cafile proxy https-proxy noproxy strict-ssl; do
    value=$(cd / && npm config get "$key" 2>/dev/null) || continue
    case $value in '' | null | undefined) ;; *) printf '%s=%s\n' "$key" "$value" ;; esac
  done
}

make_machine() {
  local root=$1 release=$2 mirror
  ((EUID == 0)) || none "needs root"
  command -v debootstrap >/dev/null || none "needs debootstrap"
  "${in_namespaces[@]}" true 2>/dev/null || none "namespaces of mounts and processes are not permitted here"
  mirror=$(debian_sources | xargs -r grep -ohE 'https?://[^[:space:]]+/debian/?([[:space:]]|$)' | head -n 1 | tr -d '[:space:]') || true
  "${in_namespaces[@]}" debootstrap --variant=minbase "$release" "$root" ${mirror:+"$mirror"} >&2 ||
    none "debootstrap failed"
  take_settings "$root" "$release"
}

# take_settings FOLDER RELEASE: what reaches the package sources.
take_settings() {
  local root=$1 release=$2 file
  rm -f "$root/etc/apt/sources.list"
  for file in $(debian_sources) /etc/apt/{trusted.gpg.d,keyrings,auth.conf,auth.conf.d} /usr/local/share/ca-certificates \
    /etc/ssl/certs/ca-certificates.crt /etc/resolv.conf /etc/hosts; do
    [[ -e $file ]] || continue
    mkdir -p "$root${file%/*}"
    cp -rL "$file" "$root${file%/*}/"
  done
  debian_sources | while read -r file; do sed -i "s/bookworm/$release/g" "$root$file"; done
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/short-lived"  # nobody needs these files after a power cut
  apt-config dump --format '%F "%v";%n' Acquire | grep -v '^Acquire::IndexTargets' >"$root/etc/apt/apt.conf.d/99host"
  ! command -v npm >/dev/null || npm_settings >"$root/root/.npmrc"
}

# make_devices FOLDER: what a container has in /dev. With this machine's /dev a damaged one here would fail there, and a command
# there that replaces /dev/null would damage this machine.
make_devices() {
  local dev=$1 name major minor
  mount -t tmpfs -o mode=755,nosuid devices "$dev"
  while read -r name major minor; do
    mknod -m 666 "$dev/$name" c "$major" "$minor" 2>/dev/null || { : >"$dev/$name"; mount --bind "/dev/$name" "$dev/$name"; }
  done <<<'null 1 3
zero 1 5
full 1 7
random 1 8
urandom 1 9
tty 5 0'
  [[ ! -c /dev/net/tun ]] || { mkdir "$dev/net"; mknod -m 666 "$dev/net/tun" c 10 200 2>/dev/null || rmdir "$dev/net"; }
  mkdir "$dev/pts" "$dev/shm"
  mount -t devpts -o newinstance,ptmxmode=666,mode=620,gid=5 devpts "$dev/pts"
  mount -t tmpfs -o mode=1777,nosuid,nodev shm "$dev/shm"
  ln -s pts/ptmx "$dev/ptmx"
  ln -s /proc/self/fd "$dev/fd"
  ln -s fd/0 "$dev/stdin"
  ln -s fd/1 "$dev/stdout"
  ln -s fd/2 "$dev/stderr"
}

# in_machine FOLDER BINDS [OUTSIDE INSIDE]... COMMAND...: inside the new namespaces, as their first process.
in_machine() {
  local root=$1 binds=$2
  shift 2
  mount --bind "$root" "$root"
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  make_devices "$root/dev"
  for (( ; binds > 0; --binds)); do
    mkdir -p "$root/$2"
    mount --bind "$1" "$root/$2"
    shift 2
  done
  local kept=(HOME=/root LANG=C.UTF-8 TERM="${TERM-dumb}" PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin) name
  for name in CI {http,https,ftp,all,no}_proxy {HTTP,HTTPS,FTP,ALL,NO}_PROXY NODE_EXTRA_CA_CERTS $(compgen -e CCACHE_ || true); do
    [[ ! -v $name ]] || kept+=("$name=${!name}")
  done
  env -i "${kept[@]}" chroot "$root" "$@"
}

case ${1-} in
  make)
    (($# == 2 || $# == 3)) || usage
    make_machine "$2" "${3:-bookworm}"
    ;;
  run)
    (($# >= 3)) || usage
    root=$(realpath "$2") binds=()
    shift 2
    while [[ ${1-} == --bind ]]; do
      (($# > 3)) || usage
      binds+=("$(realpath "$2")" "$3")
      shift 3
    done
    [[ ${1-} != -- ]] || shift
    (($#)) || usage
    exec "${in_namespaces[@]}" "$(readlink -f "$0")" in-namespaces "$root" $((${#binds[@]} / 2)) "${binds[@]}" "$@"
    ;;
  in-namespaces)
    shift
    in_machine "$@"
    ;;
  *) usage ;;
esac
