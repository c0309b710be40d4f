// Prints the tables of mpc_bench.
#pragma once

#include <string>

namespace firn::bench {

double thread_cpu_s();   ///< processor seconds of this thread
double process_cpu_s();  ///< of all threads
double wall_s();

int print_recovery();
int print_layers(const std::string& instances);
int draw_gap(const std::string& instances, const std::string& svg, const std::string& csv);
int search_best(const std::string& folder, int sweeps);
int print_large(int threads);
int print_forward();

}  // namespace firn::bench
