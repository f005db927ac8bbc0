#!/busybox sh
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=dash
# The first process: loads what the disk needs, and hands over to systemd on it.
b=/busybox
$b mkdir -p /proc /sys /dev /root
$b mount -t proc proc /proc
$b mount -t sysfs sysfs /sys
$b mount -t devtmpfs dev /dev
while read -r module; do $b insmod "/modules/$module"; done </modules/order
i=0
while [ ! -b /dev/vda ] && [ $i -lt 200 ]; do
  $b usleep 50000
  i=$((i + 1))
done
$b mount -t ext4 -o noatime /dev/vda /root
$b mount --move /dev /root/dev
$b umount /sys
$b umount /proc
exec $b switch_root /root /lib/systemd/systemd
