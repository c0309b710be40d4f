// CLocale gives a thread the C locale for a scope, whatever locale the program has: numbers have a point.
#pragma once

#include <locale.h>

#include <clocale>
#include <cstring>

namespace firn::python {

class CLocale {
 public:
  CLocale() : before_(uselocale(shared())) {}
  ~CLocale() { uselocale(before_); }
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  static locale_t shared() {
    static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
    return locale;
  }
  locale_t before_;
};

/// Takes back another locale of the program, if a library has set one.
inline void restore_c_locale() {
  if (std::strcmp(std::setlocale(LC_ALL, nullptr), "C") != 0) std::setlocale(LC_ALL, "C");
}

}  // namespace firn::python
