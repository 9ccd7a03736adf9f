# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# Completion of lidard for bash: commands, options, and file names by their suffix. Commands, options and choices are those that
# `lidard --help` and `lidard COMMAND --help` name.
_lidard() {
  local word=$2 before=$3 command=${COMP_WORDS[1]} choices
  COMPREPLY=()
  _lidard_help() { lidard "$@" --help 2>/dev/null; }
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
    _lidard_words "$(_lidard_help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\)  .*/\1/p') --help --version"
    return
  fi
  case $before in
    -c | --config) _lidard_files yaml yml; return ;;
    --pcap) _lidard_files pcap pcapng gz zst; return ;;
    --model) _lidard_words "$(lidard models 2>/dev/null | sed '1d; s/ .*//')"; return ;;
    --calibration) _lidard_files yaml yml xml; return ;;
    --motion | --bag) _lidard_files bag csv; return ;;
    --*)
      choices=$(_lidard_help "$command" | sed -n "s/^ .*$before TEXT:{\(.*\)}.*/\1/p")
      if [[ -n $choices ]]; then _lidard_words "${choices//,/ }"; return; fi ;;
  esac
  case $command:$word in
    *:-*) _lidard_words "$(_lidard_help "$command" | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | tr -d ' ,')" ;;
    check:* | run:*) _lidard_files yaml yml ;;
    import:*) _lidard_files launch yaml yml ;;
    inspect:* | decode:* | snapshot:* | calibrate:* | replay:* | record:*) _lidard_files pcap pcapng gz zst ;;
    *) _lidard_words --help ;;
  esac
}
complete -F _lidard lidard
