#!/usr/bin/env bash
# Makes a Debian package of a build: the programs, the parts that run Python, the module firn, experiments and labs.
#
#     scripts/make_package.sh BUILD FILE.deb          # ./firn package builds first
#
# It is for the Debian and the Python that the build is for. `firn reproduce` and `firn help` need the sources.
set -euo pipefail

build=$(readlink -f "$1") file=$2 root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tree=$work/tree home=$work/tree/usr/lib/firn

mkdir -p "$tree/DEBIAN" "$tree/usr/bin" "$home/bin" "$home/python" "$tree/usr/share/firn" "$tree/usr/share/doc/firn"
for program in "$build"/bin/*; do
  [[ ${program##*/} == firn-demo ]] || cp -- "$program" "$home/bin/"  # the demo lies beside its sources
done
cp -- "$build"/python/firn_*.so "$home/python/"
find "$home" -type f ! -name '*.jar' -exec strip --strip-unneeded {} +
ln -s ../lib/firn/bin/firn "$tree/usr/bin/firn"
mkdir -p "$tree/usr/share/"{bash-completion/completions,zsh/vendor-completions,fish/vendor_completions.d,man/man1}
"$build/bin/firn" completion bash >"$tree/usr/share/bash-completion/completions/firn"
"$build/bin/firn" completion zsh >"$tree/usr/share/zsh/vendor-completions/_firn"
"$build/bin/firn" completion fish >"$tree/usr/share/fish/vendor_completions.d/firn.fish"
"$build/bin/firn" completion man -o "$tree/usr/share/man/man1"
gzip -9n "$tree"/usr/share/man/man1/*.1

modules=$tree/usr/lib/python3/dist-packages/firn
mkdir -p "$modules"
cp -- "$root"/python/lib/firn/*.py "$root"/python/lib/firn/*.pyi "$root"/python/lib/firn/py.typed "$modules/"
for folder in experiments labs; do
  mkdir "$tree/usr/share/firn/$folder"
  (cd "$root/$folder" && find . -type d -name results -prune -o -type f ! -name '*.pyc' -print0 |
    xargs -0 cp --parents -t "$tree/usr/share/firn/$folder")
done
cp -- "$root/LICENSE" "$tree/usr/share/doc/firn/copyright"
cp -- "$root/python/README.md" "$tree/usr/share/doc/firn/python.md"

# Libraries that the programs are linked with, and what is loaded or run on demand.
mkdir "$work/debian"
printf 'Source: firn\n\nPackage: firn\nArchitecture: any\nDescription: x\n' >"$work/debian/control"
mapfile -t linked < <(find "$home" -type f ! -name '*.jar')
depends=$(cd "$work" && dpkg-shlibdeps -O --ignore-missing-info "${linked[@]}" 2>"$work/log" | sed -n 's/^shlibs:Depends=//p')
[[ -n $depends ]] || { cat "$work/log" >&2; exit 1; }
version=$(sed -n 's/^project(firn VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")~$(git -C "$root" log -1 --date=format:%Y%m%d --format=%cd.%h 2>/dev/null || date -u +%Y%m%d)
minor=$(basename "$home"/python/firn_core.cpython-3*.so | sed 's/.*cpython-3\([0-9]*\).*/\1/')
cat >"$tree/DEBIAN/control" <<CONTROL
Package: firn
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: The Firn authors <firn@localhost>
Installed-Size: $(du -sk "$tree" | cut -f1)
Depends: $depends, libhdf5-103-1, python3 (>= 3.$minor), python3 (<< 3.$((minor + 1))), python3-numpy
Suggests: python3-h5py, python3-matplotlib, chromium
Section: science
Priority: optional
Description: closed-loop additive manufacturing
 Prints a part layer by layer, measures the surface after each layer, decides the next layer from the measurement,
 records everything, and lets researchers replay, tune and compare feedback schemes, also those written in Python.
CONTROL
mkdir -p "$(dirname "$file")"
dpkg-deb --root-owner-group -Zzstd -z15 --build "$tree" "$file" >/dev/null
printf '%s\n' "$file"
