# Writes a text file as a C++ array: cmake -D IN=contract.py -D OUT=contract_text.cpp -D NAME=kContractText -P embed.cmake
file(READ ${IN} text)
file(WRITE ${OUT} "namespace firn::python {\nextern const char ${NAME}[];\nconst char ${NAME}[] = R\"firn_text(${text})firn_text\";\n}\n")
