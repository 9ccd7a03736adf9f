# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# Completion of lidard for bash: commands, options, and file names by their suffix.
_lidard() {
  local word=$2 before=$3 command=${COMP_WORDS[1]}
  COMPREPLY=()
  _lidard_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$word"); }
  _lidard_files() {
    local suffix
    mapfile -t COMPREPLY < <(
      compgen -d -S / -- "$word"
      for suffix in "$@"; do compgen -f -X "!*.$suffix" -- "$word"; done
    )
    compopt -o nospace -o filenames 2>/dev/null
  }
  if ((COMP_CWORD == 1)); then
    _lidard_words "run replay decode inspect check models keys discover record snapshot status events metrics dump import calibrate --help --version"
    return
  fi
  case $before in
    -c | --config) _lidard_files yaml yml; return ;;
    --pcap) _lidard_files pcap pcapng gz zst; return ;;
    --model) _lidard_words "$(lidard models 2>/dev/null | sed '1d; s/ .*//')"; return ;;
    --calibration) _lidard_files yaml yml xml; return ;;
    --calibration-model) _lidard_words "ros_drivers exact veloview"; return ;;
    --format) _lidard_words "csv pcd json"; return ;;
    --color) _lidard_words "height intensity"; return ;;
    --rate) _lidard_words "max 1"; return ;;
  esac
  case $command:$word in
    run:-*) _lidard_words "--config --help" ;;
    replay:-*) _lidard_words "--config --pcap --rate --loop --start --duration --wait --motion --clock --bag --help" ;;
    decode:-*) _lidard_words "--model --source --port --calibration --calibration-model --format --frame --clock --time --output --help" ;;
    record:*) _lidard_words "--config --output --interface --duration --help" ;;
    calibrate:-*) _lidard_words "--config --pcap --bag --motion --reference --json --output --picture --help" ;;
    snapshot:-*) _lidard_words "--config --pcap --at --range --areas --only --color --motion --width --output --help" ;;
    inspect:-* | models:*) _lidard_words "--json --help" ;;
    keys:*) _lidard_words "--markdown --man --json --help" ;;
    check:-*) _lidard_words "--config --ports --help" ;;
    check:* | run:*) _lidard_files yaml yml ;;
    status:* | events:*) _lidard_words "--socket --json --watch --help" ;;
    metrics:* | dump:*) _lidard_words "--socket --help" ;;
    import:-*) _lidard_words "--output --tables --help" ;;
    import:*) _lidard_files launch yaml yml ;;
    discover:*) _lidard_words "--hokuyo --sick --wait --json --help" ;;
    *) _lidard_files pcap pcapng gz zst ;;
  esac
}
complete -F _lidard lidard
