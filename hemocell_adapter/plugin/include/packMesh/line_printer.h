// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Prints the XML that HemoCell has read. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <algorithm>
#include <string>

#include <hemocell.h>

namespace packmesh {
namespace plugin {

/// Prints XML with each tag in the line that it has in the file.
class LinePrinter : public tinyxml2::XMLPrinter {
 public:
  LinePrinter() : tinyxml2::XMLPrinter(nullptr, true) {}
  bool VisitEnter(const tinyxml2::XMLElement& element, const tinyxml2::XMLAttribute* attribute) override {
    const std::string text = CStr();
    const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
    if (lines < element.GetLineNum())
      PushText(std::string(static_cast<std::size_t>(element.GetLineNum() - lines), '\n').c_str());
    return tinyxml2::XMLPrinter::VisitEnter(element, attribute);
  }
  using tinyxml2::XMLPrinter::VisitEnter;
};

}  // namespace plugin
}  // namespace packmesh
