// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/member_value.h"

#include <fmt/format.h>

namespace packmesh::hemocell {

std::string toText(const Value& value) {
  return std::visit(
      [](const auto& v) -> std::string {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, bool>)
          return v ? "true" : "false";
        else if constexpr (std::is_same_v<T, Vec3>)
          return fmt::format("{} {} {}", v.x(), v.y(), v.z());
        else if constexpr (std::is_same_v<T, std::vector<double>>)
          return fmt::format("{}", fmt::join(v, " "));
        else if constexpr (std::is_same_v<T, std::shared_ptr<const Given>>)
          return v->what;
        else
          return fmt::format("{}", v);
      },
      value);
}

}  // namespace packmesh::hemocell
