// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/setting.h"

#include <cctype>

namespace packmesh::hemocell {

std::string tagOf(const std::string& option) {
  std::string tag;
  for (std::size_t i = 0; i < option.size(); ++i) {
    if (option[i] == '-' && i + 1 < option.size())
      tag += static_cast<char>(std::toupper(static_cast<unsigned char>(option[++i])));
    else
      tag += option[i];
  }
  return tag;
}

}  // namespace packmesh::hemocell
