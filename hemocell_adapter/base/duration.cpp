// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/duration.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace packmesh::hemocell {
namespace {

constexpr double minute = 60.0, hour = 3600.0, day = 86400.0, year = 365.25 * day;

/// "3 h 20 min"; the second part is omitted if it is 0.
std::string inTwoParts(double seconds, double large, const char* largeName, double small,
                       const char* smallName) {
  const auto parts = static_cast<std::int64_t>(std::llround(seconds / small));
  const auto perLarge = static_cast<std::int64_t>(large / small);
  std::string text = fmt::format("{} {}", parts / perLarge, largeName);
  if (parts % perLarge != 0) text += fmt::format(" {} {}", parts % perLarge, smallName);
  return text;
}

}  // namespace

std::string durationText(double seconds) {
  if (seconds < 10.0) return fmt::format("{:.3g} s", seconds);
  if (seconds < 2 * minute) return fmt::format("{:.0f} s", seconds);
  if (seconds < 2 * hour) return inTwoParts(seconds, minute, "min", 1.0, "s");
  if (seconds < 2 * day) return inTwoParts(seconds, hour, "h", minute, "min");
  if (seconds < 2 * year) return fmt::format("{:.0f} days", seconds / day);
  if (seconds < 1000 * year) return fmt::format("{:.0f} years", seconds / year);
  return "more than 1000 years";
}

}  // namespace packmesh::hemocell
