# Writes OUT, a .cpp that defines firn::lcm_type_texts(): the .lcm files FILES, one after another.
set(code "#include <string_view>\nnamespace firn {\nstd::string_view lcm_type_texts();\nstd::string_view lcm_type_texts() {\n  return ")
foreach(file ${FILES})
  file(READ ${file} text)
  string(APPEND code "R\"lcm(${text})lcm\"\n")
endforeach()
file(WRITE ${OUT} "${code};\n}\n}  // namespace firn\n")
