# Sourced by the scripts: where the project lies, what it needs, and how that gets installed. Debian 12 is what it is
# tested on. Everything here talks on standard error: standard output belongs to the trace.

# The script's own folder, through symbolic links, from any working directory.
project=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")

run_packages="g++ cmake ninja-build libeigen3-dev libboost-graph-dev nlohmann-json3-dev libsundials-dev libsuitesparse-dev libcli11-dev graphviz gnuplot-nox librsvg2-bin fonts-liberation fontconfig"
study_packages="libspectra-dev" # of bgsim-studies alone
fit_packages="libceres-dev libnlopt-dev" # of bgsim fit alone
test_packages="$run_packages $study_packages $fit_packages catch2 python3 python3-jsonschema clang-format clang libclang-rt-dev mold"
browser_packages="chromium"
oracle_packages="python3-numpy python3-scipy" # of scripts/oracle
lint_packages="$test_packages clang-tidy"

say() { printf '%s\n' "$*" >&2; }
die() { say "$@"; exit 2; }

# Installs those of the named Debian packages that are missing. Costs one dpkg-query (about 10 ms) if none is.
install_packages() {
  command -v dpkg-query >/dev/null || {
    say "note: no dpkg here; taking for granted that these are installed under their own names: $*"
    return 0
  }
  local installed package missing=()
  # It fails where a package has never been heard of, which is the very case this is for.
  installed=" $(dpkg-query -W -f '${db:Status-Status} ${Package} ' "$@" 2>/dev/null || true)"
  for package in "$@"; do
    [[ $installed == *" installed $package "* ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  local root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || die "These packages are missing: ${missing[*]}" \
      "Installing them takes root, and there is no sudo here. As root, run:" \
      "  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
    # Without a terminal nobody can type a password: then fail at once rather than hang.
    if [[ -t 0 ]]; then root=(sudo); else root=(sudo -n); fi
    "${root[@]}" true || die "sudo refused to install the missing packages: ${missing[*]}" \
      "As root, run: apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  fi
  say "Installing: ${missing[*]}"
  local apt=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=600)
  local log
  log=$(mktemp)
  # A repository of no concern here may be out of reach: what decides is whether the install works.
  "${apt[@]}" update </dev/null >"$log" 2>&1 || say "note: apt-get update complained; going on"
  if ! "${apt[@]}" install --no-install-recommends "${missing[@]}" </dev/null >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    rm -f "$log"
    die "apt-get could not install: ${missing[*]}"
  fi
  rm -f "$log"
}

# npm fetches the plotting library of the report's page (cmake/Web.cmake). Any npm will do; Debian's package brings
# Node.js and some three hundred small ones, so it is installed only where there is none.
install_npm() { command -v npm >/dev/null || install_packages npm; }

# A build folder that was made for another place (a copied checkout) is of no use to CMake: start it again.
drop_foreign_build() {
  local cache=$1/CMakeCache.txt
  [[ -f $cache ]] || return 0
  grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$project" "$cache" || rm -rf "$1"
}
