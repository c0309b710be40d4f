// The labs of a study: each seed prints in one of its own, drawn from the priors of the study or of a
// declared world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/study.h"

namespace firn {

/// Returns the priors of a part's labs: those of the study, and those of the world that the part is.
std::vector<KeyRange> priors_of(const Study& study, std::size_t part);
/// Returns the keys of a seed's lab, "KEY=VALUE" for each prior.
std::vector<std::string> drawn_lab(const Study& study, std::size_t part, std::uint64_t seed);
/// Sets the keys of a seed's lab in the experiment of an arm on a part.
/// @throws ConfigError naming study file, line, key, seed and limit
void draw_lab(const Study& study, std::size_t part, std::uint64_t seed, Experiment& experiment);
/// @throws ConfigError as above: the experiment lacks a key that is drawn, or cannot have the lowest or the
/// highest values of all of them
void check_labs(const Study& study, std::size_t part, const Experiment& experiment);

/// Makes the worlds that a study names its parts: fills experiment, overrides, seeds, metrics and priors from
/// the declaration. @param folder of the study file
/// @throws ConfigError: the declaration cannot be read, no world has labs of the kind, or the study asks for
/// more seeds than are declared
void take_worlds(Study& study, const std::filesystem::path& folder);
/// Keeps so many seeds: of a declaration its first ones, else 1 to `count`.
/// @throws ConfigError: the declaration has fewer
void take_seeds(Study& study, std::size_t count);

}  // namespace firn
