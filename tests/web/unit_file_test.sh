#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The unit file is one that systemd takes without complaint, and denies casweb all that it does not need.
# Usage: unit_file_test.sh UNIT CASWEB       exit 77: systemd-analyze is not there
set -euo pipefail
unit=$1
casweb=$2
command -v systemd-analyze >/dev/null || exit 77

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
sed "s#/usr/bin/casweb#$casweb#" "$unit" > "$folder/casweb.service"
code=0
complaints=$(systemd-analyze verify --man=no "$folder/casweb.service" 2>&1) || code=$?
[ "$code" -eq 0 ] && [ -z "$complaints" ] || { echo "$complaints"; exit 1; }
# In tenths.
systemd-analyze security --offline=true --threshold=12 --no-pager "$folder/casweb.service" | tail -1
grep -q '^MemoryMax=' "$unit" || { echo "MemoryMax= is missing"; exit 1; }
