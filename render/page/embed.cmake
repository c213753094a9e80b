# Writes FILES into OUTPUT, C++ that gives each by its name: see page.h.
set(text "#include \"render/page/page.h\"\n\nnamespace kirireel::page {\n\n")
string(APPEND text "std::string_view embeddedFile(std::string_view name) {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  # Hexadecimal digits, because CMake interprets brackets and semicolons of the file.
  file(READ ${file} digits HEX)
  string(LENGTH "${digits}" length)
  math(EXPR bytes "${length} / 2")
  string(REGEX REPLACE "(..)" "\\\\x\\1" digits "${digits}")
  string(APPEND text "  if (name == \"${name}\") return {\"${digits}\", ${bytes}};\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace kirireel::page\n")
file(WRITE ${OUTPUT} "${text}")
