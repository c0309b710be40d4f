#!/usr/bin/env bash
# Lints of a few seconds, on what is about to be committed. To have git call it before each commit:
#   ln -s "$PWD/scripts/pre_commit.sh" "$(git rev-parse --git-path hooks)/pre-commit"
set -euo pipefail
cd "$(git rev-parse --show-toplevel)"

mapfile -t files < <(git diff --cached --name-only --diff-filter=ACMR)
status=0
for file in "${files[@]}"; do
  case $file in
    *.h | *.cpp)
      git show ":$file" | clang-format --assume-filename="$file" | cmp -s - <(git show ":$file") || {
        printf 'pre_commit: %s: clang-format would change it\n' "$file" >&2
        status=1
      }
      ;;
    *.sh | firn | .ci/run) git show ":$file" | bash -n || status=1 ;;
  esac
done
for lint in layers house packages tests docs; do
  python3 -B "scripts/check_$lint.py" >/dev/null || { python3 -B "scripts/check_$lint.py" >&2 || true; status=1; }
done
exit "$status"
