# Sourced by the other scripts of this folder: messages, Debian packages, pip. Every failure ends in one sentence with a remedy.

say() { printf '[kanefe] %s\n' "$*"; }
# What works beside us ends first: the error is the last line.
die() { [ -z "${beside:-}" ] || wait "$beside" || true; printf '[kanefe] error: %s\n' "$*" >&2; exit 1; }

log_dir=${TMPDIR:-/tmp}

# quietly NAME COMMAND...: the output goes to a log, whose end is shown when the command fails.
quietly() {
  local name=$1
  shift
  log=$(mktemp "$log_dir/kanefe-$name.XXXXXX") || die "no temporary file can be made in $log_dir; free some space there or set TMPDIR"
  if "$@" >"$log" 2>&1 </dev/null; then
    rm -f "$log"
    return 0
  fi
  tail -n 6 "$log" | cut -c1-300 | sed 's/^/    | /' >&2
  return 1
}

log_says() { grep -qiE "$1" "$log"; }

readonly no_network='could not resolve|temporary failure (in name resolution|resolving)|name or service not known|failed to fetch|cannot initiate the connection|could not connect|unable to connect|newconnectionerror|connecttimeout|max retries exceeded|network is unreachable|connection (refused|timed out)'

on_debian() { command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; }

# missing_packages NAME...: those that are not installed.
missing_packages() {
  local name
  for name in "$@"; do
    dpkg-query -W -f '${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || printf '%s ' "$name"
  done
}

# install_packages NAME...: apt is asked only when a package is missing, so a second run needs no network.
install_packages() {
  local missing as_root=() updated=yes start=$SECONDS
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || die "these Debian packages are missing: ${missing% }; run this as root, or install sudo, or ask an administrator for: apt-get install $missing"
    sudo -n true 2>/dev/null || { [ -t 0 ] && sudo -v; } || die "these Debian packages are missing: ${missing% }; sudo was refused: run this as root or ask an administrator for: apt-get install $missing"
    as_root=(sudo)
  fi
  say "Debian packages to install: ${missing% }"
  if ! quietly apt "${as_root[@]}" apt-get -o APT::Update::Error-Mode=any -o DPkg::Lock::Timeout=300 update 2>/dev/null; then
    # One broken source of several may not matter; when none answers, asking for each package would take minutes.
    updated=no
    if log_says "$no_network" && ! log_says '^(hit|get):'; then
      die "apt cannot reach its package mirror; check the network and the sources of apt, then run this again"
    fi
  fi
  # shellcheck disable=SC2086
  if ! quietly apt "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends $missing; then
    log_says 'no space left|enough free space' && die "the disk is too full for the Debian packages; free about 3 GB and run this again"
    log_says 'could not get lock|unable to acquire' && die "another package manager is running; wait for it to end and run this again"
    if log_says "$no_network" || { [ $updated = no ] && log_says 'unable to locate package|no installation candidate'; }; then
      die "apt cannot reach its package mirror; check the network and the sources of apt, then run this again"
    fi
    log_says 'unable to locate package|no installation candidate' && die "this system has no package for some of: ${missing% }; use Debian 12 or newer with its 'main' section enabled in the sources of apt"
    die "apt-get could not install ${missing% }; the whole log is $log"
  fi
  say "Debian packages installed in $((SECONDS - start)) s"
}

# pip_install PYTHON ARGUMENT...: a few tries, so that without a network it ends soon. Python compiles what it imports.
pip_install() {
  local python=$1 start=$SECONDS
  shift
  if ! quietly pip "$python" -m pip install --disable-pip-version-check --no-input --retries 3 --no-compile "$@"; then
    log_says 'no space left' && die "the disk is too full for the Python packages; free 1 GB and run this again"
    log_says "$no_network" && die "pip cannot reach its package index; check the network and the configuration of pip, then run this again"
    die "pip could not install the Python packages; the whole log is $log"
  fi
  say "Python packages installed in $((SECONDS - start)) s"
}

# make_environment PYTHON FOLDER [OPTION...]: a fresh virtual environment; only one that these scripts made is replaced.
make_environment() {
  local python=$1 folder=$2
  shift 2
  if [ -e "$folder" ] && [ ! -e "$folder/.kanefe" ]; then
    die "$folder exists and was not made by this set-up; move it away and run this again"
  fi
  rm -rf "$folder"
  mkdir "$folder" || die "$folder cannot be made; check that this folder is writable"
  touch "$folder/.kanefe"
  quietly venv "$python" -m venv "$@" "$folder" || die "$python cannot make a virtual environment in $folder; see the lines above (Debian: apt-get install python3-venv)"
  say "environment $folder made with $("$folder/bin/python" --version)"
}

# fingerprint FILE... : changes whenever the set-up must be done again (its recipe, the system, the place of the checkout).
fingerprint() { { cat "$@" /etc/os-release .ci/common.sh 2>/dev/null; pwd; } | sha256sum | cut -c1-64; }

# up_to_date FOLDER STAMP FINGERPRINT
up_to_date() { [ "$(cat "$1/$2" 2>/dev/null)" = "$3" ] && "$1/bin/python" -c pass 2>/dev/null; }

# One set-up at a time in this checkout.
lock() {
  { exec 9>.venv.lock; } 2>/dev/null || die "this folder is not writable: $PWD"
  flock -n 9 || { say "waiting for another set-up in this folder"; flock 9; }
}

# What the user has set for other Pythons must not reach ours.
unset PYTHONHOME PYTHONPATH VIRTUAL_ENV
export PYTHONNOUSERSITE=1 LC_ALL=C.UTF-8
