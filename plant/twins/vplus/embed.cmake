# Writes the V+ texts of the robot as C++: cmake -D FOLDER=drivers/robot/vplus -D OUT=vplus_text.cpp -P embed.cmake
set(code "#include \"plant/twins/vplus_text.h\"\nnamespace firn::plant {\nstd::vector<IceProgramText> vplus_texts() {\n  return {\n")
foreach(file firn lines motion paths)
  file(READ ${FOLDER}/${file}.v2 text)
  string(APPEND code "      {\"${file}.v2\", R\"vplus_text(${text})vplus_text\"},\n")
endforeach()
file(WRITE ${OUT} "${code}  };\n}\n}\n")
