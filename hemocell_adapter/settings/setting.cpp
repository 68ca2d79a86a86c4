// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/setting.h"

#include <cctype>

#include "hemocell_adapter/settings/attribute_tables.h"

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

std::string Setting::key() const {
  if (!otherKey.empty()) return otherKey;
  return tag.empty() ? tagOf(option) : tag;
}

void Setting::apply(Request& settings, const std::vector<Value>& given, const Origin& from) const {
  store(settings, given);
  if (attributes.empty()) {
    std::string stated = key();
    if (stated == catTag) stated += "." + std::get<std::string>(given[0]);
    if (stated == "fixed" || stated == "start")
      if (const Source source = sourceIn(given[0]); !isState(source) && !source.given)
        stated = keyOfSpecies(source.file.stem().string(), stated);
    settings.origins[stated] = from;
    return;
  }
  const std::string& cell = countOf.empty() ? std::get<std::string>(given[0]) : countOf;
  for (const std::string& attribute : attributes) settings.origins[keyOfSpecies(cell, attribute)] = from;
}

}  // namespace packmesh::hemocell
