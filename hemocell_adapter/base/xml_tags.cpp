// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/xml_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {

using tinyxml2::XMLElement;
namespace fs = std::filesystem;

namespace {

/// Describes why XML is not well-formed.
std::string faultOf(const tinyxml2::XMLDocument& document) {
  switch (document.ErrorID()) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "an element is not closed by its own end tag";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT:
      return "expected a tag, <name ...> or </name>";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "expected an attribute, name=\"value\"";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "a comment is not closed by -->";
    case tinyxml2::XML_ERROR_PARSING_TEXT:
      return "text outside of any tag";
    case tinyxml2::XML_ERROR_PARSING:
      return "a tag is not closed before the end of the file";
    default:
      return document.ErrorName();
  }
}

/// Rejects tags with very many attributes: the parser compares each attribute with all before it.
void refuseManyAttributes(const std::string& content, const fs::path& file) {
  constexpr int most = 1000;
  const auto after = [&](std::size_t at, const char* end) {
    const std::size_t found = content.find(end, at);
    return found == content.npos ? content.size() : found + std::char_traits<char>::length(end);
  };
  for (std::size_t at = content.find('<'); at < content.size(); at = content.find('<', at)) {
    if (content.compare(at, 4, "<!--") == 0) {
      at = after(at + 4, "-->");
    } else if (content.compare(at, 9, "<![CDATA[") == 0) {
      at = after(at, "]]>");
    } else {
      const std::size_t tag = at;
      int attributes = 0;
      for (++at; at < content.size() && content[at] != '>'; ++at) {
        if (content[at] == '"' || content[at] == '\'')
          at = std::min(content.find(content[at], at + 1), content.size());
        attributes += at < content.size() && content[at] == '=';
        if (attributes > most)
          throw InputError(fmt::format(
              "{}:{}: a tag has more than {} attributes", file.string(),
              1 + std::count(content.begin(), content.begin() + std::ptrdiff_t(tag), '\n'), most));
      }
    }
  }
}

}  // namespace

void loadXml(tinyxml2::XMLDocument& document, const fs::path& file) {
  parseXml(document, contentOf(file, "an XML file"), file);
}

void parseXml(tinyxml2::XMLDocument& document, const std::string& content, const fs::path& file) {
  refuseManyAttributes(content, file);
  switch (document.Parse(content.data(), content.size())) {
    case tinyxml2::XML_SUCCESS:
      return;
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      throw InputError(
          fmt::format("{}: is empty or not text; expected XML with the root <hemocell>", file.string()));
    default:
      throw InputError(fmt::format("{}:{}: is not well-formed XML: {}", file.string(),
                                   document.ErrorLineNum(), faultOf(document)));
  }
}

std::string placeOf(const XMLElement& element, const fs::path& file) {
  return fmt::format("{}:{}: <{}>", file.string(), element.GetLineNum(), element.Name());
}

std::string textOf(const XMLElement& element) {
  std::string text;
  for (const auto* node = element.FirstChild(); node; node = node->NextSibling()) {
    if (const auto* part = node->ToText()) text += part->Value();
  }
  return text;
}

Value valueOf(const XMLElement& element, const ValueSpec& spec, const fs::path& file) {
  return located(placeOf(element, file), [&] {
    if (const XMLElement* inside = element.FirstChildElement())
      throw InputError(fmt::format("expected {}, found the tag <{}>", expectation(spec), inside->Name()));
    return parseValue(spec, textOf(element));
  });
}

const XMLElement* onlyChild(const XMLElement& parent, const char* name, const fs::path& file) {
  const XMLElement* first = parent.FirstChildElement(name);
  if (!first) return nullptr;
  if (const XMLElement* second = first->NextSiblingElement(name)) {
    throw InputError(fmt::format("{}: this tag occurs twice (first in line {})", placeOf(*second, file),
                                 first->GetLineNum()));
  }
  return first;
}

}  // namespace packmesh::hemocell
