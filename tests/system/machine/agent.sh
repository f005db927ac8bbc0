#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs each line that comes in on the virtual serial port, and answers with what it printed, a byte 036, its exit status
# and the end of the line. It says 0 of its own when it is ready.
exec 3<>/dev/virtio-ports/agent
printf '\0360\n' >&3
while IFS= read -r line <&3; do
  bash -c "$line" </dev/null >&3 2>&1
  printf '\036%d\n' $? >&3
done
