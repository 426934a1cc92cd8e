#!/usr/bin/env bash
# Functions that the scripts share. They source this file; do not run it.

me=$(basename "$0")

# shellcheck disable=SC2034 # used by those that source this
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

die() {
  echo "$me: $*" >&2
  exit 1
}

# The header comment of a script is its --help.
print_help() {
  sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
}

# The value of a flag, or the end: flag_value "$@" with the flag in front.
flag_value() {
  [[ $# -ge 2 ]] || die "$1 needs a value"
  echo "$2"
}

# Where scripts/build puts what it builds with a preset: build_folder release
build_folder() {
  [[ $1 == release ]] && echo "$project/build" || echo "$project/build-$1"
}

# Runs a command as root: directly, or by sudo. Fails when there is neither.
as_root() {
  if ((EUID == 0)); then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    return 1
  fi
}

# LCM's UDP needs a route for multicast, which a machine without network has not. Adds one, or says how.
ensure_multicast_route() {
  local add="ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo" sudo="sudo -n"
  ((EUID != 0)) || sudo=
  ip route get 239.255.76.67 &>/dev/null || $sudo sh -c "$add" &>/dev/null || true
  ip route get 239.255.76.67 &>/dev/null || die "no network route for LCM's multicast; as root: $add"
}
