#!/bin/sh
# Gets a machine ready for `make demo` and `make test`: `sh tools/setup.sh [demo|test|style]...`
#
# On Debian and its kin it installs the distribution's own packages, only those that are missing, as root or with sudo,
# and asks nothing. Elsewhere it says what is missing and goes on. A second run finds nothing to do.
set -eu

# Loaded at run time, so that no link step would miss them: a Vulkan driver and what a window needs.
run_time="mesa-vulkan-drivers libvulkan1 libxkbcommon-x11-0 libxkbcommon0 libx11-6 libx11-xcb1 libxcursor1 libxi6 \
libxrandr2 libwayland-client0"
# The tests drive a real window on a display of their own.
for_tests="xvfb xdotool x11-apps"

say() { printf 'setup: %s\n' "$*" >&2; }

# The packages to have, by the words on the command line.
wanted() {
    printf '%s ' "$run_time"
    for word in "$@"; do
        [ "$word" = test ] && printf '%s ' "$for_tests"
    done
    command -v cc >/dev/null 2>&1 || printf 'gcc libc6-dev '
    command -v make >/dev/null 2>&1 || printf 'make '
    return 0
}

# Those of the arguments that are not installed.
missing_packages() {
    for package in "$@"; do
        status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
        [ "$status" = installed ] || printf '%s ' "$package"
    done
}

# Runs a command as root without asking for a password; fails where that can't be.
as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo -n "$@"
    else
        return 1
    fi
}

# apt-get, patient with another apt at work and with mirrors that hiccup.
apt() {
    attempt=1
    while ! as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" >&2; do
        [ "$attempt" -lt 4 ] || return 1
        say "apt-get $1 failed (attempt $attempt of 4); trying again"
        sleep $((attempt * 5))
        attempt=$((attempt + 1))
    done
}

install_packages() {
    # shellcheck disable=SC2046,SC2086 # lists of words
    lacking=$(missing_packages $(wanted "$@"))
    [ -n "$lacking" ] || return 0
    remedy="apt-get install -y --no-install-recommends $lacking"
    if ! as_root true 2>/dev/null; then
        say "missing, and neither root nor password-less sudo to install them: $lacking"
        say "run this once: sudo $remedy"
        return 0
    fi
    say "installing: $lacking"
    apt update || say "the package lists could not be refreshed; going on with those at hand"
    # shellcheck disable=SC2086 # a list of words
    apt install -y --no-install-recommends $lacking || say "could not install them; run this once: $remedy"
}

# Without apt: what the dynamic linker and the path don't know.
name_missing() {
    lacking=""
    for library in libvulkan.so.1 libxkbcommon-x11.so.0 libxkbcommon.so.0 libX11.so.6 libX11-xcb.so.1 libXcursor.so.1 \
        libXi.so.6 libXrandr.so.2 libwayland-client.so.0; do
        { ldconfig -p 2>/dev/null || true; } | grep -qF "$library" || lacking="$lacking $library"
    done
    programs="cc"
    for word in "$@"; do
        [ "$word" = test ] && programs="$programs Xvfb xdotool xwd"
    done
    for program in $programs; do
        command -v "$program" >/dev/null 2>&1 || lacking="$lacking $program"
    done
    [ -n "$lacking" ] || return 0
    say "this is no Debian, so nothing was installed. Not found:$lacking"
    say "install them with your system's package manager, and a Vulkan driver (Mesa's lavapipe will do); going on"
}

# cargo, and for the style checks its two components.
check_toolchain() {
    if ! command -v cargo >/dev/null 2>&1; then
        say "cargo was not found: install Rust from https://rustup.rs and run this again"
        exit 1
    fi
    for word in "$@"; do
        [ "$word" = style ] || continue
        for component in rustfmt clippy; do
            cargo "${component#rust}" --version >/dev/null 2>&1 && continue
            command -v rustup >/dev/null 2>&1 && rustup component add "$component" >&2 && continue
            say "$component is missing and rustup could not add it: its check will be left out"
        done
    done
}

if command -v apt-get >/dev/null 2>&1 && command -v dpkg-query >/dev/null 2>&1; then
    install_packages "$@"
else
    name_missing "$@"
fi
check_toolchain "$@"
