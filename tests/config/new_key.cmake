# Writes OUT: the header IN with one more key, which is one member of ThresholdOptions and one row of its table.
file(READ ${IN} text)
foreach(place "struct ThresholdOptions {" "kThresholdOptions{")
  if(NOT text MATCHES "${place}")
    message(FATAL_ERROR "${IN} has no ${place}")
  endif()
endforeach()
string(REPLACE "struct ThresholdOptions {" "struct ThresholdOptions {\n  double toy_share = 0.25;" text "${text}")
string(REPLACE "kThresholdOptions{"
  "kThresholdOptions{Option{\"toy_share\", &ThresholdOptions::toy_share, \"mm\", above(0, 0.5), \"of a toy\"}," text "${text}")
file(WRITE ${OUT} "${text}")
