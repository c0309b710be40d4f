#include "print/simulated/validity_words.h"

#include <cstdio>

namespace firn {

std::string validity_words(const std::vector<plant::Validity>& validity) {
  std::string words;
  for (const plant::Validity& v : validity) {
    char text[160];
    std::snprintf(text, sizeof text, "%s%s reached %.2g of %.2g", words.empty() ? "; the world's " : ", ",
                  v.quantity.c_str(), v.reached, v.most);
    words += text;
  }
  return words;
}

}  // namespace firn
