#include "core/slice/mesh/defects.h"

#include <array>
#include <utility>

#include "core/options/enumerators.h"

namespace firn::slice {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kTexts = {{
    {"not_finite", "facets with a corner that is no number were left out"},
    {"degenerate", "facets have no area on the grid"},
    {"not_closed", "the surface is not closed or its facets are wound against each other"},
    {"below_platform", "part of the mesh lies below z = 0 and is not printed"},
    {"inside_out", "the mesh is inside out: all facets were turned"},
    {"branching", "more than two facets meet on an edge"},
    {"turned", "contours with facets wound the wrong way were turned"},
    {"gap_closed", "gaps in contours were closed"},
    {"open_dropped", "an open contour was left out"},
    {"coarse", "the coordinates lie so far from the origin that the file has lost digits of them"},
    {"overlap", "contours crossed or touched and were merged"},
}};
static_assert(kTexts.size() == kTableSize<DefectKind>);

}  // namespace

std::string_view name(DefectKind kind) { return kTexts[std::size_t(kind)].first; }
std::string_view explanation(DefectKind kind) { return kTexts[std::size_t(kind)].second; }

}  // namespace firn::slice
