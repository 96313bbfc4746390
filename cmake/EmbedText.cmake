# SPDX-License-Identifier: BSD-3-Clause
# Writes C++ that holds text files, for a program that writes them out again:
#   cmake -DOUT=<file.cpp> -DHEADER=<declaration> -DFUNCTION=<name> -DROOT=<folder> -DNAMES=<a;b> -P EmbedText.cmake
# The function, of namespace cas::mav::gen, returns Files: name to text.
set(text "#include \"${HEADER}\"\n\nnamespace cas::mav::gen {\n\nconst Files& ${FUNCTION}() {\n  static const Files kFiles{\n")
foreach(name IN LISTS NAMES)
  file(READ "${ROOT}/${name}" content)
  string(APPEND text "{\"${name}\", R\"~~(${content})~~\"},\n")
endforeach()
string(APPEND text "  };\n  return kFiles;\n}\n\n}  // namespace cas::mav::gen\n")
file(WRITE "${OUT}" "${text}")
