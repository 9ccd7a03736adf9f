# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# For scripts that tell a line per step: what it does with the time that it usually takes. All else is in the file $log.

# Begins a new log.
begin_log() {
  log=$1
  mkdir -p "$(dirname "$log")"
  : >"$log"
}

# step TEXT COMMAND...: runs a command; what it prints is shown only if it fails, and then its end.
step() {
  local text=$1 begin=$SECONDS
  shift
  printf '%s ... ' "$text"
  if "$@" >>"$log" 2>&1; then
    echo "$((SECONDS - begin)) s"
  else
    printf 'failed. The end of %s:\n\n' "$log"
    tail -n 20 "$log"
    return 1
  fi
}
