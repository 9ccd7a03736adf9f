# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# CPack counts for each symbolic link the program behind it. Installed-Size is here what deb-substvars(5) says: KiB of files
# and links, each rounded up, and 1 KiB for anything else.
set(correct [[
  umask 022
  folder=$(mktemp -d)
  dpkg-deb -R "$0" "$folder/root"
  cd "$folder/root"
  size=$(find . -mindepth 1 -path ./DEBIAN -prune -o -printf '%y %s\n' |
         awk '{kib += /^[fl]/ ? int(($2 + 1023) / 1024) : 1} END {print kib}')
  sed -i "s/^Installed-Size: .*/Installed-Size: $size/" DEBIAN/control
  dpkg-deb --root-owner-group -Zxz -b . "$0"
  rm -r "$folder"]])
foreach(package IN LISTS CPACK_PACKAGE_FILES)
  if(package MATCHES "\\.deb$")
    execute_process(COMMAND sh -ec "${correct}" ${package} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  endif()
endforeach()
