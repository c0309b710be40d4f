#!/usr/bin/env bash
# Makes the Debian packages of a build: firn (programs, experiments, labs, documents), firn-dev (core for find_package(Firn)),
# python3-firn (the module firn, controllers in Python) and firn-doc (the documents as pages for a browser).
#
#     scripts/make_package.sh BUILD FOLDER            # ./firn package builds first
#
# They are for the Debian and the Python that the build is for. What lies where is told by cmake/install.cmake.
set -euo pipefail

build=$(readlink -f "$1") folder=$2 root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$folder"

# Debian's policy 5.6.2 wants an address that answers: that of whoever packages it, as other programs of Debian take it from
# the environment, else the author's of the last commit.
maintainer=${DEBEMAIL:+${DEBFULLNAME:-$(id -un)} <$DEBEMAIL>}
maintainer=${maintainer:-$(git -C "$root" log -1 --format='%an <%ae>' 2>/dev/null || true)}
[[ $maintainer == *'<'*@*'>' ]] || { echo "make_package.sh: DEBEMAIL is not set, and there is no commit that names an author" >&2; exit 2; }

# 1.0.0-1 of a commit with the tag v1.0.0; after it 1.0.0+DAY.COMMIT-1.
version=$(sed -n 's/^project(firn VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
if [[ $(git -C "$root" tag --points-at HEAD 2>/dev/null) != *"v$version"* ]]; then
  version+=+$(git -C "$root" log -1 --date=format:%Y%m%d --format=%cd.%h 2>/dev/null || date -u +%Y%m%d)
fi
version+=-1
day=$(git -C "$root" log -1 --format=%cD 2>/dev/null || date -R)
minor=$(sed -n 's/.*cpython-3\([0-9]*\).*/\1/p' <<<"$(echo "$build"/python/firn_core.cpython-3*.so)")

# lay NAME: what the build installs for the package, below its tree.
lay() {
  cmake --install "$build" --component "$1" --prefix "$work/$1/usr" >/dev/null
}

# needed NAME: libraries that its programs are linked with.
needed() {
  local files
  mkdir -p "$work/debian"
  printf 'Source: firn\n\nPackage: %s\nArchitecture: any\nDescription: x\n' "$1" >"$work/debian/control"
  mapfile -t files < <(find "$work/$1" -type f -perm -u+x ! -name '*.py' -o -type f -name '*.so')
  (cd "$work" && dpkg-shlibdeps -O --ignore-missing-info "${files[@]}" 2>"$work/log" | sed -n 's/^shlibs:Depends=//p') ||
    { cat "$work/log" >&2; exit 1; }
}

# opened NAME: packages of the libraries that its programs open while they run, by the sonames in them.
opened() {
  local so
  find "$work/$1/usr/lib/firn" -type f -perm -u+x -exec grep -haoE 'libhdf5_serial(_hl)?\.so\.[0-9]+' {} + | sort -u | while read -r so; do
    dpkg -S "*/$so" | sed 's/:.*//;q'
  done | sed -z 's/\n\(.\)/, \1/g'
}

# pack NAME ARCHITECTURE FIELDS DESCRIPTION: copyright, changes, sums, control; then the package.
pack() {
  local name=$1 architecture=$2 fields=$3 description=$4 tree=$work/$1 doc
  doc=$tree/usr/share/doc/$name
  mkdir -p "$doc" "$tree/DEBIAN"
  cat >"$doc/copyright" <<'COPYRIGHT'
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: Firn

Files: *
Copyright: 2026 The Firn authors
License: Apache-2.0
 On Debian systems the full text of the Apache License, version 2.0, is in /usr/share/common-licenses/Apache-2.0.
COPYRIGHT
  if [[ $name == firn ]]; then gzip -9nc "$root/CHANGELOG.md" >"$doc/changelog.gz"; fi
  printf 'firn (%s) unstable; urgency=medium\n\n  * CHANGELOG.md, which is changelog.gz of the package firn.\n\n -- %s  %s\n' \
    "$version" "$maintainer" "$day" | gzip -9n >"$doc/changelog.Debian.gz"
  find "$tree/usr" -type d -exec chmod 755 {} +
  find "$tree/usr" -type f -exec chmod go=rX {} +
  (cd "$tree" && find usr -type f -print0 | LC_ALL=C sort -z | xargs -0 md5sum) >"$tree/DEBIAN/md5sums"
  cat >"$tree/DEBIAN/control" <<CONTROL
Package: $name
Source: firn
Version: $version
Architecture: $architecture
Maintainer: $maintainer
Installed-Size: $(du -sk "$tree/usr" | cut -f1)
$fields
Priority: optional
$description
CONTROL
  sed -i '/^$/d' "$tree/DEBIAN/control"
  [[ $name != firn ]] || sed -i '/^Source: firn$/d' "$tree/DEBIAN/control"
  local file=$folder/${name}_${version}_$architecture.deb
  dpkg-deb --root-owner-group -Z"${DPKG_DEB_COMPRESSOR_TYPE:-xz}" --build "$tree" "$file" >/dev/null
  printf '%s\n' "$file"
}

amd64=$(dpkg --print-architecture)
lay firn
find "$work/firn/usr/lib/firn" -type f ! -name '*.jar' -exec strip --strip-unneeded {} +
find "$work/firn/usr/share/man" -name '*.1' -exec gzip -9n {} +
mkdir -p "$work/firn/usr/share/doc/firn"
cp "$root/cmake/install/README.Debian" "$work/firn/usr/share/doc/firn/"
pack firn "$amd64" "Depends: $(needed firn), $(opened firn)
Recommends: python3-firn
Suggests: firn-doc, coinor-cbc, chromium
Section: science" "Description: closed-loop additive manufacturing
 Prints a part layer by layer, measures the surface after each layer, decides
 the next layer from the measurement, records everything, and lets researchers
 replay, tune and compare feedback schemes.
 .
 Three labs are simulated instrument by instrument, so that all of it can be
 tried without a printer: firn demo."

lay python3-firn
find "$work/python3-firn/usr/lib/firn" -type f -exec strip --strip-unneeded {} +
mkdir -p "$work/python3-firn/usr/share/doc/python3-firn"
cp "$root/python/README.md" "$work/python3-firn/usr/share/doc/python3-firn/"
pack python3-firn "$amd64" "Depends: firn (= $version), $(needed python3-firn), python3 (>= 3.$minor), python3 (<< 3.$((minor + 1))), python3-numpy
Suggests: python3-h5py, python3-matplotlib
Section: python" "Description: closed-loop additive manufacturing: module for Python
 Runs as NumPy arrays, prints in simulated time, comparisons of feedback
 schemes, and schemes written in Python."

lay firn-dev
find "$work/firn-dev/usr/lib" -name '*.a' -exec strip --strip-debug {} +
pack firn-dev "$amd64" "Depends: libsleef-dev, libpng-dev, libpolyclipping-dev, libopencv-core-dev, libopencv-imgproc-dev
Suggests: cmake
Section: libdevel" "Description: closed-loop additive manufacturing: libraries for development
 Headers and static libraries of Firn's pure part: grids, surfaces, model,
 feedback schemes, slicing, certified motion, statistics. With CMake:
 find_package(Firn), then Firn::control and others."

site=$work/firn-doc/usr/share/doc/firn-doc/html
mkdir -p "${site%/*}"
"$root/scripts/make_site.py" "$site"
rm -f "$site"/sitemap.xml*  # of a site that has an address
pack firn-doc all "Suggests: firn
Section: doc" "Description: closed-loop additive manufacturing: documents
 All documents of Firn as pages for a browser, with a search that works
 without a server: /usr/share/doc/firn-doc/html/index.html."
