#!/usr/bin/env bash
# Builds the page that the program carries: view/src -> view/dist. The same sources give the same bytes.
#   ./build.sh           writes view/dist
#   ./build.sh --check   fails if view/dist is not what the sources give
# Needs Node.js 20 or newer with npm; package-lock.json says which libraries.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

target=dist
if [ "${1:-}" = --check ]; then
    target=$(mktemp -d)
    trap 'rm -rf "$target"' EXIT
fi

# what is there already, from the very same list, is not fetched again
if ! cmp -s package-lock.json node_modules/.from-lock; then
    npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
    cp package-lock.json node_modules/.from-lock
fi
npx --no-install tsc --noEmit

mkdir -p "$target"
npx --no-install esbuild src/main.ts --bundle --minify --format=esm --target=es2022 --charset=utf8 \
    --legal-comments=none --log-level=warning --outfile="$target/view.js"
npx --no-install esbuild src/view.css --bundle --minify --log-level=warning --outfile="$target/view.css"
cp src/index.html "$target/index.html"
{
    echo "This page contains the libraries below."
    for package in three uplot; do
        printf '\n%s %s\n\n' "$package" "$(node -p "require('./node_modules/$package/package.json').version")"
        cat "node_modules/$package/LICENSE"
    done
} >"$target/licences.txt"

if [ "$target" != dist ]; then
    diff -rq dist "$target" || { echo "view/dist is not what view/src gives: run view/build.sh" >&2; exit 1; }
fi
