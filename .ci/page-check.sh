#!/bin/sh
# page-check.sh DOM NAME: whether the DOM of an opened page has what it must have.
set -eu
fail() {
    echo "page-test: $2: $1" >&2
    grep -oE 'data-errors="[^"]*"' "$dom" >&2 || true
    exit 1
}
dom=$1
grep -qE 'data-ready="frames:[1-9][0-9]*"' "$dom" || fail "the page did not get ready" "$2"
grep -qF 'data-errors="[]"' "$dom" || fail "there were errors" "$2"
grep -qE '<canvas' "$dom" || fail "there is no picture" "$2"
for id in slider play speed frame parameters scene plots; do
    grep -qF "id=\"$id\"" "$dom" || fail "there is no #$id" "$2"
done
[ "$(grep -oE 'id="slider"[^>]*max="[0-9]+"|max="[0-9]+"[^>]*id="slider"' "$dom" | wc -l)" -gt 0 ] || fail "the slider has no range" "$2"
echo "page-test: $2: $(grep -oE 'frames:[0-9]+' "$dom" | head -1), $(grep -o 'class="uplot' "$dom" | wc -l) plots, no errors"
