# shellcheck shell=bash
# Where the tests keep what takes long to make or fetch and does not depend on the sources; sourced, not run. It is outside of
# target, so that a fresh clone finds it. Everything in it is named by a digest of what it is made from, and may be removed.
CACHE=${SCANRIG_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/scanrig}
mkdir -p "$CACHE"
