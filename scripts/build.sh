# Functions that Allrun and Alltest share: installing packages and building. Sourced; `here` is the project's folder.
# shellcheck shell=bash
# shellcheck disable=SC2154  # here is set by the script that sources this file
install="${install:-yes}"

# install_packages LIST...: installs the packages of these files that dpkg does not report as installed.
install_packages() {
    local missing=() package sudo=() lists=("${@/#/$here/}")
    while read -r package; do
        dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2> /dev/null | grep -q '^ii' || missing+=("$package")
    done < <(grep -hv '^#' "${lists[@]}" | grep -v '^$')
    [ "${#missing[@]}" -gt 0 ] || return 0
    if [ "$install" = no ]; then
        echo "missing packages (not installed because of --no-install): ${missing[*]}" >&2
        return 0
    fi
    if ! command -v apt-get > /dev/null; then
        echo "apt-get was not found; install by hand: ${missing[*]}" >&2
        return 0
    fi
    [ "$(id -u)" = 0 ] || sudo=(sudo)
    if [ "$(id -u)" != 0 ] && ! command -v sudo > /dev/null; then
        echo "not root and no sudo; ask your administrator to run:" >&2
        echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 4
    fi
    echo "installing ${#missing[@]} Debian packages: ${missing[*]}"
    "${sudo[@]}" apt-get update -qq
    "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "${missing[@]}" > /dev/null
}

# make_venv: packages of PyPI that tests need, in build/venv; taufactor, which runs on Debian's torch, in build/venv/taufactor.
# Without them their tests are skipped, or fail in CI.
make_venv() {
    local venv="$here/build/venv" list="$here/requirements-test.txt"
    ! cmp -s "$list" "$venv/installed.txt" || return 0
    [ "$install" = yes ] || return 0
    echo "installing packages of PyPI in build/venv (requirements-test.txt)"
    rm -rf "$venv"
    mkdir -p "$here/build"
    {
        /usr/bin/python3 -m venv "$venv" &&
            "$venv/bin/pip" install -r "$list" &&
            "$venv/bin/pip" install --target "$venv/taufactor" --no-deps taufactor &&
            "$venv/bin/pip" install --target "$venv/taufactor" ipython scikit-image "numpy<2" && # torch was built for NumPy 1
            cp "$list" "$venv/installed.txt"
    } > "$here/build/venv.log" 2>&1 || echo "that failed: build/venv.log" >&2
}

# build_project PRESET FOLDER TARGET: configures if necessary and builds; prints the errors if it fails.
build_project() {
    local log="$here/$2/build.log"
    for tool in cmake ninja g++; do
        command -v "$tool" > /dev/null || { echo "$tool is missing: run without --no-install, or install the packages in packages.apt" >&2; exit 4; }
    done
    mkdir -p "$here/$2"
    if [ ! -e "$here/$2/build.ninja" ]; then
        echo "configuring (log: $2/configure.log)"
        (cd "$here" && cmake --preset "$1") > "$here/$2/configure.log" 2>&1 || { tail -n 30 "$here/$2/configure.log" >&2; exit 4; }
    fi
    echo "building (log: $2/build.log)"
    cmake --build "$here/$2" --target "$3" > "$log" 2>&1 || { grep -E -A 5 'error|FAILED' "$log" | head -n 40 >&2; exit 4; }
}
