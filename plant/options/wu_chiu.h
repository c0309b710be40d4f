// WuChiuOptions holds the parameters of the droplet-by-droplet height model after Wu and Chiu.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/options/option.h"

namespace firn::plant {

/// Which heights a droplet meets.
enum class FlowOrder : std::uint8_t {
  kDrop,  ///< those that the droplet before it left
  kPass,  ///< those at the start of its pass, as in Eq. (4) of [Lu 2015]
};
inline constexpr std::array<std::string_view, 2> kFlowOrderWords{"drop", "pass"};
constexpr std::span<const std::string_view> words_of(FlowOrder) { return kFlowOrderWords; }

/// Structure after Y. Wu and G. T.-C. Chiu, "Height model for drop-on-demand inkjet", ASME Lett. Dyn. Sys.
/// Control 1(3) 031010 (2021), arXiv 2409.07021, of which only the abstract was read: volume and area are
/// propagated droplet by droplet, piecewise linear in the height differences of a 3 x 3 neighbourhood. The
/// equations (plant/inkjet/wu_chiu.cpp) are ours, and so are all values [U]; those of the paper are unknown.
struct WuChiuOptions {
  double side_share = 0.0789;    ///< of the droplet's volume, to each side neighbour of equal height
  double corner_share = 0.0263;  ///< to each corner neighbour
  double higher_side_per_mm = 200.0;
  double higher_corner_per_mm = 217.391;
  double lower_side_per_mm = 40.0;
  double lower_corner_per_mm = 40.0;
  double most_share = 2.0;
  double least_cover = 0.8;
  double cover = 0.6;
  double cover_side = 0.15;
  double cover_corner = 0.05;
  FlowOrder order = FlowOrder::kDrop;
  bool operator==(const WuChiuOptions&) const = default;
};
inline constexpr OptionTable kWuChiuOptions{
    Option{"side_share", &WuChiuOptions::side_share, "", within(0, 0.2),
           "share of a droplet's volume that each side neighbour of equal height gets; default h2 by h1 + 4 "
           "h2 + 4 h3 of "
           "[Lu 2015, Table I]"},
    Option{"corner_share", &WuChiuOptions::corner_share, "", within(0, 0.04),
           "the same of each corner neighbour; default h3 by h1 + 4 h2 + 4 h3"},
    Option{"higher_side_per_mm", &WuChiuOptions::higher_side_per_mm, "1/mm", within(0, 1e5),
           "a side neighbour's share falls by this part for each mm that it is higher; default 1 by h1 + h2"},
    Option{"higher_corner_per_mm", &WuChiuOptions::higher_corner_per_mm, "1/mm", within(0, 1e5),
           "the same of corner neighbours; default 1 by h1 + h3"},
    Option{"lower_side_per_mm", &WuChiuOptions::lower_side_per_mm, "1/mm", within(0, 1e5),
           "a side neighbour's share grows by this part for each mm that it is lower; 0 as in [Lu 2015, (5)] "
           "[U]"},
    Option{"lower_corner_per_mm", &WuChiuOptions::lower_corner_per_mm, "1/mm", within(0, 1e5),
           "the same of corner neighbours [U]"},
    Option{"most_share", &WuChiuOptions::most_share, "", within(1, 4),
           "a lower neighbour gets at most so many times its share [U]"},
    Option{"least_cover", &WuChiuOptions::least_cover, "", within(0.05, 1),
           "least covered part of a cell with ink; 1 = height is volume by the cell's area, as in [Lu 2015] "
           "[U]"},
    Option{"cover", &WuChiuOptions::cover, "", within(0, 1),
           "part of its own cell that a droplet covers on ground of equal height [U]"},
    Option{"cover_side", &WuChiuOptions::cover_side, "", within(0, 1),
           "part of each side neighbour that it covers [U]"},
    Option{"cover_corner", &WuChiuOptions::cover_corner, "", within(0, 1),
           "part of each corner neighbour that it covers [U]"},
    Option{"order", &WuChiuOptions::order, "", Range{},
           "heights that a droplet meets: drop = left by the one before it, pass = at the start of its pass"},
};

}  // namespace firn::plant
