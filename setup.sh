#!/bin/sh
# Makes the virtual environment VENV with tendril and its pinned packages.
# usage: setup.sh VENV EXTRAS, for instance: setup.sh .venv "[test]"
set -eu
venv=$1
extras=${2:-}
cd "$(dirname "$0")"

# Two of these at once (`make run` beside `make test`) would spoil each other's environment.
exec 9>.setup.lock
flock 9
if [ -e "$venv/ready$extras" ] && [ ! pyproject.toml -nt "$venv/ready$extras" ] \
    && [ ! constraints.txt -nt "$venv/ready$extras" ]; then
    exit 0
fi

# install_debian PACKAGE...: installs when root, else says the exact line and stops.
install_debian() {
    line="apt-get install -y $*"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        echo "setup: $line"
        apt-get update -qq
        DEBIAN_FRONTEND=noninteractive $line -qq >/dev/null
    else
        echo "setup: system packages are missing. Run this line, then make again:" >&2
        echo "    sudo apt-get update && sudo $line" >&2
        exit 1
    fi
}

missing=""
for pair in libEGL.so.1=libegl1 libGL.so.1=libgl1 libusb-1.0.so.0=libusb-1.0-0; do
    if ! PATH="$PATH:/sbin:/usr/sbin" ldconfig -p | grep -q "${pair%%=*}"; then missing="$missing ${pair#*=}"; fi
done
# shellcheck disable=SC2086
[ -z "$missing" ] || install_debian $missing

python=""
for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11; do
    if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null
    then python=$candidate; break; fi
done
if [ -z "$python" ]; then
    echo "setup: no Python 3.11, 3.12 or 3.13 found; install one, or name it: make PYTHON=..." >&2
    exit 1
fi
if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    install_debian "$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')"
fi

echo "setup: $("$python" --version) into $venv (first time: a few minutes)"
# What an earlier set-up finished is built upon; one that was cut off is thrown away.
ls "$venv"/ready* >/dev/null 2>&1 || "$python" -m venv --clear "$venv"
# Pins hold for the build of the package itself, too.
PIP_CONSTRAINT="$PWD/constraints.txt" "$venv/bin/python" -m pip install --quiet \
    --disable-pip-version-check --editable ".$extras"
echo "setup: compiling kernels (once; a minute)"
"$venv/bin/python" -m pipelines.compile_kernels
touch "$venv/ready$extras"
