#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The unit file is one that systemd takes without complaint, and denies casd all that it does not need.
# Usage: unit_file_test.sh CONFIG_FOLDER CASD       exit 77: systemd-analyze is not there
set -euo pipefail
config=$1
casd=$2
command -v systemd-analyze >/dev/null || exit 77

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# The programs are not installed here.
sed "s#/usr/bin/casd#$casd#" "$config/systemd/casd.service" > "$folder/casd.service"

complaints=$(systemd-analyze verify --man=no "$folder/casd.service" 2>&1)
[ -z "$complaints" ] || { echo "$complaints"; exit 1; }

# In tenths: 1.4 at most.
systemd-analyze security --offline=true --threshold=14 --no-pager "$folder/casd.service" | tail -1

# Settings that the service depends on.
for line in Type=notify Restart=on-failure RestartPreventExitStatus=78 WatchdogSec= DynamicUser=yes \
    Environment=CAS_RUNTIME_DIR=%t/cas Group=cas RuntimeDirectory=cas MemoryMax=; do
  grep -q "^$line" "$config/systemd/casd.service" || { echo "$line is missing"; exit 1; }
done
# Serial lines that the pages name, and networks that stations are in.
for class in ttyACM ttyUSB ttyS ttyAMA ttyTHS 'ttyHS\*' ttyMSM ttymxc ttyO ttyLP 'ttySC\*' ttyPS ttyGS rfcomm pts; do
  grep -q "^DeviceAllow=char-$class rw$" "$config/systemd/casd.service" || { echo "no DeviceAllow of $class"; exit 1; }
done
for network in localhost 192.168.0.0/16 100.64.0.0/10 255.255.255.255 224.0.0.0/4 fc00::/7 fe80::/10 ff00::/8; do
  grep -q "^IPAddressAllow=.*\(=\| \|^\)$network\( \|$\)" <(sed 's/=/= /' "$config/systemd/casd.service") ||
    { echo "no IPAddressAllow of $network"; exit 1; }
done
# A restart must be over before a controller takes its sensors for dead: 0.3 s.
grep -q '^RestartSec=10ms$' "$config/systemd/casd.service" || { echo "RestartSec is not 10ms"; exit 1; }
! grep -q '^ExecStartPre' "$config/systemd/casd.service" || { echo "ExecStartPre delays a restart"; exit 1; }
# /run/cas would lie below /run/private.
if grep -q "^RuntimeDirectoryPreserve=" "$config/systemd/casd.service"; then
  echo "RuntimeDirectoryPreserve hides /run/cas from the group"; exit 1
fi
