#!/bin/sh
# Opens the page of a run in headless Chromium, from file:// or from `meniscus view`, and looks at what came of it.
#   .ci/page-test.sh MENISCUS DIR    writes the page of the output folder DIR with the binary MENISCUS, then opens it
#   .ci/page-test.sh PAGE.html|DIR   opens a page that is there already
#   .ci/page-test.sh http://…        opens the page of a server
# SHOTS=folder keeps the screenshots. Without Chromium, and no right to install it, the test is skipped.
set -eu

if [ $# -eq 2 ]; then
    "$1" page "$2"
    set -- "$2"
fi
page=$1
case $page in
http://*) ;;
*)
    [ -d "$page" ] && page=$page/page/index.html
    [ -f "$page" ] || { echo "page-test: there is no $page" >&2; exit 4; }
    page=file://$(cd "$(dirname "$page")" && pwd)/$(basename "$page")
    ;;
esac

browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$browser" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    { apt-get update && apt-get install -y --no-install-recommends chromium; } >/dev/null 2>&1 || true
    browser=$(command -v chromium || true)
fi
if [ -z "$browser" ]; then
    echo "page-test: SKIPPED: no Chromium here and it cannot be installed"
    exit 0
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
shots=${SHOTS:-$work}
mkdir -p "$shots"

# open NAME HASH WIDTH,HEIGHT: the page's DOM to $work/NAME.html, its picture to $shots/NAME.png.
open() {
    for what in --dump-dom "--screenshot=$shots/$1.png"; do
        timeout 120 "$browser" --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader \
            --hide-scrollbars --virtual-time-budget=15000 --disable-background-networking \
            --disable-component-update --disable-sync --no-first-run --disable-quic \
            --user-data-dir="$work/profile" --window-size="$3" "$what" "$page$2" \
            >"$work/out" 2>"$work/log" || { cat "$work/log" >&2; echo "page-test: the browser failed" >&2; exit 1; }
        [ "$what" = --dump-dom ] && mv "$work/out" "$work/$1.html"
    done
    sh "$(dirname "$0")/page-check.sh" "$work/$1.html" "$1"
    [ -s "$shots/$1.png" ] || { echo "page-test: $1: no screenshot" >&2; exit 1; }
}

open wide "" 1280,900
open narrow "#frame=1" 480,1000
open plain "#plain" 1280,900
