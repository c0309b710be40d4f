// A bench is one measurement of a program that holds several: the name by which it is called chooses one.
#pragma once

#include <string_view>

namespace firn::bench {

using Main = int(int argc, char** argv);

/// Makes a bench known to the program's main.
struct Bench {
  Bench(std::string_view name, Main* run);

  std::string_view name;
  Main* run;
};

}  // namespace firn::bench

/// FIRN_BENCH(name) { … } is the bench's main; once in a source, whose other names stand in a namespace of
/// its own.
#define FIRN_BENCH(name)                               \
  static int run_##name(int argc, char** argv);        \
  const ::firn::bench::Bench bench{#name, run_##name}; \
  static int run_##name(int argc, char** argv)
