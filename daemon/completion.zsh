#compdef lidard
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# Completion of lidard for zsh: commands, options, and file names by their suffix. Commands, options and choices are those
# that `lidard --help` and `lidard COMMAND --help` name.
_lidard() {
  local -a words_of
  _lidard_help() { lidard "$@" --help 2>/dev/null; }
  if ((CURRENT == 2)); then
    words_of=(${(f)"$(_lidard_help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\)  *\(.*\)/\1:\2/p')"})
    _describe command words_of
    return
  fi
  case ${words[CURRENT-1]} in
    -c | --config) _files -g '*.(yaml|yml)(-.)'; return ;;
    --pcap) _files -g '*.pcap*(-.)'; return ;;
    --model) words_of=(${(f)"$(lidard models 2>/dev/null | sed '1d; s/ .*//')"}); compadd -a words_of; return ;;
    --calibration) _files -g '*.(yaml|yml|xml)(-.)'; return ;;
    --motion | --bag) _files -g '*.(bag|csv)(-.)'; return ;;
    --*)
      words_of=(${(s:,:)"$(_lidard_help $words[2] | sed -n "s/^ .*${words[CURRENT-1]} TEXT:{\(.*\)}.*/\1/p")"})
      if (($#words_of)); then compadd -a words_of; return; fi ;;
  esac
  if [[ $PREFIX == -* ]]; then
    words_of=(${(f)"$(_lidard_help $words[2] | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | tr -d ' ,')"})
    compadd -a words_of
    return
  fi
  case ${words[2]} in
    run | check | import) _files -g '*.(yaml|yml|launch)(-.)' ;;
    inspect | decode | snapshot | calibrate | replay | record) _files -g '*.pcap*(-.)' ;;
    *) compadd -- --help ;;
  esac
}
_lidard "$@"
